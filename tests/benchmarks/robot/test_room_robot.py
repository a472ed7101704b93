"""The robot of accuracy_area: its sonars hear the room, and what it runs into stops it."""

import math

import numpy as np
import pytest

from benchmarks.robot.room_robot import KIND, RoomHead, RoomRobot
from benchmarks.robot.rooms import make_room
from facetlog.errors import DeviceTimeout
from facetlog.robot.pose2 import Pose2
from facetlog.robot.simulator.body.dynamics import MotionErrors

ROOM = make_room(2)
BLOCK = next(thing for thing in ROOM.things if thing.kind == "block")


def _before_the_block() -> RoomRobot:
    x, y = BLOCK.middle[:2].tolist()
    return RoomRobot(ROOM, Pose2(x + 0.9, y, math.pi), MotionErrors(), 0)


def test_its_sonars_hear_what_is_lower_than_it_is() -> None:
    robot = _before_the_block()
    robot.advance(1.0)
    ahead = [s.range for s in robot.state.sonars if s.place and abs(s.place.heading) < 0.2]
    assert min(ahead) < 0.9


def test_it_drives_as_far_as_it_is_told_and_no_farther_than_its_lease() -> None:
    robot = RoomRobot(ROOM, Pose2(-1.0, -1.0, -2.4), MotionErrors(), 0)
    robot.drive(0.2, 0.0, lease=0.5)
    robot.advance(3.0)
    way = math.dist((robot.true.x, robot.true.y), (-1.0, -1.0))
    assert 0.05 < way < 0.2
    assert math.hypot(robot.state.pose.x, robot.state.pose.y) == pytest.approx(way, abs=0.002)
    assert not robot.touched


def test_what_it_runs_into_is_noticed() -> None:
    robot = _before_the_block()
    for _ in range(60):
        robot.drive(0.3, 0.0)
        robot.advance(0.1)
    assert robot.touched


def test_who_waits_in_vain_is_told() -> None:
    robot = _before_the_block()
    with pytest.raises(DeviceTimeout):
        robot.wait_for(lambda _: False, 1.0)


def test_its_head_stands_in_whole_steps() -> None:
    head = RoomHead(_before_the_block())
    found = head.look(0.1234, -0.2)
    assert found.pan == pytest.approx(0.1234, abs=head.limits.pan_step)
    assert found.pan / head.limits.pan_step == pytest.approx(
        round(found.pan / head.limits.pan_step)
    )
    assert np.isclose(head.where().tilt, -0.2, atol=head.limits.tilt_step)
    assert KIND.radius > 0.2
