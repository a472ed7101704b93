"""Cameras that all look from one direction, and such as look apart, are named."""

from functools import cache

import numpy as np
import pytest

from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.reconstruct import reconstruct
from facetlog.perception.surfaces.view_directions import looking_apart, one_direction
from facetlog.perception.types import Pose, View
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.worlds import make_world
from facetlog.robot.tour import looking_at, ring_poses, tour_camera
from tests.rendered import solid_truth, tour

UP = np.array([0.0, 0.0, 1.0])
WORLD = make_world("block")
MIDDLE = np.array(solid_truth(WORLD).vertices).mean(axis=0)
TOWARDS = np.array([0.86, 0.5, 0.6]) / np.linalg.norm([0.86, 0.5, 0.6])


@cache
def straight_at_it(near: float, far: float) -> Scene:
    """The scene of 16 views on the way towards the block, so many inches from its middle."""
    ways = np.linspace(far, near, 16)
    poses = [looking_at(MIDDLE + way * TOWARDS, MIDDLE) for way in ways]
    views = views_of(WORLD, poses, tour_camera())
    return reconstruct(views, name="block", up=UP)


def at(poses: tuple[Pose, ...]) -> tuple[View, ...]:
    blank = np.zeros((480, 640), np.uint8)
    return tuple(View(f"{k}.png", blank, tour_camera(), pose) for k, pose in enumerate(poses))


@pytest.mark.parametrize("near", [25.0, 27.0])
@pytest.mark.slow
def test_cameras_that_drive_straight_at_a_thing_are_named(near: float) -> None:
    scene = straight_at_it(near, 35.0)
    (warning,) = [said for said in scene.warnings if "one direction" in said]
    assert warning.startswith("the cameras look from one direction, within ")
    assert "from different sides" in warning


@pytest.mark.slow
def test_a_way_that_ends_close_to_the_thing_shows_depth() -> None:
    scene = straight_at_it(15.0, 45.0)
    assert scene.faces
    assert not any("one direction" in said for said in scene.warnings)


@pytest.mark.slow
def test_a_tour_round_a_thing_is_no_fault() -> None:
    scene = reconstruct(tour("block"), name="block", up=UP)
    assert scene.warnings == ()


@pytest.mark.parametrize(("across", "named"), [(4.0, True), (14.0, False)])
def test_without_a_face_the_angle_at_the_common_focus_counts(across: float, named: bool) -> None:
    ring = ring_poses([0.0, 0.0, 0.0], 30.0, (10.0,), round(360.0 / across))
    views = at(ring[:2])
    assert bool(one_direction(views)) == named


def test_neither_frame_nor_scale_matters() -> None:
    views = at(tuple(looking_at([way, 1e5, 0.0], [0.0, 1e5, 0.0]) for way in (3e3, 4e3, 5e3)))
    (warning,) = one_direction(views)
    assert "within 0 degrees" in warning


def test_cameras_inside_a_thing_that_look_outwards_are_named() -> None:
    outwards = tuple(
        Pose(pose.rotation @ np.diag([-1.0, 1.0, -1.0]), pose.centre)
        for pose in ring_poses([0.0, 0.0, 0.0], 3.0, (0.0, 1.0), 8)
    )
    (line,) = looking_apart(at(outwards))
    assert line.startswith("the cameras look away from one another")
    assert "place them round the thing" in line


def test_cameras_that_look_at_one_thing_do_not_look_apart() -> None:
    assert looking_apart(tour("block")) == ()


def test_cameras_side_by_side_do_not_look_apart() -> None:
    first = looking_at([0.0, -9.0, 0.0], [0.0, 0.0, 0.0])
    row = tuple(
        Pose(first.rotation, first.centre + np.array([x, 0.0, 0.0])) for x in (0.0, 1.0, 2.0)
    )
    assert looking_apart(at(row)) == ()
