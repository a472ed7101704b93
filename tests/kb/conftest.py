"""Ideal solids, and the facts of those of their faces that are seen."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.facts.all_facts import scene_facts
from facetlog.perception.scene import Body
from facetlog.perception.surfaces.exact_solids.polyhedra import drop_faces, polyhedron
from facetlog.perception.types import FloatArray

Fact = tuple[str | int | float, ...]
Build = Callable[..., tuple[Fact, ...]]


@dataclass(frozen=True)
class Solid:
    """Points (n, 3) and outlines counter-clockwise from outside."""

    points: FloatArray
    faces: tuple[tuple[int, ...], ...]

    def __add__(self, other: "Solid") -> "Solid":
        shift = len(self.points)
        moved = tuple(tuple(i + shift for i in f) for f in other.faces)
        return Solid(np.vstack([self.points, other.points]), self.faces + moved)

    def turned(self, rotation: FloatArray, scale: float = 1.0) -> "Solid":
        return Solid(scale * self.points @ rotation.T, self.faces)


BOX_FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


def cuboid(size: Sequence[float], at: Sequence[float] = (0.0, 0.0, 0.0)) -> Solid:
    """Bottom, top, front, right, back, left."""
    x, y, z = size
    ground = [(0.0, 0.0), (x, 0.0), (x, y), (0.0, y)]
    points = [(a, b, h) for h in (0.0, z) for a, b in ground]
    return Solid(np.array(points) + np.asarray(at), BOX_FACES)


def prism(outline: Iterable[tuple[float, float]], depth: float) -> Solid:
    """Return a prism whose end is an outline in the x-z plane, counter-clockwise seen from -y."""
    ring = list(outline)
    n = len(ring)
    points = np.array([(x, y, z) for y in (0.0, depth) for x, z in ring])
    sides = tuple((i, i + n, (i + 1) % n + n, (i + 1) % n) for i in range(n))
    return Solid(points, (tuple(range(n)), tuple(reversed(range(n, 2 * n))), *sides))


def pyramid(side: float, height: float) -> Solid:
    s = side
    points = np.array([(0, 0, 0), (s, 0, 0), (s, s, 0), (0, s, 0), (s / 2, s / 2, height)], float)
    return Solid(points, ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)))


def room_corner(size: float = 2.0) -> Solid:
    """Return a floor and two walls, seen from inside."""
    s = size
    points = np.array(
        [(0, 0, 0), (s, 0, 0), (s, s, 0), (0, s, 0), (0, 0, s), (s, 0, s), (0, s, s)], float
    )
    return Solid(points, ((0, 1, 2, 3), (0, 4, 5, 1), (0, 3, 6, 4)))


def four_legs(length: float, width: float, height: float, thick: float) -> Solid:
    corners = [(x, y) for x in (0.0, length - thick) for y in (0.0, width - thick)]
    legs = [cuboid((thick, thick, height), (x, y, 0.0)) for x, y in corners]
    return legs[0] + legs[1] + legs[2] + legs[3]


def table(length: float = 1.4, width: float = 0.7, height: float = 0.74) -> Solid:
    board = cuboid((length, width, 0.04), (0.0, 0.0, height - 0.04))
    return board + four_legs(length, width, height - 0.04, 0.06)


def chair() -> Solid:
    seat = cuboid((0.42, 0.42, 0.04), (0.0, 0.0, 0.42))
    back = cuboid((0.42, 0.03, 0.44), (0.0, 0.39, 0.46))
    return seat + back + four_legs(0.42, 0.42, 0.42, 0.04)


SOLIDS: dict[str, Callable[[], Solid]] = {
    "box": lambda: cuboid((0.254, 0.2032, 0.1524)),
    "wedge": lambda: prism([(0, 0), (0.2, 0), (0.1, 0.1732)], 0.25),
    "ramp": lambda: prism([(0, 0), (0.2, 0), (0, 0.2)], 0.25),
    "pyramid": lambda: pyramid(0.2, 0.15),
    "cylinder": lambda: prism(
        [(0.1 * np.cos(t), 0.1 * np.sin(t)) for t in np.arange(12) * np.pi / 6], 0.3
    ),
    "room": room_corner,
    "table": table,
    "chair": chair,
    "step": lambda: prism([(0, 0), (0.4, 0), (0.4, 0.2), (0.2, 0.2), (0.2, 0.4), (0, 0.4)], 0.3),
}


def build_facts(
    solid: Solid,
    *,
    seen: Iterable[int] | None = None,
    up: Sequence[float] | None = (0.0, 0.0, 1.0),
    metric: bool = True,
    implied: Iterable[int] = (),
    angle_sd: float = 0.4,
) -> tuple[Fact, ...]:
    """Return facts of the faces `seen` (all if None) of one thing, t1, named by their places from
    0.

    Faces that are `implied` were not measured; all angles have the deviation `angle_sd`.
    """
    chosen = sorted(range(len(solid.faces)) if seen is None else seen)
    size = float(np.ptp(solid.points, axis=0).max())
    whole = polyhedron(solid.points, solid.faces, sd=1e-3 * size, up=up, metric=metric, name="made")
    scene = drop_faces(whole, set(range(len(solid.faces))) - set(chosen))
    body = Body(tuple(range(len(scene.faces))), tuple(range(len(scene.edges))))
    faces = {f"f{place}": f"f{face}" for place, face in enumerate(chosen, 1)}
    hidden = {f"f{face}" for face in implied}

    def renamed(value: str | int | float) -> str | int | float:
        if isinstance(value, str) and value[:1] in "ev" and value[1:].isdigit():
            return f"{value[0]}{int(value[1:]) - 1}"
        return faces.get(value, value) if isinstance(value, str) else value

    found: list[Fact] = []
    for fact in scene_facts(replace(scene, bodies=(body,))):
        name, *values = fact.row
        row = [renamed(value) for value in values]
        if name in ("angle", "dihedral", "tilt"):
            row[-1] = angle_sd
        if name == "evidence" and row[0] in hidden:
            row[-1] = "implied"
        if name != "scanned":  # all of it is found in pictures
            found.append((name, *row))
    return tuple(found)


@pytest.fixture(scope="module")
def base() -> Iterator[KnowledgeBase]:
    """Return a knowledge base for all tests of a module."""
    with KnowledgeBase() as base:
        yield base


@pytest.fixture(scope="session")
def solid() -> Callable[[str], Solid]:
    """Return an ideal solid by name."""
    return lambda name: SOLIDS[name]()


@pytest.fixture(scope="session")
def facts_of() -> Build:
    """Return facts of an ideal solid by name; keywords as build_facts."""

    @cache
    def build(name: str, **options: Any) -> tuple[Fact, ...]:
        return build_facts(SOLIDS[name](), **options)

    return build


@pytest.fixture(scope="session")
def facts_of_solid() -> Build:
    """Return facts of a solid; keywords as build_facts."""
    return build_facts
