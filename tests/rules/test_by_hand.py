"""Compiled models judge as rules that were written by hand of the same definitions.

The built-in models have gone on since; by_hand/ keeps them in both languages.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids import polyhedra
from facetlog.perception.surfaces.exact_solids.builders import BUILDERS, build
from facetlog.perception.surfaces.exact_solids.polyhedra import moved, seen_from, together

BY_HAND = Path(__file__).parent / "by_hand"
MODELS = tuple(sorted(path.stem for path in BY_HAND.glob("*.pl")))
SOLIDS = ("cuboid", "wedge", "pyramid", "l_block", "room_corner", "table", "stick_table", "chair")
EYES = ((2.0, 1.0, 1.5), (-2.0, -1.0, 1.0), (1.0, 1.0, -2.0))
# Sizes are drawn between a smaller and a larger one than usual: a share of the builder's own.
SMALLER, LARGER = 0.7, 1.5
# The degrees of both are products over the same measured values; a compiled table counts legs by
# their own degrees, where the other asks how many hold.
MOST_APART = 0.02

Bases = tuple[KnowledgeBase, KnowledgeBase]


@pytest.fixture(scope="module")
def bases() -> Iterator[Bases]:
    """The models in the language, and those by hand."""
    with KnowledgeBase() as compiled, KnowledgeBase() as by_hand:
        for name in MODELS:
            compiled.load_rules(BY_HAND / f"{name}.model")
            by_hand.load_rules(BY_HAND / f"{name}.pl", trusted=True)
        yield compiled, by_hand


def solid(name: str) -> Scene:
    return getattr(polyhedra, name)()  # type: ignore[no-any-return]


def varied(builder: str, seed: int) -> Scene:
    rng = np.random.default_rng(seed)
    while True:
        sizes = {
            p.name: p.default * rng.uniform(SMALLER, LARGER) if p.kind == "length" else p.default
            for p in BUILDERS[builder].parameters
        }
        with suppress(ValueError):  # no such thing can be
            return build(builder, sizes)


def similar(scene: Scene, seed: int) -> Scene:
    rng = np.random.default_rng(seed)
    turn = Rotation.random(random_state=rng).as_matrix()
    return moved(scene, turn, rng.uniform(-3.0, 3.0, 3), float(np.exp(rng.uniform(-1.0, 1.0))))


def outcome(verdict: Verdict) -> object:
    """What both must agree on: of what holds also who plays which part, and the sizes."""
    if verdict.state is not State.HOLDS:
        return verdict.state
    parts = {part.role: part.faces for part in verdict.parts if not part.is_group}
    sizes = {size.name: pytest.approx(size.value) for size in verdict.sizes}
    return verdict.state, parts, sizes


def differences(bases: Bases, scene: Scene) -> list[str]:
    facts: Sequence[Fact] = [fact.row for fact in scene_facts(scene)]
    things = [str(fact[1]) for fact in facts if fact[0] == "thing"]
    found = []
    for base in bases:
        base.load_scene("s", facts)
    for thing in things:
        for model in MODELS:
            compiled, by_hand = (base.judge("s", model, thing) for base in bases)
            apart = abs(compiled.degree - by_hand.degree)
            if outcome(compiled) != outcome(by_hand) or apart > MOST_APART:
                found.append(f"{compiled.summary}\n  by hand: {by_hand.summary}")
    return found


def two_things() -> Scene:
    return together(solid("chair"), moved(solid("table"), translation=(2.0, 0.5, 0.0)))


@pytest.mark.parametrize("name", SOLIDS)
def test_verdicts_on_solids_are_those_by_hand(bases: Bases, name: str) -> None:
    whole = solid(name)
    seen = [seen_from(whole, eye) for eye in EYES]
    for scene in (whole, *seen, seen_from(whole, *EYES[:2]), similar(whole, len(name))):
        assert differences(bases, scene) == []


@pytest.mark.parametrize("name", BUILDERS)
@pytest.mark.slow
def test_verdicts_on_things_of_any_size_are_those_by_hand(bases: Bases, name: str) -> None:
    scene = varied(name, len(name))
    assert differences(bases, scene) == []
    assert differences(bases, seen_from(scene, *EYES[:2])) == []


def test_verdicts_on_several_things_are_those_by_hand(bases: Bases) -> None:
    assert differences(bases, two_things()) == []


def test_a_difference_is_told(bases: Bases, tmp_path: Path) -> None:
    compiled, _ = bases
    text = (BY_HAND / "table.pl").read_text(encoding="utf-8")
    stricter = tmp_path / "table.pl"
    stricter.write_text(text.replace("tolerance(cover,   0.80)", "tolerance(cover,   1.80)"))
    with KnowledgeBase() as other:
        other.load_rules(stricter, trusted=True)
        assert len(differences((compiled, other), solid("table"))) == 1
