"""Tables: units from the schema, rounding by deviations, alignment, and width."""

import math
from fractions import Fraction

import pytest
from rich.cells import cell_len

from facetlog.kb.engine.terms import Atom, Struct, Term
from facetlog.perception.facts.fact_schema import ArgumentKind
from facetlog.query_shell.meanings import Meaning, meanings
from facetlog.query_shell.shown_terms import shown, term_json
from facetlog.query_shell.table import Table


def table(goal: str, names: str, rows: list[tuple[Term, ...]], **size: int) -> list[str]:
    made = Table(names.split(), meanings(goal), "m", **size)
    block = made.block(rows)
    return [*made.head(rows), *block]


def test_heads_have_units_and_numbers_are_rounded_by_their_deviation() -> None:
    rows: list[tuple[Term, ...]] = [
        (Atom("f1"), 90.03846, 0.03478),
        (Atom("f10"), 9.5, 1.25),
    ]
    assert table("angle(f2, B, Deg, Sd)", "B Deg Sd", rows) == [
        "B    Deg (°)  Sd (°)",
        "───  ───────  ──────",
        "f1    90.038   0.035",
        "f10    9.5     1.2",
    ]


def test_a_deviation_that_is_not_shown_rounds_nothing() -> None:
    assert table("length(F, L, _)", "F L", [(Atom("f1"), 0.2540348)])[2] == "f1   25.40"


def test_areas_pixels_and_scenes_without_scale_have_their_units() -> None:
    known = meanings("area(F, A, Sd), observed(V, W, U, X, _, _), length(F, L, _)")
    made = Table(["A", "U", "L", "F"], known, "units")
    rows: list[tuple[Term, ...]] = [(1.0, 2.0, 3.0, Atom("f1"))]
    made.block(rows)
    assert made.head(rows)[0].split("  ") == ["A (units²)", "U (px)", "L (units)", "F"]


def test_the_value_of_a_measure_has_the_unit_of_its_fact() -> None:
    known = meanings("measure(dihedral(A, B), V, Sd, Kind)")
    assert known["V"] == Meaning(ArgumentKind.DEGREES, "Sd")
    assert known["Sd"] == Meaning(ArgumentKind.DEGREES, is_sd=True)


def test_a_variable_of_two_kinds_has_no_unit() -> None:
    assert "X" not in meanings("angle(A, B, X, _), length(A, X, _)")


def test_each_pixel_has_its_own_deviation() -> None:
    known = meanings("observed(V, View, U, W, SdU, SdW)")
    assert (known["U"].sd, known["W"].sd) == ("SdU", "SdW")


def test_small_numbers_are_not_shown_as_nothing() -> None:
    rows: list[tuple[Term, ...]] = [(0.1524,), (2.8e-6,), (0.0,), (-0.25,)]
    lines = table("true", "X", rows)
    assert [line.strip() for line in lines[2:]] == ["0.1524", "2.8e-06", "0.0000", "-0.2500"]
    assert len({line.find(".") for line in lines[2:]}) == 1


@pytest.mark.parametrize("value", [math.inf, -math.inf, math.nan, 1e300, 5e-324, -0.0])
def test_every_number_can_be_shown(value: float) -> None:
    (line,) = Table(["V", "Sd"], meanings("length(f1, V, Sd)"), "m").block([(value, value)])
    assert line.strip()


def test_wide_characters_take_two_cells() -> None:
    lines = table("true", "A B", [(Atom("日本"), 1), (Atom("abcd"), 2)])
    assert lines[2:] == ["日本  1", "abcd  2"]


def test_control_characters_do_not_reach_the_terminal() -> None:
    (line,) = Table(["A"], {}, "m").block([(Atom("a\x1b[2J\nb"),)])
    assert line.isprintable()


def test_a_table_fits_the_terminal() -> None:
    rows: list[tuple[Term, ...]] = [(Atom("x" * 100), Atom("日" * 60), 1)]
    lines = table("true", "A B N", rows, width=50)
    assert all(cell_len(line) <= 50 for line in lines)
    assert lines[2].endswith("1")
    assert "…" in lines[2]


def test_names_of_scenes_are_shown_without_quotation_marks() -> None:
    assert Table(["Scene"], {}, "m").block([(Atom("block-0"),)]) == ["block-0"]
    made = Table(["Scene", "S"], {}, "m", scenes=["block-0"])
    assert made.block([(Atom("block-0"), Atom("block-0"))]) == ["block-0  block-0"]
    assert made.block([(Atom("block-0"), Atom("block-1"))]) == ["block-0  'block-1'"]


@pytest.mark.parametrize(
    ("term", "text"),
    [
        (Atom("f1"), "f1"),
        (Atom("block-0"), "'block-0'"),
        (Atom(""), "''"),
        (Atom("Big"), "'Big'"),
        ("text", '"text"'),
        (Fraction(1, 3), "1r3"),
        (2**70, str(2**70)),
        ((Atom("a"), (1, 2)), "[a, [1, 2]]"),
        (Struct("-", (Struct("-", (1, 2)), 3)), "1-2-3"),
        (Struct("-", (1, Struct("-", (2, 3)))), "1-(2-3)"),
        (Struct("*", (Struct("+", (1, 2)), -3)), "(1+2)*(-3)"),
        (Struct("<", (Struct("+", (1, 2)), 4)), "1+2 < 4"),
        (Struct("f", (Struct(":-", (Atom("a"), Atom("b"))),)), "f((a :- b))"),
        (Struct("-", (Atom("+"), Atom("a"))), "(+)-a"),
        (Struct("[|]", (1, Struct("[|]", (2, Atom("t"))))), "[1, 2|t]"),
        (Struct(",", (Atom("a"), Atom("b"))), "','(a, b)"),
    ],
)
def test_terms_are_written_as_prolog_reads_them(term: Term, text: str) -> None:
    assert shown(term) == text


def test_json_tells_strings_from_atoms_and_has_no_infinities() -> None:
    assert term_json((Atom("a"), "a", math.inf, Fraction(1, 3))) == [
        "a",
        {"string": "a"},
        {"float": "inf"},
        {"rational": "1/3"},
    ]


def test_lengths_of_a_table_share_a_unit_in_which_their_deviations_can_be_read() -> None:
    rows = [(0.254, 7e-5, 0.0516)]
    assert table("length(F, L, S), area(F, A, _)", "L S A", rows) == [
        " L (mm)  S (mm)  A (cm²)",
        "───────  ──────  ───────",
        "254.000   0.070    516.0",
    ]
