"""Users' files of rules: faults and their places, warnings, trust, replacement."""

import gc
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import pytest

from facetlog.errors import EngineError, RuleSyntaxError
from facetlog.kb.engine.engine import house
from facetlog.kb.engine.terms import Atom, Term
from facetlog.kb.engine.transport import ask
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.loaded import RuleFile
from tests.kb.hostile_cases import FACTS, GOOD


class Shelf(NamedTuple):
    """A knowledge base and a place for files."""

    base: KnowledgeBase
    path: Path

    def load(self, text: str, *, trusted: bool = True) -> RuleFile:
        """Return the file with this text, loaded."""
        self.path.write_text(text, encoding="utf-8", newline="")
        return self.base.load_rules(self.path, trusted=trusted)

    def faults(self, text: str, *, trusted: bool = True) -> list[str]:
        """Return faults of the text, each without the file's name."""
        before = dict(self.base.models)
        with pytest.raises(RuleSyntaxError) as caught:
            self.load(text, trusted=trusted)
        assert dict(self.base.models) == before
        lines = str(caught.value).split("\n")
        assert all(line.startswith(f"{self.path}:") for line in lines), lines
        return [line.removeprefix(f"{self.path}:") for line in lines]


@pytest.fixture
def base() -> Iterator[KnowledgeBase]:
    with KnowledgeBase() as base:
        base.load_scene("s", FACTS)
        yield base


@pytest.fixture
def shelf(base: KnowledgeBase, tmp_path: Path) -> Shelf:
    return Shelf(base, tmp_path / "slab.pl")


def test_prolog_must_be_trusted(shelf: Shelf) -> None:
    (fault,) = shelf.faults(GOOD, trusted=False)
    assert fault.startswith(" rules in Prolog are a program")
    assert "--trust" in fault
    assert "trust=True" in fault
    assert shelf.load(GOOD).warnings == ()


def test_line_ends_of_windows_are_read(shelf: Shelf) -> None:
    assert shelf.load(GOOD.replace("\n", "\r\n")).models == ("slab",)


def test_a_file_that_cannot_be_read_is_named(base: KnowledgeBase, tmp_path: Path) -> None:
    with pytest.raises(RuleSyntaxError, match=r"gone\.pl: there is no such file"):
        base.load_rules(tmp_path / "gone.pl")
    with pytest.raises(RuleSyntaxError, match=r"cannot be read|may not be read"):
        base.load_rules(tmp_path)


@pytest.mark.parametrize("model", ["box", "table", "stairs"])
def test_a_users_copy_says_what_the_built_in_model_does(base: KnowledgeBase, model: str) -> None:
    expected = base.judge("s", model, "t1").to_json()
    base.load_rules(house("rules") / f"{model}.model")
    found = base.judge("s", model, "t1").to_json()
    assert {**found, "confidence": None} == {**expected, "confidence": None}


def test_the_model_of_the_documentation_loads(shelf: Shelf) -> None:
    text = (Path(__file__).parents[3] / "docs" / "model-reference.md").read_text()
    blocks = [block.split("```")[0] for block in text.split("```prolog")[1:]]
    (slab,) = (block.split("\n", 1)[1] for block in blocks if ":- module(slab" in block)
    assert shelf.load(slab).warnings == ()


def test_a_users_model_counts_and_is_replaced_by_its_next_version(shelf: Shelf) -> None:
    shelf.load(GOOD.replace("slab", "box"))
    assert [p.role for p in shelf.base.judge("s", "box", "t1").parts] == ["board"]
    assert list(shelf.base.query("is_a(t1, box)")) == [()]
    shelf.load(GOOD)
    assert [p.role for p in shelf.base.judge("s", "box", "t1").parts] == ["a", "b", "c"]
    assert list(shelf.base.query("is_a(t1, box)")) == []


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
    assert shelf.load(TRUSTED).models == ("slab",)
    assert list(shelf.base.query("is_a(T, slab)")) == [(Atom("t1"),)]


def test_what_a_trusted_file_put_elsewhere_goes_with_it(shelf: Shelf) -> None:
    probe = TRUSTED.replace("G = face_of", "findall(X, user:told(X), L), length(L, 1), G = face_of")
    for _ in range(3):
        shelf.load(probe)
        assert list(shelf.base.query("is_a(T, slab)")) == [(Atom("t1"),)]


@pytest.mark.parametrize("text", [GOOD, TRUSTED])
@pytest.mark.parametrize("trusted", [True, False])
def test_files_that_come_and_go_leave_no_module_behind(
    shelf: Shelf, text: str, trusted: bool
) -> None:
    def modules_after() -> Term:
        for _ in range(10):
            with suppress(RuleSyntaxError):
                shelf.load(text, trusted=trusted)
        counts = ask("statistics", "")
        assert isinstance(counts, tuple)
        return counts[0]

    assert modules_after() == modules_after()


def test_two_bases_may_trust_one_file(shelf: Shelf) -> None:
    shelf.load(TRUSTED)
    with KnowledgeBase() as other:
        other.load_scene("s", FACTS)
        other.load_rules(shelf.path, trusted=True)
        assert list(other.query("is_a(T, slab)")) == [(Atom("t1"),)]
    gc.collect()
    assert list(shelf.base.query("is_a(T, slab)")) == [(Atom("t1"),)]


def test_a_trusted_file_finds_what_lies_beside_it(shelf: Shelf) -> None:
    (shelf.path.parent / "helper.pl").write_text(":- module(helper, [helps/1]).\nhelps(yes).\n")
    line = ":- use_module(helper).\n:- helps(yes) -> true ; throw(no_help).\n"
    shelf.load(TRUSTED.replace(":- dynamic", line + ":- dynamic"))


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
    found = shelf.faults(TRUSTED.replace(old, new))
    assert [f for f, start in zip(found, faults, strict=False) if f.startswith(start)] == found


def test_warnings_of_a_trusted_file_name_its_line(shelf: Shelf) -> None:
    (warning,) = shelf.load(TRUSTED.replace("call(G)", "call(G), X = 1")).warnings
    assert warning.startswith(f"{shelf.path}:8: ")
    assert "Singleton variables: [X]" in warning


def test_the_limits_of_a_question_hold_for_a_trusted_model(shelf: Shelf) -> None:
    shelf.load(TRUSTED.replace("call(G)", "call(G), repeat, fail"))
    shelf.base.limits = type(shelf.base.limits)(seconds=0.3, inferences=10**12)
    with pytest.raises(EngineError, match="time limit"):
        shelf.base.judge("s", "slab", "t1")


# --- files in the model language ---

HOSTILE = r"""model slab
  "A board.')). :- shell(touch). % \"

  face board

  flat: board is level  "it is \'. :- initialization(halt). '\"
"""


def test_no_text_of_a_model_becomes_a_goal(base: KnowledgeBase, tmp_path: Path) -> None:
    path = tmp_path / "a\n:- halt.\n%b'.model"
    path.write_text(HOSTILE)
    base.load_rules(path)
    base.judge("s", "slab", "t1")
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_a_number_of_many_digits_is_refused_or_read_at_once(
    base: KnowledgeBase, tmp_path: Path
) -> None:
    path = tmp_path / "many.model"
    digits = "9" * 300_000
    path.write_text(f"model many\n  face a\n\n  c: count(a) at most {digits}\n")
    with suppress(RuleSyntaxError):
        base.load_rules(path)
