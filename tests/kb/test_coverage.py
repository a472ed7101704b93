"""Which lines decided verdicts."""

from facetlog.kb.coverage import LineCoverage, coverage
from facetlog.kb.explaining.proof import Note, Proof, State
from facetlog.kb.explaining.verdict import Condition, Verdict

HOLDS, FAILS, UNKNOWN = State.HOLDS, State.FAILS, State.UNKNOWN


def _verdict(model: str = "m", **states: State) -> Verdict:
    found = set(states.values())
    state = FAILS if FAILS in found else UNKNOWN if UNKNOWN in found else HOLDS
    conditions = tuple(
        Condition(label, "", Proof(one, 0, 1, "", Note("fact"))) for label, one in states.items()
    )
    return Verdict(model, "t1", state, 0, 1, (), (), conditions)


def _lines(*verdicts: Verdict, **given: bool) -> dict[str, LineCoverage]:
    (found,) = coverage(verdicts, {"m": given})
    return {line.label: line for line in found.lines}


def test_states_are_counted() -> None:
    lines = _lines(
        _verdict(a=HOLDS, b=FAILS), _verdict(a=UNKNOWN, b=FAILS), _verdict(a=HOLDS, b=HOLDS)
    )
    assert (lines["a"].held, lines["a"].failed, lines["a"].unknown) == (2, 0, 1)
    assert (lines["b"].held, lines["b"].failed, lines["b"].unknown) == (1, 2, 0)


def test_a_line_decides_alone_only_where_no_other_is_in_the_verdicts_state() -> None:
    lines = _lines(
        _verdict(a=FAILS, b=HOLDS),  # a
        _verdict(a=FAILS, b=FAILS),  # nobody alone
        _verdict(a=UNKNOWN, b=FAILS),  # b: it fails whatever comes of a
        _verdict(a=UNKNOWN, b=HOLDS),  # a
        _verdict(a=HOLDS, b=HOLDS),  # all of them
    )
    assert (lines["a"].decided, lines["b"].decided) == (2, 1)


def test_lines_that_never_decided_are_named_but_for_expected_ones() -> None:
    (found,) = coverage(
        [_verdict(a=FAILS, b=HOLDS)], {"m": {"a": False, "b": False, "c": False, "d": True}}
    )
    assert found.idle == ("b", "c")
    assert found.to_json()["never_decided"] == ["b", "c"]


def test_what_is_expected_is_counted_itself() -> None:
    expected = Proof(FAILS, 0, 0, "", Note("fact"))
    line = Proof(HOLDS, 0.75, 0.75, "", Note("expect", "0.25"), (expected,))
    verdict = Verdict("m", "t1", HOLDS, 1, 1, (), (), (Condition("wish", "", line),))
    found = _lines(verdict)["wish"]
    assert (found.expected, found.held, found.failed, found.decided) == (True, 0, 1, 0)
