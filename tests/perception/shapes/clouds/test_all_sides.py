"""Clouds that go all round things, and views of them from one side."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.shapes.clouds.lines_of_sight import compute_least_hidden, covers_all_sides
from tests.perception.shapes.sampled_shapes import box_points, turned

NOISE = 0.005
SIZE = (0.7, 0.5, 0.5)
COUNT = 6000


def spacing(area: float) -> float:
    return float(np.sqrt(area / COUNT))


BOX_SPACING = spacing(2.0 * (0.7 * 0.5 + 0.7 * 0.5 + 0.5 * 0.5))


@settings(max_examples=5)
@given(st.integers(0, 2**31), st.sampled_from([1e-3, 1.0, 1e3]))
def test_samples_all_over_a_box_go_all_round_in_any_frame_and_unit(seed: int, unit: float) -> None:
    points = unit * turned(box_points(SIZE, COUNT, noise=NOISE), seed)
    assert covers_all_sides(points, noise=unit * NOISE, spacing=unit * BOX_SPACING)


@settings(max_examples=5)
@given(st.integers(0, 2**31))
def test_three_sides_of_a_box_lie_open_to_who_looks_at_their_corner(seed: int) -> None:
    points = turned(box_points(SIZE, COUNT, noise=NOISE, sides=("+x", "+y", "+z")), seed)
    assert not covers_all_sides(points, noise=NOISE, spacing=BOX_SPACING)


def test_a_thin_top_on_thin_legs_goes_all_round_though_it_hides_little() -> None:
    top = box_points((1.0, 0.6, 0.0), 16_000, noise=NOISE, sides=("+z",))
    legs = [
        box_points((0.01, 0.01, 0.3), 100, seed=k, noise=NOISE) + np.array([x, y, -0.3])
        for k, (x, y) in enumerate([(0.1, 0.1), (0.9, 0.1), (0.1, 0.5), (0.9, 0.5)])
    ]
    table = turned(np.concatenate([top, *legs]))
    apart = float(np.sqrt(0.6 / 16_000))
    assert compute_least_hidden(table, noise=NOISE, spacing=apart) == pytest.approx(0.02, abs=0.01)
    assert covers_all_sides(table, noise=NOISE, spacing=apart)
