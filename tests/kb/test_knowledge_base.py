"""Scenes loaded, replaced and dropped; questions to one and to many; Python as predicates."""

import itertools
import json
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from facetlog.errors import EngineError, QueryError
from facetlog.kb.engine.terms import Atom, Term, Var
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.limits import Limits
from facetlog.kb.loading.encode import format_fact_clause, iter_program_lines

from .fresh import python


@pytest.fixture
def base() -> Iterator[KnowledgeBase]:
    with KnowledgeBase() as base:
        yield base


def faces(base: KnowledgeBase, *scenes: str) -> list[tuple[Term, ...]]:
    return list(base.query("face(F)", scenes=scenes or None))


def test_one_scene_gives_the_variables_of_the_question(base: KnowledgeBase) -> None:
    base.load_scene("s", [("face", "f1"), ("face", "f2"), ("area", "f1", 2.5, 0.1)])
    answers = base.query("face(F), area(F, Area, _Sd)")
    assert answers.names == ("F", "Area")
    assert list(answers) == [(Atom("f1"), 2.5)]
    assert list(base.query("face(f9)")) == []
    assert list(base.query("face(f2)")) == [()]


def test_several_scenes_are_asked_together(base: KnowledgeBase) -> None:
    base.load_scene("a", [("face", "fa")])
    base.load_scene("b", [("face", "fb")])
    answers = base.query("face(F)")
    assert answers.names == ("Scene", "F")
    assert list(answers) == [(Atom("a"), Atom("fa")), (Atom("b"), Atom("fb"))]
    assert faces(base, "b") == [(Atom("fb"),)]
    both = base.query("in(S, face(F)), in(T, face(G)), F @< G")
    assert list(both) == [(Atom("a"), Atom("fa"), Atom("b"), Atom("fb"))]


def test_a_scene_takes_the_place_of_one_of_its_name(base: KnowledgeBase) -> None:
    base.load_scene("s", [("face", "old")])
    base.load_scene("s", [("face", "new")])
    assert faces(base) == [(Atom("new"),)]
    with pytest.raises(EngineError, match="wobbly"):
        base.load_scene("s", [("face", "newer"), ("wobbly", "f1")])
    assert faces(base) == [(Atom("new"),)]


def test_a_question_goes_on_with_the_scene_that_it_began_with(base: KnowledgeBase) -> None:
    base.load_scene("s", [("face", f"f{i}") for i in range(5000)])
    answers = base.query("face(F)")
    assert next(answers) == (Atom("f0"),)
    base.load_scene("s", [("face", "new")])
    base.drop_scene("s")
    assert len(list(answers)) == 4999


def test_bases_do_not_see_each_other(base: KnowledgeBase) -> None:
    base.load_scene("s", [("face", "mine")])
    with KnowledgeBase() as other:
        other.load_scene("s", [("face", "yours")])
        assert faces(other) == [(Atom("yours"),)]
    assert faces(base) == [(Atom("mine"),)]


def test_a_scene_that_is_not_loaded_is_named(base: KnowledgeBase) -> None:
    with pytest.raises(EngineError, match="no scene 'attic'"):
        base.query("face(F)", scenes=["attic"])
    with pytest.raises(KeyError):
        base.drop_scene("attic")


def test_dropped_scenes_leave_no_module_and_no_clause() -> None:
    run = python(
        "import json\n"
        "from facetlog.kb.knowledge_base import KnowledgeBase\n"
        "base = KnowledgeBase()\n"
        "facts = [('thing', 't')] + [('face', f'f{i}') for i in range(300)]\n"
        "def use(times):\n"
        "    for i in range(times):\n"
        "        base.load_scene('s', facts)\n"
        "        list(base.query('face(F), verdict(t, box, S, D)'))\n"
        "        if i % 2:\n"
        "            base.drop_scene('s')\n"
        "    if 's' in base.scenes:\n"
        "        base.drop_scene('s')\n"
        "    return base.send('statistics', '')\n"
        "print(json.dumps([use(30), use(30), use(30)]))\n"
    )
    assert run.returncode == 0, run.stderr
    (modules, clauses), *later = json.loads(run.stdout)
    assert max(found for found, _ in later) <= modules
    # What Prolog loads for itself came with the first ones; now and then clauses wait for the
    # collector.
    assert min(found for _, found in later) < clauses + 30


def test_values_are_given_as_values_and_never_as_text(base: KnowledgeBase) -> None:
    awkward = "'), halt, X = ('"
    ((found,),) = base.query("X = Given", bindings={"Given": awkward})
    assert found == awkward
    with pytest.raises(QueryError, match="Gone"):
        base.query("X = 1", bindings={"Gone": 1})


