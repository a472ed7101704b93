"""Conditions that no solid can meet."""

import re
from pathlib import Path

import pytest

from facetlog.grammar.lint.conflicts import SLENDER, THIN
from tests.grammar.linted import errors, faults_in

THREE = "face a, b, d\na adjoins b, b adjoins d\n"


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


def test_a_contradiction_with_a_kind_says_what_that_is() -> None:
    (fault,) = faults_in(PIECES + "thickness(top) at least 50 % of width(top)")
    assert fault.hint == "a board: its thickness is at most 35 % of its width"
