"""The record of verdicts.json accepts what recognition writes, and nothing else."""

import json
from typing import Any

import pytest

from facetlog.kb.recognize import recognize
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.verdicts_schema import VerdictsRecord


def _verdicts(name: str, *, full: bool = False) -> dict[str, Any]:
    scene = build(name, {})
    facts = (fact.row for fact in scene_facts(scene))
    found = recognize(facts, scene_name=scene.name)
    return {**found.to_json(full=full), "problems": [], "warnings": []}


@pytest.mark.parametrize("full", [False, True])
@pytest.mark.parametrize("name", ["cuboid", "chair", "room_corner"])
@pytest.mark.slow
def test_what_recognition_says_is_as_the_schema_has_it(name, full):
    said = json.dumps(_verdicts(name, full=full))
    record = VerdictsRecord.model_validate_json(said, strict=True)
    # nothing is left out and nothing made of it: all that was said comes back
    back = record.model_dump_json(by_alias=True, exclude_defaults=True)
    assert json.loads(back) == json.loads(said)
    assert record.recognised
    assert {verdict.state for verdict in record.verdicts} - {"holds"}
