"""Facts of ideal solids, worked out from their polygons as the schema defines them."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise, permutations
from typing import Any

import numpy as np
import pytest
from shapely.geometry import Polygon
from shapely.ops import unary_union

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
    """A prism whose end is an outline in the x-z plane, counter-clockwise seen from -y."""
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
    """A floor and two walls, seen from inside."""
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


def _frame(normal: FloatArray) -> FloatArray:
    helper = np.eye(3)[np.argmin(np.abs(normal))]
    u = np.cross(normal, helper)
    u /= np.linalg.norm(u)
    return np.array([u, np.cross(normal, u)])


def _rectangle(flat: FloatArray) -> tuple[float, float]:
    ring = Polygon(flat).minimum_rotated_rectangle.exterior.coords
    a, b, c = (np.array(p) for p in ring[:3])
    lengths = sorted((float(np.linalg.norm(b - a)), float(np.linalg.norm(c - b))))
    return lengths[1], lengths[0]


def _solidity(solid: Solid) -> float:
    """Its share of the box round it that is square to its first edge and its first face.

    What has no inside, as a room's corner, fills none.
    """
    corners = [
        solid.points[[ring[0], *pair]] for ring in solid.faces for pair in pairwise(ring[1:])
    ]
    volume = sum(float(np.linalg.det(triangle)) for triangle in corners) / 6
    first, second, third = solid.points[list(solid.faces[0][:3])]
    along, up = second - first, np.cross(second - first, third - second)
    axes = np.array([along, np.cross(up, along), up])
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    return max(0.0, volume) / float(np.prod(np.ptp(solid.points @ axes.T, axis=0)))


def build_facts(
    solid: Solid,
    *,
    seen: Iterable[int] | None = None,
    up: Sequence[float] | None = (0.0, 0.0, 1.0),
    metric: bool = True,
    implied: Iterable[int] = (),
    angle_sd: float = 0.4,
    ratio_sd: float = 0.01,
    prefix: str = "f",
) -> tuple[Fact, ...]:
    """Facts of the faces `seen` (all if None) of one thing, t1."""
    points = solid.points
    chosen = tuple(range(len(solid.faces))) if seen is None else tuple(seen)
    rings = {f"{prefix}{i}": solid.faces[i] for i in chosen}
    hidden = {f"{prefix}{i}" for i in implied}
    used = sorted({v for ring in rings.values() for v in ring})
    diameter = float(np.ptp(points[used], axis=0).max())
    length_sd = 0.002 * diameter
    facts: list[Fact] = [("scene", "made"), ("scale", "metric" if metric else "unknown")]
    facts.append(("thing", "t1"))
    if up is not None:
        facts.append(("up", *map(float, up)))
    facts += [("vertex", f"v{v}") for v in used]
    facts += [("point", f"v{v}", *map(float, points[v])) for v in used]

    normals: dict[str, FloatArray] = {}
    for name, ring in rings.items():
        corners = points[list(ring)]
        area2 = sum(np.cross(corners[i], corners[(i + 1) % len(ring)]) for i in range(len(ring)))
        normals[name] = np.asarray(area2 / np.linalg.norm(area2))
    edges: dict[frozenset[int], str] = {}
    for ring in rings.values():
        for pair in zip(ring, ring[1:] + ring[:1], strict=True):
            edges.setdefault(frozenset(pair), f"e{len(edges)}")
    for pair_set, edge in edges.items():
        a, b = sorted(pair_set)
        facts.append(("edge", edge, f"v{a}", f"v{b}"))
        span = float(np.linalg.norm(points[a] - points[b]))
        facts.append(("edge_length", edge, span, length_sd))
        facts.append(("evidence", edge, "measured"))

    extents = []
    biggest = max(rings, key=lambda n: Polygon(points[list(rings[n])] @ _frame(normals[n]).T).area)
    flat_all = points[used] @ _frame(normals[biggest]).T
    hull = Polygon(flat_all).convex_hull
    if hull.geom_type == "Polygon":
        extents += list(_rectangle(np.array(hull.exterior.coords)))
    extents.append(float(np.ptp(points[used] @ normals[biggest])))
    facts.append(("thing_size", "t1", *sorted(extents, reverse=True)))
    solidity = _solidity(solid)
    facts.append(("solidity", "t1", solidity, ratio_sd))
    facts.append(("hollow_side", "t1", float(solidity < 0.8), ratio_sd))
    facts.append(("curved", "t1", 0.0))

    lowest = float((points[used] @ np.asarray(up)).min()) if up is not None else 0.0
    for name, ring in rings.items():
        normal, corners = normals[name], points[list(ring)]
        frame = _frame(normal)
        flat = Polygon(corners @ frame.T)
        length, width = _rectangle(corners @ frame.T)
        shadows = [Polygon(points[list(r)] @ frame.T) for r in rings.values()]
        silhouette = unary_union([s.buffer(1e-9) for s in shadows if s.area > 1e-12])
        facts += [
            ("face", name),
            ("part_of", name, "t1"),
            ("evidence", name, "implied" if name in hidden else "measured"),
            ("area", name, flat.area, ratio_sd * flat.area),
            ("length", name, length, length_sd),
            ("width", name, width, length_sd),
            ("fill", name, flat.area / (length * width), ratio_sd),
            ("share", name, flat.area / silhouette.area, ratio_sd),
            ("coverage", name, 1.0),
        ]
        reach = float(((points[used] - corners[0]) @ normal).max())
        facts.append(("protrusion", name, max(reach, 0.0), length_sd))
        behind = float(((corners[0] - points[used]) @ normal).max())
        facts.append(("reach_behind", name, max(behind, 0.0), length_sd))
        facts += [("corner", name, i + 1, f"v{v}") for i, v in enumerate(ring)]
        for pair in zip(ring, ring[1:] + ring[:1], strict=True):
            facts.append(("bounds", edges[frozenset(pair)], name))
        if up is not None:
            facts += _heights(name, normal, corners, np.asarray(up), lowest, length_sd, angle_sd)
            facts.append(("clear_below", name, _clearance(name, rings, points, np.asarray(up))))
            if abs(float(normal @ np.asarray(up))) > 0.9:  # the level of one face is as large as it
                facts.append(("level_length", name, length, length_sd))
                facts.append(("level_width", name, width, length_sd))
    for a, b in permutations(rings, 2):
        facts += _pair(a, b, rings, normals, points, edges, angle_sd, length_sd)
    return tuple(facts)


def _heights(
    name: str,
    normal: FloatArray,
    corners: FloatArray,
    up: FloatArray,
    lowest: float,
    sd: float,
    angle_sd: float,
) -> list[Fact]:
    rise = float(normal @ up)
    heights = corners @ up - lowest
    facts: list[Fact] = [
        ("tilt", name, float(np.degrees(np.arccos(min(1.0, abs(rise))))), angle_sd),
        ("elevation", name, float(heights.mean()), sd),
        ("top_of", name, float(heights.max()), sd),
        ("bottom_of", name, float(heights.min()), sd),
    ]
    if abs(rise) > 0.05:
        facts.append(("upward" if rise > 0 else "downward", name))
    return facts


def _clearance(
    name: str, rings: dict[str, tuple[int, ...]], points: FloatArray, up: FloatArray
) -> float:
    # Down from the face; what covers a fifth of it ends the free space, its own underside included.
    frame = _frame(up)
    outline = Polygon(points[list(rings[name])] @ frame.T)
    if outline.area < 1e-9 * float(np.ptp(points, axis=0).max()) ** 2:
        return 0.0
    height = float((points[list(rings[name])] @ up).mean())
    ground = float((points @ up).min())
    below = [
        (Polygon(points[list(r)] @ frame.T), float((points[list(r)] @ up).mean()))
        for other, r in rings.items()
        if other != name
    ]
    below = [
        (p, h)
        for p, h in below
        if p.area > 1e-6 * outline.area and h < height - 1e-6 * (height - ground)
    ]
    free = height - ground
    for shape, level in below:
        if shape.intersection(outline).area > 0.2 * outline.area:
            free = min(free, height - level)
    return free


def _pair(
    a: str,
    b: str,
    rings: dict[str, tuple[int, ...]],
    normals: dict[str, FloatArray],
    points: FloatArray,
    edges: dict[frozenset[int], str],
    angle_sd: float,
    length_sd: float,
) -> list[Fact]:
    angle = float(np.degrees(np.arccos(np.clip(normals[a] @ normals[b], -1.0, 1.0))))
    offset = float((points[list(rings[a])].mean(0) - points[rings[b][0]]) @ normals[b])
    facts: list[Fact] = [
        ("angle", a, b, angle, angle_sd),
        ("offset", a, b, offset, length_sd),
    ]
    loop = rings[b]
    ring_edges = {frozenset(p) for p in zip(loop, loop[1:] + loop[:1], strict=True)}
    mine = rings[a]
    for pair in zip(mine, mine[1:] + mine[:1], strict=True):
        if frozenset(pair) in ring_edges:
            convex = offset < 0
            facts.append(("adjoins", a, b, edges[frozenset(pair)]))
            dihedral = 180 - angle if convex else 180 + angle
            facts.append(("dihedral", a, b, dihedral, angle_sd))
            facts.append(("convex" if convex else "concave", a, b))
    if angle > 175:
        facts.append(("opposite", a, b))
    return facts


@pytest.fixture(scope="session")
def solid() -> Callable[[str], Solid]:
    """An ideal solid by name."""
    return lambda name: SOLIDS[name]()


@pytest.fixture(scope="session")
def facts_of() -> Build:
    """Facts of an ideal solid by name; keywords as build_facts."""

    @cache
    def build(name: str, **options: Any) -> tuple[Fact, ...]:
        return build_facts(SOLIDS[name](), **options)

    return build


@pytest.fixture(scope="session")
def facts_of_solid() -> Build:
    """Facts of a solid; keywords as build_facts."""
    return build_facts
