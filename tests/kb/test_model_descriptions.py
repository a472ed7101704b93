"""What a rule file says of its models beside what is judged: lines, groups, what they are."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from facetlog.errors import EngineError
from facetlog.kb.engine.terms import Atom
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Part, Recognition, Verdict
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
    assert "it is large – fill" in "\n".join(miss.miss_lines())


def test_a_condition_without_a_reason_is_told_by_its_line(desk: Desk) -> None:
    fails = model("m", WRITTEN, reason="", test="at_least(fill(A), 0.95)")
    verdict = desk.verdict(fails)
    assert "fails: large: fill(a) at least 50 % – fill(f1)" in verdict.summary
    assert "large: large: fill(a) at least 50 % (31%) [slab.model:9]" in said(verdict)


def test_nothing_is_shown_of_lines_that_the_file_does_not_name(desk: Desk) -> None:
    verdict = desk.verdict(model("m", "written(m, other, 'x:1', \"other\")."))
    assert "[" not in said(verdict)
    known = {"label", "reason", "state", "degree", "because"}
    assert set(verdict.to_json()["conditions"][0]) == known


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


def test_an_empty_group_is_no_part_that_was_not_seen(desk: Desk) -> None:
    verdict = desk.verdict(model("m", GROUP, test="at_least(area(A), area(A))"))
    assert verdict.state is State.UNKNOWN
    assert "area(f1) is not known" in verdict.summary


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
    assert verdict.summary == f"{kinds} ({verdict.confidence:.0%})"
    assert verdict.degree == pytest.approx(0.84, abs=0.005)
    assert verdict.to_json()["specialises"] == ["seat", "elsewhere", "furniture"]
    assert desk.base.judge("s", "chair", "t1").specialises == ()


def verdicts_of(*rows: tuple[str, str, float, tuple[str, ...]]) -> list[str]:
    verdicts = tuple(
        Verdict(name, thing, State.HOLDS, degree, degree, (), (), (), specialises=general)
        for name, thing, degree, general in rows
    )
    return [f"{v.thing} {v.model}" for v in Recognition("s", verdicts).best]


def test_of_one_thing_the_special_comes_before_what_it_is() -> None:
    assert verdicts_of(
        ("table", "t1", 0.9, ()),
        ("desk", "t1", 0.6, ("table", "furniture")),
        ("furniture", "t1", 0.95, ()),
        ("box", "t1", 0.92, ()),
        ("desk", "t2", 0.7, ("table", "furniture")),
        ("table", "t2", 0.8, ("furniture",)),
    ) == ["t1 desk", "t1 furniture", "t1 box", "t1 table", "t2 desk", "t2 table"]


def test_models_that_are_each_other_are_listed_by_degree() -> None:
    rows = (("a", "t1", 0.6, ("b",)), ("b", "t1", 0.9, ("a",)))
    assert verdicts_of(*rows) == ["t1 b", "t1 a"]


# ---- measures of one's own

LEAN = """measured(lean(F), V, Sd, deg) :- measure(tilt(F), T, Sd, _), V is 90 - T.
measured(lean(_), 1.0, 0.0, deg).
measured(twice(F), V, 0, deg) :- measure(lean(F), L, _, deg), V is 2*L."""


@pytest.mark.parametrize(
    ("test", "state", "words"),
    [
        ("near(lean(A), 0, 3)", State.HOLDS, "lean(f1) = 0° ± 2°"),
        ("not(at_most(lean(A), 50))", State.HOLDS, "lean(f3) = 70° ± 2°"),
        ("at_most(lowest([lean(A), lean(f2)]), 5)", State.HOLDS, ""),
        ("all([at_least(fill(A), 0.5), at_most(twice(A), 1)])", State.HOLDS, "twice(f1) = 0°"),
        ("near(lean(unseen), 1, 0)", State.HOLDS, "lean(unseen) = 1°"),
    ],
)
def test_a_measure_of_the_files_own(desk: Desk, test: str, state: State, words: str) -> None:
    verdict = desk.verdict(model("m", LEAN, test=test))
    assert verdict.state is state
    assert words in said(verdict)


def test_a_measure_of_which_no_clause_answers_is_unknown(desk: Desk) -> None:
    verdict = desk.verdict(model("m", "measured(lean(f9), 1, 1, deg).", test="at_most(lean(A), 5)"))
    assert verdict.state is State.UNKNOWN
    assert "lean(f1) is not known" in verdict.summary


def test_own_measures_are_sorted(desk: Desk) -> None:
    order = (
        "size(m, Thing, _, Face, metres(1)) :- findall(lean(F), face_of(Thing, F), All),"
        " longest_first(All, [lean(Face)|_])."
    )
    verdict = desk.verdict(model("m", LEAN, order))
    assert [size.name for size in verdict.sizes] == ["f3"]


@pytest.mark.parametrize(
    "clause",
    [
        "measured(odd(_), V, 0, deg) :- V = big.",
        "measured(odd(_), 1, S, deg) :- S = -1.",
        "measured(odd(_), 1, 1, K) :- K = metre.",
        "measured(odd(_), V, 0, deg) :- V is inf.",
        "measured(odd(_), V, 0, deg) :- V is 10**400.",
    ],
)
def test_what_is_no_measure_is_an_error_when_it_is_asked(desk: Desk, clause: str) -> None:
    with pytest.raises(EngineError):
        desk.verdict(model("m", clause, test="at_most(odd(A), 5)"))


def test_a_measure_that_never_ends_meets_the_limit(desk: Desk) -> None:
    endless = "measured(odd(_), V, 0, deg) :- between(1, inf, V), V < 0."
    desk.base.limits = Limits(inferences=1_000_000)
    try:
        with pytest.raises(EngineError, match="limit of inferences"):
            desk.verdict(model("m", endless, test="at_most(odd(A), 5)"))
    finally:
        desk.base.limits = Limits()


def test_an_isolated_process_tells_the_same(desk: Desk, tmp_path: Path) -> None:
    models = (model("m", WRITTEN, GROUP, LEAN, test="near(lean(A), 0, 3)"), *KINDS[:2])
    general = "specialises(m, seat).\n"
    with KnowledgeBase(isolated=True) as base:
        other = Desk(base, tmp_path / "m.pl").verdict(*models, general)
    assert other.to_json() == desk.verdict(*models, general).to_json()
    assert other.specialises == ("seat", "furniture")


def test_helpers_of_the_same_names_are_no_fault(desk: Desk) -> None:
    helpers = "group(1).\nwritten(2).\nspecialises(3).\nmeasured(4)."
    assert desk.verdict(model("m", helpers)).state is State.HOLDS
