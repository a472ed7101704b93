"""Crisp knowledge bases: no deviations, no degrees between, the paper's answer."""

from collections.abc import Callable
from pathlib import Path

import pytest

from facetlog.kb.knowledge_base import BUILTIN_MODELS
from facetlog.kb.loading.encode import Fact
from facetlog.kb.recognize import open_knowledge_base

Build = Callable[..., tuple[Fact, ...]]

RULES = """:- module(m, []).
:- use_module(facetlog(vocabulary)).
model(m, "A model.", [a]).
candidate(m, _, [f1]).
condition(m, line, "it is so", _, [_], at_least(fill(f1), 0.5)).
"""
FACTS: tuple[Fact, ...] = (("thing", "t1"), ("face", "f1"), ("fill", "f1", 0.55, 0.4))


def test_crisp_and_graded_bases_stand_side_by_side(tmp_path: Path) -> None:
    path = tmp_path / "m.pl"
    path.write_text(RULES)
    with (
        open_knowledge_base([path], trusted=True, crisp=True) as crisp,
        open_knowledge_base([path], trusted=True) as graded,
    ):
        for base in (crisp, graded):
            base.load_scene("s", FACTS)
        degrees = [base.judge("s", "m", "t1").degree for base in (crisp, graded, crisp)]
    assert degrees[0] == degrees[2] == 1.0
    assert 0.5 < degrees[1] < 0.6


@pytest.mark.parametrize("name", ["box", "table", "pyramid", "room"])
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
