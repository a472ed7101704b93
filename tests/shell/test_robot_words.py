"""No error of collect or mount tells people to call a function."""

import json
import math
import re

import pytest

from facetlog.cli import main
from facetlog.commands.robot_words import (
    COLLECT_AGAIN,
    MOUNT_AGAIN,
    format_early_end,
    reword_errors,
)
from facetlog.errors import DeviceError, DeviceTimeout, InputError
from facetlog.robot.collecting import run
from facetlog.robot.collecting.drive import MobileBase
from facetlog.robot.collecting.option_words import worded
from facetlog.robot.collecting.plan import Plan
from facetlog.robot.collecting.record import Record
from facetlog.robot.collecting.request import Request
from facetlog.robot.collecting.run import Collected
from facetlog.robot.collecting.session import Ended, Listener, Rig, record_end
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.pioneer.guard import MOTORS_OFF_TEXT
from facetlog.robot.pioneer.pioneer import Pioneer
from facetlog.robot.pose2 import Pose2
from tests.exploring.explorations import OPTICS, REACH, picture
from tests.robot.collecting.fakes import FakeCamera, FakeHead, FakeRobot


def make_rig(place: Pose2) -> Rig:
    """A robot that stands there, with all that belongs to it."""
    robot = FakeRobot(place)
    head = FakeHead(robot)
    base = MobileBase(robot, place, pace=Pace())
    return Rig(base, head, FakeCamera(robot, head, picture), OPTICS, REACH, 0.0)


CLEAR = "; then call clear_stop() to drive on"


@pytest.mark.parametrize(
    ("said", "shown"),
    [
        (MOTORS_OFF_TEXT + CLEAR, "motors are off: press the MOTORS button, then AGAIN"),
        (f"wheel stalled: free the robot{CLEAR}", "wheel stalled: free the robot; then AGAIN"),
        (
            "press the MOTORS button or call enable_motors(); see that the STOP button is out; "
            "then go on with --resume",
            "press the MOTORS button; see that the STOP button is out; then AGAIN",
        ),
        ("release it, then --resume", "release it, then AGAIN"),
        ("give baud=9600 to leave the rate", "give --baud 9600 to leave the rate"),
        ("the camera is frozen", "the camera is frozen"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("again", [COLLECT_AGAIN, MOUNT_AGAIN])
def test_what_to_do_is_said_in_options(said, shown, again):
    fault = worded(DeviceTimeout(said), again)
    assert isinstance(fault, DeviceTimeout)
    assert str(fault) == shown.replace("AGAIN", again)
    assert str(worded(fault, again)) == str(fault)
    with pytest.raises(DeviceTimeout, match=re.escape(str(fault))), reword_errors(again):
        raise DeviceTimeout(said)


FAULT = DeviceError(MOTORS_OFF_TEXT)


def test_collect_says_what_to_do_before_and_on_the_way(tmp_path, monkeypatch, capsys):
    argv = ["collect", "tcp:127.0.0.1:1", "--tour", "paper", "-o", str(tmp_path), "--json"]
    shown = "press the MOTORS button, then go on with --resume --start X,Y,HEADING_DEG"

    def fails(*_: object) -> Collected:
        raise FAULT

    monkeypatch.setattr(run, "run_collection", fails)
    assert main(argv) == 3
    assert shown in capsys.readouterr().err

    again = "go on with --resume --start 1.500,0.250,108.4"
    stands = Pose2(1.5, 0.25, math.radians(-251.6))
    ended = Ended(0, 3, worded(FAULT, again), stands, stands=True)

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
            Ended(1, 3, DeviceError("the line is closed"), Pose2()),
            "the line is closed; go on with --resume --start 0.000,0.000,0.0 (where it was last "
            "heard, and may have gone on); 1 of at most 24 views are there",
        ),
        (
            Ended(
                1,
                3,
                InputError("no room: make room, then go on with --resume --start 0.000,0.000,0.0"),
                Pose2(),
            ),
            "no room: make room, then go on with --resume --start 0.000,0.000,0.0 (where it was "
            "last heard, and may have gone on); 1 of at most 24 views are there",
        ),
    ],
)
def test_an_early_end_is_one_line(ended, line):
    assert format_early_end(ended, 1, 24, most="at most ") == line


@pytest.mark.parametrize(
    ("raised", "why", "code"),
    [
        (KeyboardInterrupt(), "interrupted", 130),
        (InputError("view002.png: the disk is full"), "view002.png: the disk is full", 2),
        (FAULT, "motors are off: press the MOTORS button, then", 3),
    ],
)
def test_what_is_raised_on_the_way_is_said_once_in_the_last_line(
    tmp_path, monkeypatch, capsys, raised, why, code
):
    def collects(_: Request, listener: Listener) -> Collected:
        record = Record(tmp_path, OPTICS, {})
        with record_end(make_rig(Pose2(1.5, 0.25)), 3, record, listener):
            raise raised

    monkeypatch.setattr(run, "run_collection", collects)
    argv = ["collect", "tcp:127.0.0.1:1", "--tour", "paper", "-o", str(tmp_path)]
    assert main(argv) == code
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"facetlog: {why}")
    assert line.endswith(
        "go on with --resume --start 1.500,0.250,0.0 (where it stands by odometry); "
        "0 of 3 views are there"
    )
    # The log has it in the same words.
    recorded = json.loads((tmp_path / "collect.jsonl").read_text().splitlines()[-1])["fault"]
    assert line.startswith(f"facetlog: {recorded}")


def test_mount_says_what_to_do(tmp_path, monkeypatch, capsys):
    def fails(*_: object, **__: object) -> Pioneer:
        raise FAULT

    monkeypatch.setattr(Pioneer, "connect", fails)
    argv = ["mount", "tcp:127.0.0.1:1", "--board", "7x5", "--square", "0.05", "--marker", "0.03"]
    assert main([*argv, "-o", str(tmp_path / "mount.toml")]) == 3
    assert "MOTORS button, then call facetlog mount again" in capsys.readouterr().err
