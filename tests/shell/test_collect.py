"""`facetlog collect` and `facetlog mount`: what they refuse, in one line, before anything moves."""

import json
import os
import signal
import socket
import time
from pathlib import Path
from typing import cast

import numpy as np
import pytest

from facetlog.cli import main
from facetlog.commands.collect import _ProgressLines
from facetlog.commands.collect_options import recorded_goal
from facetlog.commands.robot_options import ended_by_signals
from facetlog.judging.view_verdicts import ViewVerdict, ViewVerdicts
from facetlog.perception.types import Pose
from facetlog.robot.camera.checks import Quality
from facetlog.robot.collecting.record import Taken
from facetlog.robot.pose2 import Pose2
from facetlog.stream import Goal

HEADER = "image,x,y,z,pan_deg,tilt_deg\n"
EXPLORE = ("--explore", "--target", "1,2,0", "--keep-out", "0.5")
CAMERA = "width = 640\nheight = 480\nfx = 500\nfy = 500\ncx = 319.5\ncy = 239.5\n"


def _refusal(capsys: pytest.CaptureFixture[str]) -> str:
    """What is said, with nothing on stdout."""
    out, err = capsys.readouterr()
    assert out == ""
    return err.splitlines()[-1]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--tour", "none.csv"], "tour none.csv is missing"),
        (["--tour", "paper", "--start", "1,2"], "--start '1,2': give X,Y,HEADING_DEG"),
        (["--tour", "paper", "--start", "1,2,east"], "give X,Y,HEADING_DEG"),
        (["--tour", "paper", "--speed", "0"], "--speed 0: give metres a second"),
        (["--tour", "paper", "--speed", "3"], "--speed 3: give metres a second"),
        (["--tour", "paper", "--keep-out", "1,2"], "give RADIUS, or X,Y,RADIUS"),
        (["--tour", "paper", "--keep-out", "-1"], "a radius is above 0"),
        (["--tour", "paper", "--keep-out", "1", "--keep-out", "2"], "each is X,Y,RADIUS"),
        (["--tour", "paper", "--resume"], "no collection to go on with: leave out --resume"),
        (["--tour", "paper", "--head-port", "aux9"], "--head-port 'aux9': give aux1, aux2 or aux3"),
        (["--tour", "paper", "--head-unheard"], "a sony-evi-d30 answers, leave it out"),
        (["--tour", "paper", "--mount", "none.toml"], "none.toml is missing"),
        (["--tour", "paper", "--camera-file", "none.toml"], "none.toml is missing"),
        (["--tour", "paper", "--unit", "yd"], "unknown unit 'yd'"),
        (["--tour", "paper", "--mcap", "a.bag"], "--mcap a.bag: give a file whose name ends in"),
        ([], "give --tour CSV, or --explore --target X,Y,Z --keep-out RADIUS"),
        (["--tour", "paper", "--until", "table >= 90%"], "--until goes with --explore"),
        (["--tour", "paper", "--target", "1,2,0"], "--target goes with --explore"),
        (["--tour", "paper", "--dry-run"], "--dry-run goes with --explore"),
        (["--explore", "--tour", "paper"], "--explore chooses the views itself: leave out --tour"),
        (["--explore", "--target", "1,2,0"], "--explore needs --keep-out RADIUS"),
        (["--explore"], "metres) and --keep-out RADIUS (how near the robot may come, metres)"),
        (["--explore", "--keep-out", "0.5"], "--explore needs --target X,Y,Z"),
        ([*EXPLORE, "--target", "1,2"], "--target '1,2': give X,Y,Z (metres)"),
        ([*EXPLORE, "--until", "table"], "--until 'table': give a model and a degree"),
        ([*EXPLORE, "--until", "tabel >= 90%"], "--until: there is no model 'tabel'"),
        ([*EXPLORE, "--max-views", "2"], "--max-views 2: a face needs 3 views or more"),
        ([*EXPLORE, "--dry-run"], "holds no collection: --dry-run goes on from one"),
    ],
)
@pytest.mark.slow
def test_options_that_cannot_be_are_refused(
    options: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "views"
    assert main(["collect", "tcp:127.0.0.1:1", "-o", str(out), *options]) == 2
    assert said in _refusal(capsys)
    assert not out.exists()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--board", "7", "--square", "0.04", "--marker", "0.03"], "give COLUMNSxROWS"),
        (["--board", "7x5", "--square", "0", "--marker", "0.03"], "--square 0: give metres"),
        (["--board", "7x5", "--square", "0.04", "--marker", "0.05"], "markers are smaller"),
    ],
)
def test_boards_that_cannot_be_are_refused(
    options: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    argv = ["mount", "tcp:127.0.0.1:1", "-o", str(tmp_path / "mount.toml"), *options]
    assert main(argv) == 2
    assert said in _refusal(capsys)


def test_a_robot_that_is_not_there_is_complained_of_before_its_camera(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for options in ([], ["--camera", "http://10.0.0.7/"]):
        argv = ["collect", "/dev/nonexistent", "--tour", "paper", "-o", str(tmp_path / "out")]
        assert main([*argv, *options]) == 3
        assert "/dev/nonexistent: there is no such port" in _refusal(capsys)


def test_a_folder_with_something_else_in_it_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
    assert main(["collect", "tcp:127.0.0.1:1", "--tour", "paper", "-o", str(tmp_path)]) == 2
    assert "holds notes.txt: give an empty folder with -o" in _refusal(capsys)


def test_a_collection_is_not_overwritten(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = {"schema": "facetlog-collect/1", "tour": "paper"}
    (tmp_path / "collect.jsonl").write_text(json.dumps(log) + "\n", encoding="utf-8")
    argv = ["collect", "tcp:127.0.0.1:1", "--tour", "paper", "-o", str(tmp_path)]
    assert main(argv) == 2
    assert "go on with it by --resume" in _refusal(capsys)
    tour = tmp_path / "other.csv"
    tour.write_text(HEADER + "a,0,0,700,0,-100\n", encoding="utf-8")
    options = ["--unit", "mm", "-o", str(tmp_path), "--resume", "--start", "0,0,0"]
    assert main(["collect", "tcp:127.0.0.1:1", "--tour", str(tour), *options]) == 2
    assert "was collected for tour 'paper'" in _refusal(capsys)


def test_the_goal_of_a_folder_is_that_of_its_last_run(tmp_path: Path) -> None:
    begun: dict[str, object] = {"schema": "facetlog-collect/1", "tour": "explore 1,2,0"}
    runs = [{**begun, "until": "table >= 90%"}, {"result": "ended", "taken": 0}]
    for lines, goal in ((runs, Goal("table", 0.9)), ([*runs, begun], None)):
        text = "".join(json.dumps(line) + "\n" for line in lines)
        (tmp_path / "collect.jsonl").write_text(text, encoding="utf-8")
        assert recorded_goal(tmp_path) == goal


def test_the_place_where_a_collection_ended_is_told_to_who_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = [
        {"schema": "facetlog-collect/1", "tour": "paper"},
        {"result": "ended", "taken": 0, "robot": [1.5, 0.25, 90.0]},
    ]
    text = "".join(json.dumps(line) + "\n" for line in log)
    (tmp_path / "collect.jsonl").write_text(text, encoding="utf-8")
    argv = ["collect", "tcp:127.0.0.1:1", "--tour", "paper", "-o", str(tmp_path), "--resume"]
    assert main(argv) == 2
    assert "(where it ended it was 1.500,0.250,90.0)" in _refusal(capsys)


def test_where_a_killed_run_was_to_go_is_not_told_as_where_it_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = [
        {"schema": "facetlog-collect/1", "tour": "explore 1,2,0", "start": [0.0, 0.0, 0.0]},
        {"result": "chosen", "image": "view001.png", "robot": [1.5, 0.25, -251.6]},
    ]
    text = "".join(json.dumps(line) + "\n" for line in log)
    (tmp_path / "collect.jsonl").write_text(text, encoding="utf-8")
    argv = ["collect", "tcp:127.0.0.1:1", *EXPLORE, "-o", str(tmp_path), "--resume"]
    assert main(argv) == 2
    assert _refusal(capsys).endswith("(where it stood last is not recorded: measure it)")


def test_the_camera_and_its_unit_are_taken_from_beside_the_tour(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tour = tmp_path / "tour.csv"
    tour.write_text(HEADER + "a,0,0,700,0,-100\nb,900,0,700,20,-100\n", encoding="utf-8")
    argv = ["collect", _nobody(), "--tour", str(tour), "-o", str(tmp_path / "out")]
    assert main(argv) == 2
    assert "its unit of length is unknown" in _refusal(capsys)
    (tmp_path / "camera.toml").write_text(CAMERA + 'unit = "mm"\n', encoding="utf-8")
    assert main(argv) == 3
    (tmp_path / "camera.toml").write_text("width = 640\n", encoding="utf-8")
    assert main(argv) == 2
    assert "camera.toml" in _refusal(capsys)


def test_a_recording_among_the_views_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "views"
    argv = ["collect", "tcp:127.0.0.1:1", "--tour", "paper", "-o", str(out)]
    assert main([*argv, "--mcap", str(out / "a.mcap")]) == 2
    assert "is in the folder of the views: put it beside" in _refusal(capsys)


def test_a_robot_that_is_not_there_ends_with_3(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    address = _nobody()
    assert main(["collect", address, "--tour", "paper", "-o", str(tmp_path / "out")]) == 3
    assert address.removeprefix("tcp:") in _refusal(capsys)


def _nobody() -> str:
    """An address at which nobody listens."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    return f"tcp:127.0.0.1:{port}"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGTSTP])
def test_what_would_end_or_halt_the_program_is_an_interrupt(number: signal.Signals) -> None:
    before = signal.getsignal(number)
    with pytest.raises(KeyboardInterrupt):
        _signalled(number)
    assert signal.getsignal(number) is before


def _signalled(number: signal.Signals) -> None:
    with ended_by_signals():
        # Where nothing catches it, SIGTSTP would put the tests to sleep, not fail them.
        assert signal.getsignal(number) is not signal.SIG_DFL
        os.kill(os.getpid(), number)
        time.sleep(5.0)


def test_a_verdict_is_one_line() -> None:
    verdict = ViewVerdict(5, ("t1 is a box (99%)",), ("table", "chair"), ("stairs",))
    assert verdict.line == "t1 is a box (99%); unknown: stairs; no: table, chair"
    many = ViewVerdict(5, unknown=tuple("abcdef"), excluded=("table", "chair", "desk", "stool"))
    assert many.line == (
        "no model matches; unknown: a, b, c and 3 more; no: table, chair, desk and 1 more"
    )
    assert ViewVerdict(2).line == "no model matches"
    assert ViewVerdict(2, fault="poses contradict").line == "poses contradict"


class Judge:
    """Judges, and takes its time: a verdict is there when somebody waits for it."""

    def __init__(self) -> None:
        self.asked: list[int] = []

    def ask(self, views: int) -> None:
        self.asked.append(views)

    def last(self) -> list[ViewVerdict]:
        asked, self.asked = self.asked, []
        return [ViewVerdict(views, ("t1 is a box (99%)",)) for views in asked]


def test_what_is_said_is_never_more_than_one_view_behind(
    capsys: pytest.CaptureFixture[str],
) -> None:
    lines = _ProgressLines(cast(ViewVerdicts, Judge()))
    for number in range(1, 6):
        lines.view_taken(number, 5, view(number))
        said = [line for line in capsys.readouterr().err.splitlines() if "is a box" in line]
        judged = [f"facetlog: of {number - 1} views: t1 is a box (99%)"]
        assert said == (judged if number > 2 else [])


def view(number: int) -> Taken:
    pose = Pose(np.eye(3), np.zeros(3))
    place, quality = Pose2(), Quality(1.0, 1.0, 0.0)
    return Taken(number, f"{number}.png", pose, np.eye(6), place, place, 0.0, 0.0, 0, 1.0, quality)
