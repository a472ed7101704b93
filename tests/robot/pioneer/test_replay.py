"""A session's log, decoded again without the robot, gives the states that the driver had."""

import json
import time
from pathlib import Path

import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.robot.pioneer.connecting import Connected
from facetlog.robot.pioneer.guard import Cause
from facetlog.robot.pioneer.pioneer import Pioneer
from facetlog.robot.pioneer.replay import iter_replayed_states, replay
from facetlog.robot.pioneer.state import RobotState
from tests.robot.pioneer.scripted import ScriptedPort, ScriptedRobot

pytestmark = pytest.mark.usefixtures("quick")


def drive_and_log(
    path: Path,
    *,
    damage: float = 0.0,
    model: str | None = None,
    seconds: float = 0.5,
    robot: ScriptedRobot | None = None,
) -> list[RobotState]:
    """The states that a short drive had."""
    states: list[RobotState] = []
    port = ScriptedPort(robot or ScriptedRobot(), has_baud=True)
    with Pioneer.connect(port, model=model, log=path, baud=9600) as robot:
        states.append(robot.state)
        robot.enable_motors()
        port.damage = damage
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            robot.clear_stop()
            robot.drive(0.2, 0.3)
            if robot.state is not states[-1]:
                states.append(robot.state)
            time.sleep(0.03)
        port.damage = 0.0
    return states


@pytest.mark.parametrize("damage", [0.0, pytest.param(0.01, marks=pytest.mark.slow)])
def test_a_session_is_decoded_again_to_the_same_states(tmp_path: Path, damage: float) -> None:
    path = tmp_path / "traffic.jsonl"
    live = drive_and_log(path, damage=damage, model="p3at")
    found: list[Connected] = []
    again = {s.at: s for s in iter_replayed_states(replay(path), connected=found.append)}
    assert len(live) >= 3
    for state in live:
        assert again[state.at] == state
        assert np.array_equal(again[state.at].covariance, state.covariance)
    assert found[0].parameters.name == "p3at"
    assert found[0].names.name == "scripted"


def test_a_line_that_a_kill_cut_off_does_no_harm(tmp_path: Path) -> None:
    path = tmp_path / "traffic.jsonl"
    drive_and_log(path, seconds=0.2)
    count = len(list(iter_replayed_states(replay(path))))
    with path.open("ab") as file:
        file.write(b'{"at": 12.0, "direction": "in", "he')
    assert len(list(iter_replayed_states(replay(path)))) == count


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("nonsense", ":1: is no line"),
        ("[]", ":1: is no line"),
        ('{"at": 1.0, "direction": "in", "hex": "zz"}', ":1: is no line"),
        ('{"at": 1.0, "direction": "in", "hex": "00"}', ":1: is no line"),
        (
            json.dumps(
                {"at": 1, "schema": 9, "start": "", "serial": False, "model": None, "baud": None}
            ),
            "schema 9",
        ),
        ("", "no line"),
    ],
)
def test_a_file_that_is_no_log_is_the_users_matter(
    tmp_path: Path, line: str, expected: str
) -> None:
    path = tmp_path / "traffic.jsonl"
    path.write_text(line + "\n")
    with pytest.raises(InputError, match=expected):
        replay(path)


def test_a_log_on_a_full_disk_is_a_problem_and_the_robot_drives_on() -> None:
    with Pioneer.connect(ScriptedPort(ScriptedRobot()), log="/dev/full") as robot:
        robot.enable_motors()
        deadline = time.monotonic() + 20
        while robot.state.speed < 0.1 and time.monotonic() < deadline:
            robot.drive(0.2, 0.0)
            time.sleep(0.05)
        assert robot.state.speed >= 0.1
        (said,) = [p for p in robot.problems if p.cause is Cause.LOG]
        assert not said.stopped
        assert robot.halted is None
