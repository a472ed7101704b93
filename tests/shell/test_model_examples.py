"""`facetlog model test`: examples, labelled scenes, coverage and margins."""

import json
import os

import pytest

from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.mesh_export import write_mesh
from facetlog.perception.surfaces.scene_file import write_scene

MODEL = """model slab
  "A level board."
  face top
  level: top is level, top is upward                "it lies level"
  thin: height(this) at most 20 % of length(this)   "it is thin"
  expect weakly: fill(top) at least 90 %            "it is whole"
  example "board" of cuboid(width 80 cm, depth 50 cm, height 5 cm) holds at least 90 %
  example "block" of cuboid(width 80 cm, depth 50 cm, height 50 cm) fails because thin
"""


@pytest.fixture(autouse=True)
def model(tmp_path):
    (tmp_path / "slab.model").write_text(MODEL)


def test_examples_that_are_as_expected_pass(run, tmp_path):
    (tmp_path / "comment.model").write_text("# nothing yet\n")
    assert run("model", "test", ".") == (0, "2 examples, 2 passed, 0 failed\n", "")


def test_a_failing_example_is_explained_with_its_place(run, tmp_path):
    (tmp_path / "slab.model").write_text(MODEL.replace("20 %", "5 %"))
    code, out, _ = run("model", "test", "slab.model")
    assert code == 1
    assert 'slab.model:7:3: failed: slab "board": it fails, expected was that it holds' in out
    assert "- thin: it is thin" in out
    assert (
        "t1's own height = 5.000 ± 0.087 cm, needs at most 4 cm (5 % of length(t1)): 1 cm over"
        in out
    )
    assert out.splitlines()[-1] == "2 examples, 1 passed, 1 failed"


def test_scenes_are_files_beside_the_model(run, tmp_path):
    (tmp_path / "deep" / "run").mkdir(parents=True)
    write_scene(build("table", {}), tmp_path / "deep" / "run" / "scene.json")
    write_scene(cuboid(0.8, 0.5, 0.05), tmp_path / "deep" / "flat.json")
    more = '  example "file" from "flat.json" holds\n  example "folder" from "run" fails\n'
    (tmp_path / "deep" / "slab.model").write_text(MODEL + more)
    assert run("model", "test", "deep")[:2] == (0, "4 examples, 4 passed, 0 failed\n")


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ('from "gone.json"', "gone.json does not exist"),
        ('from "slab.model"', "the scene: slab.model"),
        ("of tray(width 1 cm, thickness 1 cm)", "two walls"),
    ],
)
@pytest.mark.slow
def test_a_scene_that_cannot_be_made_fails_its_example(scene, message, run, tmp_path):
    (tmp_path / "slab.model").write_text(f'{MODEL}  example "x" {scene} holds\n')
    code, out, _ = run("model", "test", "slab.model")
    assert code == 1
    assert out.startswith('slab.model:9:3: failed: slab "x": ')
    assert message in out
    assert out.endswith("3 examples, 2 passed, 1 failed\n")


def test_a_faulty_file_is_reported_and_the_others_are_tested(run, tmp_path):
    faulty = MODEL.replace("model slab", "model slob").replace("cuboid(", "cubiod(")
    (tmp_path / "a.model").write_text(faulty)
    code, out, _ = run("model", "test", "a.model", "slab.model")
    assert code == 1
    assert "a.model:7:22: error: nothing can be built that is called `cubiod`" in out
    assert out.endswith("2 examples, 2 passed, 0 failed; 2 faults kept files from being tested\n")


def test_labelled_scenes_are_tested_as_well(run, tmp_path):
    write_scene(cuboid(0.8, 0.5, 0.1), tmp_path / "flat.json")
    table = "scene,thing,model,expected\nflat.json,t1,slab,holds\nflat.json,,box,fails\n"
    (tmp_path / "labels.csv").write_text(table)
    code, out, _ = run("model", "test", "slab.model", "--scenes", "labels.csv")
    assert code == 1
    passed, failed, *_ = out.splitlines()
    assert passed == 'labels.csv:2: passed: slab "flat.json t1" holds'
    assert failed.startswith('labels.csv:3: failed: box "flat.json": it holds')
    assert out.endswith("4 examples, 3 passed, 1 failed\n")


