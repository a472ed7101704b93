"""What is open after some views: by what was not seen, taken for granted, or poorly measured."""

import math
from dataclasses import replace

import numpy as np
import pytest

from facetlog.exploring.open_questions import Interest, Lack, Lead, Needs, Open, find_needs
from facetlog.kb.confidence import Confidence
from facetlog.kb.explaining.proof import Comparison, Note, Proof, Shortfall, Side, State, Within
from facetlog.kb.explaining.verdict import Condition, Recognition, Verdict
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.types import FloatArray

BOX = cuboid(0.3, 0.2, 0.1)
MIDDLE = BOX.points.mean(axis=0)
NOWHERE: FloatArray = np.zeros((0, 3))
ALL_ROUND = MIDDLE + np.array(
    [[2 * math.cos(k), 2 * math.sin(k), 1.0] for k in np.radians(np.arange(0, 360, 15))]
)
HERE = Interest(MIDDLE, 1.0, ALL_ROUND)
BEFORE = replace(HERE, places=ALL_ROUND[:3])


def _verdict(
    model: str,
    state: State,
    low: float,
    high: float,
    sds: float = 0.0,
    confidence: float | None = None,
) -> Verdict:
    """A verdict that rests on a length, so many standard deviations within its limit."""
    conditions: tuple[Condition, ...] = ()
    if sds:
        within = Within("at_least", (0.5,))
        length = Comparison("height(t1)", 0.5 + 0.01 * sds, 0.01, "length", within)
        conditions = (Condition("height", "", Proof(State.HOLDS, low, high, "", length)),)
    said = Confidence(confidence)
    return Verdict(model, "t1", state, low, high, (), (), conditions, confidence=said)


def _needs(*verdicts: Verdict, interest: Interest = HERE) -> Needs:
    return find_needs(BOX, Recognition("box", verdicts), interest)


def _open(*verdicts: Verdict, interest: Interest = HERE) -> dict[str, Open]:
    return {each.model: each for each in _needs(*verdicts, interest=interest).open}


def test_what_holds_may_turn_by_an_error_of_measurement() -> None:
    near = _open(_verdict("box", State.HOLDS, 0.84, 0.84, sds=1.0))
    assert near["box"].measured == pytest.approx(0.1587, abs=1e-4)
    assert near["box"].assumed == 0.0
    assert _open(_verdict("box", State.HOLDS, 1.0, 1.0, sds=5.0)) == {}


def test_a_name_may_be_wrong_as_far_as_its_sides_were_not_looked_at() -> None:
    box = _verdict("box", State.HOLDS, 0.75, 0.75, confidence=0.75)
    desk = _verdict("desk", State.FAILS, 0.0, 0.0)
    found = _open(box, desk, interest=BEFORE)
    # Three looks from one side show half of what looks sideways, and what looks up.
    assert 0.25 * 0.3 < found["box"].assumed < 0.25 * 0.7
    assert found["desk"].assumed == pytest.approx(found["box"].assumed / 2)
    assert _open(box, desk) == {}


def _unknown(label: str, detail: Comparison | Note) -> Condition:
    return Condition(label, "", Proof(State.UNKNOWN, 0.0, 1.0, label, detail))


def test_what_an_open_condition_lacks_follows_from_its_reason() -> None:
    within = Within("at_least", (0.5,))
    on_space = Comparison("free_below(f1)", 0.1, 0.0, "ratio", within, unseen=(0.1, 0.9))
    too_vague = Comparison("height(t1)", 0.5, 0.3, "length", within)
    so_far = replace(too_vague, kind="count", shortfall=Shortfall(1.0, 0.0, Side.BELOW))
    conditions = {
        Lack.SPACE: _unknown("room", on_space),
        Lack.CORNERS: _unknown("high", too_vague),
        Lack.SIDES: _unknown("legs", so_far),
    }
    for lack, condition in conditions.items():
        verdict = replace(_verdict("table", State.UNKNOWN, 0.0, 1.0), conditions=(condition,))
        assert _open(verdict)["table"].lack == {lack}
    part = _unknown("left", Note("missing", cause="a part that it needs was not seen"))
    both = (part, conditions[Lack.SPACE])
    verdict = replace(_verdict("table", State.UNKNOWN, 0.0, 1.0), conditions=both)
    assert _open(verdict)["table"].lack == {Lack.SIDES, Lack.SPACE}


def test_another_name_overtakes_by_what_was_not_seen_but_not_a_special_case_of_the_leading() -> (
    None
):
    table = _verdict("table", State.HOLDS, 0.9, 0.9, confidence=0.7)
    desk = replace(
        _verdict("desk", State.UNKNOWN, 0.0, 1.0, confidence=0.1), specialises=("table",)
    )
    chair = _verdict("chair", State.UNKNOWN, 0.0, 1.0, confidence=0.2)
    assert _needs(table, desk, chair).overtaken == pytest.approx(0.2)
    unseen = _needs(table, desk, chair, interest=BEFORE)
    assert 0.2 + 0.3 * 0.3 < unseen.overtaken < 0.2 + 0.3 * 0.7
    assert _needs(chair).overtaken == 1.0
    assert _needs(table).overtaken == 0.0


def test_a_name_that_was_ruled_out_before_may_be_wrong_as_well_as_right() -> None:
    opened = (Open("t1", "box", assumed=0.02, measured=0.1), Open("t1", "desk", likely=0.01))
    needs = Needs(opened, (), Lead("t1", "box", {"box": 0.9}))
    doubted = needs.contradicted()
    assert doubted.overtaken == pytest.approx(0.51)
    assert doubted.open[0].measured == 0.1
    assert doubted.open[1:] == opened[1:]
    # Also where nothing else of it was open; and where nothing leads nothing is contradicted.
    assert Needs((), (), needs.lead).contradicted().overtaken == 0.5
    assert Needs(opened, ()).contradicted().open == opened


def test_things_that_stand_elsewhere_leave_all_of_the_target_open() -> None:
    far = replace(HERE, target=MIDDLE + np.array([5.0, 0.0, 0.0]))
    found = _open(_verdict("box", State.HOLDS, 1.0, 1.0), interest=far)
    assert found[""].unseen == 1.0
