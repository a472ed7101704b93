"""The plain texts are as plain as is said, and how they are counted."""

import pytest

from benchmarks.shapes.accuracy_plain import FOLDER, TEXTS, recall
from benchmarks.shapes.accuracy_shapes import list_own_tasks
from benchmarks.shapes.own_shapes import KINDS
from benchmarks.shapes.shape_judging import Judged, Task, judge_task
from facetlog.kb.batch_judge import BatchJudge


def answered(label: str, verdicts: dict[str, str]) -> Judged:
    rows = [{"model": name, "state": state, "degree": 0.5} for name, state in verdicts.items()]
    row = {"path": label, "verdicts": rows, "error": None}
    return Judged(Task(label, label), "none", row, True, 0.1)


def test_recall_is_of_the_own_model_whatever_else_holds() -> None:
    found = [
        answered("armchair", {"chair": "holds", "table": "holds"}),
        answered("chair", {"chair": "unknown", "table": "holds"}),
        answered("stool", {"chair": "holds"}),  # not counted
        answered("lamp", {"chair": "holds"}),
    ]
    assert (recall(found, "chair").hits, recall(found, "chair").of) == (1, 2)


@pytest.mark.slow
def test_each_text_knows_a_table_on_four_legs_and_a_plain_box() -> None:
    number = {name: place for place, (name, _, _) in enumerate(KINDS)}
    names = {"plain box": "box", "table on square legs": "table"}
    judges = [BatchJudge((FOLDER / f"{text}.model",)) for text in TEXTS]
    for name, label in names.items():
        (task,) = list_own_tasks([number[name]])
        for text, one in zip(TEXTS, judge_task(task, judges), strict=True):
            assert recall([one], label).hits == 1, (text, name)
    for judge in judges:
        judge.close()
