"""From degree to confidence: monotone, cautious, kept as JSON, by kind of input, state and text."""

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.calibration import (
    FEATURES,
    Calibration,
    Counted,
    Evidence,
    InputKind,
    Scale,
    compute_judging_key,
    content_key,
    load_shipped_calibration,
)
from facetlog.kb.calibration_fit import (
    Sample,
    compute_calibration_error,
    compute_error_by_model,
    fit,
    held_out,
    read_samples,
    write_samples,
)
from facetlog.kb.confidence import Confidence
from facetlog.kb.explaining.proof import State
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact

Build = Callable[..., tuple[Fact, ...]]

PICTURES, WHOLE, SCANNED = InputKind.PICTURES, InputKind.WHOLE, InputKind.SCANNED
SOURCES = "abcdef"
HOLDS = State.HOLDS


def sample(
    degree: float,
    truth: bool,
    model: str = "box",
    kind: InputKind = WHOLE,
    source: str = "here",
) -> Sample:
    return Sample(model, f"key of {model}", kind, source, HOLDS, degree, degree, truth)


def ask(
    calibration: Calibration,
    degree: float,
    model: str = "box",
    kind: InputKind = WHOLE,
    views: int = 0,
    seen: float = 1.0,
) -> Confidence:
    evidence = Evidence(kind, views, seen)
    return calibration.compute(model, f"key of {model}", HOLDS, degree, evidence)


def value(confidence: Confidence) -> float:
    assert confidence.value is not None
    return confidence.value


def test_a_model_that_is_too_sure_is_brought_down_to_how_often_it_is_right() -> None:
    found = ask(fit(sample(0.99, i % 4 != 0) for i in range(400)), 0.99)
    assert found.value == pytest.approx(0.75, abs=0.01)
    assert (found.cases, found.true, found.is_wide) == (400, 300, False)
    assert found.format(0.99) == "75%"


def test_few_cases_give_an_interval_and_none_give_a_wider_one() -> None:
    many = [sample(0.9, i % 8 != 0, source=SOURCES[i % 6]) for i in range(96)]
    few = [sample(0.9, True, "table")] * 4
    elsewhere = [sample(0.9, True, "bed", PICTURES)]
    calibration = fit([*many, *few, *elsewhere])
    box, table, bed = (ask(calibration, 0.9, model) for model in ("box", "table", "bed"))
    assert not box.is_wide
    assert table.is_wide
    assert value(table) < 1.0
    assert table.format(0.9).startswith("few cases: ")
    assert (bed.cases, bed.is_wide) == (0, True)
    assert width(box) < width(table) < width(bed)


def width(confidence: Confidence) -> float:
    assert confidence.low is not None
    assert confidence.high is not None
    return confidence.high - confidence.low


def test_a_model_without_cases_or_of_another_text_has_no_confidence_and_a_reason() -> None:
    calibration = fit([sample(0.9, True)] * 9)
    other = calibration.compute("box", "another text", HOLDS, 0.9, Evidence(WHOLE))
    for found in (ask(calibration, 0.9, "trolley"), other, ask(Calibration(), 0.9)):
        assert found.value is found.low is found.high is None
        assert found.origin == found.reason != ""
        assert found.format(0.9) == "degree 90%"


shares = st.floats(0, 1)
samples_drawn = st.lists(
    st.builds(
        Sample,
        st.sampled_from(("box", "table")),
        st.just("key"),
        st.sampled_from(InputKind),
        st.sampled_from(SOURCES),
        st.sampled_from(State),
        shares,
        shares,
        st.booleans(),
        st.integers(0, 40),
        shares,
    ),
    min_size=1,
    max_size=40,
)


@given(samples_drawn, st.sampled_from(State), st.sampled_from(InputKind))
def test_confidences_rise_with_the_degree_and_the_evidence_and_never_say_nought_or_one(
    drawn: Sequence[Sample], state: State, kind: InputKind
) -> None:
    calibration = fit(drawn)
    ladders = (
        [(i / 50, Evidence(kind, 8, 0.7)) for i in range(51)],
        [(0.6, Evidence(kind, views, 0.7)) for views in range(41)],
        [(0.6, Evidence(kind, 8, i / 50)) for i in range(51)],
    )
    for rungs in ladders:
        found = [calibration.compute("box", "key", state, *rung) for rung in rungs]
        if found[0].value is None:
            continue
        values = [value(one) for one in found]
        lows, highs = [one.low or 0.0 for one in found], [one.high or 0.0 for one in found]
        for along in (lows, values, highs):
            assert along == sorted(along)
            assert 0.0 < along[0] <= along[-1] < 1.0
        assert all(low <= said <= high for low, said, high in zip(lows, values, highs, strict=True))


