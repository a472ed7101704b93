"""What faces up, told by heights: thin boards, cushions, and what is closed all round."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.shapes.clouds.cloud_levels import levels_by_height
from facetlog.perception.shapes.clouds.cloud_scene import scene_of_cloud
from facetlog.perception.types import FloatArray
from tests.perception.shapes.sampled_shapes import box_points

Z = np.array([0.0, 0.0, 1.0])
NOISE = 0.006
COUNT = 20_000
TABLE_AREA = 1.6


def boxes(
    *parts: tuple[tuple[float, float, float], tuple[float, float, float]], noise: float = NOISE
) -> FloatArray:
    """Points all over boxes of these sizes and lowest corners."""
    areas = [2.0 * (a * b + b * c + a * c) for (a, b, c), _ in parts]
    return np.concatenate(
        [
            box_points(size, round(COUNT * area / sum(areas)), seed=k, noise=noise) + place
            for k, ((size, place), area) in enumerate(zip(parts, areas, strict=True))
        ]
    )


def thin_table(thickness: float) -> FloatArray:
    """A table 1 × 0.6 × 0.5 on legs of 4 cm."""
    legs = [((0.04, 0.04, 0.5), (x, y, 0.0)) for x in (0.0, 0.96) for y in (0.0, 0.56)]
    return boxes(((1.0, 0.6, thickness), (0.0, 0.0, 0.5 - thickness)), *legs)


def found(points: FloatArray, area: float, up: FloatArray = Z, unit: float = 1.0) -> list[float]:
    """Mean heights of the levels of points on so much surface, of which none is known."""
    nothing = np.zeros(len(points), dtype=bool)
    spacing = unit * float(np.sqrt(area / len(points)))
    every = levels_by_height(points, up, nothing, noise=unit * NOISE, spacing=spacing)
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


def test_an_open_box_has_its_bottom_for_a_level_and_not_its_rim() -> None:
    sides = ("-x", "+x", "-y", "+y", "-z")
    points = box_points((0.8, 0.8, 0.2), COUNT, noise=NOISE, sides=sides)
    assert found(points, 1.28) == [pytest.approx(0.0, abs=NOISE)]


def test_boards_of_a_shelf_that_is_open_in_front_are_levels_each() -> None:
    boards = [((0.8, 0.3, 0.03), (0.0, 0.0, z)) for z in (0.0, 0.4, 0.8)]
    sides = [((0.03, 0.3, 0.83), (x, 0.0, 0.0)) for x in (0.0, 0.77)]
    heights = sorted(found(boxes(*boards, *sides), 2.5))
    np.testing.assert_allclose(heights, [0.03, 0.43, 0.83], atol=4.0 * NOISE)


@pytest.mark.parametrize("thickness", [0.02, 0.035])
@pytest.mark.slow
def test_a_scene_has_one_broad_face_that_looks_up_from_a_thin_board(thickness: float) -> None:
    scene = scene_of_cloud(Cloud.of(thin_table(thickness)), up=Z)
    assert [body.whole for body in scene.bodies] == [True]
    points = scene.points
    tops = [
        np.ptp(points[list(face.outline)], axis=0)
        for face in scene.faces
        if face.plane.normal @ Z > 0.95
    ]
    broad = [size for size in tops if size[0] > 0.9 and size[1] > 0.5]
    assert len(broad) == 1
