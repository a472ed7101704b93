"""How often do plain texts of three to twelve conditions hold of chairs, tables and boxes?

Four files of benchmarks/plain_texts, a chair, a table and a box in each, take the built-in models'
places: `faces` says what a stranger wrote who had read docs/models.md once, `pieces` the same by
solid parts, `space` what the things leave free, in six conditions at most, `twelve` what a careful
author would add, in twelve at most. Shapes, answers and halves are those of accuracy_shapes. The
recall is how often a shape's own model holds, whatever else does. A text that wants three legs is
false of a table on a pedestal: `recall on legs` leaves out what plain_texts/no_legs.txt lists.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path

from benchmarks.common import Report, Row, Settings, Table, find_data_set, hash_tree
from benchmarks.shapes.accuracy_shapes import list_file_tasks
from benchmarks.shapes.shape_judging import (
    CLASSES,
    COUNTED_AS,
    Judged,
    Task,
    confusion,
    is_held_out,
    judge_by_each,
)
from facetlog.batch.confusion import Proportion

NAME = "accuracy_plain"
FOLDER = Path(__file__).resolve().parent / "plain_texts"
TEXTS = ("faces", "pieces", "space", "twelve")
NO_LEGS = frozenset(
    line
    for line in (FOLDER / "no_legs.txt").read_text(encoding="utf-8").splitlines()
    if not line.startswith("#")
)
HALVES = (("development", False), ("held out", True))


def _label(task: Task) -> str | None:
    """Return the class that a shape is of, `none` of other things, None of what is not counted."""
    counted = COUNTED_AS.get(task.label)
    return task.label if counted is None else counted.answer


def recall(found: Sequence[Judged], name: str) -> Proportion:
    """Return how many shapes of a class the model of that name holds of, alone or beside others."""
    own = [one for one in found if _label(one.task) == name]
    holding = [one for one in own if _state(one, name) == "holds"]
    return Proportion(len(holding), len(own))


def _state(one: Judged, name: str) -> str:
    """Return the state of the best verdict of a model on a shape's things."""
    states = {str(v["state"]) for v in one.row["verdicts"] if v["model"] == name}
    return next((s for s in ("holds", "unknown", "fails") if s in states), "none")


def _figures(text: str, half: str, found: Sequence[Judged]) -> Row:
    each = {name: recall(found, name) for name in CLASSES}
    every = _sum_up(each.values())
    on_legs = [one for one in found if one.task.name not in NO_LEGS]
    accuracy = confusion(found).accuracy
    return {
        "text": text,
        "half": half,
        **{f"recall of {name}": _share(each[name]) for name in CLASSES},
        "recall": _share(every),
        "recall on legs": _share(_sum_up(recall(on_legs, name) for name in CLASSES)),
        "accuracy": _share(accuracy),
    }


def _sum_up(parts: Iterable[Proportion]) -> Proportion:
    """Return what several proportions are together."""
    some = list(parts)
    return Proportion(sum(p.hits for p in some), sum(p.of for p in some))


def _share(part: Proportion) -> str:
    return f"{part.value or 0.0:.3f} ({part.hits} of {part.of})"


def _missed(text: str, found: Sequence[Judged]) -> list[Row]:
    """Return shapes of the development half of which their own text does not hold."""
    rows: list[Row] = []
    for one in found:
        name = _label(one.task)
        if name in CLASSES and not is_held_out(one.task.name):
            state = _state(one, name)
            if state != "holds":
                rows.append({"text": text, "shape": one.task.name, "label": name, "state": state})
    return rows


def measure(_settings: Settings) -> Report:
    """Return both tables; without the third-party data the benchmark is skipped."""
    folder = find_data_set("shapes")
    if isinstance(folder, str):
        return Report(NAME, skipped=folder)
    texts = [(FOLDER / f"{text}.model",) for text in TEXTS]
    every = judge_by_each(list_file_tasks(folder)["meshes"], texts)
    figures: list[Row] = []
    missed: list[Row] = []
    for text, found in zip(TEXTS, zip(*every, strict=True), strict=True):
        halves = [
            (half, [one for one in found if is_held_out(one.task.name) == held])
            for half, held in HALVES
        ]
        figures += [_figures(text, half, some) for half, some in [*halves, ("all", list(found))]]
        missed += _missed(text, found)
    return Report(
        NAME,
        (
            Table("Recall, whichever text holds beside it, and four answers", tuple(figures)),
            Table("Development half: not held by their own text", tuple(missed)),
        ),
        {"shapes": hash_tree(folder), "texts": hash_tree(FOLDER)},
        ("Wanted: recall 0.88 by three to six conditions, accuracy 0.93 by up to twelve.",),
    )
