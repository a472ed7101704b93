"""Terms there and back, of all kinds, exactly."""

import math
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.errors import EngineError
from facetlog.kb.engine.terms import Atom, Struct, Term, Var, decode_terms, format_prolog_term
from facetlog.kb.knowledge_base import KnowledgeBase

# Prolog has these in the place of surrogates, which are no characters (engine.py).
IN_THEIR_PLACE = "".join(map(chr, range(0x10F000, 0x10F800)))
NAMES = st.text(
    st.characters(exclude_categories=("Cs",), exclude_characters=IN_THEIR_PLACE), max_size=8
)
TERMS: st.SearchStrategy[Term] = st.recursive(
    st.one_of(
        st.integers(),
        st.floats(allow_nan=False),
        st.fractions().filter(lambda f: f.denominator > 1),
        NAMES,
        NAMES.map(Atom),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3).map(tuple),
        st.builds(Struct, NAMES, st.lists(inner, max_size=3).map(tuple)),
    ),
    max_leaves=8,
)


@pytest.fixture(scope="module")
def base() -> KnowledgeBase:
    return KnowledgeBase()


def there_and_back(base: KnowledgeBase, term: Term) -> Term:
    ((back,),) = base.query("X = Given", bindings={"Given": term})
    return back


@pytest.mark.parametrize(
    "number", [2**63, -(2**63) - 1, 10**300, 7**20_000, -(2**100_000)], ids=int.bit_length
)
def test_integers_of_any_size_are_exact(base: KnowledgeBase, number: int) -> None:
    assert there_and_back(base, number) == number


def test_atoms_strings_lists_and_variables_are_told_apart(base: KnowledgeBase) -> None:
    answers = base.query("X = f(a, \"a\", [a], [], '[]', Y, Y, _)")
    row = dict(zip(answers.names, next(answers), strict=True))
    x = row["X"]
    assert isinstance(x, Struct)
    assert x.args[:5] == (Atom("a"), "a", (Atom("a"),), (), Atom("[]"))
    assert x.args[5] == x.args[6] != x.args[7]
    assert x.args[5] == row["Y"]


def test_term_text_refuses_what_is_no_variable() -> None:
    with pytest.raises(ValueError, match="no name of a Prolog variable"):
        format_prolog_term(Var("x), halt"))


@pytest.mark.parametrize(
    "term",
    [
        Struct("{}", (Struct(":", (Atom("s"), "a")),)),
        Struct("facetlog variable", (3,)),
        Struct("facetlog variable", (Atom("abc"),)),
        Struct("$VAR", (1,)),
    ],
    ids=repr,
)
def test_no_term_is_taken_for_a_mark_of_the_writer(base: KnowledgeBase, term: Term) -> None:
    assert there_and_back(base, term) == term
    answers = base.query("X = f(Given, Y, Y)", bindings={"Given": term})
    ((x, y),) = answers
    assert x == Struct("f", (term, y, y))
    assert isinstance(y, Var)


@pytest.mark.parametrize("levels", [600, 100_000])
def test_what_is_nested_deeper_than_python_reads_is_one_line(levels: int) -> None:
    assert decode_terms('[{"f": "g", "t": [1]}]') == [Struct("g", (1,))]
    with pytest.raises(EngineError, match="nested too deeply"):
        decode_terms(f"""[{'{"f": "g", "t": [' * levels}1{"]}" * levels}]""")


@settings(max_examples=80)
@given(TERMS)
def test_terms_survive_the_way_to_prolog_and_back(term: Term) -> None:
    assert there_and_back(KnowledgeBase(), term) == term


@pytest.mark.parametrize("text", ["\0", "a\0b", "ä€😀", "'), halt, X = ('", "\\", "\n", "", "[]"])
def test_awkward_text_is_kept_and_never_runs(base: KnowledgeBase, text: str) -> None:
    assert there_and_back(base, Atom(text)) == Atom(text)
    assert there_and_back(base, text) == text


@pytest.mark.parametrize("number", [0.1, -0.0, 5e-324, 1.7976931348623157e308, math.inf, -math.inf])
def test_floats_are_exact(base: KnowledgeBase, number: float) -> None:
    back = there_and_back(base, number)
    assert isinstance(back, float)
    assert math.copysign(1, back) == math.copysign(1, number)
    assert back == number


def test_a_rational_is_no_float(base: KnowledgeBase) -> None:
    assert there_and_back(base, Fraction(1, 3)) == Fraction(1, 3)
    assert list(base.query("X is 2r6 + 1r3")) == [(Fraction(2, 3),)]
