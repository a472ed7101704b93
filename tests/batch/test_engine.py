"""Scenes into rows, of which a bad one costs no other."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.batch.confusion import answer
from facetlog.batch.engine import SceneEngine
from facetlog.batch.rows import HOLDS
from facetlog.batch.settings import Item, Settings
from facetlog.kb.recognize import judge_scene, open_knowledge_base
from facetlog.perception.facts import all_facts
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


def test_a_scene_that_facts_cannot_be_made_of_costs_no_other(
    engine: SceneEngine, items: list[Item], monkeypatch: pytest.MonkeyPatch
) -> None:
    made = all_facts.fact_columns

    def failing(scene: Scene, kinds: set[str]) -> object:
        if len(scene.faces) == 5:
            raise ZeroDivisionError("a wedge")
        return made(scene, kinds)

    monkeypatch.setattr(all_facts, "fact_columns", failing)
    rows = list(map(engine.row, items))
    assert [row["path"] for row in rows] == [item.path for item in items]
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
