"""Up from a floor is found where something can only stand there, and is unknown otherwise."""

import numpy as np
import pytest

from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.scene import Plane
from facetlog.perception.shapes.clouds.cloud_scene import make_cloud_scene
from facetlog.perception.shapes.regions.floor_and_walls import FacedSurface, find_up
from facetlog.perception.types import FloatArray
from tests.perception.shapes.sampled_shapes import box_points, rectangle, turned

X, Y, Z = np.eye(3)
Point = tuple[float, float, float]


def blocks(*parts: tuple[Point, Point], per_area: float = 2500.0) -> FloatArray:
    """Points all over blocks, each given by its sides and its lowest corner."""
    return np.concatenate(
        [
            box_points(
                size,
                round(per_area * 2.0 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0])),
                seed=k,
            )
            + np.array(place)
            for k, (size, place) in enumerate(parts)
        ]
    )


def sheet(length: float, width: float, level: float = 0.0) -> FloatArray:
    count = round(5000 * length * width)
    low = np.array([-0.5 * length, -0.5 * width, level])
    return rectangle(np.random.default_rng(9), count, low, length * X, width * Y)


def legs(length: float, width: float, height: float, side: float) -> FloatArray:
    places = [(x, y) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    return blocks(
        *(
            ((side, side, height), (x * length - 0.5 * side, y * width - 0.5 * side, 0.0))
            for x, y in places
        )
    )


TABLE = np.concatenate([legs(1.0, 0.6, 0.7, 0.07), blocks(((1.2, 0.8, 0.05), (-0.6, -0.4, 0.7)))])


def found_up(points: FloatArray, seed: int) -> FloatArray | None:
    noisy = points + np.random.default_rng(1).normal(0.0, 0.002, points.shape)
    up = make_cloud_scene(Cloud.of(turned(noisy, seed))).up
    return None if up is None else up @ turned(np.eye(3), seed).T


@pytest.mark.parametrize(
    "thing", [TABLE, blocks(((0.4, 0.4, 0.8), (0.0, 0.0, 0.0)))], ids=["table", "tall box"]
)
@pytest.mark.slow
def test_a_table_and_a_tall_box_say_that_they_stand_on_a_floor(thing: FloatArray) -> None:
    up = found_up(np.concatenate([sheet(3.0, 2.4), thing]), 3)
    assert up is not None
    assert float(up[2]) > 0.999


ON_A_PLANE = {
    "wall cabinet": [sheet(3.0, 2.4), blocks(((0.9, 0.7, 0.35), (0.0, 0.0, 0.0)))],
    "shelf on a wall": [sheet(3.0, 2.4), blocks(((0.9, 0.04, 0.25), (0.0, 0.0, 0.0)))],
    "top turned over, with its legs": [sheet(1.2, 0.8), legs(0.9, 0.5, 0.45, 0.05)],
    "the same with thick legs": [sheet(1.2, 0.8), legs(0.8, 0.4, 0.3, 0.12)],
}


@pytest.mark.parametrize("scene", ON_A_PLANE)
@pytest.mark.slow
def test_up_is_unknown_where_things_may_hang_or_be_legs(scene: str) -> None:
    assert found_up(np.concatenate(ON_A_PLANE[scene]), 3) is None


def test_a_body_beneath_the_floor_alone_is_no_thing_on_it() -> None:
    floor = sheet(3.0, 2.4)
    above = blocks(((0.4, 0.4, 0.8), (0.0, 0.0, 0.0)))
    below = blocks(((0.05, 0.05, 0.05), (0.2, 0.2, -0.6)))
    points = np.concatenate([floor, above[above[:, 2] > 0.0], below])
    owner = np.where(np.arange(len(points)) < len(floor), 0, -1)
    plane = Plane(Z, 0.0, 1e-9 * np.eye(4))
    up = find_up(FacedSurface.of(points, owner, [plane], noise=0.002, spacing=0.02))
    assert up is not None
    assert float(up.direction @ Z) == pytest.approx(1.0)
