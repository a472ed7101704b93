"""The least change of one measured value that turns a verdict."""

from pathlib import Path

import pytest

from facetlog.kb.explaining.margins import margin, state_with, turned
from facetlog.kb.explaining.proof import Comparison, Note, Proof, Shortfall, Side, State, Within
from facetlog.kb.explaining.verdict import Condition, Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid

HOLDS, FAILS, UNKNOWN = State.HOLDS, State.FAILS, State.UNKNOWN


def _compared(
    measure: str,
    value: float,
    within: Within,
    *,
    kind: str = "length",
    sd: float = 0.01,
    state: State | None = None,
) -> Proof:
    low = {"at_least": within.limits[0], "between": within.limits[0]}.get(within.sort, -1e9)
    high = {"at_most": within.limits[0], "between": within.limits[-1]}.get(within.sort, 1e9)
    if within.sort == "near":
        low, high = within.limits[0] - within.limits[1], sum(within.limits)
    low, high = low - within.fading / 2, high + within.fading / 2
    inside = low <= value <= high
    side = Side.BELOW if value < low else Side.ABOVE
    shortfall = None if inside else Shortfall(max(low - value, value - high), sd, side)
    own = state or (HOLDS if inside else FAILS)
    return Proof(own, 0, 1, "", Comparison(measure, value, sd, kind, within, shortfall))


def _step(name: str, state: State, *children: Proof, test: str = "") -> Proof:
    return Proof(state, 0, 1, test, Note(name), children)


def _fact(state: State) -> Proof:
    return _step("fact", state)


def _verdict(*proofs: Proof) -> Verdict:
    states = {proof.state for proof in proofs}
    state = FAILS if FAILS in states else UNKNOWN if UNKNOWN in states else HOLDS
    conditions = tuple(Condition(f"line{i}", "", proof) for i, proof in enumerate(proofs))
    return Verdict("m", "t1", state, 0, 1, (), (), conditions, length_unit="m")


def test_what_an_error_of_measurement_may_turn_is_nearest() -> None:
    near = _compared("width(f1)", 0.5, Within("at_least", (0.4,)), sd=0.05)
    far = _compared("length(f1)", 0.5, Within("at_most", (0.55,)), sd=0.001)
    found = margin(_verdict(far, near))
    assert found is not None
    assert (found.label, found.measure, found.becomes) == ("line1", "width(f1)", FAILS)
    assert found.change == pytest.approx(-0.1)
    assert found.sds == pytest.approx(2)
    assert found.text() == "fails if width(f1) were 10 cm less (2.0 sd)"


@pytest.mark.parametrize(
    ("value", "within", "change"),
    [
        (92.0, Within("near", (90.0, 5.0)), 3.0),
        (87.0, Within("near", (90.0, 5.0)), -2.0),
        (99.0, Within("near", (90.0, 5.0)), -4.0),
        (3.0, Within("between", (1.0, 9.0)), -2.0),
        (0.5, Within("between", (1.0, 9.0)), 0.5),
        (2.0, Within("at_most", (3.0,), 1.0), 1.5),
        (4.0, Within("at_most", (3.0,), 1.0), -0.5),
    ],
)
def test_the_change_leads_to_the_nearest_edge(value: float, within: Within, change: float) -> None:
    found = margin(_verdict(_compared("tilt(f1)", value, within)))
    assert found is not None
    assert found.change == pytest.approx(change)


def test_a_value_that_several_lines_read_has_to_satisfy_all_of_them() -> None:
    low = _compared("width(f1)", 0.5, Within("at_least", (0.7,)))
    lower = _compared("width(f1)", 0.5, Within("at_least", (0.6,)))
    found = margin(_verdict(lower, low))
    assert found is not None
    assert found.change == pytest.approx(0.2)
    assert found.becomes is HOLDS


def test_what_is_too_uncertain_is_not_made_certain() -> None:
    doubtful = _compared("width(f1)", 0.5, Within("at_least", (0.4,)), sd=9.0, state=UNKNOWN)
    assert {m.becomes for m in turned(_verdict(doubtful))} == {FAILS}


def test_expectations_turn_nothing() -> None:
    short = _compared("width(f1)", 0.5, Within("at_least", (0.7,)))
    assert margin(_verdict(_step("expect", HOLDS, short), _fact(HOLDS))) is None


