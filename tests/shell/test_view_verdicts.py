"""Verdicts on a folder of views that grows, from a process of their own."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from facetlog.exploring.open_questions import Interest
from facetlog.judging.view_verdicts import ViewVerdicts
from facetlog.perception.types import Pose, View
from facetlog.robot.recording import Format, write_views
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.worlds import BLOCK_CENTRE, INCH, make_world
from facetlog.robot.tour import tour_camera, tour_poses

pytestmark = pytest.mark.slow


def _folder(folder: Path, count: int) -> Path:
    """The paper's block from the first and every third pose, in metres, with z up."""
    poses = tour_poses()[::3][:count]
    views = views_of(make_world("block", 0), poses, tour_camera())
    metric = [
        View(v.name, v.image, v.camera, Pose(v.pose.rotation, v.pose.centre * INCH)) for v in views
    ]
    write_views(folder, metric, layout=Format.TRANSFORMS)
    path = folder / "transforms.json"
    told = {"unit": "m", "up": [0, 0, 1], **json.loads(path.read_text(encoding="utf-8"))}
    path.write_text(json.dumps(told), encoding="utf-8")
    return folder


def test_each_question_is_about_the_views_of_its_time(tmp_path):
    with ViewVerdicts(_folder(tmp_path, 8)) as verdicts:
        verdicts.ask(2)
        (few,) = verdicts.last()
        verdicts.ask(8, finally_=True)
        (all_,) = verdicts.last()
    assert few.best == ()
    assert all_.best[0].startswith("t1 is a box (")
    assert "no: " in all_.line
    assert all_.document is not None


def test_what_is_undecided_of_a_target_comes_with_the_verdict(tmp_path):
    target = np.array([*BLOCK_CENTRE, 3.0]) * INCH
    places = np.array([pose.centre for pose in tour_poses()[::3][:8]]) * INCH
    with ViewVerdicts(_folder(tmp_path, 8)) as verdicts:
        found = verdicts.explored(8, Interest(target, 1.0, places))
        missed = verdicts.explored(8, Interest(target + 5.0, 1.0, places))
    assert found.needs is not None
    assert found.needs.lead is not None
    assert found.needs.lead.model == "box"
    assert [thing.name for thing in found.needs.things] == ["t1"]
    # No thing stands there: what is there is open.
    assert missed.needs is not None
    assert [each.model for each in missed.needs.open] == [""]


KILLED = """
import sys, time
from pathlib import Path
from facetlog.judging.view_verdicts import ViewVerdicts
if __name__ == "__main__":
    with ViewVerdicts(Path(sys.argv[1])) as verdicts:
        verdicts.ask(3)
        verdicts.last()
        verdicts.ask(3)
        print(verdicts.process, flush=True)
        time.sleep(1000)
"""


def test_the_process_that_judges_ends_with_one_that_is_killed_without_a_word(tmp_path):
    script = tmp_path / "judging.py"
    script.write_text(KILLED, encoding="utf-8")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    arguments = [sys.executable, str(script), str(tmp_path / "nothing")]
    pipe = subprocess.PIPE
    with subprocess.Popen(arguments, env=environment, stdout=pipe, stderr=pipe) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        judge = int(process.stdout.readline())
        process.kill()
        # It is at its end when all processes that may write there are gone.
        assert process.stderr.read() == b""
    deadline = time.monotonic() + 20.0
    while _runs(judge):
        assert time.monotonic() < deadline, "it goes on"
        time.sleep(0.05)


def test_that_the_process_that_judges_was_killed_is_said_once(tmp_path):
    with ViewVerdicts(_folder(tmp_path, 3)) as verdicts:
        os.kill(verdicts.process, signal.SIGKILL)
        verdicts.ask(3)
        (answer,) = verdicts.last()
        assert answer.line == "the process that judges views has died: no more verdicts"
        verdicts.ask(3)
        assert verdicts.last() == []
        assert not verdicts.explored(3, Interest(np.zeros(3), 1.0, np.zeros((3, 3)))).views


def _runs(process: int) -> bool:
    """Whether it is there, and not only waits to be asked how it ended."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False
