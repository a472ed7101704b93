"""What becomes of users' files of rules that cannot be used."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.errors import RuleSyntaxError
from facetlog.kb.engine import Engine

GOOD = """:- module(slab, []).
:- use_module(facetlog(vocabulary)).
model(slab, "A level board.", [board]).
candidate(slab, Thing, [Board]) :- face_of(Thing, Board).
condition(slab, flat, "it lies level", _, [Board], at_most(tilt(Board), 5)).
"""


@pytest.fixture
def engine() -> Iterator[Engine]:
    engine = Engine()
    before = engine.rules
    yield engine
    assert engine.rules == before


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("condition(slab, x, ", "6: syntax error"),
        ("candidate(slab, T, [X]) :- shell(X, T).", "6: shell/2 is not a word"),
        ("candidate(slab, T, [X]) :- user:face_of(T, X).", "6: (:)/2 is not a word"),
        ("candidate(slab, T, [X]) :- G = face_of(T, X), call(G).", "6: call/1 is not a word"),
        ("candidate(slab, T, [X]) :- findall(Y, Y, [T|X]).", "6: a variable stands where a goal"),
        ("candidate(slab, T, [X]) :- maplist(shell, [T], [X]).", "6: shell/2 is not a word"),
        ("candidate(slab, T, [X]) :- assertz(face_of(T, X)).", "6: assertz/1 is not a word"),
        ("candidate(slab, T, [X]) :- fact(face(X)), fact(part_of(X, T)).", None),
        ("candidate(slab, T, [X]) :- fact(T), X = T.", "6: fact/1 is not a word"),
        ("candidate(slab, T, [X]) :- fact(shell(X)), T = t.", "6: fact/1 is not a word"),
        (":- initialization(halt).", "6: the directive initialization halt is refused"),
        (":- use_module(library(process)).", "6: the directive"),
        ("face_of(a, b).", "6: face_of/2 is a word of the vocabulary"),
        ("append(a, b, c).", "6: append/3 is Prolog's own"),
        ("atom(x).", "6: atom/1 is Prolog's own"),
        ("'this is' --> grammar.", "6: this is no rule"),
        ("user:term_expansion(a, b).", "6: this is no rule"),
        (
            'condition(slab, y, "", _, [B], at_most(tlit(B), 5)).',
            "6: tlit/1 is no word of the vocabulary or of this file; did you mean tilt?",
        ),
        ('condition(slab, y, "", _, [B], all([levl(B)])).', "did you mean level?"),
        ("means(flat(X), at_most(tilt(X), 1)).", None),
    ],
)
def test_faults_name_file_line_and_what(
    engine: Engine, tmp_path: Path, line: str, message: str | None
) -> None:
    path = tmp_path / "slab.pl"
    path.write_text(GOOD + line + "\n")
    if message is None:
        engine.unload_rules(engine.load_rules(path))
        return
    with pytest.raises(RuleSyntaxError) as caught:
        engine.load_rules(path)
    text = str(caught.value)
    assert text.startswith(f"{path}:")
    assert message in text
    assert "\n" not in text


def test_a_file_without_a_model_says_what_is_missing(engine: Engine, tmp_path: Path) -> None:
    path = tmp_path / "empty.pl"
    path.write_text("% nothing\n")
    with pytest.raises(RuleSyntaxError, match=r"empty\.pl: a model needs model/3"):
        engine.load_rules(path)


def test_a_file_that_is_not_there_is_named(engine: Engine, tmp_path: Path) -> None:
    with pytest.raises(RuleSyntaxError, match=r"gone\.pl: there is no such file"):
        engine.load_rules(tmp_path / "gone.pl")


def test_the_built_in_models_pass_the_check_of_users_files(tmp_path: Path) -> None:
    engine = Engine()
    for builtin in engine.rules:
        engine.unload_rules(engine.load_rules(builtin.path))


def test_the_model_of_the_documentation_loads(engine: Engine, tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "docs" / "models.md").read_text()
    path = tmp_path / "slab.pl"
    path.write_text(text.split("```prolog\n")[1].split("```")[0])
    loaded = engine.load_rules(path)
    engine.unload_rules(loaded)
    assert loaded.models == ("slab",)
