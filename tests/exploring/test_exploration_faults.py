"""What may happen to a robot that explores: it ends or goes on with one line, and loses nothing."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.exploring.explorer import Explorer
from facetlog.judging.view_verdicts import ViewVerdict
from facetlog.robot.camera.source import Frame
from facetlog.robot.collecting.record import Taken, read_record
from facetlog.robot.collecting.route import Circle
from facetlog.robot.head.head import HeadState
from facetlog.robot.pioneer.state import SonarRange
from tests.exploring.explorations import (
    FORBIDDEN,
    ROBOT,
    START,
    TARGET,
    Exploration,
    Seeing,
    all_open,
    judged,
    led,
    log_of,
)
from tests.robot.collecting.fakes import FakeRobot, FakeState

VIEWS = 6
THING = 0.15  # radius of what stands in the way, m


def _explorer() -> Explorer:
    return Explorer(judged(all_open), most=VIEWS)


def _goes_on(folder: Path, first: Exploration) -> None:
    """The views that are there stay, and a second run takes those that are missing."""
    there = [view.name for view in read_record(folder)[1]]
    second = Exploration(folder, _explorer(), start=first.robot.true, resume=True)
    ended = second.run()
    names = [view.name for view in read_record(folder)[1]]
    assert ended.fault is None
    assert names[: len(there)] == there
    assert len(set(names)) == len(names) == VIEWS


@pytest.mark.slow
def test_a_door_that_is_closed_on_the_way_sends_it_to_another_view(tmp_path: Path) -> None:
    Exploration(tmp_path / "free", _explorer()).run()
    third = read_record(tmp_path / "free")[1][2].robot
    # Where the third view is to be taken from something stands.
    thing = third.x, third.y
    robot = Seeing(START, (Circle(*thing, THING),))
    shut = Exploration(tmp_path / "shut", _explorer(), robot, sees=True)
    ended = shut.run()
    assert (ended.taken, ended.fault) == (VIEWS, None)
    said = [line for line in shut.heard.lines if "is blocked at" in line]
    blocked = [line for line in log_of(tmp_path / "shut") if line.get("result") == "blocked"]
    assert len(blocked) == len(said) > 0
    gap = min(math.dist((p.x, p.y), thing) for p in robot.true_path) - THING
    assert gap > ROBOT.radius
    nearest = min(math.dist((p.x, p.y), TARGET[:2]) for p in robot.true_path)
    assert nearest > FORBIDDEN[0].radius


@pytest.mark.slow
def test_a_robot_that_is_walled_in_ends_with_the_reason(tmp_path: Path) -> None:
    robot = FakeRobot(START)
    # Whichever way it turns, something is right before it.
    robot.faults.append(
        lambda state: replace(
            state,
            sonars=tuple(
                SonarRange(i, 0.05, state.at, place) for i, place in enumerate(ROBOT.sonars)
            ),
        )
    )
    exploration = Exploration(tmp_path, _explorer(), robot, sees=True)
    ended = exploration.run()
    assert ended.taken == 0
    assert "clear its way" in str(ended.fault) or "can be reached" in exploration.stops.reason
    assert math.dist((robot.true.x, robot.true.y), (START.x, START.y)) < 0.05


@pytest.mark.parametrize("slip", [0.05, -0.05])
@pytest.mark.slow
def test_wheels_that_slip_by_a_twentieth_lose_no_view(tmp_path: Path, slip: float) -> None:
    exploration = Exploration(tmp_path, _explorer(), FakeRobot(START, odometry=(slip, slip)))
    ended = exploration.run()
    assert (ended.taken, ended.fault) == (VIEWS, None)
    assert len(read_record(tmp_path)[1]) == VIEWS


def test_a_head_that_is_lost_ends_it_and_it_goes_on_later(tmp_path: Path) -> None:
    exploration = Exploration(tmp_path, _explorer())
    look = exploration.head.look

    def lost(pan: float, tilt: float, timeout: float = 10.0) -> HeadState:
        if len(exploration.head.looks) == 3:
            raise DeviceTimeout("the head does not answer: check its cable and power")
        return look(pan, tilt, timeout)

    exploration.head.look = lost  # type: ignore[method-assign]
    ended = exploration.run()
    assert (ended.taken, str(ended.fault)[:24]) == (3, "the head does not answer")
    assert "go on with --resume --start" in exploration.heard.lines[-1]
    _goes_on(tmp_path, exploration)


@pytest.mark.parametrize("why", ["sent no picture for 10.0 s", "is frozen: the same to the pixel"])
@pytest.mark.slow
def test_a_camera_that_is_gone_or_frozen_ends_it_and_it_goes_on_later(
    tmp_path: Path, why: str
) -> None:
    exploration = Exploration(tmp_path, _explorer())
    shot = exploration.camera.shot

    def gone(after: float, timeout: float) -> Frame:
        if len(exploration.camera.shots) == 4:
            raise DeviceTimeout(why)
        return shot(after, timeout)

    exploration.camera.shot = gone  # type: ignore[method-assign]
    ended = exploration.run()
    assert (ended.taken, str(ended.fault)) == (4, why)
    assert exploration.robot.state.speed == 0.0
    _goes_on(tmp_path, exploration)


class Drained(FakeRobot):
    """A robot whose battery is low when it has driven for so long, s."""

    LASTS = 30.0

    def drive(self, speed: float, turning: float, lease: float = 0.3) -> None:
        if self.state.at > FakeState.at + self.LASTS:
            raise DeviceError("the battery is low (10.9 V, limit 11.0 V): charge it")
        super().drive(speed, turning, lease)


def test_a_low_battery_ends_it_with_its_voltage(tmp_path: Path) -> None:
    exploration = Exploration(tmp_path, _explorer(), Drained(START))
    ended = exploration.run()
    assert 0 < ended.taken < VIEWS
    assert str(ended.fault) == "the battery is low (10.9 V, limit 11.0 V): charge it"
    _goes_on(tmp_path, exploration)


def test_ctrl_c_while_it_drives_loses_nothing(tmp_path: Path) -> None:
    class Interrupted(FakeRobot):
        def wait_for(self, condition: Callable[[FakeState], bool], timeout: float) -> FakeState:
            if self.state.at > FakeState.at + Drained.LASTS:
                raise KeyboardInterrupt
            return super().wait_for(condition, timeout)

    exploration = Exploration(tmp_path, _explorer(), Interrupted(START))
    with pytest.raises(KeyboardInterrupt):
        exploration.run()
    assert 0 < len(read_record(tmp_path)[1]) < VIEWS
    assert log_of(tmp_path)[-1]["fault"] == "interrupted"
    assert exploration.robot.stops > 0
    _goes_on(tmp_path, exploration)


def test_ctrl_c_while_views_are_judged_loses_nothing(tmp_path: Path) -> None:
    def pressed(views: int) -> ViewVerdict:
        if views == 4:
            raise KeyboardInterrupt
        return all_open(views)

    exploration = Exploration(tmp_path, Explorer(judged(pressed), most=VIEWS))
    with pytest.raises(KeyboardInterrupt):
        exploration.run()
    assert len(read_record(tmp_path)[1]) == 4
    _goes_on(tmp_path, exploration)


def test_views_of_a_thing_that_was_moved_are_named_and_it_goes_on(tmp_path: Path) -> None:
    why = "view004.png contradicts the others: was something moved?"

    def moved(views: int) -> ViewVerdict:
        if views == 4:
            return ViewVerdict(views, fault=why)
        return ViewVerdict(views, needs=led(1.0)) if views > 5 else all_open(views)

    exploration = Exploration(tmp_path, Explorer(judged(moved), most=24))
    ended = exploration.run()
    assert (ended.taken, ended.fault) == (6, None)
    assert f"of 4 views: {why}" in exploration.heard.lines


@pytest.mark.slow
def test_a_view_that_was_chosen_again_is_not_judged_again(tmp_path: Path) -> None:
    asked: list[int] = []

    def count(views: int) -> ViewVerdict:
        asked.append(views)
        return all_open(views)

    free = Exploration(tmp_path / "free", _explorer())
    free.run()
    fifth: Taken = read_record(tmp_path / "free")[1][4]
    robot = Seeing(START, (Circle(fifth.robot.x, fifth.robot.y, THING),))
    shut = Exploration(tmp_path / "shut", Explorer(judged(count), most=VIEWS), robot, sees=True)
    assert shut.run().taken == VIEWS
    assert any("is blocked at" in line for line in shut.heard.lines)
    assert asked == sorted(set(asked))
    assert np.isfinite([view.covariance for view in shut.record.taken]).all()
