"""Terms there and back, of all kinds, exactly."""

import pytest

from facetlog.errors import EngineError
from facetlog.kb.engine.terms import Atom, Struct, Term, Var, decode_terms, format_prolog_term
from facetlog.kb.knowledge_base import KnowledgeBase


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
