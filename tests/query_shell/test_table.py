"""Tables: units from the schema, rounding by deviations, alignment, and width."""

import math
from fractions import Fraction

import pytest
from rich.cells import cell_len

from facetlog.kb.engine.terms import Atom, Struct, Term
from facetlog.perception.facts.fact_schema import ArgumentKind
from facetlog.query_shell.meanings import Meaning, meanings
from facetlog.query_shell.shown_terms import convert_term, shown
from facetlog.query_shell.table import Table


def table(goal: str, names: str, rows: list[tuple[Term, ...]], **size: int) -> list[str]:
    made = Table(names.split(), meanings(goal), "m", **size)
    block = made.block(rows)
    return [*made.head(rows), *block]


def test_heads_have_units_and_numbers_are_rounded_by_their_deviation():
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


def test_the_value_of_a_measure_has_the_unit_of_its_fact():
    known = meanings("measure(dihedral(A, B), V, Sd, Kind)")
    assert known["V"] == Meaning(ArgumentKind.DEGREES, "Sd")
    assert known["Sd"] == Meaning(ArgumentKind.DEGREES, is_sd=True)


@pytest.mark.parametrize("value", [math.inf, -math.inf, math.nan, 1e300, 5e-324, -0.0])
def test_every_number_can_be_shown(value):
    (line,) = Table(["V", "Sd"], meanings("length(f1, V, Sd)"), "m").block([(value, value)])
    assert line.strip()


def test_a_table_fits_the_terminal():
    rows: list[tuple[Term, ...]] = [(Atom("x" * 100), Atom("日" * 60), 1)]
    lines = table("true", "A B N", rows, width=50)
    assert all(cell_len(line) <= 50 for line in lines)
    assert lines[2].endswith("1")
    assert "…" in lines[2]


@pytest.mark.parametrize(
    ("term", "text"),
    [
        (Atom("f1"), "f1"),
        (Atom("block-0"), "'block-0'"),
        (Atom(""), "''"),
        ("text", '"text"'),
        (Fraction(1, 3), "1r3"),
        ((Atom("a"), (1, 2)), "[a, [1, 2]]"),
        (Struct("-", (Struct("-", (1, 2)), 3)), "1-2-3"),
        (Struct("-", (1, Struct("-", (2, 3)))), "1-(2-3)"),
        (Struct("*", (Struct("+", (1, 2)), -3)), "(1+2)*(-3)"),
        (Struct("<", (Struct("+", (1, 2)), 4)), "1+2 < 4"),
        (Struct("f", (Struct(":-", (Atom("a"), Atom("b"))),)), "f((a :- b))"),
        (Struct("[|]", (1, Struct("[|]", (2, Atom("t"))))), "[1, 2|t]"),
    ],
)
def test_terms_are_written_as_prolog_reads_them(term, text):
    assert shown(term) == text


def test_json_tells_strings_from_atoms_and_has_no_infinities():
    assert convert_term((Atom("a"), "a", math.inf, Fraction(1, 3))) == [
        "a",
        {"string": "a"},
        {"float": "inf"},
        {"rational": "1/3"},
    ]


def test_lengths_of_a_table_share_a_unit_in_which_their_deviations_can_be_read():
    rows = [(0.254, 7e-5, 0.0516)]
    assert table("length(F, L, S), area(F, A, _)", "L S A", rows) == [
        " L (mm)  S (mm)  A (cm²)",
        "───────  ──────  ───────",
        "254.000   0.070    516.0",
    ]
