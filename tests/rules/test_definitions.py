"""Verdicts on things of any size: what each of them is, and nothing else."""

from collections.abc import Iterator

import numpy as np
import pytest

from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.knowledge_base import BUILTIN_MODELS, KnowledgeBase
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.surfaces.exact_solids.builders import BUILDERS, build

# Sizes are drawn about the builder's own: a share of each.
SMALLER, LARGER = 0.85, 1.2

# What each thing is. Of these a person might call it so as well, or a rule on shape and size alone
# cannot tell: a stool and a bench are small tables, a step of two blocks is a stuffed chair or a
# stool with a step, and a closed block higher than deep may be a box or a cabinet.
IS = {
    "cuboid": {"box"},
    "l_block": {"chair", "step_stool"},
    "room_corner": {"room_corner"},
    "table": {"table"},
    "desk": {"table", "desk"},
    "chair": {"chair"},
    "stool": {"stool", "table"},
    "bench": {"bench", "table"},
    "shelf": {"shelf", "bookcase"},
    "cabinet": {"cabinet", "box"},
    "stairs": {"stairs"},
    "bed": {"bed"},
    "sofa": {"sofa"},
    "frame": {"picture_frame"},
}
# Nothing of these looks upwards: what is no table, stool or chair may have a top that was not seen,
# and so what is no crate a floor. Of a corner nobody saw whether other walls stand round it.
TOPPED = (
    "table",
    "stool",
    "chair",
    "desk",
    "bench",
    "sofa",
    "bed",
    "crate",
    "step_stool",
    "stairs",
    "cabinet",
)
OPEN = {(thing, model) for thing in ("wedge", "pyramid") for model in TOPPED}
OPEN.add(("room_corner", "crate"))


@pytest.fixture(scope="module")
def base() -> Iterator[KnowledgeBase]:
    with KnowledgeBase() as base:
        yield base


def verdicts(base: KnowledgeBase, builder: str, *, metric: bool) -> dict[str, Verdict]:
    rng = np.random.default_rng(len(builder))
    sizes = {
        p.name: p.default * rng.uniform(SMALLER, LARGER)
        for p in BUILDERS[builder].parameters
        if p.kind == "length"
    }
    facts = [fact.row for fact in scene_facts(build(builder, sizes))]
    if not metric:
        facts = [("scale", "unknown") if fact[0] == "scale" else fact for fact in facts]
    base.load_scene("s", facts)
    return {model: base.judge("s", model, "t1") for model in BUILTIN_MODELS}


def holding(found: dict[str, Verdict]) -> set[str]:
    return {model for model, verdict in found.items() if verdict.state is State.HOLDS}


@pytest.mark.parametrize("builder", BUILDERS)
@pytest.mark.slow
def test_each_thing_is_what_it_is_and_nothing_else(base: KnowledgeBase, builder: str) -> None:
    found = verdicts(base, builder, metric=True)
    assert holding(found) == IS.get(builder, set())
    for model in set(BUILTIN_MODELS) - holding(found):
        if (builder, model) not in OPEN:
            assert found[model].state is State.FAILS, found[model].summary


@pytest.mark.parametrize("builder", ["desk", "shelf", "cabinet", "stairs", "room_corner"])
@pytest.mark.slow
def test_no_model_needs_metres(base: KnowledgeBase, builder: str) -> None:
    assert holding(verdicts(base, builder, metric=False)) == IS[builder]
