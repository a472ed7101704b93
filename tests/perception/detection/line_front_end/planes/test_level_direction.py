"""Up where nobody states it: from level and upright lines, near how the cameras were held."""

import numpy as np
import pytest

from facetlog.perception.detection.line_front_end.planes.level_direction import (
    held_up,
    level_direction,
)
from facetlog.perception.surfaces.reconstruct import reconstruct
from facetlog.perception.types import FloatArray, Pose, View
from facetlog.robot.rendering.views import random_similarity
from facetlog.robot.tour import ring_poses, tour_camera
from tests.rendered import tour

UP = np.array([0.0, 0.0, 1.0])


def views_from(elevation: float, rolled: float = 0.0) -> tuple[View, ...]:
    """Twelve blank views from a ring that high above the horizon, rolled about their axes."""
    c, s = np.cos(np.deg2rad(rolled)), np.sin(np.deg2rad(rolled))
    roll = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    poses = ring_poses([0.0, 0.0, 0.0], 30.0, (elevation,), 12)
    blank = np.zeros((480, 640), np.uint8)
    return tuple(
        View(f"{k}.png", blank, tour_camera(), Pose(pose.rotation @ roll, pose.centre))
        for k, pose in enumerate(poses)
    )


def lines(directions: FloatArray) -> FloatArray:
    """Segments (n, 2, 3) of length one along directions (n, 3), anywhere."""
    starts = np.random.default_rng(0).uniform(-1.0, 1.0, directions.shape)
    return np.stack([starts, starts + directions], axis=1)


def level_and_upright(count: int) -> FloatArray:
    turns = np.random.default_rng(1).uniform(0.0, np.pi, count)
    level = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(count)])
    return np.concatenate([level, np.tile(UP, (count // 3, 1))])


def degrees_off(up: FloatArray | None) -> float:
    assert up is not None
    return float(np.degrees(np.arccos(np.clip(up @ UP, -1.0, 1.0))))


def test_up_is_square_to_what_is_level_and_along_what_is_upright() -> None:
    ways = level_and_upright(12)
    ways += np.random.default_rng(2).normal(scale=0.003, size=ways.shape)
    found = level_direction(lines(ways), np.ones(len(ways)), views_from(30.0))
    assert degrees_off(found) < 0.3


def test_lines_in_all_directions_tell_nothing() -> None:
    ways = np.random.default_rng(3).normal(size=(200, 3))
    assert level_direction(lines(ways), np.ones(200), views_from(30.0)) is None
    assert level_direction(np.zeros((0, 2, 3)), np.zeros(0), views_from(30.0)) is None


@pytest.mark.parametrize("rolled", [90.0, 180.0])
def test_cameras_that_were_not_held_upright_tell_nothing_above_the_ground(rolled: float) -> None:
    ways = level_and_upright(12)
    views = views_from(20.0, rolled)
    found = level_direction(lines(ways), np.ones(len(ways)), views)
    assert found is None or float(found @ UP) < -0.9
    assert not held_up(views, UP)


@pytest.mark.parametrize("rolled", [0.0, 30.0])
def test_the_grounds_normal_is_up_if_the_cameras_were_held_so(rolled: float) -> None:
    views = views_from(20.0, rolled)
    assert held_up(views, UP)
    assert not held_up(views, np.array([1.0, 0.0, 0.0]))  # a wall


@pytest.mark.parametrize("world", ["wedge", "stool"])
@pytest.mark.slow
def test_a_scene_in_any_frame_has_the_up_of_its_ground(world: str) -> None:
    frame = random_similarity(np.random.default_rng(5))
    scene = reconstruct([frame.view(view) for view in tour(world)[::2]], name=world)
    assert scene.up is not None
    assert float(scene.up @ (frame.rotation @ UP)) > np.cos(np.deg2rad(1.0))
    assert any(said.startswith("up is not stated: it is that of the") for said in scene.warnings)
