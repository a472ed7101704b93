"""Faults underlined: wide characters, several lines, faults at the end."""

import pytest

from facetlog.errors import QueryError
from facetlog.query_shell.screen import WIDTH, underlined


@pytest.mark.parametrize(
    ("text", "start", "end", "lines"),
    [
        ("angel(A, B)", 0, 5, ["angel(A, B)", "^~~~~"]),
        ("face(日本), x", 10, 11, ["face(日本), x", " " * 12 + "^"]),
        ("f(日本)", 2, 4, ["f(日本)", "  ^~~~"]),
        ("face(F", 6, 6, ["face(F", " " * 6 + "^"]),
        ("a,\nb c", 5, 6, ["line 2 of the goal:", "b c", "  ^"]),
        ("a,\n", 3, 3, ["a,", "  ^"]),
        ("\tx", 1, 2, ["    x", "    ^"]),
        ("X is 1/0", 0, 0, ["X is 1/0", "^~~~~~~~"]),
    ],
)
def test_the_fault_is_underlined(text, start, end, lines):
    assert underlined(QueryError("", text=text, start=start, end=end)) == lines


def test_an_error_without_a_goal_underlines_nothing():
    assert underlined(QueryError("there is no model x")) == []


def test_of_a_long_line_the_part_round_the_fault_is_shown():
    text = "a" * 5000 + "bad" + "c" * 5000
    line, carets = underlined(QueryError("", text=text, start=5000, end=5003))
    assert len(line) == WIDTH
    assert line[carets.index("^") :][:3] == "bad"
    assert carets.strip() == "^~~"
