"""No error of collect or mount tells people to call a function."""

import json
import math
import re
from pathlib import Path

import pytest

from facetlog.cli import main
from facetlog.commands.robot_words import (
    COLLECT_AGAIN,
    MOUNT_AGAIN,
    early_end_line,
    worded,
    wording_errors,
)
from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.collecting import run
from facetlog.robot.collecting.plan import Plan
from facetlog.robot.collecting.request import Request
from facetlog.robot.collecting.run import Collected
from facetlog.robot.collecting.session import Ended, Listener
from facetlog.robot.head.canon_vcc4 import CanonVcC4
from facetlog.robot.pioneer.guard import MOTORS_OFF_TEXT
from facetlog.robot.pioneer.pioneer import Pioneer
from facetlog.robot.pose2 import Pose2
from tests.robot.head.simulated import Silence, SimulatedLine

CLEAR = "; then call clear_stop() to drive on"


@pytest.mark.parametrize(
    ("said", "shown"),
    [
        (MOTORS_OFF_TEXT, "motors are off: press the MOTORS button, then AGAIN"),
        (MOTORS_OFF_TEXT + CLEAR, "motors are off: press the MOTORS button, then AGAIN"),
        (
            f"STOP button pressed: pull it out, then call enable_motors(){CLEAR}",
            "STOP button pressed: pull it out, then AGAIN",
        ),
        ("pull it out, then switch the motors on", "pull it out, then AGAIN"),
        (f"wheel stalled: free the robot{CLEAR}", "wheel stalled: free the robot; then AGAIN"),
        ("free it, then go on with --resume", "free it, then AGAIN"),
        ("release it, then --resume", "release it, then AGAIN"),
        ("say what it is like with model= (p2dx)", "say what it is like with --model (p2dx)"),
        ("give baud=9600 to leave the rate", "give --baud 9600 to leave the rate"),
        ("the camera is frozen", "the camera is frozen"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("again", [COLLECT_AGAIN, MOUNT_AGAIN])
def test_what_to_do_is_said_in_options(said: str, shown: str, again: str) -> None:
    fault = worded(DeviceTimeout(said), again)
    assert isinstance(fault, DeviceTimeout)
    assert str(fault) == shown.replace("AGAIN", again)
    with pytest.raises(DeviceTimeout, match=re.escape(str(fault))), wording_errors(again):
        raise DeviceTimeout(said)


def test_a_silent_canon_head_is_told_with_its_option() -> None:
    line = SimulatedLine(Silence())
    head = CanonVcC4(line, answers=True, clock=line.clock)
    needed = pytest.raises(DeviceError, match=r"power.*CTS.* --head-unheard")
    with needed, wording_errors(COLLECT_AGAIN):
        head.start()


FAULT = DeviceError(MOTORS_OFF_TEXT)


def test_collect_says_what_to_do_before_and_on_the_way(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    argv = ["collect", "tcp:127.0.0.1:1", "--tour", "paper", "-o", str(tmp_path), "--json"]
    shown = "press the MOTORS button, then go on with --resume --start X,Y,HEADING_DEG"

    def fails(*_: object) -> Collected:
        raise FAULT

    monkeypatch.setattr(run, "run_collection", fails)
    assert main(argv) == 3
    assert shown in capsys.readouterr().err

    ended = Ended(0, 3, FAULT, Pose2(1.5, 0.25, math.radians(-251.6)), stands=True)

    def ends(_: Request, listener: Listener) -> Collected:
        listener.ended_early(ended, 0, 3)
        return Collected(Plan((), (), ()), ended, (), 0.0, 1.0)

    monkeypatch.setattr(run, "run_collection", ends)
    assert main(argv) == 3
    out, err = capsys.readouterr()
    shown = shown.replace("X,Y,HEADING_DEG", "1.500,0.250,108.4")
    # Once, and in one line.
    assert err.splitlines() == [
        f"facetlog: motors are off: {shown} (where it stands by odometry); 0 of 3 views are there"
    ]
    assert shown in json.loads(out)["fault"]


@pytest.mark.parametrize(
    ("ended", "line"),
    [
        (
            Ended(1, 3, DeviceTimeout("the head is silent: check its power"), Pose2(), stands=True),
            "the head is silent: check its power; go on with --resume --start 0.000,0.000,0.0 "
            "(where it stands by odometry); 1 of at most 24 views are there",
        ),
        (
            Ended(1, 3, DeviceError("the line is closed"), Pose2()),
            "the line is closed; go on with --resume --start 0.000,0.000,0.0 (where it was last "
            "heard, and may have gone on); 1 of at most 24 views are there",
        ),
        (
            Ended(1, 3),
            "1 of at most 24 views are there: go on with --resume --start X,Y,HEADING_DEG (where "
            "the robot stands)",
        ),
    ],
)
def test_an_early_end_is_one_line(ended: Ended, line: str) -> None:
    assert early_end_line(ended, 1, 24, most="at most ") == line


def test_who_explored_has_no_number_of_views_that_are_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    argv = ["collect", "tcp:127.0.0.1:1", "-o", str(tmp_path)]
    ended = Collected(Plan((), (), ()), Ended(0, 24, FAULT), (), 1.14, 9.6)
    monkeypatch.setattr(run, "run_collection", lambda *_: ended)
    assert main([*argv, "--explore", "--target", "1,2,0", "--keep-out", "0.5"]) == 3
    assert capsys.readouterr().out == "0 views, 1.1 m driven in 10 s, ended early\n"
    assert main([*argv, "--tour", "paper"]) == 3
    assert capsys.readouterr().out == "0 of 0 views, 1.1 m driven in 10 s, ended early\n"


def test_mount_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fails(*_: object, **__: object) -> Pioneer:
        raise FAULT

    monkeypatch.setattr(Pioneer, "connect", fails)
    argv = ["mount", "tcp:127.0.0.1:1", "--board", "7x5", "--square", "0.05", "--marker", "0.03"]
    assert main([*argv, "-o", str(tmp_path / "mount.toml")]) == 3
    assert "MOTORS button, then call facetlog mount again" in capsys.readouterr().err
