"""Answers as columns: any value exactly, as rows and as arrays, a chunk at a time."""

import math
import struct
from itertools import islice

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.errors import EngineError, QueryError
from facetlog.kb.engine.columns import decode_chunk
from facetlog.kb.engine.terms import Atom, Struct, Term, Var
from facetlog.kb.knowledge_base import KnowledgeBase
from tests.kb.engine.test_terms import IN_THEIR_PLACE

CHARACTERS = st.characters(exclude_categories=["Cs"], exclude_characters=IN_THEIR_PLACE)
TEXTS = st.text(CHARACTERS, max_size=8) | st.sampled_from(
    ["", "\n", "\0", "a\0b", "\x1f", ",", "[]", "😀", "'", '"', "\\", "ä", "€"]
)
FLOATS = st.floats(allow_nan=False, allow_infinity=True) | st.sampled_from([0.0, -0.0, 5e-324])
INTEGERS = st.integers() | st.sampled_from([2**200, -(2**200), 2**63, 2**63 - 1, -(2**63)])
FRACTIONS = st.fractions().filter(lambda f: f.denominator > 1)
ATOMS = st.builds(Atom, TEXTS)
SIMPLE = (ATOMS, TEXTS, FLOATS, INTEGERS, st.integers(-(2**63), 2**63 - 1), FRACTIONS)
NESTED: st.SearchStrategy[Term] = st.recursive(
    st.one_of(*SIMPLE),
    lambda inner: (
        st.lists(inner, max_size=3).map(tuple)
        | st.builds(Struct, TEXTS, st.lists(inner, min_size=1, max_size=3).map(tuple))
    ),
    max_leaves=6,
)
KINDS: st.SearchStrategy[st.SearchStrategy[Term]] = st.sampled_from(
    [*SIMPLE, FLOATS | INTEGERS, NESTED]
)
WIDEST = 6


@st.composite
def tables(draw: st.DrawFn) -> tuple[tuple[Term, ...], ...]:
    """Return rows of equal width; each column has values of one kind, or of several."""
    kinds = draw(st.lists(KINDS, min_size=1, max_size=WIDEST))
    return tuple(draw(st.lists(st.tuples(*kinds), max_size=5)))


def echoed(base: KnowledgeBase, rows: tuple[tuple[Term, ...], ...]) -> list[tuple[Term, ...]]:
    """Return the rows after their way to Prolog and back."""
    names = [f"V{i}" for i in range(len(rows[0]))] if rows else ["V"]
    goal = f"member([{','.join(names)}], Rows)"
    return list(base.query(goal, bindings={"Rows": rows}))


def exact(term: Term) -> object:
    """Key that tells 0.0 from -0.0, and 1 from 1.0."""
    match term:
        case float():
            return struct.pack("<d", term)
        case tuple():
            return tuple(map(exact, term))
        case Struct(functor, args):
            return (functor, *map(exact, args))
        case _:
            return type(term), term


@settings(max_examples=150)
@given(tables())
@pytest.mark.slow
def test_any_table_comes_back_exactly(
    base: KnowledgeBase, rows: tuple[tuple[Term, ...], ...]
) -> None:
    assert exact(tuple(echoed(base, rows))) == exact(rows)


def test_not_a_number_comes_back(base: KnowledgeBase) -> None:
    ((a, b),) = echoed(base, ((math.nan, (math.nan,)),))
    assert isinstance(a, float)
    assert math.isnan(a)
    assert isinstance(b, tuple)
    assert math.isnan(b[0])  # type: ignore[arg-type]


def test_a_variable_keeps_its_identity_within_a_row(base: KnowledgeBase) -> None:
    answers = base.query("A = f(X, Y), B = g(Y)")
    assert answers.names == ("A", "X", "Y", "B")
    assert list(answers) == [
        (Struct("f", (Var("X0"), Var("X1"))), Var("X0"), Var("X1"), Struct("g", (Var("X1"),)))
    ]


def test_an_integer_longer_than_python_prints_comes_back(base: KnowledgeBase) -> None:
    assert echoed(base, ((10**5000, (-(10**5000),)),)) == [(10**5000, (-(10**5000),))]


def test_a_cyclic_term_is_refused(base: KnowledgeBase) -> None:
    with pytest.raises(QueryError, match="does not contain itself"):
        list(base.query("X = f(X)"))
    assert list(base.query("X = 1")) == [(1,)]


@pytest.mark.parametrize(
    ("goal", "dtype"),
    [
        ("member(X, [1.5, 2.5])", np.float64),
        ("member(X, [1, 2])", np.int64),
        ("member(X, [1, 2.5])", np.float64),
        ("member(X, [9007199254740993, 2.5])", np.object_),
        ("member(X, [18446744073709551616])", np.object_),
        ("member(X, [a, b])", np.object_),
        ("member(X, [[1], [2]])", np.object_),
        ("member(X, [1, a])", np.object_),
        ("between(1, 5000, X)", np.int64),
        ("between(1, 5000, N), X is sqrt(N)", np.float64),
    ],
)
def test_arrays_hold_what_the_tuples_hold(
    base: KnowledgeBase, goal: str, dtype: type[np.generic]
) -> None:
    array = base.query(goal).arrays()["X"]
    assert array.dtype == dtype
    answers = base.query(goal)
    at = answers.names.index("X")
    assert array.tolist() == [row[at] for row in answers]


def test_chunks_of_different_kinds_make_one_array(base: KnowledgeBase) -> None:
    # Floats in the first chunk, integers in a later one.
    array = base.query("between(1, 1000, N), ( N < 500 -> X = 0.5 ; X = N )").arrays()["X"]
    assert array.dtype == np.float64
    assert array[[0, -1]].tolist() == [0.5, 1000.0]


def test_the_first_answer_does_not_wait_for_the_last(base: KnowledgeBase) -> None:
    answers = base.query("between(1, inf, X)")
    assert [x for (x,) in islice(answers, 5000)] == list(range(1, 5001))
    answers.close()


def test_what_was_read_as_tuples_and_the_rest_as_arrays(base: KnowledgeBase) -> None:
    answers = base.query("between(1, 5000, X)")
    assert [x for (x,) in islice(answers, 3)] == [1, 2, 3]
    assert answers.arrays()["X"].tolist() == list(range(4, 5001))


@pytest.mark.parametrize("pieces", [[b"2 nn", b"1,2"], [b"1 n", "1", "2"], [b"1 ff", b""]])
def test_a_chunk_that_lacks_a_column_is_an_error(pieces: list[bytes | str]) -> None:
    with pytest.raises(EngineError, match="cannot be read"):
        decode_chunk(pieces)
