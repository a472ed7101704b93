"""The camera of the simulated robot."""

import math

import numpy as np
import pytest

from facetlog.robot.simulator.camera.viewpoint import Viewpoint, make_camera
from facetlog.robot.simulator.world_file import CameraSetup, MountSetup
from facetlog.robot.tour import tour_camera


def test_the_mount_of_a_world_file_is_in_degrees_and_turns_with_robot_and_head() -> None:
    setup = MountSetup(x=0.1, y=0.02, z=0.5, yaw_deg=10.0, pinhole_ahead=0.05, pinhole_up=0.01)
    assert setup.mount.yaw == pytest.approx(math.radians(10.0))
    head = math.radians(80.0)  # to the left, with the mount's yaw
    pose = Viewpoint(1.0, 2.0, math.pi / 2, head, 0.0).camera_pose(setup.mount)
    assert pose.centre == pytest.approx([1.0 - 0.02 - 0.05, 2.0 + 0.1, 0.51])
    assert pose.rotation[:, 2] == pytest.approx([-1.0, 0.0, 0.0])


def test_the_default_camera_is_the_tours_and_a_smaller_one_sees_the_same() -> None:
    setup = CameraSetup()
    assert make_camera(setup) == tour_camera()
    whole, half = make_camera(setup), make_camera(setup, 0.5)
    corner = np.linalg.inv(whole.matrix) @ [-0.5, -0.5, 1.0]
    assert half.matrix @ corner == pytest.approx([-0.5, -0.5, 1.0])


def test_between_two_headings_it_turns_the_shorter_way() -> None:
    start, end = Viewpoint(0, 0, 3.1, 0, 0), Viewpoint(1, 0, -3.1, 0.2, 0)
    middle = start.towards(end, 0.5)
    assert (middle.x, middle.pan) == (0.5, 0.1)
    assert middle.heading == pytest.approx(math.pi)


def test_positive_roll_and_skew_turn_the_picture_clockwise_about_the_view() -> None:
    for setup in (MountSetup(roll_deg=10), MountSetup(skew_deg=10)):
        right = Viewpoint(0, 0, 0, 0, 0).camera_pose(setup.mount).rotation[:, 0]
        assert right == pytest.approx([0, -math.cos(math.radians(10)), -math.sin(math.radians(10))])
