"""Goals as text: tokens, calls, where one ends, and the goals of a file."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.query_shell.goal_text import (
    MOST_LINES,
    TokenKind,
    call_at,
    calls,
    goals,
    is_complete,
    split_goals,
    tokens,
    variables,
)

ODD = st.text(st.sampled_from("aB_1 ,.()[]{}|'\"`%/*\\\n:=é界") | st.characters(), max_size=40)


@given(ODD)
def test_tokens_are_the_text_but_for_white_space(text: str) -> None:
    at = 0
    for token in tokens(text):
        assert text[at : token.start].strip() == ""
        assert text[token.start : token.end] == token.text
        at = token.end
    assert text[at:].strip() == ""


@given(ODD)
def test_nothing_that_is_typed_is_an_error(text: str) -> None:
    for place in range(len(text) + 1):
        call_at(text, place)
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
def test_tokens_are_those_of_prolog(text: str, kinds: list[str]) -> None:
    assert [token.kind.value for token in tokens(text)] == kinds


def test_brackets_in_quotations_and_comments_do_not_count() -> None:
    assert is_complete("X = '(' % (")
    assert not is_complete("X = (a")
    (call,) = calls("f('(', \")\")")
    assert [[t.kind for t in argument] for argument in call.arguments] == [
        [TokenKind.NAME],
        [TokenKind.TEXT],
    ]


@pytest.mark.parametrize("text", ["", "face(F).", "% only a note", "X > 3", "a) b", "!"])
def test_a_goal_may_end_here(text: str) -> None:
    assert is_complete(text)


@pytest.mark.parametrize("text", ["face(F),", "X =", "findall(F, (a", "[a", "'a", "a ->", "a :-"])
def test_a_goal_goes_on(text: str) -> None:
    assert not is_complete(text)


def test_the_argument_at_the_cursor_belongs_to_the_innermost_call() -> None:
    text = "holds(near(angle(f1, ["
    assert call_at(text, len(text)) == ("angle", 1)
    assert call_at("angle(f1, f2), ", 15) is None
    assert call_at("(a, ", 4) is None


def test_variables_stand_in_order_without_those_of_no_interest() -> None:
    assert variables("angle(B, A, _, _Sd), A @< B % C") == ("B", "A")


def asked(text: str) -> list[tuple[int, str]]:
    return [(goal.line, goal.text) for goal in goals(text.splitlines(keepends=True))]


def test_a_line_is_a_goal_and_so_is_what_ends_with_a_full_stop() -> None:
    assert asked("face(F)\n% note\n\nedge(E,\n  A, B).\na. b.\n") == [
        (1, "face(F)"),
        (4, "edge(E,\n  A, B)"),
        (6, "a"),
        (6, "b"),
    ]


def test_a_forgotten_bracket_costs_one_goal() -> None:
    assert asked("face(\nedge(E, A, B)\n") == [(1, "face("), (2, "edge(E, A, B)")]
    assert asked("face(\n\nthing(T)\n") == [(1, "face("), (3, "thing(T)")]
    many = "face(\n" + "thing(T)\n" * (2 * MOST_LINES)
    assert len(asked(many)) == 2 * MOST_LINES + 1


def test_a_command_is_its_whole_line() -> None:
    assert asked(":load a. b (\nface(F)\n") == [(1, ":load a. b ("), (2, "face(F)")]


def test_goals_are_asked_while_others_are_still_awaited() -> None:
    def lines() -> object:
        yield "face(F)\n"
        raise AssertionError("the second line was read before the first goal was asked")

    assert next(goals(lines())).text == "face(F)"  # type: ignore[arg-type]
