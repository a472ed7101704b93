"""From degree to confidence: monotone, cautious, kept as JSON, by kind of input, state and text."""

import json
from collections.abc import Callable, Sequence
from itertools import product
from pathlib import Path
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.calibration import (
    Calibration,
    Curve,
    InputKind,
    Maps,
    compute_judging_key,
    content_key,
    load_shipped_calibration,
)
from facetlog.kb.calibration_fit import (
    Sample,
    choose_form,
    compute_calibration_error,
    fit,
    held_out,
)
from facetlog.kb.explaining.proof import State
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact

Build = Callable[..., tuple[Fact, ...]]

KEYS = {"box": "k1", "table": "k2"}
PICTURES, WHOLE, SCANNED = InputKind.PICTURES, InputKind.WHOLE, InputKind.SCANNED
SOURCES = "abcdef"


def sample(
    score: float,
    truth: bool,
    model: str = "box",
    kind: InputKind = PICTURES,
    source: str = "here",
) -> Sample:
    return Sample(model, kind, source, state_at(score), score, score, truth)


def state_at(score: float) -> State:
    return State.HOLDS if score >= 0.5 else State.FAILS


def said(
    calibration: Calibration, score: float, model: str = "box", kind: InputKind = PICTURES
) -> float:
    content, state = KEYS.get(model, ""), state_at(score)
    confidence = calibration.confidence(model, content, kind, state, score, score)
    assert confidence is not None
    return confidence


def test_a_model_that_is_too_sure_is_brought_down_to_how_often_it_is_right() -> None:
    samples = [sample(0.99, i % 4 != 0) for i in range(400)] + [sample(0.0, False)] * 400
    calibration = fit(samples, KEYS)
    assert said(calibration, 0.99) == pytest.approx(0.75, abs=0.002)
    assert said(calibration, 0.0) == pytest.approx(0.5 / 401, abs=1e-6)


def test_verdicts_of_another_state_do_not_count() -> None:
    holding = [Sample("box", PICTURES, "a", State.HOLDS, 0.5, 0.5, True)] * 9
    unknown = [Sample("box", PICTURES, "a", State.UNKNOWN, 0.5, 0.5, False)] * 99
    calibration = fit(holding + unknown, KEYS)
    by_state = {s: calibration.confidence("box", "k1", PICTURES, s, 0.5, 0.5) for s in State}
    assert by_state == {State.HOLDS: 0.95, State.UNKNOWN: 0.005, State.FAILS: None}


@given(
    st.lists(
        st.tuples(st.floats(0, 1), st.booleans(), st.sampled_from(InputKind)),
        min_size=1,
        max_size=60,
    )
)
def test_a_map_never_falls_and_never_says_nought_or_one(
    drawn: Sequence[tuple[float, bool, InputKind]],
) -> None:
    calibration = fit([sample(score, truth, kind=kind) for score, truth, kind in drawn], KEYS)
    for (kind, state), maps in calibration.maps.items():
        for curve in (maps.pooled, maps.curve("box", "k1")):
            along = [curve.at(i / 200) for i in range(201)]
            assert along == sorted(along)
            assert 0.0 < along[0] <= along[-1] < 1.0
        counted = sum(k is kind and state_at(score) is state for score, _, k in drawn)
        assert maps.pooled.samples == counted


def everywhere(truth: bool, model: str = "box", kind: InputKind = PICTURES) -> list[Sample]:
    """Return five verdicts from each source."""
    return [sample(0.9, truth, model, kind, source) for source in SOURCES for _ in range(5)]


def test_models_and_kinds_have_maps_of_their_own_and_lean_on_others_where_they_have_few() -> None:
    right, wrong = everywhere(True), everywhere(False, "table")
    one = sample(0.9, True, "table", WHOLE, "a")
    samples = [*right, *wrong, *everywhere(False, kind=SCANNED), one]
    calibration = fit(samples, KEYS)
    assert said(calibration, 0.9) > 0.8
    assert said(calibration, 0.9, "table") < 0.2
    assert said(calibration, 0.9, kind=SCANNED) < 0.2
    # Of one verdict little is known: by itself 3/4, and all together are right in one of three.
    share = 1 / (1 + choose_form(samples).strength)
    of_all = (len(right) + 1 + 0.5) / (len(samples) + 1)
    of_kind = share * 0.75 + (1 - share) * of_all
    own = share * 0.75 + (1 - share) * of_kind
    assert said(calibration, 0.9, "table", WHOLE) == pytest.approx(own, abs=1e-6)
    assert calibration.maps[WHOLE, State.HOLDS].pooled.at(0.9) == pytest.approx(of_kind, abs=1e-6)
    assert Calibration().confidence("box", "k1", PICTURES, State.HOLDS, 0.9, 0.9) is None


