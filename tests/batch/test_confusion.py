"""The confusion matrix: what is counted, and what the shares are of."""

import pytest

from facetlog.batch.confusion import Confusion, Proportion, answer
from facetlog.batch.labels import Label, truths
from facetlog.batch.rows import Row

CLASSES = ("chair", "table", "box")


def _row(path: str, error: str | None = None, **degrees: float) -> Row:
    verdicts = [
        {
            "model": model,
            "state": "holds" if degree else "fails",
            "degree": degree,
            "confidence": degree / 2,
        }
        for model, degree in degrees.items()
    ]
    return {"path": path, "verdicts": verdicts, "error": error, "warnings": []}


def _counted(*cases: tuple[str, Row], count_as: tuple[str, ...] = ()) -> Confusion:
    labels = {row["path"]: Label(row["path"], label) for label, row in cases}
    confusion = Confusion(labels, CLASSES, truths(count_as, CLASSES))
    for _, row in cases:
        confusion.add(row)
    return confusion


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        (_row("a", table=0.8, chair=0.4), ("table", 0.8)),
        (_row("a", chair=0.4, table=0.8), ("chair", 0.4)),
        (_row("a", desk=0.9, box=0.1), ("box", 0.1)),
        (_row("a", desk=0.9), ("none", None)),
        (_row("a", error="no"), ("error", None)),
    ],
)
def test_the_answer_is_the_first_that_holds_of_the_models_asked_for(
    row: Row, expected: tuple[str, float | None]
) -> None:
    model, verdict = answer(row, CLASSES)
    assert (model, None if verdict is None else verdict["degree"]) == expected


def test_shares_are_of_what_was_counted() -> None:
    confusion = _counted(
        ("chair", _row("a", chair=1.0)),
        ("armchair", _row("b", chair=1.0)),
        ("chair", _row("c", table=1.0)),
        ("table", _row("d", table=1.0)),
        ("lamp", _row("e")),
        ("lamp", _row("f", box=0.7)),
        ("box", _row("g", error="g: empty")),
        ("desk", _row("h", table=1.0)),
        ("cabinet", _row("i", box=1.0)),
        ("cabinet", _row("j")),
        ("cabinet", _row("k", chair=1.0)),
        count_as=("armchair=chair", "desk=", "cabinet=none|box"),
    )
    confusion.add(_row("unknown", box=1.0))
    assert confusion.accuracy[:] == (5, 9)
    assert confusion.recall("chair")[:] == (2, 3)
    assert confusion.precision("chair")[:] == (2, 3)
    assert confusion.recall("box")[:] == (0, 1)
    assert confusion.precision("box")[:] == (0, 1)
    assert confusion.recall("none")[:] == (2, 4)
    assert confusion.left_out == {("desk", "table"): 1, ("cabinet", "box"): 1}
    assert confusion.unlabelled == 1
    assert [m.path for m in confusion.mistakes] == ["c", "f", "g", "k"]
    text = "\n".join(confusion.lines())
    assert "c: chair, answered table (50%)" in text
    assert "g: box, answered error: empty" in text
    assert "not counted: cabinet → box 1, desk → table 1" in text
    data = confusion.to_json()
    assert data["matrix"]["chair"] == {"chair": 2, "table": 1, "box": 0, "none": 0, "error": 0}
    assert sum(sum(row.values()) for row in data["matrix"].values()) == 9


def test_the_interval_is_wilsons() -> None:
    # Newcombe 1998, table I: 81 of 263, method 3
    low, high = Proportion(81, 263).interval or (0.0, 0.0)
    assert (round(low, 4), round(high, 4)) == (0.2553, 0.3662)
    assert Proportion(0, 0).interval is None
    assert str(Proportion(0, 0)) == "–"
