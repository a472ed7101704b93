"""`recognize --follow` and `recognise_stream`: a step for each view, and when no more is read."""

import json
import signal
import subprocess
import sys
from dataclasses import replace

import cv2
import numpy as np
import pytest

from facetlog.__main__ import INTERRUPTED
from facetlog.cli import main
from facetlog.degree_plot import Degrees, write_degree_plot
from facetlog.errors import InputError
from facetlog.kb.explaining.proof import State
from facetlog.perception.types import Pose
from facetlog.pipeline import open_models
from facetlog.robot.recording import Format
from facetlog.robot.rendering.views import simulate
from facetlog.robot.rendering.worlds import make_world
from facetlog.robot.tour import tour_camera, tour_poses
from facetlog.stream import Goal, Stop, recognise_stream
from tests.rendered import tour

UP = np.array([0.0, 0.0, 1.0])


def _block():
    """Views of a block, with how many were drawn."""
    drawn = []

    def views():
        for view in tour("block")[::2]:
            drawn.append(view.name)
            yield view

    return views(), drawn


@pytest.mark.slow
def test_no_view_is_drawn_once_the_goal_is_reached():
    views, drawn = _block()
    with open_models() as base:
        *steps, last = recognise_stream(
            views, up=UP, base=base, stop=Stop(until=Goal("box", 0.9)), polish=False
        )
    assert len(drawn) == len(steps) == last.used < 12
    assert [v.model for v in last.recognition.best] == ["box"]
    assert "box holds to 90%" in last.ended
    assert not any(Goal("box", 0.9).reached(s.recognition) for s in steps[2:-1])


@pytest.mark.slow
def test_what_no_view_has_looked_into_is_unknown_while_views_come():
    with open_models() as base:
        steps = list(recognise_stream(tour("table")[:10], up=UP, base=base, polish=False))
    known = [s.recognition for s in steps if s.recognition is not None]
    states = [v.state for found in known for v in found.verdicts if v.model == "table"]
    assert State.FAILS not in states
    assert states[0] is State.UNKNOWN
    assert states[-2] is State.HOLDS


@pytest.mark.slow
def test_a_view_that_turns_out_to_contradict_is_used_no_more():
    views = list(tour("block")[::2])
    about_up = cv2.Rodrigues(np.radians(4.0) * UP)[0]
    pose = views[5].pose
    wrong = replace(views[5], name="wrong.png", pose=Pose(about_up @ pose.rotation, pose.centre))
    with open_models() as base:
        *steps, last = recognise_stream(
            (*views[:7], wrong), up=UP, base=base, stop=Stop(max_views=8), polish=False
        )
    assert [step.used for step in steps] == [1, 2, 3, 4, 5, 6, 7, 7]
    assert "wrong.png" in steps[-1].problem
    assert any("wrong.png" in line for line in last.scene.warnings)
    assert last.ended == "there were no more views"


@pytest.mark.parametrize("text", ["table", "table > 90%", "table >= 900%", "Table >= 5%", ">= 9%"])
def test_a_goal_of_another_form_is_refused(text):
    with pytest.raises(InputError, match="table >= 90%"):
        Goal.parse(text)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("views") / "block"
    world = make_world("block", 0)
    simulate(made, world, tour_poses()[:9:2], tour_camera(), layout=Format.PAN_TILT)
    return made


def test_a_folder_is_followed_line_by_line_and_written(folder, tmp_path, capsys):
    code = main(
        ["recognize", str(folder), "--follow", "--timeout", "0.2", "-o", str(tmp_path / "o")]
    )
    out, err = capsys.readouterr()
    lines = out.splitlines()
    assert [line.split()[0] for line in lines[:5]] == ["1", "2", "3", "4", "5"]
    assert "sd ≤" in lines[4]
    assert lines[5].startswith("block: 5 views")
    assert "no new view came for 0.2 s" in err
    assert code == 0
    assert (tmp_path / "o" / "scene.json").is_file()
    plot = (tmp_path / "o" / "degrees.svg").read_text()
    assert "<svg" in plot


def _started(command):
    """A run that Ctrl-C reaches, also where whoever runs the tests in the background ignores it."""
    return subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
@pytest.mark.slow
def test_killed_it_leaves_nothing_and_interrupted_all_that_is_known(folder, tmp_path, how):
    out = tmp_path / "out"
    command = [sys.executable, "-m", "facetlog", "recognize", str(folder), "--follow"]
    with _started([*command, "-o", str(out)]) as run:
        lines = [run.stdout.readline() for _ in range(5)]
        run.send_signal(how)
        said, _ = run.communicate(timeout=60)
    assert lines[4].startswith("   5  ")
    if how is signal.SIGKILL:
        assert list(tmp_path.iterdir()) == []
    else:
        assert run.returncode == INTERRUPTED
        assert "t1 is a box" in said
        assert (out / "verdicts.json").is_file()


@pytest.mark.slow
def test_interrupted_its_json_ends_with_all_that_is_known(folder):
    command = [sys.executable, "-m", "facetlog", "recognize", str(folder), "--follow", "--json"]
    with _started(command) as run:
        for _ in range(5):
            run.stdout.readline()
        run.send_signal(signal.SIGINT)
        said, _ = run.communicate(timeout=60)
    last = json.loads(said.splitlines()[-1])
    assert last["ended"] == "interrupted"
    assert last["recognition"]["verdicts"]


def test_the_plot_has_a_line_for_each_model_that_ever_held_and_is_the_same_each_time(tmp_path):
    degrees = [
        Degrees(1, {}, None, True, False),
        Degrees(2, {"box": 0.4, "stairs": 0.2}, 0.03, True, False),
        Degrees(3, {"box": 0.9}, 0.01, True, False),
        Degrees(3, {"box": 1.0}, 0.002, True, True),
    ]
    first, second, empty = (tmp_path / f"{name}.svg" for name in "abc")
    write_degree_plot(first, degrees, "a block")
    write_degree_plot(second, degrees, "a block")
    write_degree_plot(empty, degrees[:1], "nothing")
    text = first.read_text()
    assert text == second.read_text()
    assert text.count(">box</text>") == text.count(">stairs</text>") == 1
    assert "no model matched" in empty.read_text()
    assert "no model matched" not in text


@pytest.mark.slow
def test_a_folder_with_odometry_is_polished_with_its_drift_put_right(tmp_path, capsys):
    world = make_world("block", 0)
    layout = Format.TRANSFORMS
    views = simulate(tmp_path / "v", world, tour_poses()[::3], tour_camera(), layout=layout)
    document = json.loads((tmp_path / "v" / "transforms.json").read_text())
    rng = np.random.default_rng(3)
    drift = np.zeros(3)
    for n, frame in enumerate(document["frames"]):
        drift += rng.normal(0, 0.15, 3)
        for axis in range(3):
            frame["transform_matrix"][axis][3] += drift[axis]
        frame["covariance"] = np.diag([0.0225 * n + 1e-6] * 3 + [1e-8] * 3).tolist()
    (tmp_path / "v" / "transforms.json").write_text(json.dumps(document))
    code = main(["recognize", str(tmp_path / "v"), "--follow", "--timeout", "0.1"])
    out, err = capsys.readouterr()
    assert len(views) == 8
    assert "poses were off by up to" in err
    assert code == 0
    assert "is a box (100%)" in out


def test_a_goal_that_no_model_can_reach_is_refused_before_the_first_view(folder, capsys):
    assert main(["recognize", str(folder), "--follow", "--until", "tabel >= 90%"]) == 2
    out, err = capsys.readouterr()
    assert "there is no model 'tabel'; did you mean table?" in err
    assert out == ""
