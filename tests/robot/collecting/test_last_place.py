"""Where a collection left its robot, whatever ended it."""

import json
import math
import time
from pathlib import Path

from facetlog.robot.collecting.option_words import format_start_pose
from facetlog.robot.collecting.record import LOG_FILE
from facetlog.robot.collecting.request import TRAFFIC_FILE
from facetlog.robot.collecting.run_sessions import last_place
from facetlog.robot.pioneer.pioneer import Pioneer
from facetlog.robot.pioneer.state import RobotState
from facetlog.robot.pose2 import Pose2
from tests.robot.pioneer.scripted import ScriptedPort, ScriptedRobot

START = Pose2(2.0, 3.0, math.pi / 2)
TO_GO = [1.5, 0.25, -251.6]


def _log(folder: Path, began: float, *lines: dict[str, object]) -> None:
    start = [START.x, START.y, math.degrees(START.heading)]
    run = {"schema": "facetlog-collect/1", "tour": "paper", "start": start, "began": began}
    text = "".join(json.dumps(line) + "\n" for line in (run, *lines))
    (folder / LOG_FILE).write_text(text, encoding="utf-8")


def _driven(folder: Path) -> tuple[float, RobotState]:
    """When a run began whose robot was driving when all was cut off, and its last state."""
    log = folder / TRAFFIC_FILE
    with Pioneer.connect(ScriptedPort(ScriptedRobot()), log=log) as robot:
        began = time.time()
        robot.enable_motors()
        robot.drive(0.2, 0.0)
        there = robot.wait_for(lambda state: state.speed > 0.1 and state.pose.x > 0.02, 5.0)
        robot.drive(0.2, 0.0)
    lines = log.read_bytes().splitlines(keepends=True)
    kept = [line for line in lines if json.loads(line)["at"] <= there.at]
    log.write_bytes(b"".join(kept) + b'{"at": 1')
    return began, there


def test_a_run_that_was_killed_left_it_where_it_was_last_heard(tmp_path: Path) -> None:
    began, state = _driven(tmp_path)
    _log(tmp_path, began, {"result": "chosen", "robot": TO_GO})
    last = last_place(tmp_path)
    assert last is not None
    assert last.pose == START.compose(state.pose)
    assert last.how == f"when it was last heard it went at {state.speed:.2f} m/s, at"
    # A session from before the run is that of another one.
    _log(tmp_path, began - 3600.0, {"result": "chosen", "robot": TO_GO})
    assert last_place(tmp_path) is None


def test_a_run_that_ended_says_where_it_stands(tmp_path: Path) -> None:
    began, _ = _driven(tmp_path)
    _log(tmp_path, began, {"result": "ended", "robot": [1.5, 0.25, 90.0]})
    last = last_place(tmp_path)
    assert last is not None
    assert (last.how, format_start_pose(last.pose)) == ("where it ended it was", "1.500,0.250,90.0")
