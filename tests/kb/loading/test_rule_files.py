"""What becomes of users' files of rules: faults and their places, warnings, trust, unloading."""

import gc
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import pytest

from facetlog.errors import EngineError, QueryError, RuleSyntaxError
from facetlog.kb.engine.engine import piece_text
from facetlog.kb.engine.engine_pool import engine_pool
from facetlog.kb.engine.terms import Atom, Term, decode_reply
from facetlog.kb.knowledge_base import BUILTIN_MODELS, KnowledgeBase
from facetlog.kb.loading.builtin_rules import builtin_rules
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


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("condition(slab, x, ", "6:19: syntax error: the text ends"),
        ("candidate(slab, T, [X]) :- face_off(T, X).", "6:28: face_off/2 is no word"),
        ("candidate(slab, T, [X]) :- face_off(T, X).", "did you mean face_of/2?"),
        (
            "candidate(slab, T, [X]) :- face_of(T, X, Y).",
            "6:28: face_of has 2 arguments, not 3: face_of(Thing, Face)",
        ),
        ("candidate(slab, T, [X]) :- angle(T, X, A, B).", "6:28: angle/4 is a fact: write fact("),
        ("candidate(slab, T, [X]) :- fact(angel(T, X, A, B)).", "6:33: angel/4 is no fact; did"),
        ("candidate(slab, T, [X]) :- fact(angle(T, X)).", "6:33: angle has 4 arguments, not 2"),
        ("candidate(slob, T, [X]) :- face_of(T, X).", "6:11: slob is no model of this file; did"),
        ("candidate(slab, T, [X, Y]) :- face_of(T, X).", "6:20: the parts of the model slab are"),
        ("candidate(slab, T, X) :- face_of(T, X).", None),
        ("candidate(slab, T, faces).", "6:20: the parts of a model stand in a list"),
        ('condition(slab, y, "", _, [A, B], upward(A)).', "6:27: the parts of the model slab are"),
        ('condition(slab, y, "", _, [B]).', "6:1: condition has 6 arguments, not 5"),
        ('condition(slab, "y", "", _, [B], upward(B)).', "6:17: a condition's label is a small"),
        ("condition(slab, y, because(B), _, [B], upward(B)).", "6:20: a condition's reason is a"),
        (
            'condition(slab, y, "", _, [B], at_most(tlit(B), 5)).',
            "6:40: tlit/1 is no measure of the vocabulary or of this file; did you mean tilt?",
        ),
        ('condition(slab, y, "", _, [B], all([levl(B)])).', "6:37: levl/1 is no test of the"),
        ('condition(slab, y, "", _, [B], all([levl(B)])).', "did you mean level?"),
        ('condition(slab, y, "", _, [B], all(upward(B))).', "6:36: a list of tests is wanted"),
        ('condition(slab, y, "", _, [B], angle(B)).', "6:32: angle/1 is no test"),
        (
            'condition(slab, y, "", _, [B], at_most(angle(B), 1)).',
            "6:40: the measure angle is angle/2, not angle/1",
        ),
        (
            'condition(slab, y, "", _, [B], at_most(tilt(B), tolerance(levl))).',
            "6:59: there is no tolerance levl; did you mean level?",
        ),
        ('condition(slab, y, "", _, [B], expect(2, upward(B))).', "6:39: the weight of expect"),
        ('condition(slab, y, "", _, [B], 3).', "6:32: this is no test"),
        ("size(slab, _, [B], length, lenght(B)).", "6:28: lenght/1 is no measure"),
        ('model(Name, "", [a]).', "6:7: a model's name is a small word"),
        ('model(other, "", [a]).', "6:1: the model other needs candidate/3"),
        ('model(slab, "", [a]).', "3:1: the model slab is defined twice"),
        ('model(third, "", []).', "6:18: a model names its parts"),
        ("tolerance(flat, steep).", "6:17: a tolerance is a number"),
        ("means(level(X), upward(X)).", None),
        ("means(upward(X), level(X)).", "6:7: upward/1 is a word of the vocabulary"),
        ("means(flat(X), at_most(tilt(X), 1)).", None),
        ("candidate(slab, T, [X]) :- fact(face(X)), fact(part_of(X, T)).", None),
        ("candidate(slab, T, [X]) :- foldl(longer, [T], [], [X]). longer(X, L, [X|L]).", None),
        ("candidate(slab, T, [X]) :- call(face_of(T), X), once(call(face_of(T, X))).", None),
        ("candidate(slab, T, [X]) :- aggregate_all(max(A, F), fact(area(F, A, _)), max(_, X)),"
         " face_of(T, X).", None),
        ("candidate(slab, T, [X]) :- ( face_of(T, X) -> true ; face_of(T, X) *-> true ).", None),
        ("candidate(slab, T, [X]) :- setof(F, S^( face_of(T, F), fact(tilt(F, 3, S)) ), [X|_]).",
         None),
        ("helper --> [].", "6:1: this is no rule"),
        (":- use_module(library(lists)).", None),
    ],
)  # fmt: skip
def test_a_fault_names_file_line_column_and_what(
    shelf: Shelf, line: str, message: str | None
) -> None:
    if message is None:
        shelf.load(GOOD + line + "\n")
    else:
        assert any(message in fault for fault in shelf.faults(GOOD + line + "\n"))


