"""Lines of the shell: goals, reasons, commands, files that change."""

import json
from collections.abc import Callable, Iterator

import pytest

from facetlog.errors import EngineError, FacetlogError, QueryError, RuleSyntaxError
from facetlog.kb.engine.terms import Term
from facetlog.query_shell.asking import Outcome
from facetlog.query_shell.commands import COMMANDS
from facetlog.query_shell.lines import execute, run_batch, run_line
from facetlog.query_shell.session import Session
from facetlog.query_shell.shell import Shell

from .scenes import write_block

Said = Callable[[], tuple[str, str]]


def answer(shell: Shell, said: Said, line: str) -> str:
    said()
    shell.screen.begin_line()
    execute(shell, line)
    return said()[0]


def test_answers_are_a_table_with_units(shell, said):
    assert answer(shell, said, "length(F, L, _), F @< f3.").splitlines() == [
        "F   L (cm)",
        "──  ──────",
        "f1   30.00",
        "f2   30.00",
    ]


def test_a_goal_without_variables_is_yes_or_no(shell, said):
    assert answer(shell, said, "face(f1)") == "yes\n"
    assert answer(shell, said, "face(f99)") == "no\n"
    assert answer(shell, said, "face(F), F == f99") == "no\n"
    assert execute(shell, "face(f1)") is Outcome.YES
    assert execute(shell, "face(f99)") is Outcome.NO


def test_long_answers_are_cut_and_counted(shell, said):
    shell.limit, shell.at_prompt = 2, True
    out = answer(shell, said, "between(1, 100, X)")
    assert out.splitlines()[-1] == "… 98 more (:all shows them)"
    assert len(answer(shell, said, ":all").splitlines()) == 102
    answer(shell, said, ":limit")
    assert len(answer(shell, said, "between(1, 100, X)").splitlines()) == 102


@pytest.mark.parametrize("as_json", [False, True])
def test_the_first_answers_of_an_endless_goal_do_not_wait_for_more(shell, said, *, as_json):
    # Beyond the third nothing is found, and the search never ends: it is given up early.
    shell.limit, shell.as_json = 3, as_json
    out = answer(shell, said, "between(1, inf, X), X < 4")
    if as_json:
        found = json.loads(out)
        assert (found["rows"], found["complete"]) == ([[1], [2], [3]], False)
    else:
        assert [line.strip() for line in out.splitlines()][2:5] == ["1", "2", "3"]


def test_answers_before_a_limit_is_reached_are_shown(scene, said):
    from facetlog.kb.limits import Limits
    from facetlog.query_shell.screen import Screen

    with Session(limits=Limits(inferences=1_000_000)) as session:
        session.load_scenes([scene])
        shell = Shell(session, Screen(), limit=None)
        goal = "between(1, inf, X), X =< 3000"
        with pytest.raises(EngineError, match="limit"):
            execute(shell, goal)
        shell.as_json = True
        assert said()[0].split()[2:4] == ["1", "2"]
        with pytest.raises(EngineError):
            execute(shell, goal)
        found = json.loads(said()[0])
        assert found["rows"][:2] == [[1], [2]]
        assert (found["count"], found["complete"]) == (len(found["rows"]), False)
        assert "limit" in found["error"]["message"]


def test_a_faulty_goal_is_underlined_with_a_suggestion(shell, said):
    assert run_line(shell, "face(A), angel(A, B, C, D)") is Outcome.FAULT
    lines = said()[1].splitlines()
    assert lines[0].strip() == "face(A), angel(A, B, C, D)"
    assert lines[1].index("^~~~~") == lines[0].index("angel")
    assert "angle" in lines[2]


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("why tabel", "did you mean table"),
        ("why", "needs a model"),
        ("why box a=f1 a=f2", "given twice"),
        ("why box a=f1 f2", "PART=FACE"),
        ("why box nose=f1", "nose"),
        (":fcts", "did you mean :facts"),
        (":facts f99", "f99"),
        (":use nowhere", "no scene 'nowhere'"),
        (":load /nowhere.json", "does not exist"),
        (":help agnle", "did you mean angle"),
        (":all", "nothing was asked"),
    ],
)
@pytest.mark.slow
def test_what_cannot_be_done_is_one_line_that_says_why(shell, said, line, says):
    assert run_line(shell, line) is Outcome.FAULT
    out, err = said()
    assert out == ""
    assert says in err


