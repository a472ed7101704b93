"""What becomes of users' files of rules: faults and their places, warnings, trust, unloading."""

import gc
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import pytest

from facetlog.errors import EngineError, QueryError, RuleSyntaxError
from facetlog.kb.engine.door import ask
from facetlog.kb.engine.engine import house, piece_text
from facetlog.kb.engine.engine_pool import engine_pool
from facetlog.kb.engine.terms import Atom, Struct, Term, decode_reply, term_text
from facetlog.kb.knowledge_base import BUILTIN_MODELS, KnowledgeBase
from tests.kb.hostile_cases import FACTS, GOOD


class Shelf(NamedTuple):
    """A knowledge base and a place for files."""

    base: KnowledgeBase
    path: Path

    def load(self, text: str, *, trusted: bool = False) -> tuple[str, ...]:
        """The warnings of a file that loads, and is unloaded again."""
        self.path.write_text(text, encoding="utf-8", newline="")
        rules = self.base.load_rules(self.path, trusted=trusted)
        self.base.unload_rules(rules)
        assert rules.models == ("slab",)
        return rules.warnings

    def faults(self, text: str, *, trusted: bool = False) -> list[str]:
        """What is wrong with the text, each without the file's name."""
        with pytest.raises(RuleSyntaxError) as caught:
            self.load(text, trusted=trusted)
        lines = str(caught.value).split("\n")
        assert all(line.startswith(f"{self.path}:") for line in lines), lines
        return [line.removeprefix(f"{self.path}:") for line in lines]


@pytest.fixture(scope="module")
def base() -> Iterator[KnowledgeBase]:
    with KnowledgeBase() as base:
        base.load_scene("s", FACTS)
        yield base


@pytest.fixture
def shelf(base: KnowledgeBase, tmp_path: Path) -> Iterator[Shelf]:
    before = dict(base.models)
    yield Shelf(base, tmp_path / "slab.pl")
    assert dict(base.models) == before


def test_prolog_must_be_trusted(shelf: Shelf) -> None:
    (fault,) = shelf.faults(GOOD)
    assert fault.startswith(" rules in Prolog are a program")
    assert "--trust" in fault
    assert "trust=True" in fault
    assert shelf.load(GOOD, trusted=True) == ()


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_line_ends_of_both_kinds_are_read(shelf: Shelf, end: str) -> None:
    shelf.load(GOOD.replace("\n", end), trusted=True)


def test_a_file_that_cannot_be_read_is_named(base: KnowledgeBase, tmp_path: Path) -> None:
    with pytest.raises(RuleSyntaxError, match=r"gone\.pl: there is no such file"):
        base.load_rules(tmp_path / "gone.pl")
    with pytest.raises(RuleSyntaxError, match=r"cannot be read|may not be read"):
        base.load_rules(tmp_path)


@pytest.mark.parametrize("model", BUILTIN_MODELS)
def test_a_users_copy_says_what_the_built_in_model_does(base: KnowledgeBase, model: str) -> None:
    expected = base.judge("s", model, "t1").to_json()
    rules = base.load_rules(house("rules") / f"{model}.model")
    found = base.judge("s", model, "t1").to_json()
    base.unload_rules(rules)
    assert {**found, "confidence": None} == {**expected, "confidence": None}


def test_the_model_of_the_documentation_loads(shelf: Shelf) -> None:
    text = (Path(__file__).parents[3] / "docs" / "model-reference.md").read_text()
    blocks = [block.split("```")[0] for block in text.split("```prolog")[1:]]
    (slab,) = (block.split("\n", 1)[1] for block in blocks if ":- module(slab" in block)
    assert shelf.load(slab, trusted=True) == ()


def test_the_last_model_of_a_name_counts_until_it_goes(base: KnowledgeBase, tmp_path: Path) -> None:
    answer = base.judge("s", "box", "t1").parts
    path = tmp_path / "mine.pl"
    path.write_text(GOOD.replace("slab", "box"))
    rules = base.load_rules(path, trusted=True)
    assert [p.role for p in base.judge("s", "box", "t1").parts] == ["board"]
    assert list(base.query("is_a(t1, box)")) == [()]
    base.unload_rules(rules)
    assert base.judge("s", "box", "t1").parts == answer
    assert list(base.query("is_a(t1, box)")) == []


# --- files that the user trusts ---

TRUSTED = """:- module(box, []).
:- use_module(facetlog(vocabulary)).
:- use_module(library(lists)).
:- dynamic seen/1.
:- multifile user:told/1.
user:told(slab).
model(slab, "A level board.", [board]).
candidate(slab, Thing, [Board]) :-
    G = face_of(Thing, Board), call(G), assertz(seen(Board)).
condition(slab, flat, "it lies level", _, [Board], at_most(tilt(Board), 5)).
"""


def test_a_trusted_file_is_ordinary_prolog(shelf: Shelf) -> None:
    shelf.path.write_text(TRUSTED)
    rules = shelf.base.load_rules(shelf.path, trusted=True)
    assert rules.models == ("slab",)
    assert list(shelf.base.query("is_a(T, slab)")) == [(Atom("t1"),)]
    shelf.base.unload_rules(rules)
    with pytest.raises(QueryError, match="slab"):
        list(shelf.base.query("is_a(T, slab)"))


def test_unloading_takes_away_what_a_trusted_file_put_elsewhere(shelf: Shelf) -> None:
    probe = TRUSTED.replace("G = face_of", "findall(X, user:told(X), L), length(L, 1), G = face_of")
    for _ in range(3):
        shelf.path.write_text(probe)
        rules = shelf.base.load_rules(shelf.path, trusted=True)
        assert list(shelf.base.query("is_a(T, slab)")) == [(Atom("t1"),)]
        shelf.base.unload_rules(rules)


