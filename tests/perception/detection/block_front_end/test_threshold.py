import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from facetlog.perception.detection.block_front_end.localise import (
    PAPER_THRESHOLD,
    binary_picture,
    otsu_threshold,
    valley_threshold,
)

pictures = hnp.arrays(np.uint8, hnp.array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=12))


def two_greys(dark: float, bright: float) -> np.ndarray:
    rng = np.random.default_rng(0)
    picture = rng.normal(dark, 5, (120, 160))
    picture[30:70, 40:90] = rng.normal(bright, 5, (40, 50))
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


@given(pictures, st.integers(0, 255))
def test_at_the_threshold_is_white_and_below_it_black(picture, threshold):
    binary = binary_picture(picture, threshold)
    assert ((binary == 255) == (picture >= threshold)).all()
    assert set(np.unique(binary)) <= {0, 255}


def test_the_papers_threshold_is_the_default():
    assert PAPER_THRESHOLD == 150
    assert (binary_picture(np.array([[149, 150]], np.uint8)) == [[0, 255]]).all()


@pytest.mark.parametrize("choose", [otsu_threshold, valley_threshold])
@pytest.mark.parametrize(("dark", "bright"), [(20, 90), (150, 220)])
def test_a_chosen_threshold_parts_two_greys(choose, dark, bright):
    picture = two_greys(dark, bright)
    binary = binary_picture(picture, choose(picture))
    truth = np.zeros(picture.shape, dtype=bool)
    truth[30:70, 40:90] = True
    assert ((binary > 0) == truth).mean() > 0.99
