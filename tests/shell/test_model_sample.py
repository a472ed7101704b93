"""`facetlog model sample`: what holds holds, near misses fail one condition, a seed repeats."""

import csv
from pathlib import Path

import pytest

from facetlog.cli import main
from facetlog.perception.surfaces.drawing.thumbnail import contact_sheet
from facetlog.perception.surfaces.scene_file import read_scene

SLAB = """model slab
  "A level board or flat block."
  face top
  level: top is level, top is upward
  cover: share(top) at least 80 %
  flat: height(this) between 5 % of width(top) and 40 % of width(top)
  broad: length(top) at most 200 % of width(top)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("slab")
    (made / "slab.model").write_text(SLAB)
    for out in ("one", "two"):
        assert _sampled(made, out) == 0
    return made


def _sampled(folder: Path, out: str, *more: str) -> int:
    model = str(folder / "slab.model")
    return main(
        ["model", "sample", model, "-n", "8", "--effort", "20", "-o", str(folder / out), *more]
    )


def _rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "labels.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.slow
def test_half_of_the_samples_hold_and_half_fail_one_condition_that_is_named(folder: Path) -> None:
    kinds = [row["kind"] for row in _rows(folder / "one")]

    assert kinds.count("holds") == 4
    assert len(kinds) == 8
    assert "fails flat" in kinds
    assert {kind.removeprefix("fails ") for kind in kinds} <= {"holds", "cover", "flat", "broad"}


def test_the_model_says_of_each_scene_what_its_label_says(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, table = str(folder / "slab.model"), str(folder / "one" / "expected.csv")

    assert main(["model", "test", model, "--scenes", table]) == 0
    assert "8 passed, 0 failed" in capsys.readouterr().out


def test_a_near_miss_fails_the_named_condition_and_no_other(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    row = next(row for row in _rows(folder / "one") if row["kind"] != "holds")
    scene = str(folder / "one" / row["file"])

    assert main(["why-not", scene, "slab", "--models", str(folder / "slab.model")]) == 0
    said = capsys.readouterr().out
    assert f"- {row['kind'].removeprefix('fails ')}" in said
    assert "1 of 4 conditions fails" in said


def test_the_sheet_says_beneath_each_picture_what_a_near_miss_fails(folder: Path) -> None:
    shown = []
    for row in _rows(folder / "one"):
        kind = "" if row["kind"] == "holds" else f": {row['kind']}"
        shown.append((read_scene(folder / "one" / row["file"]), row["label"] + kind))

    assert "near slab: fails flat" in {caption for _, caption in shown}
    assert (folder / "one" / "samples.png").read_bytes() == contact_sheet(shown)


def test_one_seed_gives_the_same_scenes_again(folder: Path) -> None:
    names = {path.name for path in (folder / "one").glob("*.json")}

    assert names == {path.name for path in (folder / "two").glob("*.json")}
    for name in names - {"run.json"}:
        assert (folder / "one" / name).read_bytes() == (folder / "two" / name).read_bytes()


@pytest.mark.slow
def test_labels_are_what_classify_reads(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    labels, model = str(folder / "one" / "labels.csv"), str(folder / "slab.model")
    table = str(folder / "table.parquet")

    code = main(["classify", "--labels", labels, "--models", model, "-o", table])

    assert code == 0
    assert "8 of 8" in capsys.readouterr().out
