"""The command line: exit codes, one-line errors, and what goes to which stream."""

import json
import logging
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from facetlog import __version__
from facetlog.cli import main
from facetlog.perception.reading.read_views import ViewSet
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.mesh_export import write_mesh
from facetlog.perception.surfaces.scene_file import read_scene, write_scene


def _views(folder: Path, count: int = 3, *, levels: tuple[int, int] = (60, 120)) -> Path:
    """Pictures of a ramp of grey between two levels, without an edge."""
    picture = np.tile(np.linspace(*levels, 64), (48, 1)).astype(np.uint8)
    frames = []
    (folder / "images").mkdir(parents=True)
    for i in range(count):
        matrix = np.eye(4)
        matrix[0, 3] = i
        frames.append({"file_path": f"images/{i}.png", "transform_matrix": matrix.tolist()})
        cv2.imwrite(str(folder / "images" / f"{i}.png"), picture)
    camera = {"fl_x": 60, "fl_y": 60, "cx": 32, "cy": 24, "w": 64, "h": 48}
    (folder / "transforms.json").write_text(json.dumps({**camera, "frames": frames}))
    return folder


def _refusal(capsys: pytest.CaptureFixture[str]) -> str:
    """The one line on stderr, with nothing on stdout."""
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("facetlog: ")
    assert err.count("\n") == 1
    return err


def test_the_version_is_a_result(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr() == (f"facetlog {__version__}\n", "")


@pytest.mark.parametrize("argv", [["bogus"], ["recognize"], ["reconstruct", "x"], ["demo", "-x"]])
def test_wrong_usage_ends_with_2(argv, capsys):
    assert main(argv) == 2
    assert capsys.readouterr().out == ""


@pytest.mark.slow
def test_the_demo_judges_by_models_of_ones_own(tmp_path, monkeypatch, capsys):
    scene = cuboid()
    views = ViewSet("block", ())
    monkeypatch.setattr(
        "facetlog.commands.recognize.render_simulated_views", lambda *_, **__: views
    )
    monkeypatch.setattr("facetlog.pipeline.reconstruct_views", lambda *_, **__: scene)
    model = tmp_path / "thing_with_faces.pl"
    model.write_text(
        ":- module(thing_with_faces, []).\n"
        ":- use_module(facetlog(vocabulary)).\n"
        'model(thing_with_faces, "Anything that has a face.", [face]).\n'
        "candidate(thing_with_faces, Thing, [Face]) :- face_of(Thing, Face).\n"
        'condition(thing_with_faces, seen, "it was seen", _, [Face], measured(Face)).\n'
    )
    assert main(["demo", "--raw", "--trust", "--models", str(model)]) == 0
    told = capsys.readouterr().out
    assert "t1 is a thing_with_faces (degree 100%)" in told
    assert "no labelled scenes of it" not in told
    assert main(["demo", "--trust", "--models", str(model)]) == 0
    assert "no labelled scenes of it" in capsys.readouterr().out


def test_of_an_interruption_nothing_is_said_but_that(monkeypatch, capsys):
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("facetlog.commands.recognize.read_views_from", interrupted)
    assert main(["recognize", "views"]) == 130
    assert capsys.readouterr() == ("", "facetlog: interrupted\n")


def test_help_loads_neither_opencv_nor_the_engine():
    code = (
        "import sys; from facetlog.cli import main; main(['recognize', '--help']);"
        "sys.exit(sum(m in sys.modules for m in ('cv2', 'numpy', 'pyswip', 'scipy')))"
    )
    done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True)
    assert done.returncode == 0, done.stderr.decode()


