"""Noisy pictures halved: what noise and grain are there."""

import cv2
import numpy as np
import pytest

from facetlog.perception.detection.coarse_pictures import coarse_pictures
from facetlog.perception.detection.picture_noise import Noise
from facetlog.perception.types import Image
from tests.perception.detection.drawings import flat, with_noise


def large(sd: float, grain: float = 0.0) -> Image:
    """A grey picture with noise, and smooth patches of random brightness."""
    rng = np.random.default_rng(0)
    patches = cv2.GaussianBlur(rng.normal(0.0, 1.0, (480, 640)), (0, 0), 4.0)
    grey = 120.0 + rng.normal(0.0, sd, (480, 640)) + grain * patches / patches.std()
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


@pytest.mark.parametrize(("sd", "count"), [(1.5, 0), (5.0, 1), (60.0, 3)])
def test_the_noisier_a_picture_the_more_often_it_is_halved(sd: float, count: int) -> None:
    assert [c.factor for c in coarse_pictures(flat(), Noise(sd))] == [2, 4, 8][:count]


@pytest.mark.parametrize("sd", [5.0, 20.0])
def test_noise_alone_is_hardly_grain(sd: float) -> None:
    for coarse in coarse_pictures(large(sd), Noise(sd)):
        assert coarse.grain < 0.35 * coarse.noise


def test_a_picture_of_one_pixel_is_not_halved() -> None:
    assert coarse_pictures(with_noise(flat()[:1, :1], 5.0), Noise(5.0)) == []
