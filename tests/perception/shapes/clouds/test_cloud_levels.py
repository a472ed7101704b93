"""Surfaces that face up, found by heights: thin boards, cushions, closed shapes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facetlog.perception.shapes.clouds.cloud_sides import find_levels_by_height
from facetlog.perception.types import FloatArray
from tests.perception.shapes.sampled_shapes import boxes_points

Z = np.array([0.0, 0.0, 1.0])
NOISE = 0.006
COUNT = 20_000
TABLE_AREA = 1.6


def thin_table(thickness: float) -> FloatArray:
    """A table 1 × 0.6 × 0.5 on legs of 4 cm."""
    legs = [((0.04, 0.04, 0.5), (x, y, 0.0)) for x in (0.0, 0.96) for y in (0.0, 0.56)]
    top = ((1.0, 0.6, thickness), (0.0, 0.0, 0.5 - thickness))
    return boxes_points(top, *legs, count=COUNT, noise=NOISE)


def found(points: FloatArray, area: float, up: FloatArray = Z, unit: float = 1.0) -> list[float]:
    """Mean heights of the levels of points on so much surface, of which none is known."""
    nothing = np.zeros(len(points), dtype=bool)
    spacing = unit * float(np.sqrt(area / len(points)))
    every = find_levels_by_height(points, up, nothing, noise=unit * NOISE, spacing=spacing)
    return [float((points[rows] @ up).mean()) for rows in every]


@pytest.mark.parametrize("thickness", [0.004, 0.02, 0.04])
def test_a_board_has_one_level_however_near_its_sides_are_to_the_noise(thickness: float) -> None:
    assert found(thin_table(thickness), TABLE_AREA) == [
        pytest.approx(0.5 - thickness / 2.0, abs=0.025)
    ]


@settings(max_examples=5)
@given(st.integers(0, 2**31), st.sampled_from([1e-3, 1e3]))
def test_levels_turn_and_scale_with_the_cloud(seed: int, unit: float) -> None:
    rotation = Rotation.random(rng=np.random.default_rng(seed))
    points = unit * rotation.apply(thin_table(0.02))
    heights = found(points, TABLE_AREA, rotation.apply(Z), unit)
    np.testing.assert_allclose(
        np.array(heights) / unit, found(thin_table(0.02), TABLE_AREA), atol=NOISE
    )


def test_boards_of_a_shelf_that_is_open_in_front_are_levels_each() -> None:
    boards = [((0.8, 0.3, 0.03), (0.0, 0.0, z)) for z in (0.0, 0.4, 0.8)]
    sides = [((0.03, 0.3, 0.83), (x, 0.0, 0.0)) for x in (0.0, 0.77)]
    heights = sorted(found(boxes_points(*boards, *sides, count=COUNT, noise=NOISE), 2.5))
    np.testing.assert_allclose(heights, [0.03, 0.43, 0.83], atol=4.0 * NOISE)