def test_a_model_with_few_cases_leans_on_all_others() -> None:
    pool = [
        sample(0.9, i != 0, f"m{n}", source=source)
        for n in range(8)
        for source in SOURCES
        for i in range(5)
    ]
    wrong = sample(0.9, False, "new")
    alone, among = (value(ask(fit(some), 0.9, "new")) for some in ([wrong], [wrong, *pool]))
    assert alone < 0.5
    assert alone < among < value(ask(fit(pool), 0.9, "m0"))


def test_intervals_hold_the_true_share_nine_times_in_ten() -> None:
    """Models whose true shares scatter, each with few to many cases: what is said of them."""
    rng = np.random.default_rng(5)
    held = []
    for _ in range(20):
        shares = 1 / (1 + np.exp(-rng.normal(1.5, 1.5, size=12)))
        counts = rng.integers(1, 40, size=12)
        drawn = [
            sample(1.0, bool(rng.random() < share), f"m{i}")
            for i, (share, count) in enumerate(zip(shares, counts, strict=True))
            for _ in range(count)
        ]
        calibration = fit(drawn)
        for i, share in enumerate(shares):
            found = ask(calibration, 1.0, f"m{i}")
            assert found.low is not None
            assert found.high is not None
            held.append(found.low <= share <= found.high)
    # Three standard deviations of a share of .9 in 240 are .06.
    assert 0.84 <= np.mean(held) <= 0.99


def test_a_fit_is_the_same_in_any_order_and_from_kept_rows(tmp_path: Path) -> None:
    rng = Random(1)
    drawn = [
        replace(
            sample(
                rng.random(),
                rng.random() < 0.5,
                rng.choice(("box", "table")),
                rng.choice(tuple(InputKind)),
                rng.choice(("tours: box", "ikea")),
            ),
            state=rng.choice(tuple(State)),
            views=rng.randrange(30),
        )
        for _ in range(99)
    ]
    calibration = fit(drawn)
    assert fit(rng.sample(drawn, len(drawn))) == calibration
    write_samples(tmp_path / "rows.csv", drawn)
    assert fit(read_samples(tmp_path / "rows.csv")) == calibration
    assert Calibration.from_json(json.loads(json.dumps(calibration.to_json()))) == calibration


def test_samples_of_different_texts_are_refused() -> None:
    with pytest.raises(ValueError, match="different texts"):
        fit([sample(0.9, True), replace(sample(0.9, True), content="another")])


def test_each_source_is_told_by_the_others_alone() -> None:
    samples = [sample(0.9, True, source="a")] * 20 + [sample(0.9, False, source="b")] * 30
    by_others = held_out(samples)
    assert all(value(one) < 0.1 for one in by_others[:20])
    assert all(value(one) > 0.9 for one in by_others[20:])
    assert held_out(samples[:20]) == (Confidence(0.9),) * 20


def test_an_error_is_counted_by_model_and_not_within_bounds_that_were_said() -> None:
    samples = [sample(0.9, True)] * 5 + [sample(0.9, i < 3, "table") for i in range(5)]
    figures = [Confidence(0.8)] * 10
    assert compute_error_by_model(samples, figures) == pytest.approx(0.2)
    bounds = [Confidence(0.8, 0.5, 0.95)] * 10
    assert compute_error_by_model(samples, bounds) == pytest.approx(0.025)


def models(*row: object, weights: object = (1.0, 1.0, 1.0)) -> dict[str, object]:
    scale = {"weights": weights, "models": {"box": {"content": "k", "whole": list(row)}}}
    return {"schema": "facetlog-calibration/4", "sources": ["a"], "states": {"holds": scale}}


@pytest.mark.parametrize(
    "data",
    [
        {},
        {"schema": "another/1", "sources": [], "states": {}},
        {"schema": "facetlog-calibration/4"},
        {"schema": "facetlog-calibration/4", "sources": [], "states": []},
        {**models(1.0, 1.0, 2, 1, [0]), "states": {"perhaps": {}}},
        models(1.0, 1.0, 2, 1),
        models(1.0, 1.0, 2, 1, [7]),
        models("x", 1.0, 2, 1, [0]),
        models(1.0, 1.0, 2, 1, [0], weights=(1.0, -1.0, 1.0)),
        models(1.0, 1.0, 2, 1, [0], weights=(1.0,)),
    ],
)
def test_what_is_no_calibration_is_refused(data: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=r"calibration|convert|State"):
        Calibration.from_json(data)


def test_fitting_makes_the_error_small_on_samples_that_were_not_fitted() -> None:
    rng = Random(3)

    def drawn(count: int) -> list[Sample]:
        degrees = [rng.random() for _ in range(count)]
        return [sample(d, rng.random() < 1 / (1 + 9 * 0.1**d)) for d in degrees]

    calibration, check = fit(drawn(4000)), drawn(4000)
    truths = [s.truth for s in check]
    said = [value(ask(calibration, s.high)) for s in check]
    assert compute_calibration_error(said, truths) < 0.03


