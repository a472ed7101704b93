"""The models that come with facetlog: their files, and the examples they give of themselves."""

from pathlib import Path

import pytest

from facetlog.commands.model.scenes import ExampleScenes, list_builder_sizes
from facetlog.grammar.analysis import analyse
from facetlog.grammar.example_scenes import find_scene_faults
from facetlog.grammar.format import formatted
from facetlog.grammar.library import BUILTIN
from facetlog.kb.examples import list_example_cases, run_cases
from facetlog.kb.explaining.proof import State
from facetlog.kb.knowledge_base import KnowledgeBase

MODELS = sorted(BUILTIN.glob("*.model"))


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_a_model_is_without_fault_and_in_canonical_layout(path: Path) -> None:
    analysis = analyse(path)
    assert analysis.faults == ()
    assert find_scene_faults(analysis, list_builder_sizes()) == ()
    assert formatted(analysis.file.source) == analysis.file.source.text


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_examples_are_as_they_say(path: Path) -> None:
    cases = list_example_cases(analyse(path), ExampleScenes().make_facts)
    assert {case.expected.state for case in cases} == set(State)
    with KnowledgeBase() as base:
        failed = [result for result in run_cases(base, cases) if not result.passed]
    assert not failed, "\n".join(line for result in failed for line in result.lines())
