"""What a model should have or avoid."""

import pytest

from tests.grammar.linted import codes, faults_in, faults_of


def test_a_model_should_say_what_it_is_and_have_an_example() -> None:
    faults = faults_of("model top_alone\n  face a\n  a is level\n")
    assert [f.code for f in faults] == ["no-doc", "no-example"]
    assert all(f.severity == "warning" for f in faults)


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("a: a is level", "label-is-part"),
        ("each face x: a is level", "in-vain"),
        ("there is a face x where a is level", "in-vain"),
        ("there is no face x where x adjoins a, each face y: x is level", "in-vain"),
        ("length(a) at least 40 cm", "absolute-size"),
        ("length(a) = 2 * width(a) ± 3 cm", "absolute-size"),
        ("area(a) at most 2 m2 or a is level", "absolute-size"),
        ("there is a face x where length(x) at least 1 m", "absolute-size"),
        ("area(a) / (1 m2) at least 2", "absolute-size"),
    ],
)
def test_a_bad_habit_is_reported_once(line: str, code: str) -> None:
    (fault,) = faults_in(f"face a\na is measured\n{line}")
    assert (fault.code, fault.severity) == (code, "warning")


@pytest.mark.parametrize(
    "line",
    [
        "top: a is level",
        "each face x: x adjoins a",
        "there is a face x where x adjoins a",
        "there are at least 4 faces x",
        "if known: length(a) at least 40 cm",
        "expect: length(a) at least 40 cm",
        "length(a) at least 50 % of length(this)",
        "offset(a, b) at least 0",
        "length(a) at least (40 cm / 20 cm) * width(a)",
    ],
)
def test_a_good_one_is_not(line: str) -> None:
    assert codes(f"face a, b\na adjoins b\n{line}") == []


def test_sizes_within_a_definition_are_reported_at_the_line_that_uses_it() -> None:
    body = "define big(f): length(f) at least 1 m\nface a\na is level\nif known: big(a)"
    assert codes(body) == []
    (fault,) = faults_in(body.replace("if known: ", ""))
    assert fault.source.text[fault.span.start : fault.span.end] == "big(a)"
