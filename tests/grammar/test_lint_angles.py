"""Angle sets that no solid can have."""

import pytest

from tests.grammar.linted import codes, errors, faults_in

THREE = "face a, b, c\na adjoins b, b adjoins c\n"


@pytest.mark.parametrize(
    "lines",
    [
        "each pair x, y of a, b, c: angle(x, y) = 150 deg ± 15 deg",
        "angle(a, b) at least 150 deg\nangle(b, c) at most 60 deg\nangle(a, c) at most 60 deg",
        "angle(a, b) about 120 deg\nangle(b, c) at most 30 deg\nangle(c, a) at most 60 deg",
        "a is level, a is upward, b is upright, angle(a, b) = 30 deg ± 10 deg",
        "a opposite b, angle(b, a) at most 90 deg",
    ],
)
def test_angles_of_three_directions_that_cannot_be_are_an_error(lines: str) -> None:
    assert errors(THREE + lines) == ["impossible-angles"]


@pytest.mark.parametrize(
    "lines",
    [
        "each pair x, y of a, b, c: angle(x, y) = 90 deg ± 15 deg",
        "each pair x, y of a, b, c: angle(x, y) = 130 deg ± 10 deg",
        "angle(a, b) at least 120 deg\nangle(b, c) at most 60 deg\nangle(a, c) at most 60 deg",
        "angle(a, b) at least 150 deg\nangle(b, c) at most 60 deg",
        "a is level, a is upward, b is upright, angle(a, b) = 90 deg ± 10 deg",
        "a is level, b is upright, angle(a, b) = 100 deg ± 1 deg",
        "each pair x, y of a, b, c: dihedral(x, y) = 90 deg ± 15 deg",
        "each pair x, y of a, b, c: dihedral(x, y) = 270 deg ± 15 deg",
        "expect: each pair x, y of a, b, c: angle(x, y) = 150 deg ± 15 deg",
    ],
)
def test_angles_that_can_be_are_no_faults(lines: str) -> None:
    assert "impossible-angles" not in codes(THREE + lines)


def test_ends_that_just_meet_can_be() -> None:
    body = "angle(a, b) at least 120 deg\nangle(b, c) at most 60 deg\nangle(a, c) at most {} deg"
    assert codes(THREE + body.format("60")) == []
    assert errors(THREE + body.format("59.9")) == ["impossible-angles"]


def test_fading_counts_to_its_middle() -> None:
    body = (
        "angle(a, b) at least 120 deg\nangle(b, c) at most 50 deg fading {} deg\n"
        "angle(a, c) at most 60 deg"
    )
    assert errors(THREE + body.format("18")) == ["impossible-angles"]
    assert errors(THREE + body.format("22")) == []


def test_dihedrals_that_cannot_be_are_a_warning() -> None:
    (fault,) = faults_in(THREE + "each pair x, y of a, b, c: dihedral(x, y) = 30 deg ± 5 deg")
    assert (fault.code, fault.severity) == ("impossible-angles", "warning")


def test_four_directions_square_to_one_another_are_not_found() -> None:
    four = "face a, b, c, d\neach pair x, y of a, b, c, d: angle(x, y) = {} deg ± {} deg"
    (fault,) = faults_in(four.format(90, 5))
    assert (fault.code, fault.severity) == ("impossible-angles", "warning")
    assert "were found" in fault.message
    assert codes(four.format(109.47, 1)) == []  # a tetrahedron's


def test_a_cube_can_be() -> None:
    sides = "each pair x, y of a, b, c, d: angle(x, y) = 90 deg ± 91 deg\n"
    square = "\n".join(
        f"angle({x}, {y}) = 90 deg ± 1 deg"
        for x, y in ("ab", "bc", "cd", "da", "ae", "be", "ce", "de")
    )
    opposite = "a opposite c, b opposite d"
    assert "impossible-angles" not in codes(
        "face a, b, c, d, e\n" + sides + square + "\n" + opposite
    )


def test_if_known_makes_it_a_warning() -> None:
    body = "if known: each pair x, y of a, b, c: angle(x, y) = 150 deg ± 15 deg"
    (fault,) = faults_in(THREE + body)
    assert (fault.code, fault.severity) == ("impossible-angles", "warning")


def test_the_other_lines_are_named() -> None:
    lines = (
        "wide: angle(a, b) at least 150 deg\nangle(b, c) at most 60 deg\nangle(a, c) at most 60 deg"
    )
    (fault,) = faults_in(THREE + lines)
    assert "`wide` in line 5" in fault.hint
    assert fault.source.text[fault.span.start : fault.span.end] == "angle(a, c) at most 60 deg"
