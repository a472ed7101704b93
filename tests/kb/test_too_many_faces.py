"""A thing of hundreds of faces: what is too much for one model leaves the others' verdicts."""

import logging
from dataclasses import replace
from pathlib import Path

import pytest

from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.brief_verdict import STACKS
from facetlog.kb.explaining.proof import State
from facetlog.kb.limits import Limits
from facetlog.kb.recognize import judge_scene, open_knowledge_base
from facetlog.perception.facts.all_facts import fact_rows, scene_facts
from facetlog.perception.scene import Body, Scene
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid, moved, together


def heap(count: int) -> Scene:
    """Return boxes of three heights side by side, in one piece: any three may be treads of
    stairs."""
    boxes = [
        moved(
            cuboid(0.3, 0.2, 0.17 * (1 + k % 3)),
            translation=(0.3 * (k % 5) + 1e-4 * (k % 7), 0.2 * (k // 5), 0.0),
        )
        for k in range(count)
    ]
    scene = together(*boxes)
    return replace(scene, bodies=(Body(tuple(range(len(scene.faces)))),))


ANY_THREE = """model any_three
  "Any three faces."

  face a, b, c

  large: area(a) + area(b) + area(c) at least 1 mm * 1 mm
"""


@pytest.mark.slow
def test_a_batch_says_which_models_it_was_too_much_for(tmp_path: Path) -> None:
    path = tmp_path / "any_three.model"
    path.write_text(ANY_THREE)
    judge = BatchJudge((path,), limits=Limits(stack_mb=16))
    verdicts = judge.judge(fact_rows(heap(25)))
    beyond = {verdict.model for verdict in verdicts if verdict.limit == STACKS}
    assert "any_three" in beyond
    assert all(verdict.state is State.UNKNOWN for verdict in verdicts if verdict.limit)
    assert {"bed", "crate", "door"} <= {v.model for v in verdicts} - beyond
    few = judge.judge(fact_rows(cuboid(0.4, 0.3, 0.2)))
    judge.close()
    assert not any(verdict.limit for verdict in few)


def test_a_scene_is_judged_though_one_model_reaches_a_limit(
    caplog: pytest.LogCaptureFixture,
) -> None:
    scene = heap(9)
    facts = [fact.row for fact in scene_facts(scene)]
    with (
        open_knowledge_base((), limits=Limits(inferences=300_000)) as base,
        caplog.at_level(logging.WARNING, logger="facetlog"),
    ):
        found = judge_scene(base, "heap", facts)
        models = set(base.models)
    assert {verdict.model for verdict in found.verdicts} == models
    beyond = {v.model for v in found.verdicts if v.state is State.UNKNOWN and not v.conditions}
    assert "desk" in beyond
    assert beyond < models
    assert any("desk" in line and "limit" in line for line in caplog.messages)
