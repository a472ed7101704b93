"""What sonars see ahead, and how fast a robot goes by it."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.errors import DeviceError
from facetlog.robot.collecting.drive import (
    BRAKING,
    UNNOTICED,
    Body,
    MobileBase,
    compute_safe_speed,
    measure_free_way,
)
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.pioneer.parameters import find_parameters
from facetlog.robot.pioneer.state import SonarRange
from facetlog.robot.pose2 import Pose2
from tests.robot.collecting.fakes import FakeRobot, FakeState

P3DX = find_parameters("p3dx")
BODY = Body(P3DX.radius, P3DX.width)


def echo(index: int, metres: float, at: float = 0.0) -> SonarRange:
    return SonarRange(index, metres, at, P3DX.sonars[index])


@given(st.floats(0.0, 10.0))
def test_from_the_safe_speed_the_robot_stands_before_what_it_sees(free: float) -> None:
    speed = compute_safe_speed(free)
    assert speed >= 0
    assert speed * UNNOTICED + speed**2 / (2 * BRAKING) <= free + 1e-9


def test_an_echo_straight_ahead_is_as_far_as_the_robots_front_is_from_it() -> None:
    front = P3DX.sonars[3].x + 1.0 * math.cos(math.radians(10 - 7.5))
    assert measure_free_way([echo(3, 1.0)], BODY, 0.0, 0.0) == pytest.approx(front - 0.25, abs=0.02)


@pytest.mark.parametrize("index", [0, 7, 8, 11, 15])
def test_what_is_beside_or_behind_is_not_in_the_way(index: int) -> None:
    assert measure_free_way([echo(index, 0.4)], BODY, 0.0, 0.0) == math.inf


def test_the_robot_has_come_nearer_since_an_echo_and_an_old_one_is_none() -> None:
    fresh = measure_free_way([echo(3, 1.0, at=10.0)], BODY, 10.0, 0.5)
    assert measure_free_way([echo(3, 1.0, at=10.0)], BODY, 10.4, 0.5) == pytest.approx(fresh - 0.2)
    assert measure_free_way([echo(3, 1.0, at=10.0)], BODY, 12.0, 0.5) == math.inf
    assert measure_free_way([SonarRange(3, 1.0, 10.0, None)], BODY, 10.0, 0.5) == math.inf


class Wall:
    """Across the robot's way at x; gone after a time."""

    def __init__(self, robot: FakeRobot, x: float, gone: float = math.inf) -> None:
        self.robot, self.x, self.gone = robot, x, gone
        robot.faults.append(self.seen)

    def seen(self, state: FakeState) -> FakeState:
        ahead = self.x - self.robot.true.x - P3DX.sonars[3].x
        metres = 5.0 if state.at >= self.gone else max(ahead, 0.1)
        return replace(state, sonars=(echo(3, metres, state.at), echo(4, metres, state.at)))


def base(robot: FakeRobot, speed: float) -> MobileBase:
    return MobileBase(robot, Pose2(), pace=Pace(speed, slowing=5.0), body=BODY)


@pytest.mark.parametrize("speed", [0.2, 0.5])
def test_a_robot_whose_way_is_not_free_stands_before_it_and_says_so(speed: float) -> None:
    robot = FakeRobot()
    Wall(robot, 1.5)
    with pytest.raises(DeviceError, match=r"close ahead of the robot at x 1\.\d+ m.*--keep-out"):
        base(robot, speed).follow(((0.0, 0.0), (3.0, 0.0)))
    assert 0.0 < 1.5 - BODY.radius - robot.true.x < 0.1
    assert max(abs(p.x) for p in robot.true_path) < 1.5 - BODY.radius
    assert robot.stops


def test_what_is_nearer_than_a_sonar_measures_leaves_no_room() -> None:
    """It reports its least range then, however near it is."""
    assert measure_free_way([echo(3, 0.1)], BODY, 0.0, 0.2) == 0.0
