"""The one reason that a condition is given: which step of its proof it is."""

import pytest

from facetlog.kb.explaining.proof import Comparison, Note, Proof, Shortfall, Side, State, Within
from facetlog.kb.explaining.reasons import reason

HOLDS, FAILS, UNKNOWN = State.HOLDS, State.FAILS, State.UNKNOWN
AT_LEAST_HALF = Within("at_least", (0.5,))


def compared(measure: str, value: float, *, sd: float = 0.01) -> Proof:
    holds = value >= 0.5
    miss = None if holds else Shortfall(0.5 - value, sd, Side.BELOW)
    found = Comparison(measure, value, sd, "ratio", AT_LEAST_HALF, miss)
    return Proof(HOLDS if holds else FAILS, 0, 1, f"at_least({measure}, 0.5)", found)


def fact(test: str, state: State = HOLDS) -> Proof:
    truth = {HOLDS: "true", FAILS: "false", UNKNOWN: "unknown"}[state]
    return Proof(state, 0, 1, test, Note("fact", truth, f"{test} is {truth}"))


def step(name: str, state: State, *children: Proof) -> Proof:
    return Proof(state, 0, 1, name, Note(name), children)


def no(child: Proof) -> Proof:
    opposite = {HOLDS: FAILS, FAILS: HOLDS, UNKNOWN: UNKNOWN}
    return step("not", opposite[child.state], child)


NEAR, FAR = compared("share(f1)", 0.6), compared("share(f2)", 0.9)
NOT_WHOLE, WHOLE = fact("whole(t1)", FAILS), fact("whole(t1)")


def said(proof: Proof) -> str | None:
    found = reason(proof)
    return None if found is None else found.texts(None)[0]


@pytest.mark.parametrize("order", [(NEAR, FAR), (FAR, NEAR)])
def test_of_all_that_is_needed_the_nearest_to_its_limit_is_said(order: tuple[Proof, ...]) -> None:
    found = said(step("all", HOLDS, *order))
    assert found == "share(f1) = 60 ± 1 %, at least 50 % (+ 1 more)"


def test_what_an_error_of_measurement_explains_is_nearest_then_what_differs_least() -> None:
    sharp, blurred = compared("share(f1)", 0.6, sd=0.001), compared("share(f2)", 0.9, sd=0.2)
    found = reason(step("all", HOLDS, sharp, blurred))
    assert found is not None
    assert found.step == blurred
    exact, less = compared("share(f1)", 0.6, sd=0), compared("share(f2)", 0.55, sd=0)
    found = reason(step("all", HOLDS, exact, less))
    assert found is not None
    assert found.step == less
    # A relation has no limit.
    measured = compared("fill(f1)", 0.52)
    found = reason(step("all", HOLDS, fact("level(f1)"), less, measured))
    assert found is not None
    assert (found.step, found.more) == (measured, 2)


def test_two_faces_in_either_order_are_one_pair() -> None:
    pairs = [compared(f"angle({a}, {b})", 0.8) for a, b in (("f1", "f2"), ("f2", "f1"))]
    facts = [fact("adjoins(f1, f2)"), fact("adjoins(f2, f1)")]
    found = reason(step("all", HOLDS, *pairs, *facts))
    assert found is not None
    assert (found.step, found.more) == (pairs[0], 1)


def test_of_alternatives_that_hold_the_one_with_fewest_steps_is_enough() -> None:
    both = step("all", HOLDS, NEAR, FAR)
    relation = fact("level(f1)")
    found = reason(step("any", HOLDS, both, relation, compared("fill(f1)", 0.1)))
    assert found is not None
    assert (found.step, found.more) == (relation, 0)


@pytest.mark.parametrize(
    "proof",
    [
        step("any", HOLDS, no(NOT_WHOLE), FAR),
        step("any", HOLDS, step("all", HOLDS, no(NOT_WHOLE), no(fact("scanned(t1)", FAILS)))),
        step("any", HOLDS, compared("fill(f1)", 0.1), WHOLE),
        step("any", HOLDS, no(step("any", FAILS))),
        step("all", HOLDS),
        step("implies", HOLDS, compared("fill(f1)", 0.1), FAR),
        step("all", HOLDS, step("implies", HOLDS, NOT_WHOLE, FAR)),
        step("not_applied", HOLDS, fact("level(f1)", UNKNOWN)),
        step("expect", HOLDS, fact("level(f1)", UNKNOWN)),
        step("any", HOLDS, no(step("any", FAILS)), FAR),
    ],
)
def test_what_is_not_asked_of_such_a_thing_is_no_reason(proof: Proof) -> None:
    assert reason(proof) is None


@pytest.mark.parametrize(
    ("proof", "expected"),
    [
        # A guard beside something that is asked is left out of it.
        (step("any", HOLDS, step("all", HOLDS, no(NOT_WHOLE), FAR)), FAR),
        (step("any", HOLDS, FAR, WHOLE), FAR),
        # Alone it is what is asked.
        (no(NOT_WHOLE), NOT_WHOLE),
        (WHOLE, WHOLE),
        (step("if_known", HOLDS, FAR), FAR),
        (step("implies", HOLDS, NEAR, FAR), FAR),
        (step("short", HOLDS, FAR), FAR),
        (step("expect", HOLDS, FAR), FAR),
    ],
)
def test_what_is_asked_is_the_reason(proof: Proof, expected: Proof) -> None:
    found = reason(proof)
    assert found is not None
    assert (found.step, found.more) == (expected, 0)


def test_of_alternatives_that_fail_the_one_that_lacks_least_is_said() -> None:
    two = step("all", FAILS, compared("share(f1)", 0.1), compared("share(f2)", 0.1))
    one = step("all", FAILS, FAR, compared("fill(f1)", 0.3))
    found = reason(step("any", FAILS, two, one, NOT_WHOLE))
    assert found is not None
    assert (found.step, found.more) == (one.children[1], 0)
    assert not found.holds


def test_what_is_open_is_told_by_what_is_not_known() -> None:
    open_one = fact("level(f2)", UNKNOWN)
    found = reason(step("all", UNKNOWN, FAR, open_one))
    assert found is not None
    assert found.step == open_one
    found = reason(step("implies", UNKNOWN, open_one, compared("fill(f1)", 0.1)))
    assert found is not None
    assert found.step == open_one


def test_as_data_it_keeps_its_numbers() -> None:
    width = Comparison("width(f1)", 0.254, 7e-5, "length", Within("at_least", (0.1,)))
    found = reason(Proof(HOLDS, 0, 1, "", width))
    assert found is not None
    assert found.to_json("m") == {
        "text": "width(f1) = 254.0 ± 0.07 mm, at least 100 mm",
        "state": "holds",
        "more": 0,
        "measure": "width(f1)",
        "value": 0.254,
        "sd": 7e-5,
        "kind": "length",
        "within": {"sort": "at_least", "limits": [0.1]},
    }
