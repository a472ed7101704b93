"""The embedded Prolog: terms there and back, limits, errors, and a clean house."""

import os
import re
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import facetlog
from facetlog.errors import EngineError
from facetlog.kb.encode import fact_text, facts_program
from facetlog.kb.engine import Engine, Limits, LoadedScene
from facetlog.kb.terms import Atom, Struct, Term, Var, term_text

NAMES = st.text(st.characters(exclude_categories=("Cs",)), max_size=8)
TERMS: st.SearchStrategy[Term] = st.recursive(
    st.one_of(
        st.integers(),
        st.floats(allow_nan=False, allow_infinity=False),
        NAMES,
        NAMES.map(Atom),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3).map(tuple),
        st.builds(Struct, NAMES, st.lists(inner, min_size=1, max_size=3).map(tuple)),
    ),
    max_leaves=8,
)


@pytest.fixture(scope="module")
def engine() -> Engine:
    return Engine()


def python(code: str) -> subprocess.CompletedProcess[str]:
    """The code run by a fresh interpreter that finds this facetlog."""
    return subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env={**os.environ, "PYTHONPATH": str(Path(facetlog.__file__).parents[1])},
    )


def ask(engine: Engine, goal: Term, **options: Any) -> list[dict[str, Term]]:
    with engine.load_scene("s", [("face", "f1"), ("face", "f2")]) as scene:
        return engine.query(scene, goal, **options)


@settings(max_examples=60, deadline=None)
@given(TERMS)
def test_terms_survive_the_way_to_prolog_and_back(term: Term) -> None:
    assert ask(Engine(), Struct("=", (Var("X"), term))) == [{"X": term}]


@pytest.mark.parametrize("text", ["\0", "a\0b", "ä€😀", "'), halt, X = ('", "\\", "\n", ""])
def test_awkward_text_is_kept_and_never_runs(engine: Engine, text: str) -> None:
    assert ask(engine, Struct("=", (Var("X"), Atom(text)))) == [{"X": Atom(text)}]
    assert ask(engine, Struct("=", (Var("X"), text))) == [{"X": text}]


def test_facts_are_asked_with_variables(engine: Engine) -> None:
    found = ask(engine, Struct("fact", (Struct("face", (Var("F"),)),)))
    assert found == [{"F": Atom("f1")}, {"F": Atom("f2")}]
    assert ask(engine, Struct("fact", (Struct("face", (Atom("f9"),)),))) == []


@pytest.mark.parametrize(
    "goal",
    [
        Atom("halt"),
        Struct("fact", (Atom("halt"),)),
        Struct("fact", (Struct(",", (Atom("halt"), Atom("true"))),)),
        Struct("fact", (Struct(":", (Atom("user"), Atom("halt"))),)),
        Struct("shell", (Atom("true"),)),
        Struct("fact", (Var("X"),)),
    ],
)
def test_a_question_that_acts_is_refused(engine: Engine, goal: Term) -> None:
    with pytest.raises(Exception, match="not a word of the vocabulary"):
        ask(engine, goal)


def test_limits_end_a_question(engine: Engine) -> None:
    endless = Struct(
        ",", (Struct("between", (1, Atom("inf"), Var("X"))), Struct("<", (Var("X"), 0)))
    )
    with pytest.raises(EngineError, match="time limit"):
        ask(engine, endless, limits=Limits(seconds=0.2, inferences=10**12))
    with pytest.raises(EngineError, match="limit of inferences"):
        ask(engine, endless, limits=Limits(seconds=60.0, inferences=100_000))
    assert ask(engine, Atom("true")) == [{}]


def test_at_most_so_many_answers_come(engine: Engine) -> None:
    found = ask(engine, Struct("between", (1, Atom("inf"), Var("X"))), most=3)
    assert [row["X"] for row in found] == [1, 2, 3]


def test_prologs_errors_come_with_prologs_text(engine: Engine) -> None:
    with pytest.raises(EngineError, match=r"Arithmetic: evaluation error.*zero_divisor"):
        ask(engine, Struct("is", (Var("X"), Struct("/", (1, 0)))))


