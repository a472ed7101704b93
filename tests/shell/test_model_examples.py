"""`facetlog model test`: examples, labelled scenes, coverage and margins."""

import json
from pathlib import Path

import pytest

from facetlog.cli import main
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
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
def in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "slab.model").write_text(MODEL)


def test_examples_that_are_as_expected_pass(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["model", "test", "slab.model"]) == 0
    assert capsys.readouterr() == ("2 examples, 2 passed, 0 failed\n", "")


def test_files_without_models_in_a_folder_stop_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "empty.model").write_text("")
    (tmp_path / "comment.model").write_text("# nothing yet\n")
    assert main(["model", "test", "."]) == 0
    assert capsys.readouterr() == ("2 examples, 2 passed, 0 failed\n", "")


def test_a_new_model_passes_its_examples(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["model", "new", "coffee_table"]) == 0
    assert main(["model", "test", "coffee_table.model"]) == 0
    assert main(["model", "format", "--check", "coffee_table.model"]) == 0
    assert "2 examples, 2 passed" in capsys.readouterr().out


def test_a_failing_example_is_explained_where_it_stands(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "slab.model").write_text(MODEL.replace("20 %", "5 %"))
    assert main(["model", "test", "slab.model"]) == 1
    out = capsys.readouterr().out
    assert 'slab.model:7:3: failed: slab "board": it fails, expected was that it holds' in out
    assert "- thin: it is thin" in out
    assert "height of t1's highest point = 5.000 ± 0.087 cm, needs at most 4 cm: 1 cm over" in out
    assert out.splitlines()[-1] == "2 examples, 1 passed, 1 failed"


def test_scenes_stand_in_files_beside_the_model(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "deep" / "run").mkdir(parents=True)
    write_scene(build("table", {}), tmp_path / "deep" / "run" / "scene.json")
    write_scene(cuboid(0.8, 0.5, 0.05), tmp_path / "deep" / "flat.json")
    more = '  example "file" from "flat.json" holds\n  example "folder" from "run" fails\n'
    (tmp_path / "deep" / "slab.model").write_text(MODEL + more)
    assert main(["model", "test", "deep"]) == 0
    assert capsys.readouterr().out == "4 examples, 4 passed, 0 failed\n"


@pytest.mark.parametrize(
    ("scene", "says"),
    [
        ('from "gone.json"', "gone.json does not exist"),
        ('from "slab.model"', "the scene: slab.model"),
        ("of tray(width 1 cm, thickness 1 cm)", "two walls"),
        ("of cuboid(width 0 m)", "give one between"),
    ],
)
@pytest.mark.slow
def test_a_scene_that_cannot_be_had_fails_its_example(
    scene: str, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "slab.model").write_text(f'{MODEL}  example "x" {scene} holds\n')
    assert main(["model", "test", "slab.model"]) == 1
    out = capsys.readouterr().out
    assert out.startswith('slab.model:9:3: failed: slab "x": ')
    assert says in out
    assert out.endswith("3 examples, 2 passed, 1 failed\n")


def test_a_faulty_file_is_told_and_the_others_are_tested(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    faulty = MODEL.replace("model slab", "model slob").replace("cuboid(", "cubiod(")
    (tmp_path / "a.model").write_text(faulty)
    assert main(["model", "test", "a.model", "slab.model"]) == 1
    out = capsys.readouterr().out
    assert "a.model:7:22: error: nothing can be built that is called `cubiod`" in out
    assert out.endswith("2 examples, 2 passed, 0 failed; 2 faults kept files from being tested\n")


def test_labelled_scenes_are_asked_as_well(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_scene(cuboid(0.8, 0.5, 0.1), tmp_path / "flat.json")
    table = "scene,thing,model,expected\nflat.json,t1,slab,holds\nflat.json,,box,fails\n"
    (tmp_path / "labels.csv").write_text(table)
    assert main(["model", "test", "slab.model", "--scenes", "labels.csv"]) == 1
    out = capsys.readouterr().out
    assert out.startswith('labels.csv:3: failed: box "flat.json": it holds')
    assert out.endswith("4 examples, 3 passed, 1 failed\n")


def test_coverage_counts_lines_and_tells_margins(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["model", "test", "slab.model", "--coverage"]) == 0
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert "slab: 2 verdicts: 1 held, 1 failed, 0 unknown" in lines
    assert "level 2 0 0 0" in lines
    assert "thin 1 1 0 1" in lines
    assert "line 6 2 0 0 expected only" in lines
    assert "never decided: level" in lines
    (block,) = (line for line in lines if line.startswith("slab block fails"))
    assert "height of t1's highest point were 34 cm less" in block


def test_json_holds_examples_coverage_and_margins(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["model", "test", "slab.model", "--coverage", "--output", "json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["schema"], found["passed"], found["failed"]) == ("facetlog-model-test/1", 2, 0)
    board, block = found["examples"]
    assert board["expected"] == {"state": "holds", "at_least": 0.9, "because": []}
    assert board["verdict"]["state"] == "holds"
    assert block["margin"]["label"] == "thin"
    assert block["margin"]["change"] == pytest.approx(-0.34)
    (model,) = found["coverage"]
    assert model["never_decided"] == ["level"]
    assert [line["label"] for line in model["lines"]] == ["level", "thin", "line 6"]


def test_json_without_coverage_has_none(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["model", "test", "slab.model", "--output", "json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert "coverage" not in found
    assert "margin" not in found["examples"][0]


@pytest.mark.parametrize(
    "arguments", [["gone.model"], ["-"], ["slab.model", "--scenes", "gone.csv"], ["absent*"]]
)
def test_what_cannot_be_read_ends_with_2(arguments: list[str]) -> None:
    assert main(["model", "test", *arguments]) == 2
