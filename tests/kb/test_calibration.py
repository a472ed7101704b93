"""From degree to probability: monotone, cautious, kept as JSON, and only for the text it was of."""

import json
from collections.abc import Callable
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import isotonic_regression

from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.calibration import (
    Calibration,
    ModelCalibration,
    Sample,
    content_key,
    expected_calibration_error,
    fit,
    reliability_table,
    shipped_calibration,
)
from facetlog.kb.explaining.proof import State
from facetlog.kb.knowledge_base import BUILTIN_MODELS, KnowledgeBase
from facetlog.kb.loading.encode import Fact

Build = Callable[..., tuple[Fact, ...]]

COPIES = 100  # of each sample, beside which the prior nearly vanishes
KEYS = {"box": "k1", "table": "k2"}


def sample(score: float, truth: bool, model: str = "box") -> Sample:
    return Sample(model, State.HOLDS if score >= 0.5 else State.FAILS, score, score, truth)


def said(calibration: Calibration, score: float, model: str = "box") -> float:
    probability = calibration.probability(model, score, score)
    assert probability is not None
    return probability


def test_a_model_that_is_too_sure_is_brought_down_to_how_often_it_is_right() -> None:
    samples = [sample(0.99, i % 4 != 0) for i in range(400)] + [sample(0.0, False)] * 400
    calibration = fit(samples, KEYS)
    assert said(calibration, 0.99) == pytest.approx(0.75, abs=0.002)
    assert said(calibration, 0.0) == pytest.approx(0.5 / 401, abs=1e-6)


def test_the_score_is_the_middle_of_the_bounds() -> None:
    calibration = fit([sample(0.5, i < 3) for i in range(10)], KEYS)
    assert Sample("box", State.UNKNOWN, 0.2, 0.9, True).score == pytest.approx(0.55)
    assert calibration.probability("box", 0.0, 1.0) == pytest.approx(3.5 / 11)


@pytest.mark.parametrize("truth", [True, False])
def test_few_samples_never_say_nought_or_one(truth: bool) -> None:
    few = said(fit([sample(0.9, truth)], KEYS), 0.9)
    more = said(fit([sample(0.9, truth)] * 50, KEYS), 0.9)
    assert few == (0.75 if truth else 0.25)
    assert (few < more < 1.0) if truth else (few > more > 0.0)


@settings(deadline=None)
@given(st.lists(st.tuples(st.floats(0, 1), st.booleans()), min_size=1, max_size=60))
def test_a_map_never_falls_and_never_says_nought_or_one(pairs: list[tuple[float, bool]]) -> None:
    calibration = fit([sample(score, truth) for score, truth in pairs], KEYS)
    along = [said(calibration, i / 200) for i in range(201)]
    assert along == sorted(along)
    assert 0.0 < along[0] <= along[-1] < 1.0
    assert calibration.models["box"].samples == len(pairs)


@settings(deadline=None)
@given(st.lists(st.tuples(st.floats(0, 1), st.booleans()), min_size=1, max_size=60))
def test_pooled_steps_are_the_least_squares_map(pairs: list[tuple[float, bool]]) -> None:
    """As scipy's isotonic regression has it, but for the prior."""
    by_score: dict[float, list[bool]] = {}
    for score, truth in pairs:
        by_score.setdefault(round(score, 6), []).append(truth)
    scores = sorted(by_score)
    shares = [sum(by_score[s]) / len(by_score[s]) for s in scores]
    weights = [float(len(by_score[s])) for s in scores]
    expected = isotonic_regression(shares, weights=weights).x
    copies = [sample(s, t) for s in scores for t in by_score[s] for _ in range(COPIES)]
    calibration = fit(copies, KEYS)
    assert [said(calibration, s) for s in scores] == pytest.approx(expected.tolist(), abs=0.006)


def test_between_two_steps_the_map_is_straight() -> None:
    samples = [sample(0.2, False)] * 9 + [sample(0.6, True)] * 9
    calibration = fit(samples, KEYS)
    low, high = said(calibration, 0.2), said(calibration, 0.6)
    assert (low, high) == (0.05, 0.95)
    assert said(calibration, 0.3) == pytest.approx(low + (high - low) / 4)
    assert said(calibration, 0.0) == low
    assert said(calibration, 1.0) == high