def test_a_map_rises_only_where_degrees_say_what_is_true_of_other_sources() -> None:
    def of(steep: bool) -> list[Sample]:
        # Where it is not steep, each source has the same shares at both degrees.
        return [
            sample(score, i < (score * 10 if steep else 7), source=source)
            for source in SOURCES
            for score in (0.55, 0.95)
            for i in range(10)
        ]

    assert choose_form(of(True)).rising
    assert not choose_form(of(False)).rising
    flat = fit(of(False), KEYS)
    assert said(flat, 0.55) == said(flat, 0.95) == pytest.approx(84.5 / 121, abs=1e-2)


def test_each_source_is_told_by_the_others_alone() -> None:
    samples = [sample(0.9, True, source="a")] * 20 + [sample(0.9, False, source="b")] * 30
    by_others = held_out(samples, KEYS)
    assert by_others[:20] == pytest.approx([0.5 / 31] * 20, abs=1e-6)
    assert by_others[20:] == pytest.approx([20.5 / 21] * 30, abs=1e-6)
    assert held_out(samples[:20], KEYS) == (0.9,) * 20


def test_json_gives_back_what_was_written() -> None:
    rng = Random(1)
    samples = [
        sample(
            rng.random(),
            rng.random() < 0.5,
            rng.choice(("box", "table")),
            rng.choice(tuple(InputKind)),
        )
        for _ in range(99)
    ]
    calibration = fit(samples, KEYS)
    text = json.dumps(calibration.to_json())
    assert Calibration.from_json(json.loads(text)) == calibration


def kinds(state: str = "holds", **models: object) -> dict[str, object]:
    pooled = {"samples": 2, "knots": [[0, 0.1]]}
    kind = {"pictures": {state: {"all": pooled, "models": models}}}
    return {"schema": "facetlog-calibration/3", "kinds": kind}


@pytest.mark.parametrize(
    "data",
    [
        {},
        {"schema": "another/1", "kinds": {}},
        {"schema": "facetlog-calibration/3"},
        {"schema": "facetlog-calibration/3", "kinds": []},
        {"schema": "facetlog-calibration/3", "kinds": {"sounds": {"holds": {}}}},
        kinds("perhaps"),
        kinds(box={}),
        kinds(box={"content": "k", "samples": 2, "knots": [[0, 0.9], [1, 0.2]]}),
        kinds(box={"content": "k", "samples": 2, "knots": [[0, "x"]]}),
    ],
)
def test_what_is_no_calibration_is_refused(data: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=r"calibration|convert|InputKind|State"):
        Calibration.from_json(data)


def test_fitting_makes_the_error_small_on_samples_that_were_not_fitted() -> None:
    rng = Random(3)

    def drawn(count: int) -> list[Sample]:
        scores = [rng.random() for _ in range(count)]
        return [
            sample(score, rng.random() < score**3, source=rng.choice(SOURCES)) for score in scores
        ]

    calibration, check = fit(drawn(4000), KEYS), drawn(4000)
    truths = [s.truth for s in check]
    raw = compute_calibration_error([s.score for s in check], truths)
    after = compute_calibration_error([said(calibration, s.score) for s in check], truths)
    assert raw > 0.2
    assert after < 0.03


# --- in the knowledge base ---------------------------------------------------------------------


def calibrated(base: KnowledgeBase, model: str) -> Calibration:
    """Says 0.8 of this model as it stands and 0.3 of all others, of whatever degree in pictures;
    of things that were scanned 0.6."""
    own = {model: (base.models[model].judging, Curve(10, ((0.5, 0.8),)))}
    maps = {
        PICTURES: Maps(Curve(10, ((0.5, 0.3),)), own),
        SCANNED: Maps(Curve(10, ((0.5, 0.6),))),
    }
    return Calibration({(kind, state): maps[kind] for kind, state in product(maps, State)})