# --- in the knowledge base ---------------------------------------------------------------------


def calibrated(base: KnowledgeBase, model: str) -> Calibration:
    """Says even odds of this model in pictures, and surely of scans, of whatever degree."""
    kinds = {PICTURES: Counted(0.0, 0.1, 8, 4, ("a",)), SCANNED: Counted(3.0, 0.1, 9, 9, ("b",))}
    scale = Scale((0.0,) * len(FEATURES), {model: (base.models[model].judging, kinds)})
    return Calibration(dict.fromkeys(State, scale))


def test_a_confidence_is_that_of_how_the_thing_was_measured(facts_of: Build) -> None:
    facts = tuple(facts_of("box"))
    expected = {"pictures": 0.5, "scanned": pytest.approx(0.9526, abs=1e-4), "whole": None}
    with KnowledgeBase() as base, BatchJudge() as judge:
        base.calibration = judge._base.calibration = calibrated(base, "box")
        for kind, confidence in expected.items():
            seen = facts if kind == "pictures" else (*facts, (kind, "t1"))
            base.load_scene(kind, seen)
            assert base.judge(kind, "box", "t1").confidence.value == confidence
            assert base.why(kind, "box").confidence.value == confidence
            (batch,) = (v.confidence for v in judge.judge(seen) if v.model == "box")
            assert batch.value == confidence


def test_views_and_the_seen_share_are_the_same_in_a_batch(facts_of: Build) -> None:
    facts = [fact for fact in facts_of("box") if fact[0] not in ("view", "coverage")]
    faces = [str(fact[1]) for fact in facts if fact[0] == "face"]
    facts += [("coverage", face, 0.25 + 0.5 * (i % 2)) for i, face in enumerate(faces)]
    facts += [("view", f"view{i}", f"{i}.png") for i in range(7)]
    with KnowledgeBase() as base, BatchJudge() as judge:
        counted = Counted(0.0, 0.1, 8, 4, ("a",))
        scale = Scale((0.5, 0.7, 0.9), {"box": (base.models["box"].judging, {PICTURES: counted})})
        base.calibration = judge._base.calibration = Calibration(dict.fromkeys(State, scale))
        base.load_scene("s", facts)
        evidence = base.scenes["s"].get_evidence("t1")
        assert evidence.views == 7
        assert 0.25 < evidence.seen < 0.75
        one = base.judge("s", "box", "t1").confidence
        (many,) = (v.confidence for v in judge.judge(facts) if v.model == "box")
        assert value(many) == pytest.approx(value(one), abs=1e-9)


def test_a_confidence_turns_no_verdict(facts_of: Build) -> None:
    with KnowledgeBase() as base:
        base.load_scene("s", facts_of("box"))
        before = base.judge("s", "box", "t1")
        base.calibration = calibrated(base, "box")
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
        given_top = base.why("s", "table", parts={top.role: top.faces[0]})
        assert given_top.confidence.value is None
        assert all(v.confidence.value is None for v in base.why_not("s", "table"))


def test_a_users_model_in_a_built_in_ones_place_has_no_confidence(
    facts_of: Build, tmp_path: Path
) -> None:
    with KnowledgeBase() as base:
        base.load_scene("s", facts_of("box"))
        base.calibration = calibrated(base, "box")
        builtin = base.models["box"].path.read_text(encoding="utf-8")
        other = tmp_path / "box.pl"
        other.write_text(builtin + "extra(1).\n")
        base.load_rules(other, trusted=True)
        found = base.judge("s", "box", "t1")
        assert found.confidence.value is None
        assert "(degree " in found.summary
        assert "no confidence: " in "\n".join(found.lines())
        other.write_text(builtin + "% A comment says nothing.\n")
        base.load_rules(other, trusted=True)
        found = base.judge("s", "box", "t1")
        assert found.confidence.value == 0.5
        assert "true of 4 of 8 labelled cases (a)" in "\n".join(found.lines())


def test_the_shipped_calibration_is_of_the_built_in_models_as_they_are() -> None:
    shipped = load_shipped_calibration()
    assert set(shipped.scales) == set(State)
    with KnowledgeBase() as base:
        contents = {model: rules.judging for model, rules in base.models.items()}
    for scale in shipped.scales.values():
        counted = {model: content for model, (content, _) in scale.models.items()}
        assert counted.items() <= contents.items()
    for kind, state in product(InputKind, (State.HOLDS, State.FAILS)):
        cases = (kinds[kind].cases for _, kinds in shipped.scales[state].models.values())
        assert sum(cases) >= 20


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
