"""The reference: made from the grammar's own rules and tables, and leaves none of them out."""

import re
import runpy
from collections.abc import Callable
from pathlib import Path

import pytest

from facetlog.grammar.fault_codes import FAULT_KINDS
from facetlog.grammar.reading.layout import STATEMENT_WORDS
from facetlog.grammar.reading.parse import GRAMMAR
from facetlog.grammar.reference import TERMINALS, BuiltThing, reference
from facetlog.grammar.syntax_lines import syntax_sections, syntax_terminals
from facetlog.grammar.units import UNITS, Dimension
from facetlog.grammar.vocabulary import VOCABULARY

SCRIPT = Path(__file__).parents[2] / "scripts" / "write_reference.py"
THING = BuiltThing(
    "fan",
    "blades | round a hub",
    (("width", Dimension.LENGTH, 0.25), ("lean", Dimension.ANGLE, 12.0)),
)


def script(name: str) -> Callable[..., object]:
    return runpy.run_path(str(SCRIPT))[name]  # type: ignore[no-any-return]


@pytest.fixture(scope="module")
def text() -> str:
    return reference([THING])


def ways(grammar: str) -> dict[str, tuple[str, ...]]:
    return {rule.name: rule.ways for s in syntax_sections(grammar) for rule in s.rules}


def test_the_page_holds_the_reference_as_it_is_now() -> None:
    assert script("main")(["--check"]) == 0


def test_a_page_without_its_markers_is_refused() -> None:
    with pytest.raises(ValueError, match="lacks"):
        script("written")("# Models\n")


def test_every_rule_that_is_named_is_there() -> None:
    rules = ways(GRAMMAR.read_text(encoding="utf-8"))
    named = {
        name for found in rules.values() for way in found for name in re.findall("<(.+?)>", way)
    }
    assert named | {"statement"} == set(rules)


def test_every_word_of_the_grammar_is_shown() -> None:
    grammar = re.sub("//.*", "", GRAMMAR.read_text(encoding="utf-8"))
    words = set(re.findall('"([a-z]+)"', grammar))
    shown = " ".join(way for s in syntax_sections() for rule in s.rules for way in rule.ways)
    assert words <= set(re.findall("[a-z]+", re.sub("<.+?>", "", shown)))
    assert words >= STATEMENT_WORDS


def test_what_may_be_left_out_and_what_repeats_is_shown_so() -> None:
    grammar = (
        'start: a\na: "at" "least" NUM ["(" b ("," b)* ")"]\n?b: NAME -> x | NUM "." NUM -> y\n'
    )
    assert ways(grammar) == {
        "a": ("at least NUM [(<b>, ...)]",),
        "b": ("NAME", "NUM.NUM"),
    }


def test_a_terminal_of_fixed_words_is_shown_as_these() -> None:
    grammar = 'start: a\na: EACH SIGN _OR x [SIGN | x]\nx: EACH\nEACH: "each"\nSIGN: "%" | "°"\n'
    grammar += '_OR: "±" | "+/-"\n'
    assert ways(grammar)["a"] == ("each {% | °} ± <x> [% | ° | <x>]",)


def test_an_inner_rule_is_shown_as_the_one_that_stands_for_it() -> None:
    assert ways("start: all\n?all: _some -> x\n_some: NAME | NAME _some\n") == {
        "all": ("NAME", "NAME <all>")
    }


def test_a_short_comment_is_a_title_and_a_sentence_is_shown() -> None:
    grammar = (
        "// For those who change it.\nstart: a\na: NAME\n// More\n\n// It says\n// why.\nb: NAME\n"
    )
    first, second = syntax_sections(grammar)
    assert (first.title, first.comments) == ("Statements", ())
    assert (second.title, second.comments) == ("More", ("It says why.",))


def test_every_terminal_is_described() -> None:
    assert {t.name for t in syntax_terminals()} == set(TERMINALS)


def test_every_word_and_unit_has_a_row(text: str) -> None:
    for word in VOCABULARY.values():
        rows = [line for line in text.splitlines() if f"| {word.meaning} |" in line]
        assert any(word.name in row for row in rows)
    for unit in UNITS:
        assert f"`{unit}`" in text


def test_words_are_written_as_models_write_them(text: str) -> None:
    for written in (
        "`A is level`",
        "`A adjoins B`",
        "`angle(A, B)`",
        "`parallel(A, B, 15 deg)`",
        "`share_corner(A, B, C, ...)`",
    ):
        assert f"| {written} |" in text


def test_ranges_follow_from_the_bounds_of_a_word(text: str) -> None:
    assert "| angle, 0° to 90° |" in text
    assert "| length, with its sign |" in text
    assert "| count, from 3 on |" in text


def test_things_are_shown_with_their_sizes_and_cells_keep_their_bounds(text: str) -> None:
    assert "| `fan(width 25 cm, lean 12 deg)` | blades &#124; round a hub |" in text


def test_faults_are_listed_by_their_codes(text: str) -> None:
    for kind in FAULT_KINDS.values():
        assert f"| `{kind.code}` | {kind.severity.value} | {kind.meaning} |" in text
    assert "| `tilt(top) at most 5 cm` |" in text


def test_numbers_are_those_of_the_compiler(text: str) -> None:
    assert "| `expect weakly:` | weight 10 % |" in text
    assert "| `about x` | `= x ± 10 % fading 10 %` |" in text


def test_every_row_of_a_table_has_the_cells_of_its_head(text: str) -> None:
    tables = re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE)
    assert len(tables) == 6
    for table in tables:
        assert len({line.count("|") for line in table.splitlines()}) == 1
