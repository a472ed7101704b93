"""Errors of Prolog in plain words, with the word that threw it and where it stands."""

from pathlib import Path

import pytest

from facetlog.errors import EngineError, QueryError
from facetlog.kb.knowledge_base import KnowledgeBase

from .hostile_cases import FACTS

# One of each kind of error that library(error), the arithmetic and the library throw: the question,
# whose last goal or expression is at fault, and what is said.
QUESTIONS = [
    ("atom_length(X, Y)", "atom_length/2 needs a value where there is none yet"),
    ("V = f(1), atom_length(a, V)", "atom_length/2 needs a whole number, not f(1)"),
    ("V = [[_]|a], keysort(V, X)", "keysort/2 needs a list, not [[_]|a]"),
    ("V = [1], keysort(V, X)", "keysort/2 needs a pair Key-Value, not 1"),
    ("V = f(x), X is V", "is/2 computes with f(x), which is no number"),
    ("V = 0, X is 5 mod V", "mod/2 divides by 0"),
    ("X is sqrt(-1)", "is/2 computes what has no value, such as 0/0 or the root of -1"),
    ("X is exp(1000)", "is/2 computes a number that is too large, or infinite"),
    ("V = [x], number_codes(X, V)", "number_codes/2 is given a text that is no number"),
    ("order_by([1], member(X, [2]))", "order_by/2 needs asc(X) or desc(X), not 1"),
    ("V = -1, offset(V, member(X, [2]))", "offset/2 needs a number from 0, not -1"),
    ("V = a, nth0(V, [1], X)", "nth0/3 needs a whole number, not a"),
    ("V = x, union(V, [1], X)", "union/3 needs lists"),
]


@pytest.mark.parametrize(("question", "says"), QUESTIONS)
def test_an_error_of_prolog_says_what_the_word_needs_and_where_it_stands(
    question: str, says: str, base: KnowledgeBase
) -> None:
    with pytest.raises(QueryError) as told:
        list(base.query(question))
    assert str(told.value) == says
    assert 0 <= told.value.start < told.value.end == len(question)


def test_a_word_that_stands_there_twice_is_named_without_a_place(base: KnowledgeBase) -> None:
    with pytest.raises(QueryError) as told:
        list(base.query("atom_length(ab, X), V = f(X), atom_length(a, V)"))
    assert str(told.value) == "atom_length/2 needs a whole number, not f(2)"
    assert (told.value.start, told.value.end) == (0, 0)


def test_an_error_in_a_model_names_the_model(tmp_path: Path) -> None:
    rules = tmp_path / "lame.pl"
    rules.write_text(
        'model(lame, "A board.", [board]).\n'
        "candidate(lame, T, [F]) :- face_of(T, F), X = foo, Y is X + 1, Y > 0.\n"
        'condition(lame, flat, "it is level", _, [F], at_most(tilt(F), 5)).\n'
    )
    with KnowledgeBase() as own:
        own.load_rules(rules, trusted=True)
        own.load_scene("s", FACTS)
        with pytest.raises(EngineError) as told:
            own.why("s", "lame")
    assert str(told.value) == "model lame: a goal computes with foo, which is no number"
