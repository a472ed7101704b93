"""Brief verdicts: those of the full judge to the last digit, on one scene after the other."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from facetlog.errors import EngineError
from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.brief_verdict import BriefVerdict
from facetlog.kb.engine.engine import house
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.knowledge_base import BUILTIN_MODELS, KnowledgeBase
from facetlog.kb.limits import Limits
from facetlog.kb.loading.encode import Fact
from facetlog.kb.loading.model_code import JUDGING_CODE
from facetlog.kb.recognize import judge_scene, open_knowledge_base
from facetlog.perception.facts.all_facts import LEVEL_KINDS, scene_facts
from facetlog.perception.facts.fact_schema import FACT_SCHEMA
from facetlog.perception.surfaces.exact_solids.builders import build

# Measures of a file's own, and what another model says, are left to the interpreter.
OWN = """:- module(m, []).
:- use_module(facetlog(vocabulary)).
tolerance(enough, 0.4).
means(full(F), at_least(fill(F), tolerance(enough))).
measured(twice(F), V, Sd, ratio) :- measure(fill(F), V0, Sd0, _), V is 2*V0, Sd is 2*Sd0.
model(own, "Words and measures of its own.", [a]).
candidate(own, Thing, [F]) :- face_of(Thing, F).
condition(own, word, "it is full", _, [F], full(F)).
condition(own, measure, "it is full", _, [F], at_least(twice(F), 1.0)).
condition(own, several, "one of many", Thing, [_], at_least(fill(F), 0.5)) :- face_of(Thing, F).
size(own, _, [F], long, length(F)).
group(own, Thing, _, others, Fs) :- findall(F, face_of(Thing, F), Fs).
model(asking, "What another model says.", [a]).
candidate(asking, Thing, [F]) :- face_of(Thing, F).
condition(asking, other, "it is a box", Thing, [_], is_a(Thing, box)).
"""
FACTS: tuple[Fact, ...] = (
    ("thing", "t1"),
    ("face", "f1"),
    ("face", "f2"),
    ("evidence", "f1", "measured"),
    ("evidence", "f2", "measured"),
    ("part_of", "f1", "t1"),
    ("part_of", "f2", "t1"),
    ("fill", "f1", 0.55, 0.04),
    ("angle", "f1", "f2", 90.5, 1.0),
    ("angle", "f2", "f1", 90.5, 1.0),
)
NO_DEGREE = 0.001  # least_degree/1 of specialise.pl
DEVIATIONS = {
    kind.functor: [i for i, argument in enumerate(kind.arguments, 1) if argument.name == "Sd"]
    for kind in FACT_SCHEMA
}
NEEDS_UP = frozenset(
    (
        "up",
        "tilt",
        "upward",
        "downward",
        "elevation",
        "top_of",
        "bottom_of",
        "clear_below",
        "overlap",
    )
)


# What quantifiers go through depends on no part, on one, on all, on what a goal finds out of them.
QUANTIFIED = """:- module(q, []).
:- use_module(facetlog(vocabulary)).
means(big(F), at_least(fill(F), 0.6)).
means(beside(F, G), any([adjoins(F, G), at_most(angle(F, G), 45)])).
candidate(_, Thing, [A, B]) :- face_of(Thing, A), face_of(Thing, B), A @< B.
members(T, A, B, Fs) :-
    findall(F, ( face_of(T, F), \\+ memberchk(F, [A, B]), possible(beside(F, A)) ), Found),
    sort(Found, Fs).
