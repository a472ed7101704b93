"""No error of collect or mount tells people to call a function."""

import json
import re
from pathlib import Path

import pytest

from facetlog.cli import main
from facetlog.commands.robot_words import COLLECT_AGAIN, MOUNT_AGAIN, worded, wording_errors
from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.collecting import run
from facetlog.robot.collecting.plan import Plan
from facetlog.robot.collecting.run import Collected
from facetlog.robot.collecting.session import Ended
from facetlog.robot.head.canon_vcc4 import CanonVcC4
from facetlog.robot.pioneer.guard import MOTORS_OFF_TEXT
from facetlog.robot.pioneer.pioneer import Pioneer
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

    ended = Collected(Plan((), (), ()), Ended(0, 3, FAULT), (), 0.0, 1.0)
    monkeypatch.setattr(run, "run_collection", lambda *_: ended)
    assert main(argv) == 3
    out, err = capsys.readouterr()
    assert shown in err
    assert shown in json.loads(out)["fault"]


def test_mount_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fails(*_: object, **__: object) -> Pioneer:
        raise FAULT

    monkeypatch.setattr(Pioneer, "connect", fails)
    argv = ["mount", "tcp:127.0.0.1:1", "--board", "7x5", "--square", "0.05", "--marker", "0.03"]
    assert main([*argv, "-o", str(tmp_path / "mount.toml")]) == 3
    assert "MOTORS button, then call facetlog mount again" in capsys.readouterr().err
