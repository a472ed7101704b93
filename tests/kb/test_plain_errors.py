"""What Prolog throws is said in plain words, with the word that threw it and where it stands."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.cli import main
from facetlog.errors import EngineError, QueryError
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.scene_file import write_scene

from .hostile_cases import FACTS

# One or more of each kind of error that library(error), the arithmetic and the library throw: the
# question, what is said, and the part of the question that it is about.
QUESTIONS = [
    (
        "atom_length(X, Y)",
        "atom_length/2 needs a value where there is none yet",
        "atom_length(X, Y)",
    ),
    (
        "V = f(1), atom_length(a, V)",
        "atom_length/2 needs a whole number, not f(1)",
        "atom_length(a, V)",
    ),
    ("V = -1, length(X, V)", "length/2 needs a number from 0, not -1", "length(X, V)"),
    ("V = foo, member(X, [1]), X =.. V", "=../2 needs a list, not foo", "X =.. V"),
    ("V = [[_]|a], keysort(V, X)", "keysort/2 needs a list, not [[_]|a]", "keysort(V, X)"),
    ("V = [1], keysort(V, X)", "keysort/2 needs a pair Key-Value, not 1", "keysort(V, X)"),
    ("V = x, arg(1, V, X)", "arg/3 needs a term with arguments, not x", "arg(1, V, X)"),
    ("V = f(x), X is V", "is/2 computes with f(x), which is no number", "X is V"),
    ("V = foo, 1 < V", "</2 computes with foo, which is no number", "1 < V"),
    ('V = "ab", X is V + 1', 'is/2 computes with "ab", which is no number', "X is V + 1"),
    ("X is 1 / 0", "//2 divides by 0", "1 / 0"),
    ("V = 0, X is 5 mod V", "mod/2 divides by 0", "5 mod V"),
    (
        "X is sqrt(-1)",
        "is/2 computes what has no value, such as 0/0 or the root of -1",
        "X is sqrt(-1)",
    ),
    ("X is exp(1000)", "is/2 computes a number that is too large, or infinite", "X is exp(1000)"),
    ("X is 1 << 1.5", "<</2 needs a whole number, not 1.5", "1 << 1.5"),
    (
        "V = 1.5, X is numerator(V)",
        "numerator/1 needs a whole number or a fraction, not 1.5",
        "numerator(V)",
    ),
    (
        "V = [x], number_codes(X, V)",
        "number_codes/2 is given a text that is no number",
        "number_codes(X, V)",
    ),
    (
        "V = 9999999999999999999999, char_code(X, V)",
        "char_code/2 is given a number or a text that is too large for it",
        "char_code(X, V)",
    ),
    (
        "V = f(x), string_lower(V, X)",
        "string_lower/2 needs a name, a number or a string, not f(x)",
        "string_lower(V, X)",
    ),
    ("V = [a|b], atom_length(V, X)", "atom_length/2 needs text, not [a|b]", "atom_length(V, X)"),
    ("V = f(x), succ(X, V)", "succ/2 needs a whole number, not f(x)", "succ(X, V)"),
    (
        "order_by([1], member(X, [2]))",
        "order_by/2 needs asc(X) or desc(X), not 1",
        "order_by([1], member(X, [2]))",
    ),
    (
        "V = [], order_by(V, member(X, [2]))",
        "order_by/2 needs a list with something in it, not []",
        "order_by(V, member(X, [2]))",
    ),
    (
        "V = -1, offset(V, member(X, [2]))",
        "offset/2 needs a number from 0, not -1",
        "offset(V, member(X, [2]))",
    ),
    (
        "V = -1, call_nth(member(X, [2]), V)",
        "call_nth/2 needs a number from 1, not -1",
        "call_nth(member(X, [2]), V)",
    ),
    (
        "V = a, limit(V, member(X, [2]))",
        "limit/2 computes with a, which is no number",
        "limit(V, member(X, [2]))",
    ),
    ("V = a, nth0(V, [1], X)", "nth0/3 needs a whole number, not a", "nth0(V, [1], X)"),
    (
        "V = a, nth1(V, [1], X, Y)",
        "nth1/4 needs a whole number from 1, not a",
        "nth1(V, [1], X, Y)",
    ),
    (
        "V = x, compare(V, 1, 2)",
        "compare/3 needs one of <, =, > (to compare) or @<, @>, @=<, @>= (to sort), not x",
        "compare(V, 1, 2)",
    ),
    (
        "V = x, sort(0, V, [1], X)",
        "sort/4 needs one of <, =, > (to compare) or @<, @>, @=<, @>= (to sort), not x",
        "sort(0, V, [1], X)",
    ),
    ("V = x, memberchk(1, V)", "memberchk/2 needs a list, not x", "memberchk(1, V)"),
    ("V = x, union(V, [1], X)", "union/3 needs lists", "union(V, [1], X)"),
    ("V = x, max_member(X, V)", "max_member/2 needs lists", "max_member(X, V)"),
]


@pytest.fixture(scope="module")
def base() -> Iterator[KnowledgeBase]:
    with KnowledgeBase() as opened:
        yield opened


@pytest.mark.parametrize(("question", "says", "about"), QUESTIONS)
def test_an_error_of_prolog_says_what_the_word_needs_and_where_it_stands(
    question: str, says: str, about: str, base: KnowledgeBase
) -> None:
    with pytest.raises(QueryError) as told:
        list(base.query(question))
    assert str(told.value) == says
    assert question[told.value.start : told.value.end] == about


def test_a_word_that_stands_there_twice_is_named_without_a_place(base: KnowledgeBase) -> None:
    with pytest.raises(QueryError) as told:
        list(base.query("atom_length(ab, X), V = f(X), atom_length(a, V)"))
    assert str(told.value) == "atom_length/2 needs a whole number, not f(2)"
    assert (told.value.start, told.value.end) == (0, 0)


def test_a_large_value_is_cut_short(base: KnowledgeBase) -> None:
    with pytest.raises(QueryError) as told:
        list(base.query("numlist(1, 5000, L), atom_length(a, L)"))
    assert len(str(told.value)) < 200


def test_an_error_in_a_model_names_the_model(base: KnowledgeBase, tmp_path: Path) -> None:
    rules = tmp_path / "lame.pl"
    rules.write_text(
        'model(lame, "A board.", [board]).\n'
        "candidate(lame, T, [F]) :- face_of(T, F), X = foo, Y is X + 1, Y > 0.\n"
        'condition(lame, flat, "it is level", _, [F], at_most(tilt(F), 5)).\n'
    )
    loaded = base.load_rules(rules, trusted=True)
    base.load_scene("s", FACTS)
    try:
        with pytest.raises(EngineError) as told:
            base.why("s", "lame")
        assert str(told.value) == "model lame: a goal computes with foo, which is no number"
    finally:
        base.drop_scene("s")
        base.unload_rules(loaded)


def test_the_command_line_says_it_in_plain_words_with_the_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    write_scene(cuboid(), tmp_path / "scene.json")
    assert main(["query", str(tmp_path / "scene.json"), "V = foo, face(F), atom_length(F, V)"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "atom_length/2 needs a whole number, not foo" in err
    assert "^~~~~~~~~~~~~~~~~\n" in err