"""
CONDITIONS = (
    "each(F, Fs, all([big(F), at_most(angle(F, A), 60), near(angle(F, B), 90, 10)]))",
    "each(F, Fs, implies(at_least(area(F), area(A)), adjoins(F, B)))",
    "some(F, Fs, all([big(F), adjoins(F, A), at_least(offset(F, B), 0.1*length(B))]))",
    "not(some(F, Fs, any([opposite(F, A), opposite(F, B)])))",
    "any([at_least_of(4, F, Gs, big(F)), some(F, Fs, whole(T))])",
    "at_least_in(4, whole(T), F, Gs, big(F))",
    "any([whole(T), each_pair(F, G, Fs, any([adjoins(F, G), at_least(angle(F, G), 120)]))])",
    "implies(whole(T), each(F, Fs, at_least(share(F), 0.9)))",
    "expect(0.3, at_most_of(2, F, Gs, at_least(fill(F), 0.9)))",
    "if_known(each_pair(F, G, Fs, implies(all([big(F), big(G)]), at_most(angle(F, G), 100))))",
)
BODIES = (
    "members(T, A, B, Fs), separate(Fs, Gs)",
    "findall(F, ( face_of(T, F), \\+ memberchk(F, [A, B]) ), Found), sort(Found, Fs), Gs = [Fs]",
    "findall(F, ( face_of(T, F), \\+ memberchk(F, [A, B]), possible(any([all([opposite(F, A), "
    "at_least(area(F), area(B))]), adjoins(F, B)])) ), Found), sort(Found, Fs), separate(Fs, Gs)",
    "exclude(==(unseen), [A, B], Ps), findall(F, ( face_of(T, F), \\+ memberchk(F, [A, B]), "
    "possible(some(P, Ps, adjoins(F, P))) ), Found), sort(Found, Fs), Gs = [Fs, Ps]",
)


@pytest.fixture(scope="module")
def judge() -> Iterator[BatchJudge]:
    with BatchJudge() as judge:
        yield judge


def facts_of(name: str, **sizes: float) -> list[Fact]:
    return [f.row for f in scene_facts(build(name, sizes))]


def noisy(facts: Iterable[Fact], seed: int, by: float = 30.0) -> list[Fact]:
    """Return facts measured worse: deviations so many times as large, values moved by them."""
    generator = np.random.default_rng(seed)
    found = []
    for fact in facts:
        values: list[Any] = list(fact)
        for place in DEVIATIONS[str(fact[0])]:
            values[place] *= by
            values[place - 1] += values[place] * generator.normal()
        found.append(tuple(values))
    return found


def without_up(facts: Iterable[Fact]) -> list[Fact]:
    return [fact for fact in facts if fact[0] not in NEEDS_UP]


def in_brief(verdict: Verdict) -> BriefVerdict:
    return BriefVerdict(
        verdict.model,
        verdict.thing,
        verdict.state,
        verdict.degree,
        verdict.degree_at_most,
        verdict.confidence,
        tuple((part.role, part.faces) for part in verdict.parts),
        tuple((size.name, size.value, size.sd) for size in verdict.sizes),
        specialises=verdict.specialises,
    )


def assert_as_in_full(
    found: Sequence[BriefVerdict], base: KnowledgeBase, facts: Iterable[Fact]
) -> None:
    """Compare brief verdicts with those that have proofs; of what a batch refuses it has no near
    miss, of which the degree is next to nothing."""
    verdicts = judge_scene(base, "s", facts).verdicts
    assert len(found) == len(verdicts)
    for one, verdict in zip(found, verdicts, strict=True):
        expected = in_brief(verdict)
        if one.state is State.FAILS and not one.parts and verdict.degree_at_most < NO_DEGREE:
            said: dict[str, Any] = {"degree": 0.0, "degree_at_most": 0.0}
            said["confidence"] = one.confidence
            expected = replace(expected, **said, parts=(), sizes=())
        assert one == expected


def as_whole(facts: list[Fact], seed: int) -> list[Fact]:
    """Return a thing as if it were known from all sides, the rest drawn at random."""
    generator = np.random.default_rng(seed)
    found: list[Fact] = [*facts, ("whole", "t1")]
    found.append(("solidity", "t1", generator.uniform(), 0.01))
    for _, face in [fact for fact in facts if fact[0] == "face"]:
        if generator.uniform() < 0.3:
            continue  # not level
        found.extend((name, face, generator.uniform(), 0.05) for name in LEVEL_KINDS)
    return found


SCENES: dict[str, Callable[[], list[Fact]]] = {
    "cuboid": lambda: facts_of("cuboid", height=0.4),
    "tray": lambda: facts_of("tray"),
    "wedge": lambda: facts_of("wedge"),
    "room": lambda: facts_of("room_corner"),
    "desk": lambda: facts_of("desk", width=0.9),
    "chair": lambda: facts_of("chair"),
    "cabinet": lambda: facts_of("cabinet"),
    "stairs": lambda: facts_of("stairs"),
    "noisy cuboid": lambda: noisy(facts_of("cuboid"), 1),
    "noisy tray": lambda: noisy(facts_of("tray"), 2, by=10),
    "noisy pyramid": lambda: noisy(facts_of("pyramid"), 3, by=100),
    "noisy cabinet": lambda: noisy(facts_of("cabinet"), 4, by=10),
    "noisy stairs": lambda: noisy(facts_of("stairs"), 5, by=10),
    "bench without up": lambda: without_up(facts_of("bench")),
    "shelf without up": lambda: without_up(facts_of("shelf")),
    "noisy cuboid without up": lambda: without_up(noisy(facts_of("cuboid"), 6)),
    **{
        f"whole {name}": partial(lambda name, seed: as_whole(facts_of(name), seed), name, seed)
        for seed, name in enumerate(("table", "chair", "stool", "desk", "cuboid", "stairs"))
    },
    "noisy whole table": lambda: noisy(as_whole(facts_of("table"), 2), 7, by=5),
    "noisy whole cuboid": lambda: noisy(as_whole(facts_of("cuboid"), 3), 8),
    "nothing": list,
}


SLOW = ("shelf without up", "whole table", "whole stool")


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.slow] * (n in SLOW)) for n in SCENES]
)
def test_verdicts_are_those_of_the_full_judge(
    judge: BatchJudge, base: KnowledgeBase, name: str
) -> None:
    facts = SCENES[name]()
    assert_as_in_full(judge.judge(facts), base, facts)


def test_a_scene_leaves_nothing_behind(judge: BatchJudge) -> None:
    block, wedge = facts_of("cuboid"), facts_of("wedge")
    first = judge.judge(block)
    other = judge.judge(wedge)
    assert judge.judge(()) == ()
    assert judge.judge(block) == first
    assert judge.judge(wedge) == other != first


def test_models_that_cannot_be_specialised_are_judged_as_in_full(tmp_path: Path) -> None:
    path = tmp_path / "own.pl"
    path.write_text(OWN)
    facts = facts_of("cuboid")
    with (
        BatchJudge([path], trusted=True) as judge,
        open_knowledge_base([path], trusted=True) as base,
    ):
        found = judge.judge(facts)
        assert_as_in_full(found, base, facts)
        assert {"own", "asking"} <= {v.model for v in found if v.state is State.HOLDS}
        assert judge.judge(facts) == found


def test_what_is_left_to_the_interpreter_is_known(tmp_path: Path) -> None:
    path = tmp_path / "own.pl"
    path.write_text(OWN)
    with BatchJudge([path], trusted=True) as judge:
        conditions = judge.conditions()
        found = judge.judge(facts_of("cuboid"))
    assert conditions["own"].count == 3
    assert conditions["own"].interpreted == ("measure",)
    assert conditions["asking"].interpreted == ("other",)
    assert all(not conditions[name].interpreted for name in BUILTIN_MODELS)
    costs = {verdict.model: verdict.cost for verdict in found}
    assert costs["own"].candidates == 6
    assert all(cost.inferences > 0 for cost in costs.values())


def test_an_error_while_models_are_prepared_names_the_model(tmp_path: Path) -> None:
    path = tmp_path / "faulty.pl"
    path.write_text(
        ":- module(faulty, []).\n:- use_module(facetlog(vocabulary)).\n"
        "means(full(_), Meaning) :- atom_length(Meaning, _).\n"
        'model(faulty, "A word without a meaning.", [a]).\n'
        "candidate(faulty, Thing, [F]) :- face_of(Thing, F).\n"
        'condition(faulty, word, "it is full", _, [F], full(F)).\n'
    )
    with pytest.raises(
        EngineError, match=r"the model faulty cannot be prepared: atom_length/2 needs a value"
    ):
        BatchJudge([path], trusted=True)


@pytest.mark.slow
def test_what_takes_too_long_is_unknown_alone() -> None:
    small, large = facts_of("wedge"), facts_of("shelf", boards=12)
    with BatchJudge() as judge:
        unlimited = {verdict.model: verdict for verdict in judge.judge(large)}
    with BatchJudge(limits=Limits(inferences=300_000)) as judge:
        before = judge.judge(small)
        found = judge.judge(large)
        beyond = {verdict.model for verdict in found if verdict.limit}
        assert 0 < len(beyond) < len(found)
        for verdict in found:
            expected = State.UNKNOWN if verdict.limit else unlimited[verdict.model].state
            assert verdict.state is expected
        assert judge.judge(small) == before


def test_what_is_unknown_whatever_is_chosen_is_not_searched_through() -> None:
    facts = without_up(facts_of("shelf"))
    with BatchJudge(limits=Limits(inferences=4_000_000)) as judge:  # 16 million for all choices
        found = {v.model: v.state for v in judge.judge(facts)}
    assert {found["table"], found["desk"], found["shelf"]} == {State.UNKNOWN}


@pytest.mark.slow
def test_the_time_limit_holds_for_a_scene(tmp_path: Path) -> None:
    path = tmp_path / "slow.pl"
    path.write_text(
        ":- module(slow, []).\n:- use_module(facetlog(vocabulary)).\n"
        'model(slow, "Takes for ever.", [a]).\n'
        "candidate(slow, t2, [f1]) :- between(1, inf, X), X < 0.\n"
        'condition(slow, line, "it is so", _, [_], measured(f1)).\n'
    )
    with BatchJudge([path], trusted=True, limits=Limits(seconds=0.5, inferences=10**10)) as judge:
        before = judge.judge(FACTS)
        with pytest.raises(EngineError, match="time limit"):
            judge.judge((("thing", "t2"),))
        assert judge.judge(FACTS) == before


@pytest.mark.slow
def test_models_hash_says_which_models(tmp_path: Path) -> None:
    path = tmp_path / "own.pl"
    path.write_text(OWN)
    with BatchJudge() as one, BatchJudge() as same, BatchJudge([path], trusted=True) as other:
        assert one.models_hash == same.models_hash != other.models_hash
    path.write_text(OWN.replace("0.4", "0.5"))
    with BatchJudge([path], trusted=True) as changed:
        assert changed.models_hash != other.models_hash


def test_all_code_that_judges_changes_the_name_of_what_was_judged() -> None:
    root = house("rules").parent
    named = {path for pattern in JUDGING_CODE for path in root.glob(pattern)}
    assert named == {*house("rules").glob("*.pl"), *(house("kb") / "prolog").rglob("*.pl")}


def test_rows_by_functor_are_the_same_facts_in_any_order(judge: BatchJudge) -> None:
    for facts in (facts_of("desk"), without_up(facts_of("desk"))):
        assert_same_in_any_order(judge, facts)


def assert_same_in_any_order(judge: BatchJudge, facts: list[Fact]) -> None:
    rows: dict[str, list[Fact]] = defaultdict(list)
    for fact in facts:
        rows[str(fact[0])].append(fact[1:])
    shuffled = [facts[i] for i in np.random.default_rng(0).permutation(len(facts))]
    assert judge.judge(rows) == judge.judge(shuffled) == judge.judge(facts)


@pytest.mark.slow
def test_what_quantifiers_go_through_is_judged_as_in_full(tmp_path: Path) -> None:
    lines = [QUANTIFIED]
    for i, (body, test) in enumerate(product(BODIES, CONDITIONS)):
        lines.append(f'model(m{i}, "A model.", [a, b]).')
        lines.append(f'condition(m{i}, one, "it is so", T, [A, B], {test}) :- {body}.')
        lines.append(f'condition(m{i}, two, "they meet", _, [A, B], adjoins(A, B)).')
    path = tmp_path / "q.pl"
    path.write_text("\n".join(lines) + "\n")
    step = facts_of("l_block")
    with (
        BatchJudge([path], trusted=True) as judge,
        open_knowledge_base([path], trusted=True) as base,
    ):
        for facts in (step, as_whole(step, 4), noisy(facts_of("wedge"), 9, by=20)):
            assert_as_in_full(judge.judge(facts), base, facts)
