"""How shapes are counted, and that a few of them are judged as they should be."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from benchmarks.common import find_data_set
from benchmarks.shapes.accuracy_shapes import list_file_tasks, list_own_tasks
from benchmarks.shapes.own_shapes import KINDS
from benchmarks.shapes.shape_judging import Judged, Task, confusion, is_held_out, judge_task
from facetlog.kb.batch_judge import BatchJudge

NUMBER = {name: number for number, (name, _, _) in enumerate(KINDS)}


@pytest.fixture(scope="module")
def judge() -> Iterator[BatchJudge]:
    with BatchJudge() as opened:
        yield opened


@pytest.fixture(scope="module")
def folder() -> Path:
    found = find_data_set("shapes")
    if isinstance(found, str):
        pytest.skip(found)
    return found


def answered(label: str, answer: str, degree: float = 0.9) -> Judged:
    """A shape with that label and one model that holds, or none."""
    verdicts = [] if answer == "none" else [{"model": answer, "state": "holds", "degree": degree}]
    row = {"path": f"{label} {answer}", "verdicts": verdicts, "error": None}
    return Judged(Task(f"{label} {answer}", label), answer, row, True, 0.1)


@pytest.mark.parametrize(
    ("label", "answer", "right"),
    [
        ("armchair", "chair", True),
        ("lamp", "none", True),
        ("lamp", "table", False),
        ("box", "none", False),
        ("cabinet", "none", True),
        ("cabinet", "table", False),
        ("cabinet", "box", None),
        ("stool", "chair", None),
        ("desk", "table", None),
    ],
)
def test_labels_count_as_the_data_says(label: str, answer: str, right: bool | None) -> None:
    counted = confusion([answered(label, answer)])
    assert counted.accuracy.of == (0 if right is None else 1)
    assert counted.accuracy.hits == (1 if right else 0)


def test_halves_are_about_as_large_and_do_not_change() -> None:
    names = [f"set/{number}.ply" for number in range(1000)]
    held_out = [name for name in names if is_held_out(name)]
    assert 450 < len(held_out) < 550
    # what was looked at once must never be taken for held out
    assert [int(name[4:-4]) for name in held_out[:8]] == [1, 2, 3, 5, 6, 7, 8, 15]


@pytest.mark.parametrize(
    ("name", "answer"),
    [
        ("plain box", "box"),
        ("box inside out", "box"),
        ("tray", "none"),
        ("table on square legs", "table"),
    ],
)
def test_own_shape_is_answered_right(judge: BatchJudge, name: str, answer: str) -> None:
    (task,) = list_own_tasks([NUMBER[name]])
    (found,) = judge_task(task, (judge,))
    assert found.answered == answer


def test_folder_has_upright_meshes_their_clouds_and_scans(folder: Path) -> None:
    tasks = list_file_tasks(folder)
    assert [t.name for t in tasks["meshes"]] == [t.name for t in tasks["clouds"]]
    assert {t.label for t in tasks["scans"]} == {"box", "cylindric_object"}
    assert all(t.up is not None for some in tasks.values() for t in some)
    halves = [is_held_out(t.name) for t in tasks["meshes"]]
    assert 0.4 < sum(halves) / len(halves) < 0.6