def test_python_functions_are_predicates(base: KnowledgeBase) -> None:
    def twice(x: Term, y: Term) -> list[tuple[Term, ...]]:
        if isinstance(x, int):
            return [(x, 2 * x), (x, -2 * x)]
        assert isinstance(x, Var)
        assert isinstance(y, int)
        return [(y // 2, y)]

    base.define("twice", 2, twice)
    base.define("odd", 1, lambda x: isinstance(x, int) and x % 2 == 1)
    assert list(base.query("member(X, [1, 2]), odd(X), twice(X, Y)")) == [(1, 2), (1, -2)]
    assert list(base.query("twice(X, 6)")) == [(3,)]


def test_an_exception_of_a_python_function_is_raised_as_it_is(base: KnowledgeBase) -> None:
    class OwnError(Exception):
        pass

    error = OwnError("broken")

    def fails(_: Term) -> bool:
        raise error

    base.define("fails", 1, fails)
    with pytest.raises(OwnError) as caught:
        list(base.query("fails(1)"))
    assert caught.value is error
    base.define("wide", 1, lambda x: [(x, x)])
    with pytest.raises(ValueError, match="1 values"):
        list(base.query("wide(1)"))


def test_a_python_function_may_ask_questions_itself(base: KnowledgeBase) -> None:
    base.load_scene("s", [("face", "f1"), ("face", "f2")])
    base.define("faces", 1, lambda _: [(len(list(base.query("face(F)"))),)])
    assert list(base.query("between(1, 2, X), faces(N)")) == [(1, 2), (2, 2)]


def test_written_facts_load_by_themselves(facts_of: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / "facts.pl"
    path.write_text("\n".join(iter_program_lines(facts_of("box"))) + "\n")
    goal = "forall(face(F), (write(F), nl))"
    run = subprocess.run(
        ["swipl", "--on-warning=status", "-g", goal, "-t", "halt", path],
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.split() == [f"f{i}" for i in range(6)]
    assert run.stderr == ""


@pytest.mark.parametrize(
    ("goal", "limits", "message"),
    [
        ("(member(X, [1, 2]) ; between(1, inf, X), X < 0)", Limits(seconds=0.2), "time"),
        ("(member(X, [1, 2]) ; between(1, inf, X), X < 0)", Limits(inferences=10_000), "inferen"),
        ("(member(X, [1, 2]) ; length(X, N), N < 0)", Limits(stack_mb=8), "memory"),
        ("member(X, [1, 2, a]), Y is X + 1", Limits(), "is no number"),
    ],
)
def test_what_was_found_before_an_error_is_answered(
    base: KnowledgeBase, goal: str, limits: Limits, message: str
) -> None:
    answers = base.query(goal, limits=limits)
    assert [next(answers)[0], next(answers)[0]] == [1, 2]
    with pytest.raises((EngineError, QueryError), match=message):
        next(answers)


def test_the_python_of_the_documentation_runs() -> None:
    text = (Path(__file__).parents[2] / "docs" / "queries.md").read_text()
    run = python(text.split("```python\n")[1].split("```")[0])
    assert (run.returncode, run.stderr) == (0, "")


def test_a_limit_of_one_question_is_no_limit_of_the_next(base: KnowledgeBase) -> None:
    assert list(base.query("X = 1", limits=Limits(stack_mb=1))) == [(1,)]
    base.load_scene("s", [("face", f"f{i}") for i in range(20_000)])
    assert len(list(base.query("face(F)"))) == 20_000


def test_any_character_crosses_to_prolog_and_back(base: KnowledgeBase) -> None:
    # Names of files that are no UTF-8 have surrogates in Python.
    name = "a\udcffb\ud800ü\U0001f600"
    base.load_scene(name, [])
    assert list(base.query("X = Y", bindings={"Y": name})) == [(name,)]
    assert list(base.query("in(S, true)")) == [(Atom(name),)]
    base.drop_scene(name)


def test_a_closed_base_says_so() -> None:
    base = KnowledgeBase()
    base.close()
    with pytest.raises(EngineError, match="closed"):
        base.query("X = 1")
    with pytest.raises(EngineError, match="closed"):
        base.load_scene("s", [])


def test_a_column_has_a_name_of_its_own(base: KnowledgeBase) -> None:
    base.load_scene("a", [("face", "fa")])
    base.load_scene("b", [("face", "fb")])
    with pytest.raises(QueryError, match="Scene is the name"):
        base.query("in(Scene, face(F)), face(G)")
    assert faces(base, "a", "a") == [(Atom("fa"),)]


def test_an_endless_python_function_is_stopped(base: KnowledgeBase) -> None:
    base.define("natural", 1, lambda _: ((i,) for i in itertools.count()))
    with pytest.raises(ValueError, match="100,000 solutions"):
        base.query("natural(X)")


def test_a_fact_outside_the_contract_is_refused(base: KnowledgeBase) -> None:
    with pytest.raises(EngineError, match="wobbly"):
        base.load_scene("s", [("wobbly", "f1")])
    assert not base.scenes
    with pytest.raises(ValueError, match="nan"):
        format_fact_clause(("area", "f1", float("nan"), 0.0))


def test_at_most_so_many_answers_come(base: KnowledgeBase) -> None:
    assert list(base.query("between(1, inf, X)", most=3)) == [(1,), (2,), (3,)]
