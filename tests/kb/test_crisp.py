"""Crisp knowledge bases: no deviations, no degrees between, the paper's answer."""

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from facetlog.errors import EngineError
from facetlog.kb.explaining.proof import State
from facetlog.kb.knowledge_base import BUILTIN_MODELS, KnowledgeBase
from facetlog.kb.loading.encode import Fact
from facetlog.kb.recognize import open_knowledge_base

Build = Callable[..., tuple[Fact, ...]]

RULES = """:- module(m, []).
:- use_module(facetlog(vocabulary)).
model({name}, "A model.", [a]).
candidate({name}, _, [f1]).
condition({name}, line, "it is so", _, [_], {test}).
"""
# Tests of a ratio of 0.55 that was measured badly, and what they are without deviation.
TESTS = {
    "at_least(fill(f1), 0.5)": (State.HOLDS, 1.0),
    "between(fill(f1), 0.54, 0.56)": (State.HOLDS, 1.0),
    "at_least(fill(f1), 0.6)": (State.FAILS, 0.0),
    "fading(at_least(fill(f1), 0.58), 0.1)": (State.HOLDS, 1.0),
    "fading(at_least(fill(f1), 0.61), 0.1)": (State.FAILS, 0.0),
    "expect(0.25, at_least(fill(f1), 0.6))": (State.HOLDS, 1.0),
    "at_most_of(0, X, [[f1]], at_least(fill(X), 0.6))": (State.HOLDS, 1.0),
    "each_pair(X, Y, [f1, f2], near(angle(X, Y), 90, 1))": (State.HOLDS, 1.0),
    "level(f1)": (State.UNKNOWN, 0.0),
}
FACTS: tuple[Fact, ...] = (
    ("thing", "t1"),
    ("face", "f1"),
    ("face", "f2"),
    ("evidence", "f1", "measured"),
    ("evidence", "f2", "measured"),
    ("part_of", "f1", "t1"),
    ("fill", "f1", 0.55, 0.4),
    ("angle", "f1", "f2", 90.5, 10.0),
    ("angle", "f2", "f1", 90.5, 10.0),
)


@pytest.fixture(scope="module", params=[False, True], ids=["here", "isolated"])
def base(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[KnowledgeBase]:
    folder = tmp_path_factory.mktemp("rules")
    with KnowledgeBase(crisp=True, isolated=request.param) as base:
        for i, test in enumerate(TESTS):
            path = folder / f"m{i}.pl"
            path.write_text(RULES.format(name=f"m{i}", test=test))
            base.load_rules(path, trusted=True)
        base.load_scene("s", FACTS)
        yield base


@pytest.mark.parametrize(("number", "test"), list(enumerate(TESTS)))
def test_degrees_are_all_or_nothing_or_open(base: KnowledgeBase, number: int, test: str) -> None:
    state, degree = TESTS[test]
    verdict = base.judge("s", f"m{number}", "t1")
    assert verdict.state is state
    high = 1.0 if state is State.UNKNOWN else degree
    assert (verdict.degree, verdict.degree_at_most) == (degree, high)


def test_a_process_that_was_started_again_is_still_crisp(base: KnowledgeBase) -> None:
    if base.process_id is not None:
        os.kill(base.process_id, signal.SIGKILL)
        with suppress(EngineError):  # that it has ended is told once
            base.judge("s", "m0", "t1")
    assert base.judge("s", "m0", "t1").degree == 1.0


def test_crisp_and_graded_bases_stand_side_by_side(base: KnowledgeBase, tmp_path: Path) -> None:
    path = tmp_path / "m.pl"
    path.write_text(RULES.format(name="m0", test=next(iter(TESTS))))
    with open_knowledge_base([path], trusted=True) as graded:
        graded.load_scene("s", FACTS)
        degrees = [b.judge("s", "m0", "t1").degree for b in (base, graded, base)]
    assert degrees[0] == degrees[2] == 1.0
    assert 0.5 < degrees[1] < 0.6


@pytest.mark.parametrize(
    "name",
    [
        "box",
        "table",
        pytest.param("chair", marks=pytest.mark.slow),
        "wedge",
        "pyramid",
        "room",
        "step",
    ],
)
@pytest.mark.slow
def test_built_in_models_say_the_same_of_what_was_measured_well(facts_of: Build, name: str) -> None:
    with open_knowledge_base(crisp=True) as crisp, open_knowledge_base() as graded:
        for base in (crisp, graded):
            base.load_scene("s", facts_of(name))
        for model in BUILTIN_MODELS:
            mine, other = crisp.judge("s", model, "t1"), graded.judge("s", model, "t1")
            assert mine.state is other.state
            assert mine.parts == other.parts
            assert {mine.degree, mine.degree_at_most} <= {0.0, 1.0}
