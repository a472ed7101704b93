"""What differs between two tables of results."""

from copy import deepcopy
from typing import Any

import pytest

from facetlog.batch.compare import (
    Comparison,
    check_same_options,
    keep_older_options,
)
from facetlog.batch.settings import Item, Settings
from facetlog.errors import InputError
from tests.batch.fake_worker import fake_row

PATH = __file__


def _changed(**change: Any) -> list[tuple[str, str, str, str]]:
    old = fake_row(PATH, ())
    new = deepcopy(old)
    new["verdicts"][1].update(change)
    comparison = Comparison({PATH: old})
    comparison.add(new)
    return [(c.thing, c.model, c.before, c.now) for c in comparison.changes]


@pytest.mark.parametrize(
    "change",
    [{}, {"degree": 0.004}, {"parts": []}, {"confidence": 0.5}],
)
def test_what_reads_the_same_is_no_change(change: dict[str, Any]) -> None:
    assert _changed(**change) == []


@pytest.mark.parametrize(
    ("change", "now"),
    [
        ({"state": "holds", "degree": 0.93, "degree_at_most": 0.93}, "holds 93 %"),
        ({"state": "unknown", "degree_at_most": 0.5}, "unknown 0–50 %"),
        ({"degree": 0.02, "degree_at_most": 0.02}, "fails 2 %"),
    ],
)
def test_states_and_degrees_that_differ_are_changes(change: dict[str, Any], now: str) -> None:
    assert _changed(**change) == [("t1", "table", "fails 0 %", now)]


def test_an_error_is_a_change_and_a_new_scene_is_none() -> None:
    row = fake_row(PATH, ())
    comparison = Comparison({PATH: row, "absent": fake_row("absent", ())})
    comparison.add({**row, "error": "no", "verdicts": []})
    comparison.add(fake_row("absent", ()))
    comparison.add({**row, "path": "new"})
    assert [(c.before, c.now) for c in comparison.changes] == [("verdicts", "no")]
    assert list(comparison.lines())[-1] == (
        "1 verdict of 1 scene differs, of 2 compared; 1 scene is new"
    )


def test_rows_that_were_read_otherwise_are_counted_not_compared() -> None:
    comparison = Comparison({PATH: fake_row(PATH, (), "up=z unit=m degrees")})
    comparison.add(fake_row(PATH, ("better",), "up=y unit=m degrees"))
    assert comparison.changes == []
    assert list(comparison.lines()) == [
        "0 verdicts of 0 scenes differ, of 0 compared",
        "1 scene was read with other options than then, and not compared",
    ]
    assert comparison.to_json()["read_otherwise"] == 1


@pytest.mark.parametrize(
    ("given", "read"),
    [
        ({"up": False, "unit": False}, "up=z unit=mm degrees"),
        ({"up": True, "unit": False}, "up=x unit=mm degrees"),
        ({"up": True, "unit": True}, "up=x unit=m degrees"),
    ],
)
def test_options_that_are_not_given_are_those_of_then(given: dict[str, bool], read: str) -> None:
    settings = Settings(up="x", unit="m")
    old = {"a.ply": fake_row("a.ply", (), "up=z unit=mm degrees")}
    items = keep_older_options(
        [Item("a.ply"), Item("new.ply"), Item("a.ply", up="-y")], old, **given
    )
    assert items[0].read_as(settings) == read
    assert items[1] == Item("new.ply")
    assert items[2].up == "-y"


def test_scenes_that_are_all_read_otherwise_are_refused() -> None:
    old = {path: fake_row(path, ()) for path in ("a.json", "b.json")}
    items = tuple(map(Item, (*old, "new.json")))
    check_same_options(items, Settings(), old)
    check_same_options(items[2:], Settings(crisp=True), old)
    with pytest.raises(InputError, match="other options: degrees, now crisp: leave those out"):
        check_same_options(items, Settings(crisp=True), old)