def test_up_may_be_stated_and_what_was_read_is_described(tmp_path, capsys):
    folder, out = _views(tmp_path / "views"), tmp_path / "scene.json"
    assert main(["reconstruct", str(folder), "-o", str(out)]) == 0
    told = capsys.readouterr().err
    way_out = "give --unit, or a length that you know, as --scale 'height = 74 cm'"
    assert f"transforms.json, 3 pictures, up unknown, unit unknown: {way_out}\n" in told
    assert json.loads(out.read_text())["up"] is None
    assert main(["reconstruct", str(folder), "-o", str(out), "--up", "-y", "--unit", "m"]) == 0
    assert "transforms.json, 3 pictures\n" in capsys.readouterr().err
    assert json.loads(out.read_text())["up"] == [0.0, -1.0, 0.0]
    for command in (["recognize"], ["recognize", "--follow"], ["reconstruct", "-o", str(out)]):
        assert main([*command, str(folder), "--up", "w"]) == 2
        assert "--up 'w': use one of x, y, z" in _refusal(capsys)


@pytest.mark.parametrize("kind", ["folder", ".json", ".ply"])
def test_shapes_are_recognised_as_pictures_are(tmp_path, capsys, kind):
    own = tmp_path / "own.model"
    own.write_text('model slab\n  "It."\n  face a\n  a is level, height(this) at most 5 cm\n')
    source = tmp_path / ("folder/scene.json" if kind == "folder" else f"shape{kind}")
    source.parent.mkdir(exist_ok=True)
    if kind == ".ply":
        write_mesh(cuboid(), source)
    else:
        write_scene(cuboid(), source)
    stated = ["--up", "z", "--unit", "m"] if kind == ".ply" else []
    named = source.parent if kind == "folder" else source
    call = ["recognize", str(named), "--models", str(own), *stated]
    assert main([*call, "-o", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "t1 is a box" in said
    misses = [line for line in said.splitlines() if line.startswith("t1 is no ")]
    assert misses[0].startswith("t1 is no slab")
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {"scene.json", "report.html"}
    assert main([*call, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["recognised"] == [{"thing": "t1", "model": "box"}]


def test_of_a_folder_of_results_the_scene_is_recognised(tmp_path, capsys):
    folder, out = _views(tmp_path / "views"), tmp_path / "out"
    assert main(["recognize", str(folder), "-o", str(out)]) == 1
    capsys.readouterr()
    assert main(["recognize", str(out)]) == 1
    assert "views: 0 faces" in capsys.readouterr().out
    assert main(["reconstruct", str(out), "-o", str(tmp_path / "scene.json")]) == 2
    said = _refusal(capsys)
    assert f"facetlog recognize {out / 'scene.json'}" in said
    assert "mat" not in said
    # With poses they are pictures as any.
    shutil.copytree(folder, out, dirs_exist_ok=True)
    assert main(["recognize", str(out)]) == 1


def test_pictures_without_an_edge_are_a_clean_no(tmp_path, capsys):
    for room in ("perception.surfaces.reconstruct", "perception.facts.all_facts", "kb.recognize"):
        pytest.importorskip(f"facetlog.{room}")
    folder = _views(tmp_path / "views")
    (folder / "images" / "2.png").unlink()
    assert main(["recognize", str(folder), "--json", "-o", str(tmp_path / "out")]) == 1
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert found["schema"] == "facetlog-verdicts/2"
    assert found["recognised"] == []
    assert "2.png" in found["problems"][0]
    assert "facetlog: warning: picture" in err
    assert "read pictures" in err
    written = {p.name for p in (tmp_path / "out").iterdir()}
    assert {"scene.json", "facts.pl", "verdicts.json", "run.json", "views"} <= written
    assert len(list((tmp_path / "out" / "views").glob("*.png"))) == 2


def test_a_known_length_gives_a_reconstruction_its_unit(tmp_path, monkeypatch, capsys):
    shown = replace(cuboid(3.0, 2.0, 1.0), metric=False)
    monkeypatch.setattr(
        "facetlog.perception.surfaces.reconstruct.reconstruct", lambda *_, **__: shown
    )
    folder, out = _views(tmp_path / "views"), tmp_path / "scene.json"
    code = main(["reconstruct", str(folder), "-o", str(out), "--scale", "height = 2 ± 0.01 m"])
    assert code == 0
    err = capsys.readouterr().err
    assert "facetlog: by the known length the scene's unit is" in err
    assert "warning" not in err
    assert np.ptp(read_scene(out).points[:, 2]) == pytest.approx(2.0)
    assert main(["recognize", str(folder), "--scale", "2 m"]) == 2
    assert main(["recognize", str(folder), "--follow", "--scale", "height = 2 m"]) == 2
    said = capsys.readouterr().err
    assert "give a known length as" in said
    assert "--scale goes without --follow" in said


def test_a_shell_completes_commands():
    asked = {"_FACETLOG_COMPLETE": "complete_bash", "COMP_WORDS": "facetlog rec", "COMP_CWORD": "1"}
    run = subprocess.run(
        [sys.executable, "-m", "facetlog"],
        env=os.environ | asked,
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.split() == ["recognize", "reconstruct", "record"]


def test_quiet_leaves_results_and_warnings(tmp_path, monkeypatch, capsys):
    shown = replace(cuboid(3.0, 2.0, 1.0), warnings=("something is odd",))
    monkeypatch.setattr(
        "facetlog.perception.surfaces.reconstruct.reconstruct", lambda *_, **__: shown
    )
    call = ["reconstruct", str(_views(tmp_path / "views")), "-o", str(tmp_path / "scene.json")]
    assert main(["--quiet", *call]) == 0
    assert capsys.readouterr() == ("", "facetlog: warning: something is odd\n")
    assert main(call) == 0
    said = capsys.readouterr().err
    assert "transforms.json, 3 pictures" in said
    assert "whole run" in said


def test_verbose_shows_steps_with_their_times_of_all_commands_alike(tmp_path, capsys):
    scene = tmp_path / "scene.json"
    write_scene(cuboid(0.3, 0.2, 0.1), scene)
    for call in (["query", str(scene), "is_a(T, box)"], ["why", str(scene), "box"]):
        assert main(["--verbose", *call]) == 0
        said = capsys.readouterr().err
        line = r"^facetlog: \[\d+\.\d{3} s\] %s took \d+\.\d{3} s"
        for step in ("load 17 built-in models", "load scene cuboid", call[0]):
            assert re.search(line % step, said, re.MULTILINE), said
        assert "Prolog:" not in said
    assert main(["-vv", "model", "check", str(scene.with_name("absent.model"))]) == 2
    assert re.search(r"\] facetlog \S+, Python 3", capsys.readouterr().err)
    assert main(["-vv", "query", str(scene), "is_a(T, box)"]) == 0
    assert "Prolog: load_builtin took" in capsys.readouterr().err
    assert main(["query", str(scene), "is_a(T, box)"]) == 0
    assert "took" not in capsys.readouterr().err


def test_warnings_that_are_logged_have_the_form_of_all_others(capsys):
    assert main(["--quiet", "model", "check", "rules/box.model"]) == 0
    logging.getLogger("facetlog.robot.pioneer.link").warning("late: %d ms", 300)
    assert capsys.readouterr().err == "facetlog: warning: late: 300 ms\n"


@pytest.mark.parametrize(
    ("argv", "way_out"),
    [
        (["reconstruct", "scene.json", "-o", "o.json"], "facetlog recognize scene.json says what"),
        (["reconstruct", "block.ply", "-o", "out.json"], "facetlog recognize block.ply says"),
        (["recognize", "scene.json", "--square", "3 cm"], "leave it out"),
        (["recognize", "scene.json", "--follow"], "leave it out"),
        (["recognize", "photos", "--sensor", "0,0,0"], "photos holds none"),
        (["recognize", "photos/0.png"], "give the folder of all that show the thing"),
        (["query", "photos", "face(F)"], "facetlog recognize photos -o OUT makes one"),
        (["classify", "photos"], "facetlog recognize photos -o OUT makes one"),
    ],
)
def test_what_goes_to_another_command_is_pointed_there(
    tmp_path, monkeypatch, capsys, argv, way_out
):
    monkeypatch.chdir(tmp_path)
    write_scene(cuboid(), Path("scene.json"))
    Path("block.ply").write_text("ply\n")
    Path("photos").mkdir()
    cv2.imwrite("photos/0.png", np.zeros((8, 8), dtype=np.uint8))
    assert main(argv) == 2
    assert way_out in _refusal(capsys)
