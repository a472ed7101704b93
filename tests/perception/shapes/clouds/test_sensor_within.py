"""A sensor that is said to stand inside of a thing: told from one in a room."""

import numpy as np
import pytest

from facetlog.kb.explaining.proof import State
from facetlog.kb.recognize import open_knowledge_base
from facetlog.perception.facts.all_facts import facts_on_demand, scene_facts
from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.clouds.cloud_scene import SENSOR_WITHIN, make_cloud_scene
from facetlog.perception.types import FloatArray
from tests.perception.shapes.sampled_shapes import box_points, rectangle

UP = np.array([0.0, 0.0, 1.0])
OPEN_BELOW = ("-x", "+x", "-y", "+y", "+z")


def seen(points: FloatArray, *eye: float) -> Scene:
    seen_from = np.tile(np.array(eye), (len(points), 1))
    return make_cloud_scene(Cloud.of(points, seen_from=seen_from), up=UP, metric=True)


def on_a_floor() -> FloatArray:
    """A box 50 × 40 × 30 cm on a floor 3 m wide; of what it stands on nothing was seen."""
    rng = np.random.default_rng(0)
    floor = rectangle(
        rng, 8000, np.array([-1.0, -1.0, 0.0]), 3.0 * np.eye(3)[0], 3.0 * np.eye(3)[1]
    )
    beneath = (floor[:, :2] > (0.2, 0.3)).all(axis=1) & (floor[:, :2] < (0.7, 0.7)).all(axis=1)
    box = box_points((0.5, 0.4, 0.3), 4000, sides=OPEN_BELOW) + np.array([0.2, 0.3, 0.0])
    points = np.concatenate([floor[~beneath], box])
    return points + rng.normal(0.0, 0.003, points.shape)


@pytest.mark.parametrize("eye", [(0.25, 0.2, 0.15), (0.1, 0.3, 0.2)])
@pytest.mark.slow
def test_of_a_box_round_its_sensor_it_is_unknown_whether_it_is_one(
    eye: tuple[float, float, float],
) -> None:
    points = box_points((0.5, 0.4, 0.3), 12_000, noise=0.001)
    scene = seen(points, *eye)
    assert scene.warnings == (SENSOR_WITHIN,)
    assert not any(body.whole for body in scene.bodies)
    middle = points.mean(axis=0)
    assert all(float(face.plane.distance(middle)) < 0.0 for face in scene.faces)
    with open_knowledge_base() as base:
        base.load_scene(
            "s",
            (fact.row for fact in scene_facts(scene)),
            on_demand=lambda: (fact.row for fact in facts_on_demand(scene)),
        )
        verdict = base.why("s", "box")
        text = "\n".join(verdict.lines())
    assert verdict.state is State.UNKNOWN
    assert "look at it from outside, or put right where it was seen from" in text


def test_a_sensor_beside_a_thing_warns_of_nothing_and_one_in_a_thing_on_a_floor_does() -> None:
    points = on_a_floor()
    assert seen(points, -2.0, -2.0, 1.5).warnings == ()
    assert seen(points, 0.45, 0.5, 0.15).warnings == (SENSOR_WITHIN,)


@pytest.mark.parametrize("eye", [(1.5, 1.0, 1.3), (0.3, 0.3, 1.8), (2.5, 1.5, 0.9)])
@pytest.mark.slow
def test_the_walls_of_a_room_in_which_something_stands_do_not_warn(
    eye: tuple[float, float, float],
) -> None:
    walls = box_points((3.0, 2.0, 2.5), 8000, noise=0.003)
    block = box_points((0.5, 0.4, 0.9), 900, noise=0.003, sides=OPEN_BELOW) + np.array(
        [1.7, 0.5, 0.0]
    )
    assert seen(np.concatenate([walls, block]), *eye).warnings == ()
