"""Sizes are fitted into the middle of limits, also where sides change their order."""

from collections.abc import Mapping

import pytest

from facetlog.kb.explaining.proof import Comparison, Note, Proof, Shortfall, Side, State, Within
from facetlog.kb.explaining.verdict import Condition, Verdict
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.prototype.fit import fitted
from facetlog.prototype.objective import Judged, compute_margins


def _compared(value: float, within: Within) -> Proof:
    low, high = within.edges
    state = State.HOLDS if low <= value <= high else State.FAILS
    below = value < low
    missing = max(low - value, value - high)
    short = Shortfall(missing, 0.0, Side.BELOW if below else Side.ABOVE) if missing > 0 else None
    detail = Comparison("m", value, 0.0, "length", within, short)
    return Proof(state, float(state is State.HOLDS), float(state is State.HOLDS), "m", detail)


def _joined(name: str, *children: Proof) -> Proof:
    states = [child.state for child in children]
    holds = any(s is State.HOLDS for s in states) if name == "any" else set(states) == {State.HOLDS}
    state = State.HOLDS if holds else State.FAILS
    if name == "not":
        state = State.FAILS if states == [State.HOLDS] else State.HOLDS
    return Proof(state, 0.0, 1.0, name, Note(name), children)


def _judged(sizes: Mapping[str, float], *proofs: Proof) -> Judged:
    conditions = tuple(Condition(f"c{i}", "", proof) for i, proof in enumerate(proofs))
    holds = all(proof.state is State.HOLDS for proof in proofs)
    state = State.HOLDS if holds else State.FAILS
    verdict = Verdict("m", "t1", state, float(holds), float(holds), (), (), conditions)
    return Judged(sizes, cuboid(), verdict, compute_margins(verdict))


def _missing() -> Proof:
    return Proof(State.FAILS, 0.0, 0.0, "m", Note("none was found"))


def _fitted(judge: object, **start: float) -> Judged:
    return fitted(judge(start), judge)  # type: ignore[operator,arg-type]


def test_a_size_comes_into_the_middle_half_of_its_limits() -> None:
    def judge(sizes: Mapping[str, float]) -> Judged:
        return _judged(sizes, _compared(sizes["w"], Within("between", (1.0, 3.0))))

    found = _fitted(judge, w=0.4)
    assert 3.0**0.2 <= found.sizes["w"] <= 3.0**0.8
    assert min(found.margins.values()) >= 0.4


def test_two_equal_sides_grow_together_where_the_shorter_is_measured() -> None:
    def judge(sizes: Mapping[str, float]) -> Judged:
        shorter = min(sizes["a"], sizes["b"])
        return _judged(sizes, _compared(shorter, Within("between", (1.0, 3.0))))

    found = _fitted(judge, a=1.05, b=1.05)
    assert min(found.margins.values()) >= 0.4


def test_of_alternatives_the_better_one_counts_and_not_turns_the_sign() -> None:
    low = _compared(1.0, Within("at_least", (2.0,)))
    high = _compared(3.0, Within("at_least", (2.0,)))

    def margin(proof: Proof) -> float:
        (found,) = _judged({}, proof).margins.values()
        return found

    assert margin(_joined("any", low, high)) == pytest.approx(0.5)
    assert margin(_joined("not", low)) == pytest.approx(0.5)
    assert min(_judged({}, _joined("all", low, high)).margins.values()) == pytest.approx(-0.5)


def test_what_each_member_must_be_is_no_reason_to_have_fewer_members() -> None:
    region = Within("at_least", (1.0,))
    step = _joined("implies", _compared(1.05, region), _compared(0.2, region))

    # by the distance of what is to hold, though membership is nearer to its limit
    assert list(_judged({}, step).margins.values()) == pytest.approx([-0.8])


def test_what_no_size_mends_is_not_fitted() -> None:
    judged = []

    def judge(sizes: Mapping[str, float]) -> Judged:
        judged.append(sizes)
        return _judged(sizes, _compared(sizes["a"], Within("between", (1.0, 3.0))), _missing())

    _fitted(judge, a=1.05)
    assert len(judged) == 3  # as it was, and once to both sides
