"""The chain from robot to camera, against the paper's angles and against itself turned round."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facetlog.perception.pan_tilt import pan_tilt_pose
from facetlog.robot.mount.kinematics import (
    Gaze,
    camera_pose,
    compute_pose_covariance,
    find_gaze,
    stand_for,
)
from facetlog.robot.mount.mount import PARAMETERS, Mount
from facetlog.robot.pose2 import Pose2

ANGLES = st.floats(-3.1, 3.1)
PANS, TILTS, SKEWS = st.floats(-1.7, 1.7), st.floats(-0.6, 0.6), st.floats(-0.5, 0.5)
SMALL, PLACES = st.floats(-0.1, 0.1), st.floats(-5.0, 5.0)
MOUNTS = st.builds(
    Mount,
    x=SMALL, y=SMALL, z=st.floats(0.3, 1.2), yaw=SMALL, pitch=SMALL, roll=SMALL,
    tilt_zero=SMALL, skew=SMALL, pinhole_ahead=SMALL, pinhole_left=SMALL, pinhole_up=SMALL,
)  # fmt: skip


@given(PLACES, PLACES, ANGLES, PANS, TILTS, SKEWS)
def test_a_level_mount_gives_the_papers_pose(
    x: float, y: float, heading: float, pan: float, tilt: float, skew: float
) -> None:
    pose = camera_pose(Pose2(x, y, heading), Mount(z=0.7, skew=skew), Gaze(pan, tilt))
    paper = pan_tilt_pose(x, y, 0.7, heading + pan - np.pi / 2, tilt - np.pi / 2, skew)
    np.testing.assert_allclose(pose.rotation, paper.rotation, atol=1e-12)
    np.testing.assert_allclose(pose.centre, paper.centre, atol=1e-12)


@given(
    MOUNTS,
    st.builds(Pose2, PLACES, PLACES, ANGLES),
    st.floats(1.0, 4.0),
    ANGLES,
    st.floats(-0.5, 1.5),
)
def test_the_head_looks_at_the_point_it_is_sent_to(
    mount: Mount, robot: Pose2, distance: float, bearing: float, height: float
) -> None:
    point = np.array(
        [robot.x + distance * math.cos(bearing), robot.y + distance * math.sin(bearing), height]
    )
    pose = camera_pose(robot, mount, find_gaze(robot, mount, point))
    x, y, z = pose.rotation.T @ (point - pose.centre)
    assert z > 0
    assert math.hypot(x, y) / z < 1e-6


@given(MOUNTS, PLACES, PLACES, ANGLES, st.floats(1.0, 4.0), ANGLES, st.floats(-0.5, 1.5))
def test_the_robot_stands_so_that_the_pinhole_is_where_it_is_wanted(
    mount: Mount, x: float, y: float, heading: float, distance: float, bearing: float, z: float
) -> None:
    point = np.array([x + distance * math.cos(bearing), y + distance * math.sin(bearing), z])
    robot, gaze = stand_for((x, y), heading, mount, point)
    pose = camera_pose(robot, mount, gaze)
    assert robot.heading == pytest.approx(math.remainder(heading, math.tau))
    np.testing.assert_allclose(pose.centre[:2], [x, y], atol=1e-9)
    ahead = (point - pose.centre) / np.linalg.norm(point - pose.centre)
    np.testing.assert_allclose(pose.rotation[:, 2], ahead, atol=1e-6)


def test_the_covariance_is_that_of_many_drawn_poses() -> None:
    rng = np.random.default_rng(3)
    sds = np.linspace(0.002, 0.006, len(PARAMETERS))
    mount = Mount(x=0.1, z=0.7, pinhole_ahead=0.05, sds=tuple(sds.tolist()))
    robot, gaze, head_sd = Pose2(1.0, 2.0, 0.7), Gaze(0.6, -0.4), 0.003
    root = np.array([[0.02, 0.0, 0.0], [0.01, 0.015, 0.0], [0.004, -0.003, 0.01]])
    found = compute_pose_covariance(robot, root @ root.T, mount, gaze, head_sd)
    centre = camera_pose(robot, mount, gaze)
    drawn = []
    for _ in range(4000):
        dx, dy, dh = root @ rng.normal(size=3)
        values = np.array(mount.values) + sds * rng.normal(size=len(sds))
        pan, tilt = gaze.pan + head_sd * rng.normal(), gaze.tilt + head_sd * rng.normal()
        pose = camera_pose(
            Pose2(robot.x + dx, robot.y + dy, robot.heading + dh),
            mount.replace_values(tuple(values.tolist())),
            Gaze(pan, tilt),
        )
        turn = Rotation.from_matrix(pose.rotation @ centre.rotation.T).as_rotvec()
        drawn.append([*(pose.centre - centre.centre), *turn])
    sample = np.cov(np.array(drawn).T)
    # Of 4000 draws a variance is off by 2 % (one sd).
    scale = np.sqrt(np.outer(np.diag(found), np.diag(found)))
    assert np.abs((sample - found) / scale).max() < 0.1
    assert np.linalg.eigvalsh(found).min() > 0


def test_the_pinhole_turns_with_pan_and_tilt() -> None:
    mount = Mount(x=0.1, z=0.5, pinhole_ahead=0.04, pinhole_up=0.02)
    left = camera_pose(Pose2(), mount, Gaze(math.pi / 2, 0.0))
    np.testing.assert_allclose(left.centre, [0.1, 0.04, 0.52], atol=1e-12)
    up = camera_pose(Pose2(), mount, Gaze(0.0, math.pi / 2))
    np.testing.assert_allclose(up.centre, [0.08, 0.0, 0.54], atol=1e-12)


def test_a_positive_pitch_of_the_mount_looks_down_and_a_positive_tilt_up() -> None:
    down = camera_pose(Pose2(), Mount(pitch=0.1), Gaze(0.0, 0.0)).rotation[:, 2]
    up = camera_pose(Pose2(), Mount(), Gaze(0.0, 0.1)).rotation[:, 2]
    assert down[2] == pytest.approx(-math.sin(0.1))
    assert up[2] == pytest.approx(math.sin(0.1))
