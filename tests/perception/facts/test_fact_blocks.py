"""Scenes together have the facts, to the last bit, that each of them has alone."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from facetlog.perception.facts import all_facts
from facetlog.perception.facts.all_facts import fact_columns, fact_rows
from facetlog.perception.facts.fact_schema import FACT_SCHEMA
from facetlog.perception.facts.named_rows import convert_to_rows
from facetlog.perception.scene import Body, Edge, Scene, Vertex
from facetlog.perception.surfaces.exact_solids.builders import BUILDERS, build
from facetlog.perception.surfaces.exact_solids.polyhedra import (
    cuboid,
    l_block,
    moved,
    pyramid,
    room_corner,
    stick_table,
    together,
    wedge,
)

EVERY = frozenset(kind.functor for kind in FACT_SCHEMA)


def two_blocks() -> Scene:
    return together(cuboid(), moved(cuboid(), translation=(0.1, 0.1, 0.1524)))


def told_apart() -> Scene:
    return replace(cuboid(), bodies=(Body(tuple(range(6)), whole=True),))


MAKERS: tuple[Callable[[], Scene], ...] = (
    *(lambda name=name: build(name, {}) for name in sorted(BUILDERS)),  # type: ignore[misc]
    cuboid,
    l_block,
    pyramid,
    room_corner,
    stick_table,
    wedge,
    two_blocks,
    told_apart,
    lambda: Scene("nothing"),
)


def changed(scene: Scene, seed: int) -> Scene:
    """The scene with noise on its vertices, perhaps without some faces, up, or with loose edges."""
    rng = np.random.default_rng(seed)
    sd = rng.choice([0.0, 1e-4, 1e-2])
    noise = rng.normal(0.0, 1.0, (len(scene.vertices), 3)) * sd
    cov = sd**2 * np.eye(3)
    vertices = tuple(
        Vertex(vertex.point + off, vertex.cov + cov)
        for vertex, off in zip(scene.vertices, noise, strict=True)
    )
    scene = replace(scene, vertices=vertices)
    if scene.bodies or not scene.faces:
        return scene
    if rng.random() < 0.3:
        kept = rng.random(len(scene.faces)) < 0.7
        faces = tuple(face for face, stays in zip(scene.faces, kept, strict=True) if stays)
        scene = replace(scene, faces=faces)
    if rng.random() < 0.3:
        loose = rng.choice(len(vertices), 2, replace=False).tolist()
        scene = replace(scene, edges=(*scene.edges, Edge(*loose)))
    return replace(scene, up=None) if rng.random() < 0.2 else scene


changed_scenes = st.builds(
    lambda make, seed: changed(make(), seed), st.sampled_from(MAKERS), st.integers(0, 10_000)
)


@settings(max_examples=4, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(changed_scenes, min_size=1, max_size=5))
def test_scenes_together_have_the_facts_that_each_has_alone(scenes: list[Scene]) -> None:
    together = [
        {functor: convert_to_rows(columns) for functor, columns in found.items()}
        for found in fact_columns(scenes, EVERY)
    ]
    assert _bits(together) == _bits([fact_rows(scene, EVERY) for scene in scenes])


def _bits(found: list[dict[str, list[tuple[Any, ...]]]]) -> str:
    return repr(found).replace("-0.0", "0.0")


def test_several_blocks_of_scenes_have_the_facts_that_each_scene_has_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scenes = [changed(make(), 3) for make in (two_blocks, told_apart, wedge, l_block)]
    wanted = [fact_rows(scene) for scene in scenes]
    monkeypatch.setattr(all_facts, "FACES_AT_ONCE", 10)
    found = fact_columns(scenes)
    assert [
        {f: convert_to_rows(columns) for f, columns in each.items()} for each in found
    ] == wanted
