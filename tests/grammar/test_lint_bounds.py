"""Lines that contradict one another, or are said twice."""

import pytest

from tests.grammar.linted import codes, errors, faults_in

ONE = "face a\na is measured\n"
TWO = "face a, b\na adjoins b\n"


@pytest.mark.parametrize(
    "body",
    [
        ONE + "width(a) at least 120 % of length(a)",
        ONE + "tilt(a) at most 20 deg\ntilt(a) at least 30 deg",
        ONE + "a is level\ntilt(a) at least 30 deg",
        ONE + "a is level\na is upright",
        ONE + "not a is measured",
        ONE + "length(a) at least 2 * length(this)",
        ONE + "share(a) at least 80 %\nshare(a) = 50 % ± 10 %",
        TWO + "width(a) at least 50 % of length(b)\nwidth(b) at least 250 % of length(a)",
        TWO + "convex(a, b), b concave a",
        TWO + "a above b, b above a",
        TWO + "length(a) at most 40 % of length(b)\nlength(b) at most 2 * width(a)",
    ],
)
def test_a_contradiction_is_an_error(body: str) -> None:
    assert errors(body) == ["contradiction"]
    assert codes(body) == ["contradiction"]


@pytest.mark.parametrize(
    "body",
    [
        ONE + "width(a) at least 90 % of length(a)",
        ONE + "tilt(a) at most 20 deg fading 30 deg\ntilt(a) at least 30 deg",
        ONE + "a is level or a is upright",
        # A face may stand askew in its thing.
        ONE + "length(a) at least 110 % of length(this)",
        TWO + "width(a) at least 50 % of length(b)\nwidth(b) at least 150 % of length(a)",
        TWO + "a above b, not b above a, a is level",
        TWO + "tilt(a) at most 20 deg\ntilt(b) at least 30 deg",
        ONE + "a is level\nexpect: a is upward",
        ONE + "elevation(a) at least 50 % of height(this)\ntop_of(a) at most 60 % of height(this)",
    ],
)
def test_what_can_be_together_is_no_fault(body: str) -> None:
    assert codes(body) == []


def test_it_is_reported_at_the_later_line_and_names_the_other() -> None:
    (fault,) = faults_in(ONE + "low: tilt(a) at most 20 deg\nhigh: tilt(a) at least 30 deg")
    assert fault.message == "this contradicts `tilt(a) at most 20 deg` (`low` in line 5)"
    assert fault.source.get_line_and_column(fault.span.start)[0] == 6


def test_heights_of_a_flat_thing_make_it_a_warning() -> None:
    body = "bottom_of(a) at least 50 % of height(this)\nelevation(a) at most 40 % of height(this)"
    (fault,) = faults_in(ONE + body)
    assert (fault.code, fault.severity) == ("contradiction", "warning")
    assert fault.hint == "both hold only of what is 0"


def test_what_is_not_asked_everywhere_makes_it_a_warning() -> None:
    (fault,) = faults_in(ONE + "if known: tilt(a) at most 20 deg\ntilt(a) at least 30 deg")
    assert (fault.code, fault.severity) == ("contradiction", "warning")


def test_members_of_a_set_make_it_a_warning() -> None:
    sets = "face a\n{} faces leg where leg is upright, leg adjoins a\na is level\n"
    each = "each leg: tilt(leg) at most 45 deg"
    (fault,) = faults_in(sets.format("at least 3") + each)
    assert (fault.code, fault.severity) == ("contradiction", "warning")
    assert codes(sets.format("any number of") + each) == []


def test_an_optional_part_contradicts_nothing() -> None:
    body = "optional face b where b adjoins a\ntilt(b) at most 20 deg\ntilt(b) at least 30 deg"
    assert "contradiction" not in codes(ONE + body)


@pytest.mark.parametrize(
    "body",
    [
        ONE + "a is level\na is level",
        TWO + "b adjoins a",
        TWO + "each pair x, y of a, b: y adjoins x",
        ONE + "share(a) at least 80 %\n0.8 at most share(a)",
        ONE + "there is a face x where x adjoins a\nthere is a face y where a adjoins y",
        ONE + "define good(f): f is level\na is level\ngood(a)",
        ONE + "a is level, a is upward, a is level",
    ],
)
def test_what_is_said_twice_is_reported_once(body: str) -> None:
    assert codes(body) == ["said-twice"]


def test_an_expectation_does_not_make_a_line_superfluous() -> None:
    assert codes(ONE + "expect: a is level\nif known: a is upward") == []
    assert codes(ONE + "expect: a is level\na is level") == ["said-twice"]
