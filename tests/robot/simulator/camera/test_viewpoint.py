"""The chain from robot to pinhole, against the paper's own head and by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.perception.pan_tilt import pan_tilt_pose
from facetlog.robot.mount import kinematics
from facetlog.robot.mount.mount import Mount
from facetlog.robot.pose2 import Pose2
from facetlog.robot.simulator.camera.viewpoint import Viewpoint, camera_pose, make_camera
from facetlog.robot.simulator.world_file import CameraSetup, MountSetup
from facetlog.robot.tour import tour_camera

ANGLES = st.floats(-math.pi, math.pi)


@given(st.floats(-5, 5), st.floats(-5, 5), ANGLES, st.floats(-1.7, 1.7), st.floats(-0.4, 0.4))
def test_with_a_level_mount_it_is_the_papers_head(
    x: float, y: float, heading: float, pan: float, tilt: float
) -> None:
    pose = camera_pose(Viewpoint(x, y, heading, pan, tilt), MountSetup(z=0.7))
    # A = 0 looks along y and B = -90 degrees is level, see perception/pan_tilt.py
    paper = pan_tilt_pose(x, y, 0.7, heading + pan - math.pi / 2, tilt - math.pi / 2)
    assert pose.centre == pytest.approx(paper.centre)
    assert pose.rotation == pytest.approx(paper.rotation, abs=1e-12)


def test_mount_and_pinhole_move_the_camera_as_the_axes_turn() -> None:
    mount = MountSetup(x=0.1, y=0.02, z=0.5, pinhole_ahead=0.05, pinhole_up=0.01)
    ahead = camera_pose(Viewpoint(1.0, 2.0, math.pi / 2, 0.0, 0.0), mount)
    assert ahead.centre == pytest.approx([1.0 - 0.02, 2.0 + 0.15, 0.51])
    left = camera_pose(Viewpoint(1.0, 2.0, math.pi / 2, math.pi / 2, 0.0), mount)
    assert left.centre == pytest.approx([1.0 - 0.02 - 0.05, 2.0 + 0.1, 0.51])
    up = camera_pose(Viewpoint(1.0, 2.0, math.pi / 2, 0.0, math.pi / 2), mount)
    assert up.centre == pytest.approx([1.0 - 0.02, 2.0 + 0.1 - 0.01, 0.55])


@pytest.mark.parametrize(
    ("mount", "viewpoint"),
    [
        (MountSetup(yaw_deg=10), Viewpoint(0, 0, 0, math.radians(10), 0)),
        (MountSetup(tilt_zero_deg=5), Viewpoint(0, 0, 0, 0, math.radians(5))),
        (MountSetup(pitch_deg=-5), Viewpoint(0, 0, 0, 0, math.radians(5))),
    ],
)
def test_a_mount_that_is_askew_looks_elsewhere(mount: MountSetup, viewpoint: Viewpoint) -> None:
    askew = camera_pose(Viewpoint(0, 0, 0, 0, 0), mount)
    assert askew.rotation == pytest.approx(camera_pose(viewpoint, MountSetup()).rotation)


def test_positive_roll_and_skew_turn_the_picture_clockwise_about_the_view() -> None:
    for mount in (MountSetup(roll_deg=10), MountSetup(skew_deg=10)):
        right = camera_pose(Viewpoint(0, 0, 0, 0, 0), mount).rotation[:, 0]
        assert right == pytest.approx([0, -math.cos(math.radians(10)), -math.sin(math.radians(10))])


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


@given(st.lists(st.floats(-0.5, 0.5), min_size=16, max_size=16))
def test_it_is_the_chain_that_the_collection_writes_down(values: list[float]) -> None:
    lengths, angles, (x, y, heading, pan, tilt) = values[:6], values[6:11], values[11:]
    names = dict(zip(("x", "y", "z", "ahead", "left", "up"), lengths, strict=True))
    z = 1.0 + names["z"]  # a mast stands on the robot
    turns = dict(zip(("yaw", "pitch", "roll", "tilt_zero", "skew"), angles, strict=True))
    pinhole = {f"pinhole_{name}": names[name] for name in ("ahead", "left", "up")}
    mount = Mount(x=names["x"], y=names["y"], z=z, **turns, **pinhole)
    setup = MountSetup(
        x=names["x"],
        y=names["y"],
        z=z,
        **{f"{name}_deg": math.degrees(value) for name, value in turns.items()},
        **pinhole,
    )
    written = kinematics.camera_pose(Pose2(x, y, heading), mount, kinematics.Gaze(pan, tilt))
    seen = camera_pose(Viewpoint(x, y, heading, pan, tilt), setup)
    assert seen.centre == pytest.approx(written.centre, abs=1e-9)
    assert seen.rotation == pytest.approx(written.rotation, abs=1e-9)