def test_a_confidence_is_that_of_how_the_thing_was_measured(facts_of: Build) -> None:
    facts = tuple(facts_of("box"))
    expected = {"pictures": 0.8, "scanned": 0.6, "whole": None}
    with KnowledgeBase() as base, BatchJudge() as judge:
        base.calibration = judge._base.calibration = calibrated(base, "box")
        for kind, confidence in expected.items():
            seen = facts if kind == "pictures" else (*facts, (kind, "t1"))
            base.load_scene(kind, seen)
            assert base.judge(kind, "box", "t1").confidence == confidence
            assert base.why(kind, "box").confidence == confidence
            assert {v.confidence for v in judge.judge(seen) if v.model == "box"} == {confidence}


def test_a_confidence_turns_no_verdict(facts_of: Build) -> None:
    with KnowledgeBase() as base:
        base.load_scene("s", facts_of("box"))
        never = Maps(Curve(10, ((0.5, 0.001),)))
        before = base.judge("s", "box", "t1")
        base.calibration = Calibration({(PICTURES, State.HOLDS): never})
        assert base.judge("s", "box", "t1") == before  # confidences are not compared
        assert before.state is State.HOLDS


def test_a_crisp_knowledge_base_has_no_confidences() -> None:
    with KnowledgeBase(crisp=True) as base:
        assert base.calibration == Calibration()


def test_parts_that_the_model_did_not_choose_have_no_confidence(facts_of: Build) -> None:
    with KnowledgeBase() as base:
        base.load_scene("s", facts_of("table"))
        base.calibration = calibrated(base, "table")
        top = base.why("s", "table").parts[0]
        assert base.why("s", "table", parts={top.role: top.faces[0]}).confidence is None
        assert all(v.confidence is None for v in base.why_not("s", "table"))


def test_a_users_model_in_a_built_in_ones_place_has_the_map_of_all(
    facts_of: Build, tmp_path: Path
) -> None:
    with KnowledgeBase() as base:
        base.load_scene("s", facts_of("box"))
        base.calibration = calibrated(base, "box")
        builtin = base.models["box"].path.read_text(encoding="utf-8")
        other = tmp_path / "box.pl"
        other.write_text(builtin + "extra(1).\n")
        base.load_rules(other, trusted=True)
        assert base.judge("s", "box", "t1").confidence == 0.3
        other.write_text(builtin + "% A comment says nothing.\n")
        base.load_rules(other, trusted=True)
        assert base.judge("s", "box", "t1").confidence == 0.8


def test_the_shipped_calibration_is_of_the_built_in_models_as_they_are() -> None:
    shipped = load_shipped_calibration()
    assert set(shipped.maps) == set(product(InputKind, State))
    with KnowledgeBase() as base:
        contents = {model: rules.judging for model, rules in base.models.items()}
    for kind in InputKind:
        assert sum(shipped.maps[kind, state].pooled.samples for state in State) >= 100
    for maps in shipped.maps.values():
        counted = {model: content for model, (content, _) in maps.models.items()}
        assert counted.items() <= contents.items()


BOXES = "model(box).\n\ncondition(box, 'one. two', 1).\n"
SIZES = (
    "% box.model:7\nsize(box, _, [A], length, length(A)).\n"
    "% box.model:8\nsize(box, _, [A], Name, Measure) :-\n"
    "    longest_first([0.5*length(A), width(A)], Sorted),\n    nth1(1, Sorted, Measure).\n"
)


@pytest.mark.parametrize("sizes", [SIZES, "\n" + SIZES, SIZES.replace("length", "width")])
def test_sizes_that_a_verdict_reports_do_not_make_another_model(sizes: str) -> None:
    assert compute_judging_key(BOXES + sizes) == compute_judging_key(BOXES)
    assert compute_judging_key(sizes + BOXES) == compute_judging_key(BOXES)
    assert content_key(BOXES + sizes) != content_key(BOXES)


def test_what_judges_beside_a_size_makes_another_model() -> None:
    key = compute_judging_key(BOXES + SIZES)
    assert compute_judging_key(BOXES + SIZES + "condition(box, 2).\n") != key
    assert compute_judging_key(BOXES + "resize(box).\n" + SIZES) != key
    assert compute_judging_key(BOXES.replace("1)", "2)") + SIZES) != key