def test_facts_about_a_name_are_grouped_with_units_and_meaning(shell, said):
    lines = answer(shell, said, ":facts f1").splitlines()
    area = next(line for line in lines if line.startswith("area("))
    assert "m²" in area
    assert "area without holes" in area
    angle = next(i for i, line in enumerate(lines) if line.startswith("angle(F1"))
    assert lines[angle + 1].split() == ["F1", "F2", "Angle", "(°)", "Sd", "(°)"]
    assert {line.split()[0] for line in lines[angle + 3 : angle + 8]} == {"f1"}
    assert "… 2 more" in lines[angle + 11]


def test_each_command_is_explained(shell, said):
    guide = answer(shell, said, ":help")
    for name, command in COMMANDS.items():
        assert command.signature in guide
        assert answer(shell, said, f":help :{name}").startswith(command.signature)
    assert "Angle" in answer(shell, said, ":help angle")
    assert "a model" in answer(shell, said, ":help box")
    words = answer(shell, said, ":words adj").splitlines()
    assert words[:2] == ["fact:", next(w for w in words if w.startswith("  adjoins(F1, F2, E):"))]


def test_scenes_are_asked_together_or_some_of_them(shell, said, tmp_path):
    write_block(tmp_path / "second", name="second", metric=False)
    execute(shell, f":load {tmp_path / 'second'}")
    out = answer(shell, said, "length(f1, L, _)").splitlines()
    assert out[0].split("  ")[0] == "Scene"
    assert "L (m or units)" in out[0]
    assert [line.split()[0] for line in out[2:]] == ["block", "second"]
    assert "block:" in answer(shell, said, "why box")
    execute(shell, ":use second")
    assert answer(shell, said, "length(f1, L, _)").splitlines()[0].strip() == "L (units)"
    assert "* second" in answer(shell, said, ":scenes")
    execute(shell, ":use")
    assert answer(shell, said, "in(second, face(f1))") == "yes\n"


def test_a_model_that_has_changed_is_loaded_again_before_the_next_goal(shell, said, model):
    execute(shell, f":load {model}")
    good = model.read_text()
    model.write_text(
        good.replace("upward", "downward")
        .replace("face lid", "face base")
        .replace("up: lid", "up: base")
    )
    said()
    execute(shell, "why lid")
    out, err = said()
    assert "loaded again" in err
    assert "base = " in out
    execute(shell, "why lid")
    assert said()[1] == ":all shows all of it\n"


def test_of_a_faulty_new_version_the_old_one_stays_and_it_is_said_once(shell, said, model):
    execute(shell, f":load {model}")
    model.write_text(model.read_text().replace("upward", "upwards"))
    said()
    assert execute(shell, "why lid") is Outcome.YES
    assert "stays in force" in said()[1]
    assert execute(shell, "why lid") is Outcome.YES
    assert said()[1] == ":all shows all of it\n"
    model.unlink()
    execute(shell, "why lid")
    assert "cannot be read" in said()[1]


def test_reload_takes_scenes_as_they_are_now(shell, said, scene):
    write_block(scene, metric=False)
    assert execute(shell, ":reload") is Outcome.YES
    assert "(units)" in answer(shell, said, "length(f1, L, _)")
    (scene / "scene.json").write_text("{")
    assert run_line(shell, ":reload") is Outcome.FAULT
    assert "stays as it was" in said()[1]
    assert answer(shell, said, "face(f1)") == "yes\n"


def batch(shell: Shell, text: str) -> Outcome:
    return run_batch(shell, text.splitlines(keepends=True))


def test_a_batch_goes_on_after_a_fault_and_names_its_line(shell, said):
    assert batch(shell, "face(f1).\n% note\nangel(X)\nface(f99)\n") is Outcome.FAULT
    out, err = said()
    assert out == "yes\nno\n"
    assert "line 3: angel/1" in err