def test_coverage_counts_lines_and_gives_margins(run):
    code, out, _ = run("model", "test", "slab.model", "--coverage")
    assert code == 0
    lines = [" ".join(line.split()) for line in out.splitlines()]
    assert "slab: 2 verdicts: 1 held, 1 failed, 0 unknown" in lines
    assert "level 2 0 0 0" in lines
    assert "thin 1 1 0 1" in lines
    assert "line 6 2 0 0 expected only" in lines
    assert "never decided: level" in lines
    (block,) = (line for line in lines if line.startswith("slab block fails"))
    assert "t1's own height were 34 cm less" in block
    found = json.loads(run("model", "test", "slab.model", "--coverage", "--output", "json")[1])
    assert (found["schema"], found["passed"], found["failed"]) == ("facetlog-model-test/1", 2, 0)
    board, block = found["examples"]
    assert board["expected"] == {"state": "holds", "at_least": 0.9, "because": []}
    assert board["verdict"]["state"] == "holds"
    assert block["margin"]["label"] == "thin"
    assert block["margin"]["change"] == pytest.approx(-0.34)
    (model,) = found["coverage"]
    assert model["never_decided"] == ["level"]
    assert [line["label"] for line in model["lines"]] == ["level", "thin", "line 6"]


@pytest.mark.parametrize(
    "arguments", [["gone.model"], ["-"], ["slab.model", "--scenes", "gone.csv"], ["absent*"]]
)
def test_what_cannot_be_read_ends_with_2(arguments, run):
    assert run("model", "test", *arguments)[0] == 2


def _write_meshes(folder):
    """Write a flat mesh and a thick one, in centimetres with y up."""
    folder.mkdir(exist_ok=True)
    for name, height in (("slab+flat", 5.0), ("slab-thick", 50.0)):
        write_mesh(cuboid(80.0, height, 50.0), folder / f"{name}.ply")


def test_meshes_are_examples_with_the_up_and_unit_that_are_stated(run, tmp_path):
    _write_meshes(tmp_path / "own")
    high = "  tall: if known: height(this) at most 1 m\n"
    more = '  example "y" from "own/slab+flat.ply" (up y, unit cm) holds\n'
    more += '  example "z" from "own/slab+flat.ply" (up z, unit cm) fails because thin\n'
    more += '  example "m" from "own/slab+flat.ply" (up y, unit m) fails because tall\n'
    more += '  example "s" from "own/slab+flat.ply" (up y, scale "height = 5 cm") holds\n'
    (tmp_path / "slab.model").write_text(MODEL + high + more)
    assert run("model", "test", "slab.model")[:2] == (0, "6 examples, 6 passed, 0 failed\n")


@pytest.mark.parametrize("name", ["../outside.json", "link.json", "/dev/zero", "fifo.ply", "."])
def test_a_model_reads_only_files_in_its_own_folder(run, tmp_path, name):
    write_scene(cuboid(), tmp_path / "outside.json")
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "link.json").symlink_to(tmp_path / "outside.json")
    os.mkfifo(tmp_path / "in" / "fifo.ply")
    (tmp_path / "in" / "slab.model").write_text(f'{MODEL}  example "x" from "{name}" fails\n')
    code, out, _ = run("model", "test", "in/slab.model")
    assert (code, "the scene: " in out) == (1, True)
    if name in ("../outside.json", "link.json"):
        assert "is outside of" in out
        assert run("model", "test", "in/slab.model", "--trust")[0] == 0


@pytest.mark.parametrize("form", ["names", "table"])
@pytest.mark.parametrize("call", [["own"], [".", "--scenes", "own"]])
def test_a_folder_of_meshes_is_tested_by_its_table_or_its_names(run, tmp_path, form, call):
    _write_meshes(tmp_path / "own")
    (tmp_path / "own" / "slab+flat.png").write_text("no shape")
    if form == "table":
        rows = "slab+flat.ply,slab,holds\nslab-thick.ply,slab,holds\nother.ply,other,holds\n"
        (tmp_path / "own" / "expected.csv").write_text(f"file,model,expected\n{rows}")
    stated = ("--up", "y", "--unit", "cm")
    code, out, _ = run("model", "test", "slab.model", *call, *stated)
    flat, thick, *_ = out.splitlines()
    assert flat.endswith('passed: slab "slab+flat.ply" holds')
    if form == "table":
        assert thick.startswith("own/expected.csv:3: failed: slab")
        assert "thin" in thick
    assert (code, out.splitlines()[-1]) == (
        (1, "4 examples, 3 passed, 1 failed")
        if form == "table"
        else (0, "4 examples, 4 passed, 0 failed")
    )
    found = json.loads(run("model", "test", "slab.model", *call, *stated, "--json")[1])
    assert found["labelled"][0] == {"model": "slab", "expected": "holds", "holds": 1} | (
        {"fails": 1} if form == "table" else {}
    )


