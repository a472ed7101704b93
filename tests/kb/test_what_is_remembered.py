"""Answers that a scene remembers: of small questions only, and never too many answers."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.errors import EngineError
from facetlog.kb.engine.terms import Atom, Struct
from facetlog.kb.knowledge_base import KnowledgeBase

from .hostile_cases import FACTS

# How many answers the only scene remembers.
REMEMBERED = """
:- module(memory, []).
:- use_module(facetlog(vocabulary)).
model(memory, "What is remembered.", [answers]).
candidate(memory, _, [Count]) :-
    b_getval(facetlog_scene, Scene),
    (   current_predicate(Scene:'facetlog recall'/6)
    ->  findall(x, Scene:'facetlog recall'(pairs, _, _, _, _, _), Xs)
    ;   Xs = []
    ),
    length(Xs, Count0),
    atom_number(Count, Count0).
condition(memory, always, "it is so", _, _, all([])).
"""

# A term of N levels, built by unification, so that nothing is read or copied: Top is
# not(not(... near(angle(X, Y), 90, 15))).
DEEP = (
    "length(_Os, {n}), length(_Ts, {n}), length(_Ss, {n}), maplist(last, _Ss, _Ts), "
    "maplist(append([not]), _Ss, _Ls), maplist(=.., _Os, _Ls), _Os = [_Top|_Tail], "
    "append(_Tail, [near(angle(X, Y), 90, 15)], _Ts), each_pair(X, Y, [A], _Top)"
)


@pytest.fixture
def base() -> Iterator[KnowledgeBase]:
    with KnowledgeBase() as base:
        base.load_scene("s", FACTS)
        yield base


@pytest.mark.parametrize("levels", [3_000, 100_000])
def test_a_test_too_deep_to_be_compiled_is_refused(base: KnowledgeBase, levels: int) -> None:
    with pytest.raises(EngineError, match="the size of a term"):
        list(base.query(DEEP.format(n=levels), most=1))
    assert len(list(base.query("face(F)"))) == 2


@pytest.mark.parametrize(
    ("questions", "most"),
    [
        ("forall(between(1, 30, N), each_pair(X, Y, [], near(angle(X, Y), 90, N)))", 30),
        ("forall(between(1, 500, N), each_pair(X, Y, [], near(angle(X, Y), 90, N)))", 64),
        ("numlist(1, 5000, L), each_pair(X, Y, [], some(Z, L, near(angle(X, Y), 90, Z)))", 0),
        ("length(L, 50000), maplist(=(0'a), L), string_codes(S, L), "
         "each_pair(X, Y, [], parallel(X, S, 1))", 0),
    ],
)  # fmt: skip
def test_pairs_of_few_small_tests_are_remembered(
    base: KnowledgeBase, tmp_path: Path, questions: str, most: int
) -> None:
    path = tmp_path / "memory.pl"
    path.write_text(REMEMBERED)
    base.load_rules(path, trusted=True)  # before: what was remembered is forgotten
    list(base.query(questions))
    (part,) = base.judge("s", "memory", "t1").parts
    assert part.faces == (str(most),)


def test_a_test_that_looks_like_a_key_gets_its_own_answer(base: KnowledgeBase) -> None:
    false = Struct("angle", (Struct("$VAR", (0,)), Struct("$VAR", (1,))))
    assert not list(base.query("each_pair(_, _, [A, B], near(G, 90, 15))", bindings={"G": false}))
    found = list(base.query("each_pair(X, Y, [A, B], near(angle(X, Y), 90, 15))"))
    assert found == [(Atom("f1"), Atom("f2"))]


def test_what_is_asked_of_nothing_in_particular_is_not_taken_for_all(base: KnowledgeBase) -> None:
    facts = [("part_of", "f1", "t1"), ("part_of", "f2", "t2"), ("thing", "t1"), ("thing", "t2")]
    tops = [("top_of", "f1", 1.0, 0.1), ("top_of", "f2", 2.0, 0.1)]
    base.load_scene("two", [*facts, *tops])
    asked = "measure(thing_height({}), V, _, _)"
    list(base.query(asked.format("_"), scenes=["two"]))
    assert list(base.query(asked.format("t1"), scenes=["two"])) == [(1.0,)]
