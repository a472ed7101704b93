"""What may happen to a robot that explores: it ends or goes on with one line, and loses nothing."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from facetlog.errors import DeviceTimeout
from facetlog.exploring.explorer import Explorer
from facetlog.robot.collecting.record import read_record
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


def test_ctrl_c_while_it_drives_loses_nothing(tmp_path: Path) -> None:
    class Interrupted(FakeRobot):
        def wait_for(self, condition: Callable[[FakeState], bool], timeout: float) -> FakeState:
            if self.state.at > FakeState.at + 30.0:
                raise KeyboardInterrupt
            return super().wait_for(condition, timeout)

    exploration = Exploration(tmp_path, _explorer(), Interrupted(START))
    with pytest.raises(KeyboardInterrupt):
        exploration.run()
    assert 0 < len(read_record(tmp_path)[1]) < VIEWS
    assert log_of(tmp_path)[-1]["fault"] == "interrupted"
    assert exploration.robot.stops > 0
    _goes_on(tmp_path, exploration)