def test_solids_put_together_are_an_example(run, tmp_path):
    (tmp_path / "cart.model").write_text(
        """model cart
  "A board on wheels."
  board deck where deck is level
  low: elevation(deck) at most 50 % of length(deck)
  round: curved(this) at least 5 %
  example "four wheels" of cuboid(width 80 cm, depth 50 cm, height 3 cm, z 12 cm)
    and wheel(diameter 12 cm, thickness 4 cm, along 80 cm, across 50 cm) holds
  example "too many" of wheel(diameter 12 cm, along 90 cm, across 90 cm, columns 50, rows 50) fails
"""
    )
    code, out, _ = run("model", "test", "cart.model")
    assert (code, out.splitlines()[-1]) == (1, "2 examples, 1 passed, 1 failed")
    assert "more than 400 solids" in out


def test_what_is_evenly_spaced_is_told_from_what_is_not(run, tmp_path):
    (tmp_path / "rack.model").write_text(
        """model rack
  "Bars evenly one above the other."
  bar left where left is upright
  at least 3 bars rung where rung is level, rung joins left
  even: smallest step of elevation(rung) at least 80 % of largest step of elevation(rung)
  close: largest step of elevation(rung) at most 60 cm
  example "even" of cuboid(width 4 cm, depth 4 cm, height 2 m, along 44 cm)
    and cuboid(width 36 cm, depth 3 cm, height 3 cm, x 4 cm, z 20 cm, over 160 cm, levels 5) holds
  example "uneven" of cuboid(width 4 cm, depth 4 cm, height 2 m, along 44 cm)
    and cuboid(width 36 cm, depth 3 cm, height 3 cm, x 4 cm, z 20 cm, over 60 cm, levels 3)
    and cuboid(width 36 cm, depth 3 cm, height 3 cm, x 4 cm, z 160 cm) fails because even, close
"""
    )
    assert run("model", "test", "rack.model")[:2] == (0, "2 examples, 2 passed, 0 failed\n")


def test_files_of_almost_the_name_of_a_tested_model_are_named(run, tmp_path):
    _write_meshes(tmp_path / "own")
    for name in ("slob", "mailbox"):
        (tmp_path / "own" / f"{name}-flat.ply").write_text("not read")
    code, _, err = run("model", "test", "slab.model", "own", "--up", "y", "--unit", "cm")
    assert (code, "own: left out (1), 'slob': did you mean slab?" in err) == (0, True)
    assert "mailbox" not in err
    for name in ("slab+flat.ply", "slab-thick.ply"):
        (tmp_path / "own" / name).unlink()
    code, _, err = run("model", "test", "slab.model", "own")
    assert (code, "no file is of a model that is tested" in err) == (2, True)
    assert run("model", "test", "own")[0] == 2


def test_a_built_in_model_that_holds_of_all_examples_is_named(run, tmp_path):
    text = "model parcel\n  face top\n  level: tilt(top) at most 10 deg\n"
    for width in (60, 80):
        text += f'  example "{width}" of cuboid(width {width} cm, height 30 cm) holds\n'
    (tmp_path / "parcel.model").write_text(text)
    _, out, err = run("model", "test", "parcel.model")
    assert out == "2 examples, 2 passed, 0 failed\n"
    assert "write `model parcel rather than box`" in err
    (tmp_path / "parcel.model").write_text(text.replace("parcel", "parcel rather than box", 1))
    assert run("model", "test", "parcel.model")[2] == ""


def test_a_folder_of_meshes_beside_a_named_model_names_no_models(run, tmp_path):
    _write_meshes(tmp_path / "own")
    (tmp_path / "own" / "older").mkdir()
    (tmp_path / "own" / "older" / "slab.model").write_text((tmp_path / "slab.model").read_text())
    code, out, err = run("model", "test", "slab.model", "own", "--up", "y", "--unit", "cm")
    assert (code, "already defined" in out + err) == (0, False)