A = _compared("a", 1.0, Within("at_least", (0.9,)))  # holds by 0.1
B = _compared("b", 1.0, Within("at_least", (0.7,)))  # holds by 0.3
C = _compared("c", 1.0, Within("at_least", (1.2,)))  # fails by 0.2
D = _compared("d", 1.0, Within("at_least", (1.4,)))  # fails by 0.4


@pytest.mark.parametrize(
    ("proof", "changes"),
    [
        (_step("all", HOLDS, A, B), {"a": -0.1, "b": -0.3}),
        (_step("all", FAILS, A, C), {"c": 0.2}),
        (_step("all", FAILS, C, D), {}),
        (_step("any", HOLDS, A, B), {}),
        (_step("any", HOLDS, A, C), {"a": -0.1}),
        (_step("any", FAILS, C, D), {"c": 0.2, "d": 0.4}),
        (_step("not", FAILS, A), {"a": -0.1}),
        (_step("not", HOLDS, C), {"c": 0.2}),
        (_step("short", HOLDS, A), {"a": -0.1}),
        (_step("if_known", FAILS, C), {"c": 0.2}),
        (_step("implies", HOLDS, C, D), {"c": 0.2}),
        (_step("implies", FAILS, A, C), {"a": -0.1, "c": 0.2}),
        (_step("counted", HOLDS, A, B, C, test="at_least_of(2, [[f1], [f2]])"),
         {"a": -0.1, "b": -0.3}),
        (_step("counted", UNKNOWN, A, C, D, test="at_least_of(2, [[f1], [f2]])"),
         {"c": 0.2, "d": 0.4}),
        (_step("counted", HOLDS, A, C, D, test="at_most_of(1, [[f1], [f2]])"),
         {"c": 0.2, "d": 0.4}),
        (_step("counted", FAILS, A, B, C, test="at_most_of(1, [[f1], [f2]])"),
         {"a": -0.1, "b": -0.3}),
        (_step("judged", FAILS), {}),
    ],
)  # fmt: skip
def test_logic_is_followed(proof: Proof, changes: dict[str, float]) -> None:
    found = {m.measure: m.change for m in turned(_verdict(proof))}
    assert found == pytest.approx(changes)


def test_counts_change_by_whole_members() -> None:
    enough = _compared(
        "count([f1, f2, f3, f4])", 4.0, Within("at_least", (3.0,)), kind="count", sd=0
    )
    found = margin(_verdict(enough))
    assert found is not None
    assert (found.change, found.becomes) == (-2.0, UNKNOWN)
    too_few = _compared(
        "count([f1, f2])", 2.0, Within("at_least", (3.0,)), kind="count", sd=0, state=UNKNOWN
    )
    found = margin(_verdict(too_few))
    assert found is not None
    assert (found.change, found.becomes) == (1.0, HOLDS)


def _judged(base: KnowledgeBase, scene: Scene, model: str) -> Verdict:
    base.load_scene("s", (fact.row for fact in scene_facts(scene)))
    return base.why("s", model)


def test_a_thing_that_grows_by_the_margin_is_one_no_more(tmp_path: Path) -> None:
    (tmp_path / "slab.model").write_text(
        "model slab\n  face top\n  up: top is level, top is upward\n"
        "  thin: height(this) at most 20 % of length(this)\n"
    )
    with KnowledgeBase() as base:
        base.load_rules(tmp_path / "slab.model")
        slab = _judged(base, cuboid(0.8, 0.3, 0.1), "slab")
        (change,) = (m.change for m in turned(slab) if m.label == "thin")
        # The length is that of the long side, whatever the height.
        holds = _judged(base, cuboid(0.8, 0.3, 0.1 + 0.99 * change), "slab")
        fails = _judged(base, cuboid(0.8, 0.3, 0.1 + 1.01 * change), "slab")
    assert change == pytest.approx(0.06)
    assert (slab.state, holds.state, fails.state) == (HOLDS, HOLDS, FAILS)


@pytest.mark.parametrize("name", ["cuboid", "table", "shelf", "stairs"])
def test_proofs_are_joined_again_as_they_were_made(name: str) -> None:
    compared = 0
    with KnowledgeBase() as base:
        for model in ("box", "table", "chair"):
            verdict = _judged(base, build(name, {}), model)
            for condition in verdict.conditions:
                proof = condition.proof
                for comparison in proof.comparisons():
                    compared += 1
                    assert state_with(proof, comparison.measure, comparison.value) is proof.state
            for found in turned(verdict):
                assert found.becomes is not verdict.state
    assert compared > 10
