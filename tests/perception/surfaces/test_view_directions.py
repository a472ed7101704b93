"""Cameras that all look from one direction, and such as look apart, are named."""

import numpy as np
import pytest

from facetlog.perception.surfaces.reconstruct import (
    reconstruct,
    warn_of_one_direction,
    warn_of_outward_views,
)
from facetlog.perception.types import Pose, View
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.worlds import make_world
from facetlog.robot.tour import make_pose_looking_at, make_ring_poses, tour_camera
from tests.rendered import get_solid_truth

UP = np.array([0.0, 0.0, 1.0])
WORLD = make_world("block")
MIDDLE = np.array(get_solid_truth(WORLD).vertices).mean(axis=0)
TOWARDS = np.array([0.86, 0.5, 0.6]) / np.linalg.norm([0.86, 0.5, 0.6])


def at(poses: tuple[Pose, ...]) -> tuple[View, ...]:
    blank = np.zeros((480, 640), np.uint8)
    return tuple(View(f"{k}.png", blank, tour_camera(), pose) for k, pose in enumerate(poses))


@pytest.mark.parametrize(("across", "named"), [(4.0, True), (14.0, False)])
def test_without_a_face_the_angle_at_the_common_focus_counts(across: float, named: bool) -> None:
    ring = make_ring_poses([0.0, 0.0, 0.0], 30.0, (10.0,), round(360.0 / across))
    views = at(ring[:2])
    assert bool(warn_of_one_direction(views)) == named


def test_neither_frame_nor_scale_matters() -> None:
    views = at(
        tuple(make_pose_looking_at([way, 1e5, 0.0], [0.0, 1e5, 0.0]) for way in (3e3, 4e3, 5e3))
    )
    (warning,) = warn_of_one_direction(views)
    assert "within 0 degrees" in warning


@pytest.mark.slow
def test_cameras_that_drive_straight_at_a_thing_are_named() -> None:
    poses = [
        make_pose_looking_at(MIDDLE + way * TOWARDS, MIDDLE) for way in np.linspace(35.0, 27.0, 16)
    ]
    scene = reconstruct(views_of(WORLD, poses, tour_camera()), name="block", up=UP)
    (warning,) = [said for said in scene.warnings if "one direction" in said]
    assert warning.startswith("the cameras look from one direction, within ")
    assert "from different sides" in warning


def test_cameras_inside_a_thing_that_look_outwards_are_named_and_no_others() -> None:
    inwards = make_ring_poses([0.0, 0.0, 0.0], 3.0, (0.0, 1.0), 8)
    turned = np.diag([-1.0, 1.0, -1.0])
    (line,) = warn_of_outward_views(at(tuple(Pose(p.rotation @ turned, p.centre) for p in inwards)))
    assert line.startswith("the cameras look away from one another")
    row = tuple(Pose(inwards[0].rotation, np.array([x, -9.0, 0.0])) for x in (0.0, 1.0, 2.0))
    for poses in (inwards, row):
        assert warn_of_outward_views(at(poses)) == ()