def test_all_faults_of_a_file_are_told_in_their_order(shelf: Shelf) -> None:
    text = GOOD + (
        "candidate(slab, T, [X]) :- face_off(T, X),\n    shel(X).\n"
        'condition(slob, y, "", _, [B], at_most(tlit(B), tolerance(flatt))).\n'
        "append(a, b, c).\n"
    )
    assert [fault.split(" ")[0:2] for fault in shelf.faults(text)] == [
        ["6:28:", "face_off/2"],
        ["7:5:", "shel/1"],
        ["8:11:", "slob"],
        ["8:40:", "tlit/1"],
        ["8:59:", "there"],
        ["9:1:", "append/3"],
    ]


def test_all_syntax_errors_of_a_file_are_told(shelf: Shelf) -> None:
    text = GOOD + "a(X,, Y).\nb(c) :- .\ne(f).\ng(h\n"
    assert [fault.split(":")[0] for fault in shelf.faults(text)] == ["6", "7", "9"]


def test_twenty_faults_are_enough(shelf: Shelf) -> None:
    faults = shelf.faults(GOOD + "helper(X) :- nothing(X).\n" * 30)
    assert len(faults) == 21
    assert faults[-1].endswith("and more of the kind")


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends_of_any_kind_are_read(shelf: Shelf, end: str) -> None:
    shelf.load(GOOD.replace("\n", end))


def test_a_line_is_counted_with_windows_line_ends(shelf: Shelf) -> None:
    (fault,) = shelf.faults((GOOD + "helper(X) :- nothing(X).\n").replace("\n", "\r\n"))
    assert fault.startswith("6:14: nothing/1")


def test_a_byte_order_mark_is_no_part_of_the_text(shelf: Shelf) -> None:
    shelf.load("\ufeff" + GOOD)
    (fault,) = shelf.faults("\ufeff" + GOOD + "helper(X) :- nothing(X).\n")
    assert fault.startswith("6:14: nothing/1")


def test_names_of_every_script_are_read(shelf: Shelf) -> None:
    shelf.load(GOOD + "höhe('Tür 😀', \"läuft\", 'a\\nb').\n")


def test_a_variable_that_stands_alone_is_a_warning(shelf: Shelf) -> None:
    warnings = shelf.load(GOOD + "candidate(slab, T, [X]) :- face_of(T, X), face_of(_, Y).\n")
    assert warnings == (
        f"{shelf.path}:6:1: the variable Y stands here only: write _Y if that is meant",
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("% nothing\n", "1:1: a model needs model/3"),
        ('model(m, "", [a]).\n', "1:1: the model m needs candidate/3"),
        ('model(m, "", [a]). candidate(m, _, [a]).\n', "1:1: the model m needs condition/6"),
    ],
)
def test_a_file_without_a_whole_model_says_what_is_missing(
    shelf: Shelf, text: str, message: str
) -> None:
    assert shelf.faults(text)[0].startswith(message)


def test_a_file_that_cannot_be_read_is_named(base: KnowledgeBase, tmp_path: Path) -> None:
    with pytest.raises(RuleSyntaxError, match=r"gone\.pl: there is no such file"):
        base.load_rules(tmp_path / "gone.pl")
    with pytest.raises(RuleSyntaxError, match=r"cannot be read|may not be read"):
        base.load_rules(tmp_path)


def test_the_built_in_models_pass_the_check_of_users_files(base: KnowledgeBase) -> None:
    for name in BUILTIN_MODELS:
        rules = base.load_rules(builtin_rules() / f"{name}.pl")
        base.unload_rules(rules)
        assert rules.models == (name,)
        assert rules.warnings == ()


@pytest.mark.parametrize("model", BUILTIN_MODELS)
def test_a_checked_model_says_what_the_built_in_one_does(base: KnowledgeBase, model: str) -> None:
    expected = base.judge("s", model, "t1").to_json()
    rules = base.load_rules(builtin_rules() / f"{model}.pl")
    found = base.judge("s", model, "t1").to_json()
    base.unload_rules(rules)
    assert found == expected


def test_the_model_of_the_documentation_loads(shelf: Shelf) -> None:
    text = (Path(__file__).parents[3] / "docs" / "models.md").read_text()
    blocks = [block.split("```")[0] for block in text.split("```prolog")[1:]]
    (slab,) = (block.split("\n", 1)[1] for block in blocks if ":- module(slab" in block)
    assert shelf.load(slab) == ()


def test_the_last_model_of_a_name_counts_until_it_goes(base: KnowledgeBase, tmp_path: Path) -> None:
    answer = base.judge("s", "box", "t1").parts
    path = tmp_path / "mine.pl"
    path.write_text(GOOD.replace("slab", "box"))
    rules = base.load_rules(path)
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
    assert rules.trusted
    assert rules.models == ("slab",)
    assert list(shelf.base.query("is_a(T, slab)")) == [(Atom("t1"),)]
    shelf.base.unload_rules(rules)
    with pytest.raises(QueryError, match="slab"):
        list(shelf.base.query("is_a(T, slab)"))


def test_the_same_file_is_refused_without_trust(shelf: Shelf) -> None:
    assert [fault.split(":")[0] for fault in shelf.faults(TRUSTED)] == ["4", "5", "6", "9", "9"]


def test_unloading_takes_away_what_a_trusted_file_put_elsewhere(shelf: Shelf) -> None:
    probe = TRUSTED.replace("G = face_of", "findall(X, user:told(X), L), length(L, 1), G = face_of")
    for _ in range(3):
        shelf.path.write_text(probe)
        rules = shelf.base.load_rules(shelf.path, trusted=True)
        assert list(shelf.base.query("is_a(T, slab)")) == [(Atom("t1"),)]
        shelf.base.unload_rules(rules)


@pytest.mark.parametrize("text", [GOOD, TRUSTED, GOOD + "helper :- shell(x).\n"])
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
