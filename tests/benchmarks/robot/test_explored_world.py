"""A robot without a clock goes by its odometry; its views are explored as those of a real one."""

import math

import numpy as np
import pytest
from scipy.stats import chi2

from benchmarks.robot.explored_world import KEEP_OUT, ExploredWorld, OdometryRobot
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.pose2 import Pose2
from facetlog.robot.simulator.body import MotionErrors

SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))


def test_without_errors_it_is_where_it_believes_to_be() -> None:
    robot = OdometryRobot(Pose2(0.0, 0.0, 0.3), MotionErrors(), 1, Pace())
    robot.go(SQUARE, 1.0)
    off = robot.here.between(robot.true)
    # Odometry is reported in whole millimetres and 4096 parts of a turn.
    assert math.hypot(off.x, off.y) < 0.005
    assert abs(off.heading) < 0.002
    assert robot.true.heading == pytest.approx(1.0, abs=0.01)
    assert robot.driven == pytest.approx(6.0, abs=0.02)


def test_a_robot_whose_wheels_slip_is_where_its_covariance_says() -> None:
    for seed in range(3):
        robot = OdometryRobot(Pose2(), MotionErrors.usual(skids=False), seed, Pace())
        robot.go(SQUARE, 0.0)
        off = np.array([robot.true.x - robot.here.x, robot.true.y - robot.here.y])
        assert 0.002 < np.linalg.norm(off) < 0.2
        assert off @ np.linalg.solve(robot.covariance[:2, :2], off) < chi2.ppf(0.999, 2)


@pytest.mark.slow
def test_views_of_a_ring_show_the_target_and_keep_out() -> None:
    drive = ExploredWorld("block", 3)
    for candidate in drive.ring(3):
        drive.take(candidate)
    assert drive.nearest > KEEP_OUT
    assert len(drive.world.solids) == 6
    for view in drive.views:
        to_target = view.pose.rotation.T @ (drive.around.target - view.pose.centre)
        assert abs(to_target[0] / to_target[2]) < 0.05
        assert view.pose_cov is not None
        assert np.linalg.eigvalsh(view.pose_cov).min() > 0
    again = ExploredWorld("block", 3)
    for candidate in again.ring(3):
        again.take(candidate)
    for one, other in zip(drive.views, again.views, strict=True):
        assert (one.image == other.image).all()
