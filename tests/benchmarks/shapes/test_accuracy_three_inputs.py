"""The texts of crate, gate and bookcase: their examples, their meshes, and what is none of them."""

import pytest

from benchmarks.shapes.accuracy_newcomer import best_verdict
from benchmarks.shapes.accuracy_three_inputs import TEXTS
from benchmarks.shapes.three_things import THINGS, from_mesh, from_scan
from facetlog.cli import main
from facetlog.kb.explaining.proof import State
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.recognize import open_knowledge_base


@pytest.fixture(scope="module")
def base():
    with open_knowledge_base([TEXTS], trusted=True, raw=True) as opened:
        yield opened


@pytest.mark.slow
def test_the_examples_of_the_texts_are_as_they_say() -> None:
    assert main(["model", "test", str(TEXTS)]) == 0


@pytest.mark.parametrize("name", THINGS)
@pytest.mark.slow
def test_a_text_holds_of_its_own_mesh_alone(base: KnowledgeBase, name: str) -> None:
    scene = from_mesh(name)
    held = {n for n in THINGS if best_verdict(base, n, scene).state is State.HOLDS}
    assert held == {name}


@pytest.mark.slow
def test_a_gate_holds_in_a_scan_from_four_places(base: KnowledgeBase) -> None:
    assert best_verdict(base, "gate", from_scan("gate", 1, places=4)).state is State.HOLDS
