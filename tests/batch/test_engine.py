"""Scenes into rows: many at once as each alone, and a bad one costs no other."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from facetlog.batch import engine as engine_module
from facetlog.batch.confusion import answer
from facetlog.batch.engine import SceneEngine
from facetlog.batch.rows import HOLDS
from facetlog.batch.settings import Item, Settings
from facetlog.kb.recognize import judge_scene, open_knowledge_base
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.polyhedra import chair, cuboid, table, wedge
from facetlog.perception.surfaces.scene_file import write_scene


@pytest.fixture(scope="module")
def engine() -> Iterator[SceneEngine]:
    made = SceneEngine(Settings())
    yield made
    made.close()


@pytest.fixture
def items(tmp_path: Path) -> list[Item]:
    for i, scene in enumerate((chair(), cuboid(0.3, 0.2, 0.1), table(), wedge())):
        write_scene(scene, tmp_path / f"{i}.json")
    (tmp_path / "bad.json").write_text("{")
    names = ("0.json", "bad.json", "1.json", "gone.json", "2.json", "gone.ply", "3.json")
    return [Item(str(tmp_path / name)) for name in names]


def _said(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{**row, "seconds": 0.0} for row in rows]


@pytest.mark.parametrize("most", [1, 20_000, 10**6])
@pytest.mark.slow
def test_scenes_read_together_have_the_rows_that_each_has_alone(
    most: int, engine: SceneEngine, items: list[Item], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engine_module, "BYTES_AT_ONCE", most)
    rows = list(engine.rows(items))
    assert [row["path"] for row in rows] == [item.path for item in items]
    assert [row["error"] is None for row in rows] == [True, False, True, False, True, False, True]
    assert _said(rows) == _said([engine.row(item) for item in items])


def test_a_scene_that_facts_cannot_be_made_of_costs_no_other(
    engine: SceneEngine, items: list[Item], monkeypatch: pytest.MonkeyPatch
) -> None:
    made = engine_module.fact_columns

    def failing(scenes: list[Scene], kinds: set[str]) -> object:
        if any(len(scene.faces) == 5 for scene in scenes):
            raise ZeroDivisionError("a wedge")
        return made(scenes, kinds)

    monkeypatch.setattr(engine_module, "fact_columns", failing)
    rows = list(engine.rows(items))
    assert rows[-1]["error"] == f"{items[-1].path}: ZeroDivisionError: a wedge"
    assert [row["error"] is None for row in rows] == [True, False, True, False, True, False, False]


@pytest.mark.slow
def test_table_matrix_and_python_give_one_answer_and_users_models_come_first(
    items: list[Item], tmp_path: Path
) -> None:
    own = tmp_path / "trolley.model"
    own.write_text("model trolley\n  face deck where deck is level\n\n  up: deck is upward\n")
    engine = SceneEngine(Settings(models=(str(own),)))
    try:
        row = engine.row(items[4])
    finally:
        engine.close()
    facts = [fact.row for fact in scene_facts(table())]
    with open_knowledge_base([own]) as base:
        found = judge_scene(base, "s", facts)
    named = [verdict.model for verdict in found.best]
    assert named[0] == "trolley"
    assert "table" in named
    assert row["model"] == "trolley" == answer(row, ("table", "trolley"))[0]
    assert [v["model"] for v in row["verdicts"] if v["state"] == HOLDS] == named
