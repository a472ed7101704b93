"""Facts of a scene by their subjects, and scenes over a ground that views show."""

from dataclasses import replace

import numpy as np

from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.scene import Scene, SeenLattice

__all__ = ["faces_of_things", "first_values", "on_ground"]

ABOVE = np.array([[3.0, 0.0, 2.0], [0.0, 3.0, 2.0], [-3.0, -3.0, 2.0]])


def first_values(scene: Scene, functor: str) -> dict[str, float]:
    """The first value of each fact of a kind, by its subject."""
    return {str(row[0]): float(row[1]) for row in fact_rows(scene, {functor})[functor]}


def faces_of_things(scene: Scene) -> list[tuple[int, ...]]:
    return [thing.faces for thing in SceneMemo.of(scene).things]


def on_ground(scene: Scene, height: float = 0.0) -> Scene:
    """The scene over a ground at a height, of which three views see some."""
    corner, steps = np.array([-2.0, -2.0, height]), 0.1 * np.eye(3)[:2]
    lattice = SeenLattice(corner, steps, ABOVE, np.ones((3, 9, 9), dtype=np.bool_), (0, 1, 2))
    return replace(scene, views=("a", "b", "c"), lattices=(lattice,))
