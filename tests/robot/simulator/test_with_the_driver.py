"""The driver on each line of the simulated robot, by the clock (see test_driver_on_simulator)."""

import math
import time
from collections.abc import Iterator
from typing import Any

import pytest

from facetlog.robot.pioneer.pioneer import Pioneer
from facetlog.robot.simulator.world_file import (
    ErrorSetup,
    RobotSetup,
    SceneSetup,
    WorldSetup,
)
from tests.patience import allowed
from tests.robot.simulator.running import LONG, SMALL, Running, until

FLOOR = SceneSetup(world="empty")
ERRORS = ErrorSetup(left=0.01, right=-0.01, slip=0.002)
UNIT = 0.84e-3  # metres of a p2dx's odometry


@pytest.fixture
def running() -> Iterator[Running]:
    robot = RobotSetup(model="p2dx", odometry="perfect", errors=ERRORS)
    made = Running(WorldSetup(scene=FLOOR, robot=robot, camera=SMALL), pty=True)
    yield made
    made.close()


def drive(robot: Pioneer, speed: float, turning: float, seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        robot.drive(speed, turning)
        time.sleep(0.1)


def gone(before: dict[str, Any], after: dict[str, Any]) -> float:
    """Metres between where the robot truly was."""
    ends = [(state["truth"]["x"], state["truth"]["y"]) for state in (before, after)]
    return math.dist(*ends)


def standing(running: Running) -> dict[str, Any]:
    """The state once the robot stands."""
    return dict(
        until(lambda: (s := running.state())["speed"] == 0 == s["turning"] and s, "a stand")
    )


def assert_odometry_agrees(robot: Pioneer, running: Running) -> None:
    """The driver's pose is that of the encoders, to the units of the wire."""
    told = standing(running)["odometry"]
    stood = robot.state.at
    pose = robot.wait_for(lambda state: state.at > stood + 0.2, allowed(LONG)).pose
    # each report rounds to a unit; differences of rounded numbers do not add up their errors
    assert (pose.x, pose.y) == pytest.approx((told["x"], told["y"]), abs=2 * UNIT)
    assert pose.heading == pytest.approx(told["heading"], abs=2e-3)


@pytest.mark.parametrize("line", ["robot", "pty"])
@pytest.mark.slow
def test_the_drivers_pose_is_what_the_encoders_counted(running: Running, line: str) -> None:
    with Pioneer.connect(getattr(running.station.addresses, line)) as robot:
        robot.enable_motors()
        drive(robot, 0.25, 0.4, 3.0)
        robot.stop()
        assert_odometry_agrees(robot, running)
    state = running.state()
    assert not state["motors"]
    assert gone({"truth": {"x": 0.0, "y": 0.0}}, state) > 0.3
    assert state["truth"]["heading"] != pytest.approx(state["odometry"]["heading"], abs=2e-3)