def test_each_model_has_a_map_of_its_own() -> None:
    samples = [sample(0.9, True)] * 20 + [sample(0.9, False, "table")] * 20
    calibration = fit(samples, KEYS)
    assert said(calibration, 0.9) > 0.9
    assert said(calibration, 0.9, "table") < 0.1
    assert calibration.probability("chair", 0.9, 0.9) is None
    assert Calibration().probability("box", 0.9, 0.9) is None


def test_another_text_of_a_model_is_not_calibrated() -> None:
    key = content_key("model(box, ...).")
    calibration = fit([sample(0.9, True)], {"box": key})
    assert calibration.probability("box", 0.9, 0.9, content=key) is not None
    changed = content_key("model(box, ....).")
    assert calibration.probability("box", 0.9, 0.9, content=changed) is None
    assert calibration.probability("box", 0.9, 0.9, content="") is None


def test_a_model_without_a_key_cannot_be_fitted() -> None:
    with pytest.raises(KeyError, match="sofa"):
        fit([sample(0.9, True, "sofa")], KEYS)


def test_json_gives_back_what_was_written() -> None:
    rng = Random(1)
    samples = [
        sample(rng.random(), rng.random() < 0.5, rng.choice(("box", "table"))) for _ in range(99)
    ]
    calibration = fit(samples, KEYS)
    text = json.dumps(calibration.to_json())
    assert Calibration.from_json(json.loads(text)) == calibration


@pytest.mark.parametrize(
    "data",
    [
        {},
        {"schema": "another/1", "models": {}},
        {"schema": "facetlog-calibration/1"},
        {"schema": "facetlog-calibration/1", "models": []},
        {"schema": "facetlog-calibration/1", "models": {"box": {}}},
        {
            "schema": "facetlog-calibration/1",
            "models": {"box": {"content": "k", "samples": 2, "knots": [[0, 0.9], [1, 0.2]]}},
        },
        {
            "schema": "facetlog-calibration/1",
            "models": {"box": {"content": "k", "samples": 2, "knots": [[0, "x"]]}},
        },
    ],
)
def test_what_is_no_calibration_is_refused(data: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=r"calibration|convert"):
        Calibration.from_json(data)


@pytest.mark.parametrize("knots", [(), ((0.5, 1.5),), ((0.5, 0.5), (0.4, 0.6))])
def test_knots_that_are_no_map_are_refused(knots: tuple[tuple[float, float], ...]) -> None:
    with pytest.raises(ValueError, match="calibration"):
        ModelCalibration("k", 1, knots)


def test_the_error_of_a_perfect_and_of_a_boasting_forecast() -> None:
    perfect = [0.25] * 40, [i % 4 == 0 for i in range(40)]
    assert expected_calibration_error(*perfect) == pytest.approx(0.0)
    assert expected_calibration_error([0.95] * 10, [i < 5 for i in range(10)]) == pytest.approx(
        0.45
    )
    assert expected_calibration_error([], []) == 0.0


def test_the_error_weighs_bins_by_what_they_hold() -> None:
    said, true = [0.05] * 30 + [0.85] * 10, [False] * 30 + [True] * 10
    assert expected_calibration_error(said, true) == pytest.approx((30 * 0.05 + 10 * 0.15) / 40)


def test_a_reliability_table_has_every_sample_once() -> None:
    rng = Random(2)
    said = [0.0, 1.0, *(rng.random() for _ in range(200))]
    true = [rng.random() < 0.3 for _ in said]
    table = reliability_table(said, true, bins=5)
    assert sum(row.count for row in table) == len(said)
    assert sum(row.count * row.true for row in table) == pytest.approx(sum(true))
    assert all(row.low <= row.said <= row.high for row in table)
    assert table[-1].high == 1.0


