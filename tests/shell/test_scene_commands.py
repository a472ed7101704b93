"""`facetlog scene`: what it shows, writes and finds wrong, and how it ends."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import trimesh

from facetlog.cli import main
from facetlog.commands.scene import MOST_LINES
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.scene_file import encode_scene, read_scene, write_scene


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_scene(cuboid(0.3, 0.2, 0.1), Path("block.json"))
    trimesh.creation.box((300.0, 200.0, 100.0)).export("block.stl")
    trimesh.creation.cylinder(0.2, 0.5).export("can.ply")

    def called(*argv: str) -> tuple[int, str, str]:
        capsys.readouterr()
        code = main(["scene", *argv])
        return code, *capsys.readouterr()

    return called


def test_show_tells_objects_and_largest_faces_as_a_table(run):
    code, out, err = run("show", "block.json")
    assert (code, err) == (0, "")
    assert out == (
        "cuboid: 1 object, 6 faces, 12 edges, 8 vertices\n"
        "unit  metres, as the file says\n"
        "up    0 0 1, as the file says\n"
        "\n"
        "object  faces  longest (m)  middle (m)  shortest (m)  curved  whole\n"
        "t1          6          0.3         0.2           0.1      0%     no\n"
        "\n"
        "piece  object  shape  length (m)  width (m)  thickness (m)  stands on\n"
        "p1         t1  block         0.3        0.2            0.1     ground\n"
        "\n"
        "face  object  area (m²)  length (m)  width (m)   tilt  seen\n"
        "f1        t1       0.06         0.3        0.2   0.0°  100%\n"
        "f2        t1       0.06         0.3        0.2   0.0°  100%\n"
        "f3        t1       0.03         0.3        0.1  90.0°  100%\n"
        "f4        t1       0.03         0.3        0.1  90.0°  100%\n"
        "f5        t1       0.02         0.2        0.1  90.0°  100%\n"
        "f6        t1       0.02         0.2        0.1  90.0°  100%\n"
    )


def test_show_says_what_pieces_stand_on(run):
    write_scene(build("table", {}), Path("table.json"))
    code, out, _ = run("show", "table.json", "--json")
    pieces = json.loads(out)["pieces"]
    (top,) = (piece for piece in pieces if piece["shape"] == "board")
    legs = [piece["name"] for piece in pieces if piece["on_ground"]]
    assert (code, len(legs), sorted(top["on"])) == (0, 4, sorted(legs))
    assert [piece["shape"] for piece in pieces].count("bar") == 4


def test_pieces_are_written_as_a_mesh_of_their_own(run):
    write_scene(build("stool", {}), Path("stool.json"))
    assert run("convert", "stool.json", "pieces.glb", "--pieces")[:2] == (0, "")
    loaded = trimesh.load("pieces.glb")
    assert isinstance(loaded, trimesh.Scene)
    assert {name.split()[1] for name in loaded.geometry} == {"board", "bar"}
    code, _, err = run("convert", "stool.json", "pieces.ply", "--pieces")
    assert (code, "what can be written is .glb" in err) == (2, True)


@pytest.mark.parametrize(
    ("argv", "unit", "up"),
    [
        (["block.json"], ("m", "as the file says"), ([0, 0, 1], "as the file says")),
        (["block.stl"], (None, "not known"), (None, "not known")),
        (["block.stl", "--up", "-X", "--unit", "MM"], ("m", "given"), ([-1, 0, 0], "given")),
        (["block.glb"], ("m", "as the file says"), ([0, 1, 0], "as the format says")),
        (["block.glb", "--up", "none"], ("m", "as the file says"), (None, "not known")),
        (["folder"], ("m", "as the file says"), ([0, 0, 1], "as the file says")),
    ],
)
def test_show_says_how_unit_and_up_are_known(argv, unit, up, run):
    trimesh.creation.box((0.3, 0.2, 0.1)).export("block.glb")
    Path("folder").mkdir()
    write_scene(cuboid(0.3, 0.2, 0.1), Path("folder/scene.json"))
    code, out, _ = run("show", *argv, "--json")
    found = json.loads(out)
    assert code == 0
    assert found["schema"] == "facetlog-scene-summary/1"
    assert (found["unit"], found["unit_known"]) == unit
    assert (found["up"], found["up_known"]) == up
    assert (found["faces"][0]["tilt"] is None) == (up[0] is None)


def test_show_draws_the_scene(run):
    code, _, _ = run("show", "block.json", "-o", "block.png")
    picture = cv2.imread("block.png", cv2.IMREAD_UNCHANGED)
    assert code == 0
    assert picture is not None
    assert picture.shape == (960, 960, 4)
    assert 0.2 < (picture[..., 3] > 0).mean() < 0.9
    assert run("show", "block.json", "-o", "block.png")[0] == 2
    assert run("show", "block.json", "-o", "block.png", "--overwrite")[0] == 0


def test_up_and_unit_count_for_a_scene_and_its_sensors_do_not(run):
    code, out, err = run("show", "block.json", "--up", "x", "--sensor", "0,0,0", "--json")
    assert code == 0
    shown = json.loads(out)
    assert (shown["up"], shown["up_known"], shown["unit_known"]) == (
        *([1, 0, 0], "given", "as the file says"),
    )
    assert "warning: block.json: a scene says from where it was seen itself" in err
    code, _, err = run("show", "block.json", "--unit", "cm")
    assert (code, err) == (2, "facetlog: cuboid: lengths are metres already, not cm\n")


def test_a_known_length_makes_metres_of_a_scene(run):
    write_scene(replace(cuboid(3.0, 2.0, 1.0), metric=False), Path("units.json"))
    code, out, _ = run("show", "units.json", "--scale", "height = 10 ± 0.1 cm")
    assert code == 0
    assert "unit  metres, by the known length: the scene's unit is 0.1000 ± 0.001 m\n" in out
    assert run("convert", "units.json", "metres.json", "--scale", "e1 = 1 ft") == (0, "", "")
    scene = read_scene(Path("metres.json"))
    assert scene.metric
    first = scene.edges[0]
    length = np.linalg.norm(scene.points[first.end] - scene.points[first.start])
    assert length == pytest.approx(0.3048)
    assert run("validate", "metres.json")[0] == 0
    assert run("convert", "units.json", "cm.json", "--unit", "cm") == (0, "", "")
    assert np.ptp(read_scene(Path("cm.json")).points, axis=0) == pytest.approx([0.03, 0.02, 0.01])
    assert run("show", "block.json", "--scale", "e1 = 1 m")[0] == 2


def test_facts_are_written_as_prolog(run):
    assert run("convert", "block.json", "facts.pl") == (0, "", "")
    text = Path("facts.pl").read_text(encoding="utf-8")
    assert text.startswith("% Facts of one scene;")
    assert "\n'part_of'('f1','t1').\n" in text


@pytest.mark.parametrize(
    ("argv", "says"),
    [
        (["show", "block.doc"], "block.doc: .doc: files that can be read are"),
        (["show", "block.stl", "--up", "w"], "--up 'w': use one of"),
        (["show", "block.stl", "--sensor", "1,2"], "sensor '1,2': give three numbers x,y,z"),
        (["show", "block.stl", "-o", "block.jpg"], "what can be written is .png"),
        (["convert", "block.stl", "block.json"], "block.json exists: give --overwrite"),
        (["convert", "block.stl", "new.obj"], "new.obj: .obj: what can be written is .json, .ply"),
        (["convert", "empty.json", "new.ply"], "has no face with an area"),
    ],
)
def test_what_cannot_be_is_one_line_and_leaves_no_file(argv, says, run):
    Path("empty.json").write_text('{"schema": "facetlog-scene/1", "name": "empty"}')
    before = {path: path.read_bytes() for path in Path().iterdir()}
    code, _, err = run(*argv)
    assert code == 2
    assert says in err
    assert err.count("\n") == 1
    assert {path: path.read_bytes() for path in Path().iterdir()} == before


def _edited(**changes: Any) -> str:
    data = json.loads(encode_scene(cuboid(0.3, 0.2, 0.1)))
    return json.dumps({**data, **changes})


def test_validate_tells_every_fault_by_its_path(run):
    Path("form.json").write_text(_edited(up="z", name=3, more=[]))
    Path("index.json").write_text(_edited(edges=[{"start": 0, "end": 99}], bodies=[{"faces": [7]}]))
    Path("up.json").write_text(_edited(up=[0, 0, 2]))
    code, out, err = run("validate", "form.json", "index.json", "block.json", "up.json")
    assert (code, err) == (1, "")
    lines = out.splitlines()
    assert [line.split(": ")[:2] for line in lines[:-1]] == [
        ["form.json", "$.name"],
        ["form.json", "$.up"],
        ["form.json", "$.more"],
        ["index.json", "$.edges[0].end"],
        ["index.json", "$.bodies[0].faces"],
        ["up.json", "$.up"],
    ]
    assert lines[-1] == "4 files, 1 sound"


def test_validate_writes_some_faults_of_many_and_cuts_what_is_long(run):
    faces = json.loads(encode_scene(cuboid(0.3, 0.2, 0.1)))["faces"]
    Path("many.json").write_text(_edited(faces=[{**f, "support": 2} for f in faces] * 100))
    Path("long.json").write_text(_edited(**{"k" * 100_000: 1}))
    Path("digits.json").write_text(_edited(edges=[{"start": 0, "end": int("9" * 400)}]))
    code, out, _ = run("validate", "many.json", "long.json", "digits.json")
    lines = out.splitlines()
    assert code == 1
    assert lines[MOST_LINES] == f"many.json: {600 - MOST_LINES} more faults: --json has them all"
    assert len(lines) == MOST_LINES + 4
    assert max(map(len, lines)) < 300
    _, out, _ = run("validate", "many.json", "--json")
    assert len(json.loads(out)["faults"]) == 600


def test_every_reader_refuses_what_validate_refuses(run):
    Path("up.json").write_text(_edited(up=[0, 0, 1e300]))
    said = "up.json: $.up: is 1e+300 long: give a unit vector, or null"
    assert run("validate", "up.json")[1].splitlines()[0] == said
    for argv in (["show", "up.json"], ["convert", "up.json", "new.ply"]):
        assert run(*argv) == (2, "", f"facetlog: {said}\n")
