"""Names that are never used."""

import pytest

from tests.grammar.linted import codes, complete, faults_in, faults_of

GOOD = "face a, b\na adjoins b, a is level\n"


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ("let much = 5 deg\n" + GOOD, "unused-constant"),
        ("define flat(f): f is level\n" + GOOD, "unused-definition"),
        ("define flat(f): a is upward\nflat(b)\n" + GOOD, "unused-parameter"),
        ("face c\n" + GOOD, "unused-part"),
        ("any number of faces leg where leg is upright\n" + GOOD, "unused-part"),
        ("each face x: a is level\n" + GOOD.replace(", a is level", ""), "in-vain"),
        ("there is a face x where b is level\n" + GOOD, "in-vain"),
        ("there is no face x where x adjoins a, each face y: x is level\n" + GOOD, "in-vain"),
    ],
)
def test_what_is_not_used_is_reported_once(body: str, code: str) -> None:
    (fault,) = faults_in(body)
    assert (fault.code, fault.severity) == (code, "warning")


@pytest.mark.parametrize(
    "body",
    [
        "let much = 5 deg\nlet more = 2 * much\nangle(a, b) at most more\n" + GOOD,
        "let much = 5 deg\ndefine flat(f): tilt(f) at most much\nflat(b)\n" + GOOD,
        "at least 3 faces leg where leg is upright\n" + GOOD,
        "any number of faces leg where leg is upright\neach leg: leg adjoins a\n" + GOOD,
        "any number of faces leg where leg is upright\ncount(leg) at most 4\n" + GOOD,
        "face c where c adjoins a\n" + GOOD,
        "each face x: x adjoins a\n" + GOOD,
        "there are at least 4 faces x\n" + GOOD,
        "face c\nc adjoins a or c adjoins b\n" + GOOD,
        "face c\nany number of faces leg where leg adjoins a\neach leg: leg adjoins c\n" + GOOD,
        "define near(f): f adjoins a\nface c\nnear(c)\n" + GOOD,
    ],
)
def test_what_is_used_is_no_fault(body: str) -> None:
    assert codes(body) == []


def test_an_heir_uses_what_it_inherits() -> None:
    parent = complete("let much = 5 deg\nface a\na is level", "first")
    heir = 'model second is first\n  "It."\n  angle(a, b) at most much\n  face b\n'
    heir += '  example "one" of cuboid() fails\n'
    assert [f.code for f in faults_of(parent)] == ["unused-constant"]
    assert faults_of(parent + heir) == ()


def test_constants_before_the_models_are_used_by_any() -> None:
    first, second = complete(GOOD, "first"), complete(GOOD + "tilt(b) at most much", "second")
    assert [f.code for f in faults_of("let much = 5 deg\n" + first)] == ["unused-constant"]
    assert "unused-constant" not in [
        f.code for f in faults_of("let much = 5 deg\n" + first + second)
    ]


def test_a_model_with_an_error_is_not_said_to_leave_things_unused() -> None:
    faults = faults_in("let much = 5 deg\nface a, b, c\na is level, tilt(b) at most munch")
    assert [f.code for f in faults] == ["unknown-name"]
