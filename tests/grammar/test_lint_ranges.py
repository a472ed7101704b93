"""Comparisons that never hold."""

import pytest

from tests.grammar.linted import codes, errors, faults_in


@pytest.mark.parametrize(
    "condition",
    [
        "share(a) at least 110 %",
        "fill(a) between 90 % and 80 %",
        "tilt(a) at least 95 deg",
        "tilt(a) = 100 deg ± 5 deg",
        "length(a) at most -3 cm",
        "length(a) at least 110 % of length(a)",
        "length(a) - length(a) at least 2 * width(a)",
        "corners(a) = 2",
        "share(a) at least 110 % fading 15 %",
        "share(a) about 2",
    ],
)
def test_what_can_never_hold_is_an_error(condition: str) -> None:
    assert errors(f"face a\nif known: {condition}") == ["never-holds"]


@pytest.mark.parametrize(
    "condition",
    [
        "share(a) at least 110 % fading 30 %",
        "share(a) at least 100 %",
        "share(a) at least 0 %",
        "share(a) about 1",
        "tilt(a) at most 5 deg fading 3 deg",
        "fill(a) between 80 % and 90 %",
        "corners(a) = 4",
        "length(a) at most 110 % of width(a)",
        "length(a) / width(a) at least 2",
        "tilt(a) = 45 deg ± 0.1 deg",
    ],
)
def test_a_tolerance_that_decides_something_is_no_fault(condition: str) -> None:
    assert codes(f"face a\n{condition}") == []


def test_the_range_of_the_word_is_named() -> None:
    (fault,) = faults_in("face a\nshare(a) at least 110 %")
    assert fault.message == "this never holds: `share(a)` is at most 100 %"


def test_it_is_reported_wherever_it_stands() -> None:
    assert errors("face a\na is level or share(a) at least 2") == ["never-holds"]
    assert errors("face a\nthere is no face x where share(x) at least 2") == ["never-holds"]
    assert errors("face a where share(a) at least 2") == ["never-holds"]
    assert errors("face a where share(a) at least 2\na is level") == ["never-holds"]


def test_constants_are_folded() -> None:
    body = "let most = 60 %\nlet more = 2 * most\nface a\nshare(a) at least more"
    assert errors(body) == ["never-holds"]


def test_a_definition_is_reported_once_where_it_is_written() -> None:
    body = "define big(f): share(f) at least 110 %\nface a, b\na adjoins b, big(a), big(b)"
    (fault,) = faults_in(body)
    assert fault.code == "never-holds"
    assert fault.source.text[fault.span.start : fault.span.end] == "share(f) at least 110 %"


@pytest.mark.parametrize(
    ("width", "code"),
    [
        ("± 0 deg", "zero-tolerance"),
        ("± 0 %", "zero-tolerance"),
        ("± -5 deg", "negative-width"),
        ("± 5 deg fading -1 deg", "negative-width"),
    ],
)
def test_widths_that_cannot_be_meant_are_reported(width: str, code: str) -> None:
    assert codes(f"face a\ntilt(a) = 30 deg {width}") == [code]


def test_a_count_may_be_exact() -> None:
    assert codes("face a\na is level, corners(a) = 4 ± 0") == []


def test_the_number_of_a_sets_members_is_known() -> None:
    sets = "face a\n{} faces leg where leg is upright, leg adjoins a\na is level\n"
    assert errors(sets.format("at most 3") + "count(leg) at least 4") == ["never-holds"]
    assert codes(sets.format("at least 3") + "count(leg) at most 8") == []
    assert codes(sets.format("optional at least 3") + "count(leg) at least 2") == []
