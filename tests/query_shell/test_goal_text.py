"""Goals as text: tokens, calls, where one ends, and the goals of a file."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.query_shell.goal_text import (
    MOST_LINES,
    TokenKind,
    calls,
    find_call,
    goals,
    is_complete,
    split_goals,
    tokens,
    variables,
)

ODD = st.text(st.sampled_from("aB_1 ,.()[]{}|'\"`%/*\\\n:=é界") | st.characters(), max_size=40)


@given(ODD)
def test_tokens_are_the_text_but_for_white_space(text):
    at = 0
    for token in tokens(text):
        assert text[at : token.start].strip() == ""
        assert text[token.start : token.end] == token.text
        at = token.end
    assert text[at:].strip() == ""


@given(ODD)
def test_nothing_that_is_typed_is_an_error(text):
    for place in range(len(text) + 1):
        find_call(text, place)
    calls(text), is_complete(text), list(split_goals(text)), variables(text)


@pytest.mark.parametrize(
    ("text", "kinds"),
    [
        ("'a (' X", ["name", "variable"]),
        ("0'a + 1.5e3", ["number", "symbol", "number"]),
        ("a =.. B.", ["name", "symbol", "variable", "end"]),
        ('"open', ["open"]),
        ("/* open", ["open"]),
        ("% note\nÄ é _", ["comment", "variable", "name", "variable"]),
        ("'it''s'", ["name"]),
    ],
)
def test_tokens_are_those_of_prolog(text, kinds):
    assert [token.kind.value for token in tokens(text)] == kinds


def test_brackets_in_quotations_and_comments_do_not_count():
    assert is_complete("X = '(' % (")
    assert not is_complete("X = (a")
    (call,) = calls("f('(', \")\")")
    assert [[t.kind for t in argument] for argument in call.arguments] == [
        [TokenKind.NAME],
        [TokenKind.TEXT],
    ]


def asked(text: str) -> list[tuple[int, str]]:
    return [(goal.line, goal.text) for goal in goals(text.splitlines(keepends=True))]


def test_a_line_is_a_goal_and_so_is_what_ends_with_a_full_stop():
    assert asked("face(F)\n% note\n\nedge(E,\n  A, B).\na. b.\n") == [
        (1, "face(F)"),
        (4, "edge(E,\n  A, B)"),
        (6, "a"),
        (6, "b"),
    ]


def test_a_forgotten_bracket_costs_one_goal():
    assert asked("face(\nedge(E, A, B)\n") == [(1, "face("), (2, "edge(E, A, B)")]
    assert asked("face(\n\nthing(T)\n") == [(1, "face("), (3, "thing(T)")]
    many = "face(\n" + "thing(T)\n" * (2 * MOST_LINES)
    assert len(asked(many)) == 2 * MOST_LINES + 1


def test_goals_are_asked_while_others_are_still_awaited():
    def lines() -> object:
        yield "face(F)\n"
        raise AssertionError("the second line was read before the first goal was asked")

    assert next(goals(lines())).text == "face(F)"  # type: ignore[arg-type]
