"""Reasons for mistakes, with the real engine: of the very thing and parts that the row names."""

import base64
from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.batch.engine import SceneEngine
from facetlog.batch.pages.explain import Mistaken, explained
from facetlog.batch.rows import Row, closest, read_confidence
from facetlog.batch.settings import Item, Settings
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid, table
from facetlog.perception.surfaces.scene_file import write_scene

SETTINGS = Settings()


@pytest.fixture(scope="module")
def engine() -> Iterator[SceneEngine]:
    made = SceneEngine(SETTINGS)
    yield made
    made.close()


def _mistaken(row: Row, right: str, answered: str) -> Mistaken:
    return Mistaken(right=right, answered=answered, verdicts=closest(row))


def test_both_questions_are_answered_of_the_verdict_in_the_row(
    tmp_path: Path, engine: SceneEngine
) -> None:
    write_scene(table(), tmp_path / "t.json")
    item = Item(str(tmp_path / "t.json"))
    row = engine.row(item)
    found = closest(row)["table"]
    top = found["parts"][0]["names"][0]
    told = explained(item, SETTINGS, _mistaken(row, "box", "table"))
    assert base64.b64decode(told["picture"]).startswith(b"\x89PNG")
    why_not, why = told["reasons"]
    assert why_not["title"] == "Why not box"
    assert "box" in why_not["lines"][0]
    assert why["title"] == "Why table"
    assert f"top = {top}" in "\n".join(why["lines"])
    assert why["lines"][0] == f"t1 is a table ({read_confidence(found).format(found['degree'])})"
    assert read_confidence(found).value < found["degree"]
    # One leg alone is a group all the same: it cannot be given, and the proof is told nevertheless.
    for part in closest(row)["table"]["parts"][1:]:
        part["names"] = part["names"][:1]
    again = explained(item, SETTINGS, _mistaken(row, "none", "table"))
    assert again["reasons"] == [why]


def test_what_cannot_be_told_is_said_in_place_of_the_reason(
    tmp_path: Path, engine: SceneEngine
) -> None:
    write_scene(cuboid(), tmp_path / "c.json")
    item = Item(str(tmp_path / "c.json"))
    row = engine.row(item)
    closest(row)["table"]["thing"] = "t99"
    told = explained(item, SETTINGS, _mistaken(row, "table", "box"))
    assert [reason["title"] for reason in told["reasons"]] == ["Why not table", "Why box"]
    assert "t99" in told["reasons"][0]["lines"][0]
