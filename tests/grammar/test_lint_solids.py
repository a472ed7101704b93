"""What no solid can have: level faces at right angles, heights in a circle, too large an area."""

import re
from pathlib import Path

import pytest

from facetlog.grammar.faults import Severity
from facetlog.grammar.lint.solids import SLENDER, THIN
from tests.grammar.linted import codes, errors, faults_in

THREE = "face a, b, d\na adjoins b, b adjoins d\n"


@pytest.mark.parametrize(
    "lines",
    [
        "each x of a, b, d: x is level\neach pair x, y of a, b, d: angle(x, y) = 90 deg ± 15 deg",
        "a is level, tilt(b) at most 30 deg\nangle(a, b) = 90 deg ± 20 deg",
    ],
)
def test_faces_that_are_nearly_level_are_not_at_right_angles(lines: str) -> None:
    assert set(errors(THREE + lines)) == {"impossible-angles"}


@pytest.mark.parametrize(
    "lines",
    [
        "a is level, b is level\nangle(a, b) at least 170 deg",
        "a is level, b is level\nangle(a, b) at most 15 deg",
        "a is level, b is upright\nangle(a, b) = 90 deg ± 15 deg",
        "a is level, tilt(b) at most 80 deg\nangle(a, b) = 90 deg ± 1 deg",
    ],
)
def test_angles_that_leaning_faces_can_have_are_no_faults(lines: str) -> None:
    assert errors(THREE + lines) == []


def test_what_rests_on_a_dihedral_is_a_warning() -> None:
    lines = "a is level, b is level\ndihedral(a, b) = 90 deg ± 10 deg"
    (fault,) = faults_in(THREE + lines)
    assert (fault.code, fault.severity) == ("impossible-angles", Severity.WARNING)


@pytest.mark.parametrize(
    ("lines", "found"),
    [
        ("a convex b\ndihedral(a, b) = 270 deg ± 10 deg", ["contradiction"]),
        ("dihedral(b, a) at least 200 deg\na convex b", ["contradiction"]),
        ("a concave b\ndihedral(a, b) = 90 deg ± 10 deg", ["contradiction"]),
        ("a convex b\ndihedral(a, b) = 90 deg ± 10 deg", []),
        ("a concave b\ndihedral(a, b) = 270 deg ± 10 deg", []),
    ],
)
def test_the_turn_at_an_edge_is_that_of_its_kind(lines: str, found: list[str]) -> None:
    assert errors(THREE + lines) == found


@pytest.mark.parametrize(
    ("lines", "found"),
    [
        ("a above b, b above a", ["contradiction"]),
        ("a above b, b above d\nd above a", ["contradiction"]),
        ("a above b, b above d\na below d", ["contradiction"]),
        ("a above b, b above d\na above d, d below b", []),
        ("a above b\nexpect: b above a", []),
    ],
)
def test_heights_do_not_go_round_in_a_circle(lines: str, found: list[str]) -> None:
    assert errors(THREE + lines) == found


@pytest.mark.parametrize(
    ("lines", "found"),
    [
        ("area(a) at least 120 % of length(a) * width(a)", ["contradiction"]),
        ("area(a) at least 1.1 * width(a) * length(a)", ["contradiction"]),
        ("area(a) at least 120 % of length(a) * length(a)", ["contradiction"]),
        ("area(a) at least 2 m2\nlength(a) at most 1 m", ["contradiction"]),
        ("area(a) at least 2 m2\nlength(a) at most 3 m, width(a) at most 60 cm", ["contradiction"]),
        ("area(a) at least 80 % of length(a) * width(a)", []),
        ("area(a) at least 120 % of width(a) * width(a)", []),
        ("area(a) at least 120 % of length(b) * width(b)", []),
        ("area(a) at least 2 m2\nlength(a) at most 3 m", []),
    ],
)
def test_no_face_is_larger_than_its_rectangle(lines: str, found: list[str]) -> None:
    assert errors(THREE + lines) == found


def test_a_line_that_may_not_be_asked_makes_it_a_warning() -> None:
    lines = "if known: area(a) at least 2 m2\nif known: length(a) at most 1 m"
    assert codes(THREE + lines) == ["contradiction"]
    assert errors(THREE + lines) == []


PIECES = "board top\nbar leg\nblock foot\nleg carries top, foot carries leg\n"


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("thickness(top) at least 50 % of width(top)", ["contradiction"]),
        ("thickness(top) at most 30 % of width(top)", []),
        ("width(leg) at least 50 % of length(leg)", ["contradiction"]),
        ("thickness(leg) at most 20 % of width(leg)", ["contradiction"]),
        ("width(leg) at most 30 % of length(leg), thickness(leg) at least 50 % of width(leg)", []),
        ("width(foot) at most 20 % of length(foot)", ["contradiction"]),
        ("width(foot) at least 50 % of length(foot)", []),
        ("top is bar", ["contradiction"]),
    ],
)
def test_a_board_is_thin_a_bar_slender_and_a_block_neither(line: str, found: list[str]) -> None:
    assert errors(PIECES + line) == found


def test_the_shares_of_boards_and_bars_are_those_of_the_rules() -> None:
    vocabulary = Path(__file__).parents[2] / "rules" / "vocabulary.pl"
    stated = dict(re.findall(r"tolerance\((\w+),\s+([\d.]+)\)", vocabulary.read_text("utf-8")))
    assert (float(stated["thin"]), float(stated["slender"])) == (THIN, SLENDER)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("height(a) at least 120 % of height(this)", "height(a) is at most height(this)"),
        ("width(a) at least 120 % of length(a)", "width(a) is at most length(a)"),
        ("length(a) at least 200 % of length(this)", "length(a) is at most 173 % of length(this)"),
    ],
)
def test_what_holds_of_every_solid_is_said_where_a_line_contradicts_it(
    line: str, said: str
) -> None:
    (fault,) = faults_in(THREE + line)
    assert fault.message == f"this contradicts what holds of every solid: {said}"


def test_what_a_line_follows_from_is_said_too() -> None:
    (fault,) = faults_in(THREE + "a is level\nwidth(a) at most 150 % of length(a)")
    assert fault.message == (
        "this follows from what holds of every solid: width(a) is at most length(a)"
    )


def test_a_contradiction_with_a_kind_says_what_that_is() -> None:
    (fault,) = faults_in(PIECES + "thickness(top) at least 50 % of width(top)")
    assert fault.hint == "a board: its thickness is at most 35 % of its width"