@pytest.mark.parametrize("text", [GOOD, TRUSTED])
@pytest.mark.parametrize("trusted", [True, False])
def test_files_that_come_and_go_leave_no_module_behind(
    shelf: Shelf, text: str, trusted: bool
) -> None:
    def modules_after() -> Term:
        for _ in range(10):
            with suppress(RuleSyntaxError):
                shelf.load(text, trusted=trusted)
        (reply,) = engine_pool().reply("statistics", "", seconds=9.0)
        counts = decode_reply(piece_text(reply))
        assert isinstance(counts, tuple)
        return counts[0]

    assert modules_after() == modules_after()


def test_two_bases_may_trust_one_file(shelf: Shelf) -> None:
    shelf.path.write_text(TRUSTED)
    mine = shelf.base.load_rules(shelf.path, trusted=True)
    with KnowledgeBase() as other:
        other.load_scene("s", FACTS)
        other.load_rules(shelf.path, trusted=True)
        assert list(other.query("is_a(T, slab)")) == [(Atom("t1"),)]
    gc.collect()
    assert list(shelf.base.query("is_a(T, slab)")) == [(Atom("t1"),)]
    shelf.base.unload_rules(mine)


def test_a_trusted_file_finds_what_lies_beside_it(shelf: Shelf) -> None:
    (shelf.path.parent / "helper.pl").write_text(":- module(helper, [helps/1]).\nhelps(yes).\n")
    line = ":- use_module(helper).\n:- helps(yes) -> true ; throw(no_help).\n"
    shelf.load(TRUSTED.replace(":- dynamic", line + ":- dynamic"), trusted=True)


@pytest.mark.parametrize(
    ("old", "new", "faults"),
    [
        ("G = face_of", "G = = face_of", ["9: Syntax error"]),
        ("user:told(slab).", ":- use_module(library(nowhere)).", ["6: "]),
        ("user:told(slab).", ":- throw(oops).", ["6: it throws oops"]),
        ("condition(slab", "kondition(slab", [" a model needs condition/6"]),
        ("model(slab", "modell(slab", [" a model needs model/3"]),
    ],
)
def test_faults_of_a_trusted_file_name_its_line(
    shelf: Shelf, old: str, new: str, faults: list[str]
) -> None:
    found = shelf.faults(TRUSTED.replace(old, new), trusted=True)
    assert [f for f, start in zip(found, faults, strict=False) if f.startswith(start)] == found


def test_warnings_of_a_trusted_file_name_its_line(shelf: Shelf) -> None:
    (warning,) = shelf.load(TRUSTED.replace("call(G)", "call(G), X = 1"), trusted=True)
    assert warning.startswith(f"{shelf.path}:8: ")
    assert "Singleton variables: [X]" in warning


def test_a_trusted_file_that_never_ends_loading_is_no_matter_of_the_check(shelf: Shelf) -> None:
    # The limits of a question hold for what a trusted model asks, too.
    shelf.path.write_text(TRUSTED.replace("call(G)", "call(G), repeat, fail"))
    rules = shelf.base.load_rules(shelf.path, trusted=True)
    limits = shelf.base.limits
    try:
        shelf.base.limits = type(limits)(seconds=0.3, inferences=10**12)
        with pytest.raises(EngineError, match="time limit"):
            shelf.base.judge("s", "slab", "t1")
    finally:
        shelf.base.limits = limits
        shelf.base.unload_rules(rules)


# --- files in the model language ---

HOSTILE = r"""model slab
  "A board.')). :- shell(touch). % \"

  face board

  flat: board is level  "it is \'. :- initialization(halt). '\"
"""


def test_no_text_of_a_model_becomes_a_goal(base: KnowledgeBase, tmp_path: Path) -> None:
    path = tmp_path / "a\n:- halt.\n%b'.model"
    path.write_text(HOSTILE)
    rules = base.load_rules(path)
    base.judge("s", "slab", "t1")
    base.unload_rules(rules)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize(
    "clause",
    [
        "candidate(m, T, [F]) :- face_of(T, F), shell(ls)",
        "candidate(m, T, [F]) :- findall(F, \\+ (face_of(T, F) ; halt), [F])",
        "candidate(m, T, [F]) :- maplist(assertz, [F])",
        "candidate(m, T, [F]) :- call(T, F)",
        "candidate(m, T, [F]) :- user:face_of(T, F)",
        "candidate(m, _, [F]) :- F",
        "user:candidate(m, _, [_])",
        "user:candidate(m, _, [_]) :- true",
    ],
)
def test_compiled_clauses_call_harmless_words_alone(base: KnowledgeBase, clause: str) -> None:
    """Clauses that a faulty compiler could write."""
    text = f'model(m, "", [a]).\n{clause}.\ncondition(m, c, "", _, [_], all([])).\n'
    request = term_text(Struct("rules", (Atom("never"), Atom("m.model"), text)))
    with pytest.raises(RuleSyntaxError, match="calls what it may not"):
        ask(engine_pool(), "load_compiled", request)


def test_a_number_of_many_digits_is_refused_or_read_at_once(
    base: KnowledgeBase, tmp_path: Path
) -> None:
    path = tmp_path / "many.model"
    digits = "9" * 300_000
    path.write_text(f"model many\n  face a\n\n  c: count(a) at most {digits}\n")
    with suppress(RuleSyntaxError):
        base.load_rules(path)
