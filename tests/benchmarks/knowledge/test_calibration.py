"""The calibration benchmark: truths for every world, facts kept by content, figures that add up."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.common import Settings, text
from benchmarks.knowledge import calibration_scenes
from benchmarks.knowledge.calibration import estimate_chance_error, judged, report, write
from benchmarks.knowledge.calibration_scenes import (
    LABELS,
    OPEN,
    LabelledScene,
    find_main_thing,
    load_tour_scene,
    truth,
)
from benchmarks.pictures.recognition import tour_views
from facetlog.kb.calibration import Calibration
from facetlog.kb.calibration_fit import Sample, fit
from facetlog.kb.explaining.proof import State
from facetlog.kb.loading.encode import Fact
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.reading.read_views import ViewSet
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.exact_solids.polyhedra import moved, together
from facetlog.robot.tour import tour_poses


def facts_of(scene: Scene) -> tuple[Fact, ...]:
    return tuple(fact.row for fact in scene_facts(scene))


def exact(world: str, builder: str) -> LabelledScene:
    facts = facts_of(build(builder, {}))
    return LabelledScene(world, f"tours: {world}", facts, find_main_thing(facts))


@pytest.fixture(scope="module")
def found() -> tuple[Sample, ...]:
    scenes = [exact("boxes", "cuboid"), exact("cabinet", "cabinet"), exact("tables", "table")]
    return judged(
        [*scenes, exact("bench", "bench"), LabelledScene("cylinder", "tours: cylinder", (), None)]
    )


@pytest.mark.parametrize(
    ("label", "model", "expected"),
    [
        ("armchair", "chair", True),
        ("table", "chair", False),
        ("desk", "table", None),
        ("desk", "desk", True),
        ("cabinet", "box", None),
        ("vase", "box", False),
    ],
)
def test_every_label_of_a_shape_has_its_truth(
    label: str, model: str, expected: bool | None
) -> None:
    assert truth(LabelledScene(label, "kenney", (), None), model) is expected
    assert set(LABELS) >= {"box", "chair", "table"}


def test_the_main_thing_is_the_one_of_the_largest_faces() -> None:
    small = moved(build("cuboid", {}), translation=(5.0, 0.0, 0.0), scale=0.2)
    for scenes in ((small, build("cuboid", {})), (build("cuboid", {}), small)):
        facts = facts_of(together(*scenes))
        (larger,) = (f[1] for f in facts if f[0] == "thing_size" and float(f[2]) > 0.1)
        assert find_main_thing(facts) == larger
    assert find_main_thing([("thing", "t2"), ("thing", "t1")]) == "t1"
    assert find_main_thing([("scene", "s")]) is None


@pytest.fixture
def reconstructed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[float]:
    """How far from the origin the first camera of each reconstruction was, metres."""
    calls: list[float] = []

    def reconstruct(view_set: ViewSet, **_: object) -> Scene:
        calls.append(float(abs(view_set.views[0].pose.centre).max()))
        return build("cuboid", {})

    two = tour_views("block", 0, poses=tour_poses()[:2])
    monkeypatch.setattr(calibration_scenes, "tour_views", lambda *_: two)
    monkeypatch.setattr(calibration_scenes, "reconstruct_views", reconstruct)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return calls


def test_facts_are_kept_by_world_and_seed_and_code(
    reconstructed: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    load_tour_scene("tables", 3)
    load_tour_scene("tables", 4)
    made = calibration_scenes.make_world
    monkeypatch.setattr(
        calibration_scenes, "make_world", lambda *a: replace(made(*a), exposure=1.0)
    )
    load_tour_scene("tables", 3)
    monkeypatch.setattr(calibration_scenes, "_code", lambda _: "another")
    load_tour_scene("tables", 3)
    assert len(reconstructed) == 4


def test_every_model_is_asked_of_every_thing_but_where_people_differ(
    found: tuple[Sample, ...],
) -> None:
    models = {sample.model for sample in found}
    worlds = ("boxes", "cabinet", "tables", "bench")
    open_ones = sum(world in worlds and model in models for world, model in OPEN)
    assert len(found) == 4 * len(models) - open_ones
    assert sum(s.truth for s in found if s.model in ("box", "table", "chair")) == 2
    holding = {(s.source, s.model) for s in found if s.state is State.HOLDS}
    assert {("tours: boxes", "box"), ("tours: bench", "table")} <= holding


def test_the_report_counts_scenes_sources_and_samples(found: tuple[Sample, ...]) -> None:
    said = report(Settings(), found)
    sources, errors, models, before, after, weights = said.tables
    assert len(sources.rows) == 4
    assert errors.rows[0]["of"] == "all"
    assert errors.rows[0]["pairs"] == len(found)
    holding = sum(s.state is State.HOLDS for s in found)
    for table in (before, after):
        assert sum(int(str(row["verdicts"])) for row in table.rows) == holding > 0
    assert [row["verdicts"] for row in models.rows[:1]] == [holding]
    assert {row["state"] for row in weights.rows} == {s.state.value for s in found}
    lines = "\n".join(text(said.to_json()))
    assert "ECE calibrated" in lines
    assert "--fit writes this one" in lines


def test_chance_alone_makes_an_error_that_falls_with_the_number_of_verdicts() -> None:
    # Of one bin: the mean of |binomial share - p|, sqrt(2 p (1 - p) / (pi n)) for many.
    few, many = estimate_chance_error([0.3] * 100), estimate_chance_error([0.3] * 400)
    assert few == pytest.approx((2 * 0.21 / (math.pi * 100)) ** 0.5, rel=0.05)
    assert many == pytest.approx(few / 2, rel=0.1)
    assert estimate_chance_error([0.0, 1.0]) == 0.0


def test_what_is_written_is_the_calibration(found: tuple[Sample, ...], tmp_path: Path) -> None:
    calibration = fit(found)
    write(calibration, tmp_path / "c.json")
    kept = json.loads((tmp_path / "c.json").read_text(encoding="utf-8"))
    assert Calibration.from_json(kept) == calibration
