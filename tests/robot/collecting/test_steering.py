"""The controller, with a robot that accelerates as real ones do."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.robot.collecting.drive import MobileBase
from facetlog.robot.collecting.route import Circle, find_shortest_route
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.pose2 import Pose2
from tests.robot.collecting.fakes import FakeRobot

PLACES = st.floats(-2.0, 2.0)


@given(PLACES, PLACES, st.floats(-3.1, 3.1))
@settings(max_examples=25)
def test_any_place_is_reached_within_three_centimetres(x: float, y: float, heading: float) -> None:
    robot = FakeRobot()
    base = MobileBase(robot, Pose2(), pace=Pace())
    base.follow(((0.0, 0.0), (x, y)))
    base.turn_to(heading)
    state = base.stand(0.5)
    assert math.dist((robot.true.x, robot.true.y), (x, y)) < 0.03
    assert abs(math.remainder(robot.true.heading - heading, math.tau)) < math.radians(3)
    assert state.at == robot.state.at


@pytest.mark.parametrize("speed", [0.1, 0.2, 0.3])
def test_a_way_round_a_circle_never_enters_it(speed: float) -> None:
    circle = Circle(0.0, 0.0, 0.8)
    robot = FakeRobot(Pose2(-1.0, 0.0, 0.0))
    base = MobileBase(robot, Pose2(-1.0, 0.0, 0.0), pace=Pace(speed=speed))
    way = find_shortest_route((-1.0, 0.0), (1.0, 0.1), (circle.grown(0.03),))
    assert way is not None
    base.follow(way)
    base.stand(0.2)
    nearest = min(math.hypot(p.x, p.y) for p in robot.true_path)
    assert nearest > circle.radius
    assert math.dist((robot.true.x, robot.true.y), (1.0, 0.1)) < 0.03


def test_a_start_other_than_the_worlds_origin_is_composed_with_odometry() -> None:
    start = Pose2(3.0, -1.0, math.pi / 2)
    robot = FakeRobot(start)
    base = MobileBase(robot, start, pace=Pace())
    base.follow(((3.0, -1.0), (3.0, 0.5)))
    base.stand(0.2)
    assert math.dist((robot.true.x, robot.true.y), (3.0, 0.5)) < 0.03
    assert robot.state.pose.x == pytest.approx(1.5, abs=0.03)


def test_speeds_stay_within_the_pace() -> None:
    pace = Pace(speed=0.15, turning=math.radians(20))
    robot = FakeRobot()
    told: list[tuple[float, float]] = []
    drive = robot.drive

    def noted(speed: float, turning: float, lease: float = 0.3) -> None:
        told.append((speed, turning))
        drive(speed, turning, lease)

    robot.drive = noted  # type: ignore[method-assign]
    MobileBase(robot, Pose2(), pace=pace).follow(((0.0, 0.0), (1.0, 0.8), (-0.5, 0.9)))
    assert np.abs(told).max(axis=0).tolist() <= [0.15 + 1e-9, math.radians(20) + 1e-9]
    assert len(told) > 50