def test_a_scene_leaves_nothing_behind(engine: Engine) -> None:
    with engine.load_scene("first", [("face", "old")]) as first:
        pass
    with pytest.raises(EngineError):
        engine.query(first, Struct("fact", (Struct("face", (Var("X"),)),)))
    assert len(ask(engine, Struct("fact", (Struct("face", (Var("X"),)),)))) == 2


def test_scenes_stand_side_by_side(engine: Engine) -> None:
    goal = Struct("fact", (Struct("face", (Var("F"),)),))
    with (
        engine.load_scene("a", [("face", "fa")]) as a,
        engine.load_scene("b", [("face", "fb")]) as b,
    ):
        assert a.module != b.module
        assert engine.query(a, goal) == [{"F": Atom("fa")}]
        assert engine.query(b, goal) == [{"F": Atom("fb")}]


def test_a_fact_outside_the_contract_is_refused(engine: Engine) -> None:
    with (
        pytest.raises(EngineError, match="wobbly"),
        engine.load_scene("s", [("wobbly", "f1")]),
    ):
        pass
    with pytest.raises(ValueError, match="no nan"):
        fact_text(("area", "f1", float("nan"), 0.0))


def test_another_thread_is_refused(engine: Engine) -> None:
    errors: list[BaseException] = []

    def use() -> None:
        try:
            Engine()
        except EngineError as exc:
            errors.append(exc)

    thread = threading.Thread(target=use)
    thread.start()
    thread.join()
    assert "thread" in str(errors[0])


def test_written_facts_load_by_themselves(facts_of: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / "facts.pl"
    path.write_text("\n".join(facts_program(facts_of("box"))) + "\n")
    run = subprocess.run(
        [
            "swipl",
            "--on-warning=status",
            "-g",
            "forall(face(F), (write(F), nl))",
            "-t",
            "halt",
            path,
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.split() == [f"f{i}" for i in range(6)]
    assert run.stderr == ""


def test_the_interpreter_ends_cleanly_with_a_scene_open() -> None:
    code = (
        "from facetlog.kb.engine import Engine\n"
        "context = Engine().load_scene('s', [('face', 'f1')])\n"
        "context.__enter__()\n"
        "print('open')\n"
    )
    run = python(code)
    assert (run.returncode, run.stdout) == (0, "open\n"), run.stderr


def test_a_missing_swi_prolog_is_one_line_that_says_what_to_install() -> None:
    code = (
        "import sys; sys.modules['pyswip'] = None\n"
        "from facetlog.kb.engine import Engine\n"
        "from facetlog.errors import EngineError\n"
        "try:\n"
        "    Engine()\n"
        "except EngineError as exc:\n"
        "    print(exc, exc.exit_code)\n"
    )
    run = python(code)
    assert "apt install swi-prolog-nox" in run.stdout, run.stderr
    assert run.stdout.endswith(" 3\n")
    assert run.stdout.count("\n") == 1


def test_the_schema_is_the_documented_one(engine: Engine) -> None:
    root = Path(__file__).parents[2]
    rows = (root / "docs" / "facts.md").read_text().splitlines()
    documented = {
        (name, args.count(",") + 1)
        for row in rows
        if row.startswith("|")
        for name, args in re.findall(r"`(\w+)\(([^)]*)\)`", row.split("|")[1])
    }
    schema = (root / "rules" / "schema.pl").read_text()
    declared = {(n, int(a)) for n, a in re.findall(r"^fact_schema\((\w+)/(\d+)", schema, re.M)}
    assert declared == documented


def test_term_text_refuses_what_is_no_variable() -> None:
    with pytest.raises(ValueError, match="no name of a Prolog variable"):
        term_text(Var("x), halt"))


def test_loaded_scene_keeps_its_name(engine: Engine) -> None:
    with engine.load_scene("kitchen", []) as scene:
        assert isinstance(scene, LoadedScene)
        assert scene.name == "kitchen"
