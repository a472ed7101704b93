"""Descriptions of models in rule files: lines, groups, what they are."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.errors import EngineError
from facetlog.kb.engine.terms import Atom
from facetlog.kb.explaining.verdict import Part, Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.limits import Limits
from facetlog.kb.loading.encode import Fact

HEAD = """:- module(m, []).
:- use_module(facetlog(vocabulary)).
"""
MODEL = """model({name}, "A model.", [a]).
candidate({name}, Thing, [A]) :- face_of(Thing, A).
condition({name}, large, "{reason}", _, [A], {test}).
"""
TEST = "at_least(fill(A), 0.5)"
FACTS: list[Fact] = [
    ("scene", "s"),
    ("scale", "metric"),
    ("up", 0.0, 0.0, 1.0),
    ("thing", "t1"),
    *(
        fact
        for name, fill in (("f1", 0.9), ("f2", 0.3), ("f3", 0.2))
        for fact in (
            ("face", name),
            ("part_of", name, "t1"),
            ("evidence", name, "measured"),
            ("fill", name, fill, 0.1),
            ("tilt", name, 100 * fill, 2.0),
        )
    ),
]


def model(name: str, *more: str, reason: str = "it is large", test: str = TEST) -> str:
    lines = "".join(f"{line}\n" for line in more)
    return MODEL.format(name=name, reason=reason, test=test) + lines


class Desk:
    """A knowledge base with one scene, and a file of rules that is written anew."""

    def __init__(self, base: KnowledgeBase, path: Path) -> None:
        self.base, self.path = base, path
        base.load_scene("s", FACTS)

    def verdict(self, *models: str, of: str = "m") -> Verdict:
        self.path.write_text(HEAD + "".join(models))
        self.base.load_rules(self.path, trusted=True)
        return self.base.judge("s", of, "t1")


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    with KnowledgeBase() as base:
        yield Desk(base, tmp_path_factory.mktemp("rules") / "m.pl")


def said(verdict: Verdict) -> str:
    return "\n".join(verdict.lines(full=True))


# ---- lines as they were written

WRITTEN = "written(m, large, 'slab.model:9', \"large: fill(a) at least 50 %\")."


def test_a_condition_shows_the_line_that_it_was_made_from(desk: Desk) -> None:
    verdict = desk.verdict(model("m", WRITTEN))
    (line,) = verdict.conditions
    assert (line.place, line.text) == ("slab.model:9", "large: fill(a) at least 50 %")
    where = "large: it is large (100%) [slab.model:9: large: fill(a) at least 50 %]"
    assert where in said(verdict)
    (data,) = verdict.to_json(full=True)["conditions"]
    assert (data["place"], data["text"]) == (line.place, line.text)
    (miss,) = desk.base.why_not("s", "m", count=1)
    assert "it is large – fill" in "\n".join(miss.iter_miss_lines())


# ---- groups

GROUP = """group(m, Thing, [A], others, Faces) :-
    findall(F, ( face_of(Thing, F), F \\== A ), Faces).
group(m, _, _, none, []).
group(m, _, [A], legs, [[A], [f9, unseen, A]]).
group(m, _, _, none, [f1])."""


def test_groups_are_further_parts(desk: Desk) -> None:
    verdict = desk.verdict(model("m", GROUP))
    assert verdict.parts == (
        Part("a", ("f1",)),
        Part("others", ("f2", "f3"), is_group=True),
        Part("none", (), is_group=True),
        Part("legs", ("f1", "f9"), is_group=True),
    )
    assert "parts: a = f1; others = f2, f3; none = none; legs = f1, f9" in said(verdict)
    assert verdict.to_json()["parts"]["others"] == ["f2", "f3"]
    rows = set(desk.base.query("plays(F, Role, t1, m)"))
    assert {(Atom("f2"), Atom("others")), (Atom("f1"), Atom("a"))} <= rows


@pytest.mark.parametrize("members", ["f1", "[f(1)]", "[1]", "[_]", "[f1|_]"])
def test_members_that_are_no_names_are_an_error(desk: Desk, members: str) -> None:
    with pytest.raises(EngineError):
        desk.verdict(model("m", f"group(m, _, _, odd, {members})."))


# ---- what a model is

KINDS = (
    model("chair"),
    model("seat", "specialises(seat, furniture).", test="at_least(fill(A), 0.3)"),
    model(
        "m", "specialises(m, seat).", "specialises(m, elsewhere).", test="at_least(fill(A), 0.8)"
    ),
    model("furniture", "specialises(furniture, m).", test="at_least(fill(A), 0.7)"),
)


def test_a_verdict_says_what_else_the_thing_is_by_that(desk: Desk) -> None:
    verdict = desk.verdict(*KINDS)
    assert verdict.specialises == ("seat", "elsewhere", "furniture")
    kinds = "t1 is a m, which is a seat, an elsewhere and a furniture"
    assert verdict.summary == f"{kinds} ({verdict.confidence.format(verdict.degree)})"
    assert verdict.degree == pytest.approx(0.84, abs=0.005)
    assert verdict.to_json()["specialises"] == ["seat", "elsewhere", "furniture"]
    assert desk.base.judge("s", "chair", "t1").specialises == ()


# ---- measures of one's own


def test_a_measure_that_never_ends_meets_the_limit(desk: Desk) -> None:
    endless = "measured(odd(_), V, 0, deg) :- between(1, inf, V), V < 0."
    desk.base.limits = Limits(inferences=1_000_000)
    try:
        with pytest.raises(EngineError, match="limit of inferences"):
            desk.verdict(model("m", endless, test="at_most(odd(A), 5)"))
    finally:
        desk.base.limits = Limits()
