"""`facetlog model sample`: what holds holds, near misses fail one condition, a seed repeats."""

import csv
from pathlib import Path

import pytest
import trimesh

from facetlog.cli import main

SLAB = """model slab
  "A level board or flat block."
  face top
  level: top is level, top is upward
  cover: share(top) at least 80 %
  flat: height(this) between 5 % of width(top) and 40 % of width(top)
  broad: length(top) at most 200 % of width(top)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("slab")
    (made / "slab.model").write_text(SLAB)
    options = ["-n", "8", "--effort", "20"]
    for out in ("one", "two"):
        command = ["model", "sample", str(made / "slab.model"), *options, "-o", str(made / out)]
        assert main(command) == 0
    return made


def _rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "labels.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.slow
def test_half_of_the_samples_hold_and_half_fail_one_condition_that_is_named(folder):
    kinds = [row["kind"] for row in _rows(folder / "one")]

    assert kinds.count("holds") == 4
    assert len(kinds) == 8
    assert "fails flat" in kinds
    assert {kind.removeprefix("fails ") for kind in kinds} <= {"holds", "cover", "flat", "broad"}


def test_the_model_says_of_each_scene_what_its_label_says(folder, capsys):
    model, table = str(folder / "slab.model"), str(folder / "one" / "expected.csv")

    assert main(["model", "test", model, "--scenes", table]) == 0
    assert "8 passed, 0 failed" in capsys.readouterr().out


def test_a_near_miss_fails_the_named_condition_and_no_other(folder, capsys):
    row = next(row for row in _rows(folder / "one") if row["kind"] != "holds")
    scene = str(folder / "one" / row["file"])

    assert main(["why-not", scene, "slab", "--models", str(folder / "slab.model")]) == 0
    said = capsys.readouterr().out
    assert f"- {row['kind'].removeprefix('fails ')}" in said
    assert "1 of 4 conditions fails" in said


def test_one_seed_gives_the_same_scenes_again(folder):
    names = {path.name for path in (folder / "one").glob("*.json")}

    assert names == {path.name for path in (folder / "two").glob("*.json")}
    for name in names - {"run.json"}:
        assert (folder / "one" / name).read_bytes() == (folder / "two" / name).read_bytes()


@pytest.mark.slow
def test_labels_are_what_classify_reads(folder, capsys):
    labels, model = str(folder / "one" / "labels.csv"), str(folder / "slab.model")
    table = str(folder / "table.parquet")

    code = main(["classify", "--labels", labels, "--models", model, "-o", table])

    assert code == 0
    assert "8 of 8" in capsys.readouterr().out


@pytest.mark.slow
def test_samples_are_stretched_from_a_mesh_of_ones_own(folder, capsys):
    mesh = folder / "own.ply"
    trimesh.creation.box((1.0, 0.7, 0.15)).export(mesh)
    model = str(folder / "slab.model")
    command = ["model", "sample", model, "--like", str(mesh), "-n", "4", "--effort", "4"]

    assert main([*command, "-o", str(folder / "no_up")]) == 2
    assert "--up z" in capsys.readouterr().err
    assert main([*command, "--up", "z", "--unit", "m", "-o", str(folder / "like")]) == 0
    assert {row["form"] for row in _rows(folder / "like")} == {"own.ply"}
    table = str(folder / "like" / "expected.csv")
    assert main(["model", "test", model, "--scenes", table]) == 0