def test_what_is_no_probability_or_lacks_its_truth_is_refused() -> None:
    with pytest.raises(ValueError, match="no probability"):
        reliability_table([1.01], [True])
    with pytest.raises(ValueError, match="shorter"):
        reliability_table([0.5, 0.5], [True])


def test_fitting_makes_the_error_small_on_samples_that_were_not_fitted() -> None:
    rng = Random(3)

    def drawn(count: int) -> list[Sample]:
        scores = [rng.random() for _ in range(count)]
        return [sample(score, rng.random() < score**3) for score in scores]

    calibration, check = fit(drawn(4000), KEYS), drawn(4000)
    truths = [s.truth for s in check]
    raw = expected_calibration_error([s.score for s in check], truths)
    after = expected_calibration_error([said(calibration, s.score) for s in check], truths)
    assert raw > 0.2
    assert after < 0.03


# --- in the knowledge base ---------------------------------------------------------------------


def calibrated(base: KnowledgeBase, model: str) -> Calibration:
    """A calibration that says 0.8 of this model as it stands, of whatever degree."""
    fitted = ModelCalibration(base.models[model].content, 10, ((0.5, 0.8),))
    return Calibration({model: fitted})


def test_of_what_is_known_from_its_surface_no_probability_is_said(facts_of: Build) -> None:
    facts = tuple(facts_of("box"))
    for surface in ("whole", "scanned"):
        with KnowledgeBase() as base:
            base.load_scene("pictures", facts)
            base.load_scene("surface", (*facts, (surface, "t1")))
            assert base.why("pictures", "box").probability is not None
            assert base.why("surface", "box").probability is None
            assert base.judge("surface", "box", "t1").probability is None
        with BatchJudge() as judge:
            assert {v.probability for v in judge.judge((*facts, (surface, "t1")))} == {None}


def test_a_verdict_has_the_probability_of_its_model(facts_of: Build) -> None:
    with KnowledgeBase() as base:
        base.load_scene("s", facts_of("box"))
        base.calibration = calibrated(base, "box")
        verdict = base.judge("s", "box", "t1")
        assert verdict.probability == 0.8
        assert verdict.degree > 0.95
        assert verdict.to_json()["probability"] == 0.8
        assert base.why("s", "box").probability == 0.8
        assert base.judge("s", "table", "t1").probability is None


def test_a_crisp_knowledge_base_has_no_probabilities() -> None:
    with KnowledgeBase(crisp=True) as base:
        assert base.calibration == Calibration()


def test_a_verdict_on_nothing_has_no_probability() -> None:
    with KnowledgeBase() as base:
        base.load_scene("s", [("scene", "s")])
        base.calibration = calibrated(base, "box")
        verdict = base.why("s", "box")
        assert not verdict.thing
        assert verdict.probability is None


def test_parts_that_the_model_did_not_choose_have_no_probability(facts_of: Build) -> None:
    with KnowledgeBase() as base:
        base.load_scene("s", facts_of("table"))
        base.calibration = calibrated(base, "table")
        top = base.why("s", "table").parts[0]
        assert base.why("s", "table", parts={top.role: top.faces[0]}).probability is None
        assert all(v.probability is None for v in base.why_not("s", "table"))


def test_a_users_model_in_a_built_in_ones_place_is_not_calibrated(
    facts_of: Build, tmp_path: Path
) -> None:
    with KnowledgeBase() as base:
        base.load_scene("s", facts_of("box"))
        base.calibration = calibrated(base, "box")
        builtin = base.models["box"].path.read_text(encoding="utf-8")
        other = tmp_path / "box.pl"
        other.write_text(builtin + "extra(1).\n")
        base.load_rules(other, trusted=True)
        assert base.judge("s", "box", "t1").probability is None
        other.write_text(builtin + "% A comment says nothing.\n")
        base.load_rules(other, trusted=True)
        assert base.judge("s", "box", "t1").probability == 0.8


def test_the_shipped_calibration_is_of_built_in_models_and_of_enough_things() -> None:
    shipped = shipped_calibration()
    assert shipped.models
    assert set(shipped.models) <= set(BUILTIN_MODELS)
    assert all(fitted.samples >= 100 for fitted in shipped.models.values())
