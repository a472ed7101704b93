"""Made scenes obey the schema and are what they say; the ways that are compared agree."""

import doctest
from importlib.util import find_spec

import pytest

from benchmarks.knowledge import knowledge_base, time_box_rule, time_growth, time_reasons
from benchmarks.knowledge.block_scenes import block_scene
from benchmarks.knowledge.knowledge_base import (
    angle_facts,
    cpu_ms,
    python_says,
    random_planes,
    rows_against,
    swipl_says,
)
from facetlog.kb.explaining.proof import State
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.facts.fact_schema import Fact, fact_fault


def test_the_doctests_hold() -> None:
    assert doctest.testmod(knowledge_base).failed == 0


def test_made_facts_are_facts_of_the_schema() -> None:
    for facts in (angle_facts(700), random_planes(4)):
        faults = [fact_fault(Fact(str(name), tuple(args))) for name, *args in facts]
        assert not any(faults), faults
        assert len({fact[:3] for fact in facts}) == len(facts)


@pytest.mark.slow
def test_the_work_of_growth_finds_what_there_is() -> None:
    with KnowledgeBase() as base:
        for one_thing, work in time_growth.WORK.values():
            base.load_scene("s", block_scene(4, one_thing=one_thing))
            work(base, 4)
            base.load_scene("s", block_scene(5, one_thing=one_thing))
        with pytest.raises(RuntimeError, match="corners of 4 blocks"):
            time_growth.WORK["question, a join"][1](base, 4)


def test_the_plain_question_has_the_conditions_of_the_proof() -> None:
    with KnowledgeBase() as base:
        base.load_scene("blocks", block_scene(2, one_thing=False))
        assert list(base.query(time_reasons.PLAIN)) == [()]
        assert base.why("blocks", "box", parts=time_reasons.PARTS).state is State.HOLDS


def test_all_ways_of_the_box_rule_agree() -> None:
    facts = random_planes(30)
    ways = dict(time_box_rule.OURS)
    if find_spec(time_box_rule.CLINGO):
        ways |= time_box_rule.PEER
    found = {name: way(facts)[0] for name, way in ways.items()}
    assert len(set(found.values())) == 1
    assert found["join of angles"] > 0


def test_work_is_repeated_once_more_than_it_is_counted() -> None:
    done: list[str] = []
    times = cpu_ms(lambda: done.append("work"), 3, before=lambda: done.append("before"))
    assert len(times) == 3
    assert done == ["before", "work"] * 4


def test_ratios_are_those_of_medians() -> None:
    (row,) = rows_against([1.0, 2.0, 9.0], [("work", [3.0, 4.0, 5.0])])
    assert (row["ms median"], row["÷ native"]) == (4.0, 2.0)


def test_processes_of_their_own_say_what_they_measured() -> None:
    assert len(swipl_says("main :- times(2, true, Ts), length(Ts, N), print([N]).\n")) == 1  # type: ignore[arg-type]
    assert python_says("print(json.dumps(len(cpu_ms(int, 2))))") == 2
    with pytest.raises(RuntimeError, match="wrong"):
        python_says("raise SystemExit('wrong')")