@pytest.mark.parametrize(
    ("text", "outcome"),
    [
        ("face(f99)\nface(f1)", Outcome.YES),
        ("face(f99)\nface(f98)", Outcome.NO),
        ("face(f1)\nX is 1/0\nface(f1)", Outcome.FAULT),
        (":quit\nangel(X)", Outcome.YES),
        ("", Outcome.YES),
    ],
)
def test_a_batch_ends_with_the_worst_or_with_whether_anything_was_found(shell, text, outcome):
    assert batch(shell, text) is outcome


def test_each_goal_of_a_batch_is_a_line_of_json(shell, said):
    shell.as_json, shell.limit = True, 2
    batch(shell, "angle(f1, B, Deg, Sd)\nangel(X)\nface(f1)\nwhy box\n:models\n:limit 1\nface(F)")
    out, err = said()
    lines = [json.loads(line) for line in out.splitlines()]
    assert [line["schema"] for line in lines] == [
        *["facetlog-answers/1"] * 3,
        "facetlog-why/2",
        *["facetlog-command/1"] * 2,
        "facetlog-answers/1",
    ]
    assert [line["line"] for line in lines] == [1, 2, 3, 4, 5, 6, 7]
    first, fault, yes, why, models, limit, last = lines
    assert first["names"] == ["B", "Deg", "Sd"]
    assert first["units"] == {"B": "face", "Deg": "deg", "Sd": "deg"}
    assert (first["count"], first["complete"]) == (2, False)
    assert fault["error"]["start"] == 0
    assert (yes["rows"], yes["complete"]) == ([[]], True)
    assert why["verdict"]["state"] == "holds"
    assert last["count"] == 1
    assert ["box", "built", "in"] in [line.split() for line in models["lines"]]
    assert (limit["goal"], limit["ok"]) == (":limit 1", True)
    assert "line 2: angel/1" in err


def test_each_fault_of_a_batch_is_one_line_of_json(shell, said):
    shell.as_json = True
    asked = [":fcts", ":all", "why f99", ":facts f99", "halt", "angel(X)", ":all", ":all x"]
    batch(shell, "\n".join(asked))
    lines = [json.loads(line) for line in said()[0].splitlines()]
    assert [line["line"] for line in lines] == [1, 2, 3, 4, 5, 6, 7, 8]
    assert [line["goal"] for line in lines] == [*asked[:6], "angel(X)", ":all x"]
    for line in lines:
        assert line["error"]["message"]
        assert 0 <= line["error"]["start"] < line["error"]["end"] <= len(line["goal"])


class Failing:
    """Answers that end with an error."""

    names = ("X",)

    def __init__(self, fault: FacetlogError) -> None:
        self._fault = fault
        self._rows = iter([(1,), (2,)])

    def __enter__(self) -> "Failing":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def __iter__(self) -> Iterator[tuple[Term, ...]]:
        return self

    def __next__(self) -> tuple[Term, ...]:
        row = next(self._rows, None)
        if row is None:
            raise self._fault
        return row


GOAL = "member(N, [1, 2, 0]), X is N/N"


@pytest.mark.parametrize("fault", [QueryError("no such number", text=GOAL), RuleSyntaxError("x")])
def test_a_fault_while_asking_comes_after_the_answers_before_it(fault, shell, said, monkeypatch):
    def query(*_: object, **__: object) -> Failing:
        return Failing(fault)

    monkeypatch.setattr(shell.session.base, "query", query)
    for line in (GOAL, ":all"):
        shell.screen.begin_line()
        assert run_line(shell, line) is Outcome.FAULT
        out, err = said()
        assert out.split() == ["X", "─", "1", "2"]
        underline = [f"  {GOAL}", "  ^" + "~" * (len(GOAL) - 1)]
        assert err.splitlines()[:-1] == (underline if isinstance(fault, QueryError) else [])
        assert err.splitlines()[-1] == f"error: {fault}"
    shell.as_json = True
    assert run_line(shell, GOAL) is Outcome.FAULT
    found = json.loads(said()[0])
    assert (found["rows"], found["complete"]) == ([[1], [2]], False)
    assert (found["error"]["start"], found["error"]["end"]) == (0, len(GOAL))
