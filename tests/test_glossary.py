"""Words of models and questions: all are explained, each as models write it."""

import json
import re

import pytest

from facetlog.cli import main
from facetlog.glossary import TOPICS, format_markdown, list_entries
from facetlog.grammar.fault_codes import FAULT_KINDS
from facetlog.grammar.library import list_builtin_names
from facetlog.grammar.vocabulary import VOCABULARY
from facetlog.perception.facts.fact_schema import FACT_KINDS
from facetlog.perception.surfaces.exact_solids.builders import BUILDERS


@pytest.fixture(scope="module")
def entries():
    return list_entries()


def test_every_row_of_every_table_is_explained(entries):
    names = {(entry.topic, entry.name) for entry in entries}
    assert {topic for topic, _ in names} == set(TOPICS)
    assert names >= {("facts", name) for name in FACT_KINDS}
    assert names >= {("faults", name) for name in FAULT_KINDS}
    assert names >= {("solids", name) for name in BUILDERS}
    words = {name for topic, name in names if topic in ("conditions", "measures")}
    assert words == set(VOCABULARY)
    assert all(entry.usage and entry.meaning for entry in entries)


def test_words_are_shown_as_models_write_them(entries):
    usages = {entry.usage: entry.notes for entry in entries}
    for usage in (
        "A is level",
        "A adjoins B",
        "parallel(A, B, 15 deg)",
        "angle(+F1, +F2, Angle, Sd)",
    ):
        assert usage in usages
    assert usages["tilt(A)"]["gives"] == "angle, 0° to 90°"
    assert usages["offset(A, B)"]["gives"] == "length, of either sign"
    assert usages["corners(A)"]["gives"] == "count, at least 3"
    assert "room_corner(width 3 m, height 2.5 m, angle 90 deg)" in usages


def test_each_topic_is_a_table_of_equal_rows(entries):
    tables = re.findall(r"(?:^\|.*\n)+", format_markdown(entries), re.MULTILINE)
    assert len(tables) == len(TOPICS)
    for table in tables:
        assert len({line.count("|") for line in table.splitlines()}) == 1


def test_a_word_is_explained_in_all_its_topics(capsys):
    assert main(["model", "words", "tilt", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["topic"] for row in rows] == ["measures", "facts"]
    assert main(["model", "words", "tilt", "units"]) == 0
    out = capsys.readouterr().out
    assert "unknown when: up is not known" in out
    assert "cm: unit of a length" in out


def test_a_word_that_there_is_not_is_refused_with_the_nearest(capsys):
    assert main(["model", "words", "elevaton"]) == 2
    assert "elevation" in capsys.readouterr().err
    assert main(["model", "words", "frobnitz", "tilt", "splayed"]) == 2
    out, err = capsys.readouterr()
    assert "unknown when: up is not known" in out
    assert "`tilt(leg) between" in out
    assert ("frobnitz" in err, "did you mean" in err) == (True, False)


def test_builtin_models_are_listed_and_shown(capsys):
    assert main(["model", "list", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert {row["name"] for row in rows} == list_builtin_names()
    assert all(row["text"] for row in rows)
    assert main(["model", "show", "table"]) == 0
    assert "\nmodel table\n" in capsys.readouterr().out
    assert main(["model", "show", "tabel"]) == 2
