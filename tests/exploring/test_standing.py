"""Where a robot stands by its pictures of a place."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.exploring.standing import may_be_off_so_far, moved_beside, standing_by_pictures
from facetlog.perception.types import Pose
from facetlog.robot.camera.checks import Quality
from facetlog.robot.collecting.record import Taken
from facetlog.robot.mount.kinematics import Gaze, camera_pose
from facetlog.robot.mount.mount import DEFAULT_MOUNT
from facetlog.robot.pose2 import Pose2

GAZE = Gaze(0.3, -0.2)
# Of place and turn beside the first view, m and radians.
SD, TURN_SD = 0.1, math.radians(2.0)


def _seen_from(robot: Pose2) -> Pose:
    return camera_pose(robot, DEFAULT_MOUNT, GAZE)


def _taken(robot: Pose2) -> Taken:
    cov = np.diag([SD**2] * 3 + [TURN_SD**2] * 3)
    good = Quality(None, None, 0.0)
    return Taken(1, "view001.png", _seen_from(robot), cov, robot, robot, 0.3, -0.2, 0, 0.0, good)


places = st.builds(Pose2, st.floats(-5.0, 5.0), st.floats(-5.0, 5.0), st.floats(-3.0, 3.0))


@given(places, st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_the_robot_stands_where_its_aligned_picture_was_taken(
    believed: Pose2, x: float, y: float, turn: float
) -> None:
    # The camera is half a metre from the middle at most, which a turn moves too.
    true = Pose2(believed.x + 0.1 * x, believed.y + 0.1 * y, believed.heading + 0.05 * turn)
    found = standing_by_pictures(believed, _taken(believed), _seen_from(true))
    off = true.between(found)
    assert (off.x, off.y, off.heading) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


def test_what_it_drove_since_the_picture_is_kept() -> None:
    believed, since = Pose2(1.0, 2.0, 0.5), Pose2(0.3, -0.1, 0.2)
    true = Pose2(1.1, 1.95, 0.53)
    found = standing_by_pictures(believed.compose(since), _taken(believed), _seen_from(true))
    off = true.compose(since).between(found)
    assert (off.x, off.y, off.heading) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


def test_odometry_cannot_be_off_by_more_than_it_may_have_drifted() -> None:
    believed = Pose2(1.0, 2.0, 0.5)
    taken = _taken(believed)
    assert may_be_off_so_far(taken, _seen_from(Pose2(1.0 + SD, 2.0, 0.5 + TURN_SD)))
    for wrong in (Pose2(1.0 + 5 * SD, 2.0, 0.5), Pose2(1.0, 2.0, 0.5 + 5 * TURN_SD)):
        assert not may_be_off_so_far(taken, _seen_from(wrong))
    # What odometry may be off by more is none the less where it stands.
    unsure = replace(taken, covariance=25.0 * taken.covariance)
    assert may_be_off_so_far(unsure, _seen_from(Pose2(1.5, 2.0, 0.5)))


def test_how_far_off_odometry_was_is_in_words() -> None:
    off = moved_beside(Pose2(1.0, 1.0, 0.0), Pose2(1.03, 1.04, math.radians(-1.5)))
    assert off == "by its pictures odometry was off by 5 cm and 1.5°"
