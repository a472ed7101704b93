"""`facetlog collect` and `facetlog mount`: what they refuse, in one line, before anything moves."""

import json
import os
import signal
import socket
import time
from typing import cast

import numpy as np
import pytest

from facetlog.commands.collect import _ProgressLines, read_recorded_goal
from facetlog.commands.robot_options import end_at_signals
from facetlog.judging.view_verdicts import ViewVerdict, ViewVerdicts
from facetlog.perception.types import Pose
from facetlog.robot.camera.checks import Quality
from facetlog.robot.collecting.record import Taken
from facetlog.robot.pose2 import Pose2
from facetlog.stream import Goal

HEADER = "image,x,y,z,pan_deg,tilt_deg\n"
EXPLORE = ("--explore", "--target", "1,2,0", "--keep-out", "0.5")
CAMERA = "width = 640\nheight = 480\nfx = 500\nfy = 500\ncx = 319.5\ncy = 239.5\n"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--tour", "none.csv"], "tour none.csv is missing"),
        (["--tour", "paper", "--start", "1,2"], "--start '1,2': give X,Y,HEADING_DEG"),
        (["--tour", "paper", "--speed", "3"], "--speed 3: give metres a second"),
        (["--tour", "paper", "--keep-out", "1,2"], "give RADIUS, or X,Y,RADIUS"),
        (["--tour", "paper", "--resume"], "no collection to go on with: leave out --resume"),
        (["--tour", "paper", "--head-port", "aux9"], "--head-port 'aux9': give aux1, aux2 or aux3"),
        (["--tour", "paper", "--head-unheard"], "a sony-evi-d30 answers, leave it out"),
        (["--tour", "paper", "--unit", "yd"], "unknown unit 'yd'"),
        (["--tour", "paper", "--mcap", "a.bag"], "--mcap a.bag: give a file whose name ends in"),
        ([], "give --tour CSV, or --explore --target X,Y,Z --keep-out RADIUS"),
        (["--tour", "paper", "--until", "table >= 90%"], "--until goes with --explore"),
        (["--explore", "--tour", "paper"], "--explore chooses the views itself: leave out --tour"),
        (["--explore", "--target", "1,2,0"], "--explore needs --keep-out RADIUS"),
        ([*EXPLORE, "--until", "table"], "--until 'table': give a model and a degree"),
        ([*EXPLORE, "--until", "tabel >= 90%"], "--until: there is no model 'tabel'"),
        ([*EXPLORE, "--dry-run"], "holds no collection: --dry-run goes on from one"),
    ],
)
@pytest.mark.slow
def test_options_that_cannot_be_are_refused(options, said, refused, tmp_path):
    assert said in refused("collect", "tcp:127.0.0.1:1", "-o", "views", *options)
    assert not (tmp_path / "views").exists()


def test_a_missing_robot_is_reported_before_its_camera(run):
    for options in ([], ["--camera", "http://10.0.0.7/"]):
        argv = ["collect", "/dev/nonexistent", "--tour", "paper", "-o", "out"]
        code, out, err = run(*argv, *options)
        assert (code, out) == (3, "")
        assert "/dev/nonexistent: there is no such port" in err


BEGUN = {"schema": "facetlog-collect/1", "tour": "paper"}


@pytest.fixture
def log(tmp_path):
    """Return a function that writes the log of a collection in `views`."""

    def write(*lines):
        (tmp_path / "views").mkdir(exist_ok=True)
        text = "".join(json.dumps(line) + "\n" for line in lines)
        (tmp_path / "views" / "collect.jsonl").write_text(text, encoding="utf-8")

    return write


def test_a_collection_is_neither_overwritten_nor_mixed(refused, log, tmp_path):
    log(BEGUN)
    command = ["collect", "tcp:127.0.0.1:1", "-o", "views", "--tour"]
    assert "go on with it by --resume" in refused(*command, "paper")
    (tmp_path / "other.csv").write_text(HEADER + "a,0,0,700,0,-100\n", encoding="utf-8")
    options = ["other.csv", "--unit", "mm", "--resume", "--start", "0,0,0"]
    assert "was collected for tour 'paper'" in refused(*command, *options)


def test_the_goal_of_a_folder_is_that_of_its_last_run(log, tmp_path):
    runs = [{**BEGUN, "until": "table >= 90%"}, {"result": "ended", "taken": 0}]
    for lines, goal in ((runs, Goal("table", 0.9)), ([*runs, BEGUN], None)):
        log(*lines)
        assert read_recorded_goal(tmp_path / "views") == goal


@pytest.mark.parametrize(
    ("last", "place"),
    [
        (
            {"result": "ended", "taken": 0, "robot": [1.5, 0.25, 90.0]},
            "(where it ended it was 1.500,0.250,90.0)",
        ),
        # Where a killed run was to go is not where it is.
        (
            {"result": "chosen", "image": "view001.png", "robot": [1.5, 0.25, -251.6]},
            "(where it stood last is not recorded: measure it)",
        ),
    ],
)
def test_resuming_needs_the_place_and_says_where_it_was_last(last, place, refused, log):
    log({**BEGUN, "start": [0.0, 0.0, 0.0]}, last)
    assert place in refused(
        "collect", "tcp:127.0.0.1:1", "--tour", "paper", "-o", "views", "--resume"
    )


def test_the_camera_and_its_unit_are_taken_from_beside_the_tour(run, tmp_path):
    (tmp_path / "tour.csv").write_text(HEADER + "a,0,0,700,0,-100\nb,900,0,700,20,-100\n")
    argv = ["collect", _nobody(), "--tour", "tour.csv", "-o", "out"]
    for camera, code, said in (
        (None, 2, "its unit of length is unknown"),
        (CAMERA + 'unit = "mm"\n', 3, ""),
        ("width = 640\n", 2, "camera.toml"),
    ):
        if camera is not None:
            (tmp_path / "camera.toml").write_text(camera, encoding="utf-8")
        found, out, err = run(*argv)
        assert (found, out) == (code, "")
        assert said in err


def _nobody() -> str:
    """An address at which nobody listens."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    return f"tcp:127.0.0.1:{port}"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGTSTP])
def test_what_would_end_or_halt_the_program_is_an_interrupt(number):
    before = signal.getsignal(number)
    with pytest.raises(KeyboardInterrupt):
        _signalled(number)
    assert signal.getsignal(number) is before


def _signalled(number: signal.Signals) -> None:
    with end_at_signals():
        # Where nothing catches it, SIGTSTP would put the tests to sleep, not fail them.
        assert signal.getsignal(number) is not signal.SIG_DFL
        os.kill(os.getpid(), number)
        time.sleep(5.0)


def test_a_verdict_is_one_line():
    models = ("table", "chair", "desk", "stool")
    verdict = ViewVerdict(5, ("t1 is a box (99%)",), models, ("stairs",))
    assert verdict.line == "t1 is a box (99%); unknown: stairs; no: table, chair, desk and 1 more"
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


def test_what_is_said_is_never_more_than_one_view_behind(capsys):
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
