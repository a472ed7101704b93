"""Which lines are one statement, and where the comments are."""

import pytest

from facetlog.grammar.faults import applied
from facetlog.grammar.reading.layout import DEEPEST, laid_out
from facetlog.grammar.source import Source


def statements(text: str) -> list[str]:
    return [s.text(text) for s in laid_out(Source("m", text)).statements]


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("face a\nface b", 2),
        ("a: (top is level,\n  top is upward)\nb: top is level", 2),
        ("a: x is level\n  and y is level", 1),
        ("a: x is level\n  or y is level", 1),
        ("a: x is level,\n  y is level", 1),
        ("a: x at least\n 3", 1),
        ("a:\n  x is level", 1),
        ("a: x = 3 ±\n 1", 1),
        ("a: x is level   # why\n\n\n  # more\n  and y is level", 1),
        ("let a =\nlet b = 3", 2),
        ("a: x = 3 ±\nb: y is level", 2),
        ("\n\n  # nothing\n", 0),
        ("", 0),
    ],
)
def test_a_statement_goes_on_where_it_cannot_end(text: str, count: int) -> None:
    assert len(statements(text)) == count


def test_places_of_words_stay_where_comments_and_line_ends_are_taken_out() -> None:
    text = "a: x is level,  # yes\n   y is level"
    (statement,) = laid_out(Source("m", text)).statements
    joined = statement.text(text)
    assert len(joined) == len(text)
    for token in statement.tokens:
        assert joined[token.start : token.end] == token.text


def test_comments_keep_their_places_and_whether_they_stand_alone() -> None:
    found = laid_out(Source("m", '# one\nface a  # two\n"# none"')).comments
    assert [(c.text, c.alone) for c in found] == [("# one", True), ("# two", False)]


@pytest.mark.parametrize(
    ("text", "code", "column"),
    [
        ("a: (x is level", "bracket", 4),
        ("a: x is level)", "bracket", 14),
        ('a: x is level "why', "open-text", 15),
        ("a: x is level “why”", "quote", 15),
        ("a: x is level „why“", "quote", 15),
        ("a: tilt(x) at most 2,5 deg", "decimal-comma", 20),
        ("a: " + "(" * (DEEPEST + 1) + "x" + ")" * (DEEPEST + 1), "too-deep", DEEPEST + 4),
    ],
)
def test_an_open_bracket_or_text_is_blamed_where_it_stands(
    text: str, code: str, column: int
) -> None:
    layout = laid_out(Source("m", text + "\nface b"))
    (fault,) = layout.faults
    assert fault.code == code
    assert fault.source.get_line_and_column(fault.span.start) == (1, column)
    assert [s.whole for s in layout.statements] == [False, True]


@pytest.mark.parametrize(
    ("text", "after"),
    [
        ("a: x is level “why”", 'a: x is level "why"'),
        ("a: x is level „why“", 'a: x is level "why"'),
        ("a: x is level »why«", 'a: x is level "why"'),
        ('a: x is level "why”', 'a: x is level "why"'),
        ("a: tilt(x) at most 2,5 deg", "a: tilt(x) at most 2.5 deg"),
        ("a: length(x) at most 1,000 mm", "a: length(x) at most 1,000 mm"),  # or a thousand
    ],
)
def test_quotes_and_commas_of_other_languages_are_put_right_where_that_is_sure(
    text: str, after: str
) -> None:
    (fault,) = laid_out(Source("m", text)).faults
    fix = fault.sure_fix
    assert applied(text, fix.edits if fix is not None else ()) == after


def test_numbers_in_a_row_have_no_decimal_commas() -> None:
    assert not laid_out(Source("m", "a: f(1, 2), f(1,2,3)")).faults
