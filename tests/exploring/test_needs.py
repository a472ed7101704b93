"""What is open after some views: by what was not seen, and by what is poorly measured."""

import numpy as np
import pytest

from facetlog.exploring.needs import Interest, needs_of
from facetlog.kb.explaining.proof import Comparison, Proof, State, Within
from facetlog.kb.explaining.verdict import Condition, Recognition, Verdict
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid

BOX = cuboid(0.3, 0.2, 0.1)
HERE = Interest(BOX.points.mean(axis=0), 1.0)


def _verdict(model: str, state: State, low: float, high: float, sds: float = 0.0) -> Verdict:
    """A verdict that rests on a length, so many standard deviations within its limit."""
    if not sds:
        return Verdict(model, "t1", state, low, high, (), (), ())
    within = Within("at_least", (0.5,))
    length = Comparison("height(t1)", 0.5 + 0.01 * sds, 0.01, "length", within)
    condition = Condition("height", "", Proof(State.HOLDS, low, high, "", length))
    return Verdict(model, "t1", state, low, high, (), (), (condition,))


def _open(*verdicts: Verdict, interest: Interest = HERE) -> dict[str, tuple[float, float]]:
    needs = needs_of(BOX, Recognition("box", verdicts), interest)
    return {each.model: (each.unseen, each.measured) for each in needs.open}


def test_what_holds_may_turn_by_an_error_of_measurement() -> None:
    near = _open(_verdict("box", State.HOLDS, 0.84, 0.84, sds=1.0))
    assert near == {"box": (0.0, pytest.approx(0.1587, abs=1e-4))}
    assert _open(_verdict("box", State.HOLDS, 1.0, 1.0, sds=5.0)) == {}


def test_what_holds_to_a_degree_by_a_soft_tolerance_is_decided() -> None:
    assert _open(_verdict("box", State.HOLDS, 0.75, 0.75, sds=6.0)) == {}


def test_what_is_open_may_turn_within_its_bounds() -> None:
    assert _open(_verdict("box", State.UNKNOWN, 0.1, 0.9)) == {"box": (pytest.approx(0.8), 0.0)}


def test_of_a_thing_that_nothing_fits_each_model_is_as_likely() -> None:
    fails = [_verdict(model, State.FAILS, 0.0, 0.0) for model in ("box", "chair")]
    assert _open(*fails) == {"box": (0.5, 0.0), "chair": (0.5, 0.0)}
    holds = _verdict("table", State.HOLDS, 1.0, 1.0)
    assert _open(*fails, holds) == {}


def test_what_is_of_no_interest_is_not_open_but_may_be_what_a_thing_is() -> None:
    chairs = Interest(HERE.target, HERE.radius, ("chair",))
    chair = _verdict("chair", State.FAILS, 0.0, 0.0)
    box = _verdict("box", State.HOLDS, 0.75, 0.75)
    assert _open(chair, box, interest=chairs) == {}
    assert _open(chair, _verdict("box", State.FAILS, 0.0, 0.0), interest=chairs) == {
        "chair": (0.5, 0.0)
    }


def test_things_that_stand_elsewhere_leave_all_of_the_target_open() -> None:
    far = Interest(HERE.target + np.array([5.0, 0.0, 0.0]), 1.0)
    assert _open(_verdict("box", State.HOLDS, 1.0, 1.0), interest=far) == {"": (1.0, 0.0)}


def test_the_corners_of_a_thing_come_with_what_their_faces_face() -> None:
    needs = needs_of(BOX, Recognition("box", (_verdict("box", State.HOLDS, 0.84, 0.84),)), HERE)
    (thing,) = needs.things
    assert thing.corners.shape == (8, 3)
    # Three faces meet at each corner of a box.
    np.testing.assert_allclose(np.linalg.norm(thing.facing, axis=2), np.ones((8, 3)))
