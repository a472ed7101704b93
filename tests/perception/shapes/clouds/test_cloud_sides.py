"""Outer sides and the sensor's place: what a file states is believed where free space agrees."""

from collections.abc import Callable

import numpy as np
import pytest

from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.clouds.cloud_scene import make_cloud_scene
from facetlog.perception.types import FloatArray
from tests.perception.shapes.sampled_shapes import box_points, rectangle

UP = np.array([0.0, 0.0, 1.0])
SIZE = (0.4, 0.3, 0.25)
EYE = np.array([1.2, -1.1, 0.9])


def on_a_floor(*sides: str) -> tuple[FloatArray, FloatArray]:
    """A box from (0, 0, 0) on a floor 2 m wide, and which of the points are the box's."""
    rng = np.random.default_rng(0)
    floor = rectangle(
        rng, 6000, np.array([-0.8, -0.85, 0.0]), 2.0 * np.eye(3)[0], 2.0 * np.eye(3)[1]
    )
    beneath = ((floor[:, :2] > 0.0) & (floor[:, :2] < SIZE[:2])).all(axis=1)
    box = box_points(SIZE, 3000, sides=sides)
    points = np.concatenate([floor[~beneath], box])
    is_box = np.arange(len(points)) >= len(points) - len(box)
    return points + rng.normal(0.0, 0.001, points.shape), is_box


def scan() -> FloatArray:
    """The points seen from EYE: three sides of the box, and the floor without its shadow."""
    points, is_box = on_a_floor("+x", "-y", "+z")
    way = points - EYE
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = (0.01 - EYE) / way, (np.array(SIZE) - 0.01 - EYE) / way
    enters = np.minimum(one, other).max(axis=1)
    leaves = np.maximum(one, other).min(axis=1)
    in_shadow = (enters < leaves) & (enters < 1.0)
    return points[is_box | ~in_shadow]


def true_normals(points: FloatArray, is_box: FloatArray) -> FloatArray:
    middle, half = np.array(SIZE) / 2.0, np.array(SIZE) / 2.0
    off = (points - middle) / half
    side = np.eye(3)[np.abs(off).argmax(axis=1)]
    return np.where(is_box[:, None], side * np.sign(off), UP)


def assert_box_looks_outwards(scene: Scene) -> None:
    middle = np.array(SIZE) / 2.0
    faces = [face for body in scene.bodies for face in body.faces]
    assert len(faces) >= 3
    assert all(float(scene.faces[face].plane.distance(middle)) < 0.0 for face in faces)


NORMALS: dict[str, Callable[[FloatArray, FloatArray, FloatArray], FloatArray]] = {
    "outwards": lambda _points, _box, true: true,
    "inwards": lambda _points, _box, true: -true,
    "of random sign": lambda points, _box, true: (
        true * np.random.default_rng(1).choice([-1.0, 1.0], len(points))[:, None]
    ),
    "to the sensor": lambda points, _box, true: (
        true * np.sign(((EYE - points) * true).sum(axis=1))[:, None]
    ),
    "from the sensor": lambda points, _box, true: (
        true * np.sign(((points - EYE) * true).sum(axis=1))[:, None]
    ),
    "down": lambda _points, _box, true: true * np.where(true @ UP > 0.0, -1.0, 1.0)[:, None],
    "all the same": lambda points, _box, _true: np.tile(UP, (len(points), 1)),
    "all down": lambda points, _box, _true: np.tile(-UP, (len(points), 1)),
    "box inwards, floor up": lambda _points, box, true: np.where(box[:, None], -true, true),
    "half of them missing": lambda points, _box, true: true * (points[:, [0]] > 0.2),
}


@pytest.mark.parametrize("case", NORMALS)
@pytest.mark.slow
def test_normals_of_any_orientation_leave_a_box_as_it_is(case: str) -> None:
    points, is_box = on_a_floor("-x", "+x", "-y", "+y", "+z")
    normals = NORMALS[case](points, is_box, true_normals(points, is_box))
    assert_box_looks_outwards(make_cloud_scene(Cloud.of(points, normals=normals), up=UP))


@pytest.mark.parametrize(
    "place",
    [(0.2, 0.15, 0.0), (0.2, 0.15, -1.0), (-0.7, 1.2, 0.6), (0.2, 0.15, 0.1), (0.2, 0.15, 3.0)],
)
@pytest.mark.slow
def test_a_place_that_lines_of_sight_contradict_is_not_believed(
    place: tuple[float, float, float],
) -> None:
    scene = make_cloud_scene(Cloud.of(scan(), sensor_places=[place]), up=UP)
    assert_box_looks_outwards(scene)
    stated = Cloud.of(scan(), seen_from=np.tile(place, (len(scan()), 1)))
    scene = make_cloud_scene(stated, up=UP)
    assert place == (0.2, 0.15, 0.1) or len(scene.bodies) == 1
    if place != (0.2, 0.15, 0.1):  # within the box: that is said, and leaves its sides open
        assert_box_looks_outwards(scene)


def test_the_first_place_that_lines_of_sight_allow_is_taken() -> None:
    places = [(0.2, 0.15, -1.0), EYE, (0.0, 0.0, 0.0)]
    scene = make_cloud_scene(Cloud.of(scan(), sensor_places=places), up=UP)
    (lines,) = scene.sights
    np.testing.assert_allclose(lines.origin, EYE)
    assert scene.warnings == ()
    refused = make_cloud_scene(Cloud.of(scan(), sensor_places=places[::2]), up=UP)
    assert not refused.sights
    assert "not seen from (0.2, 0.15, -1) or (0, 0, 0)" in refused.warnings[0]


@pytest.mark.parametrize("in_world", [True, False])
def test_up_may_be_that_of_the_sensors_pose(in_world: bool) -> None:
    """Points in the sensor's frame, up in the world's or in that of the points."""
    forward = (np.array([0.2, 0.15, 0.1]) - EYE) / np.linalg.norm(np.array([0.2, 0.15, 0.1]) - EYE)
    right = np.cross(forward, UP) / np.linalg.norm(np.cross(forward, UP))
    axes = np.column_stack([right, np.cross(forward, right), forward])
    cloud = Cloud.of((scan() - EYE) @ axes, sensor_places=[EYE, np.zeros(3)], world_axes=axes)
    scene = make_cloud_scene(cloud, up=UP if in_world else UP @ axes)
    assert scene.up is not None
    np.testing.assert_allclose(scene.up, UP @ axes, atol=1e-9)
    np.testing.assert_allclose(scene.sights[0].origin, np.zeros(3), atol=1e-9)
    assert len(scene.bodies) == 1
