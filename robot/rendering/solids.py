"""Makers of solids: each stands on z = 0 with the middle of its plan at the origin.

Lengths are in world units; x is along the length, y along the width, z up.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from facetlog.perception.types import FloatArray
from facetlog.robot.rendering.texture import Pattern, Texture
from facetlog.robot.rendering.world import Solid

WHITE_PAINT = 0.96
# Neighbouring facets of a lit cylinder then differ by one or two grey levels, less than the noise
# of any camera: no edge to be seen.
CYLINDER_FACETS = 180
# A chair's back or a table's leg must not have faces coplanar with those of the part it stands on.
LEAST_INSET_SHARE = 0.05
# The faces of a slab in the order in which `prism` makes them.
SIDES = ("bottom", "top", "front", "right", "back", "left")

Loops = list[tuple[int, ...]]
Part: TypeAlias = tuple[FloatArray, Loops]
"""Vertices (n, 3) and faces of one piece of a solid that is joined from several."""


def placed(
    solid: Solid, x: float, y: float, *, yaw: float = 0.0, z: float = 0.0, scale: float = 1.0
) -> Solid:
    """Return the solid scaled, turned by `yaw` (radians) about the vertical, and set down at (x,
    y, z).
    """
    c, s = np.cos(yaw), np.sin(yaw)
    return solid.moved([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], (x, y, z), scale)


def printed(solid: Solid, seed: int, contrast: float = 0.7) -> Solid:
    """Return the solid with a different picture printed on each of its faces."""
    prints = []
    for index, face in enumerate(solid.faces):
        corners = solid.vertices[list(face)]
        reach = float(np.linalg.norm(corners - corners[0], axis=1).max())
        prints.append(Texture(Pattern.PRINT, seed + index, reach, contrast))
    return replace(solid, prints=tuple(prints))


def prism(
    plan: Sequence[tuple[float, float]], height: float, *, name: str, albedo: float = WHITE_PAINT
) -> Solid:
    """Return an upright prism over a simple polygon, given counter-clockwise."""
    n = len(plan)
    vertices = np.array([(x, y, z) for z in (0.0, height) for x, y in plan])
    faces: Loops = [tuple(reversed(range(n))), tuple(range(n, 2 * n))]
    faces += [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return _solid(name, vertices, faces, albedo)


def cuboid(
    length: float,
    width: float,
    height: float,
    *,
    name: str = "cuboid",
    albedo: float = WHITE_PAINT,
) -> Solid:
    """Return a rectangular block.

    >>> block = cuboid(10, 8, 6)
    >>> len(block.vertices), len(block.edges), len(block.faces)
    (8, 12, 6)
    """
    x, y = length / 2, width / 2
    return prism([(-x, -y), (x, -y), (x, y), (-x, y)], height, name=name, albedo=albedo)


def standing_wedge(side: float, height: float, *, albedo: float = WHITE_PAINT) -> Solid:
    """Return a prism over an equilateral triangle, standing on it: its upright edges are of 60°."""
    r = side / np.sqrt(3.0)
    plan = [(r * np.cos(a), r * np.sin(a)) for a in np.deg2rad([-30.0, 90.0, 210.0])]
    return prism(plan, height, name="wedge", albedo=albedo)


def wedge(length: float, side: float, *, albedo: float = WHITE_PAINT) -> Solid:
    """Return a prism over an equilateral triangle, lying on one of its rectangular sides like a
    roof.
    """
    x, y, ridge = length / 2, side / 2, side * np.sqrt(0.75)
    vertices = np.array(
        [(-x, -y, 0), (-x, y, 0), (-x, 0, ridge), (x, -y, 0), (x, y, 0), (x, 0, ridge)]
    )
    faces: Loops = [(0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)]
    return _solid("wedge", vertices, faces, albedo)


def pyramid(length: float, width: float, height: float, *, albedo: float = WHITE_PAINT) -> Solid:
    """Return a pyramid with its tip over the middle of a rectangle."""
    x, y = length / 2, width / 2
    vertices = np.array([(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0), (0, 0, height)])
    faces: Loops = [(3, 2, 1, 0), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    return _solid("pyramid", vertices, faces, albedo)


def cylinder(
    diameter: float,
    height: float,
    *,
    facets: int = CYLINDER_FACETS,
    albedo: float = WHITE_PAINT,
) -> Solid:
    """Return an upright cylinder; its side is one curved surface, whose facets have no true
    edges.
    """
    angles = 2 * np.pi * np.arange(facets) / facets
    plan = [(diameter / 2 * np.cos(a), diameter / 2 * np.sin(a)) for a in angles]
    solid = prism(plan, height, name="cylinder", albedo=albedo)
    return replace(solid, curved=frozenset(range(2, 2 + facets)))


def room_corner(
    length: float, width: float, height: float, thickness: float, *, albedo: float = WHITE_PAINT
) -> Solid:
    """Return two walls that meet square and leave the floor between them open: a prism over an
    L."""
    x, y, t = length / 2, width / 2, thickness
    plan = [(-x, -y), (x, -y), (x, t - y), (t - x, t - y), (t - x, y), (-x, y)]
    return prism(plan, height, name="room_corner", albedo=albedo)


def table(
    length: float,
    width: float,
    height: float,
    *,
    thickness: float,
    leg: float,
    inset: float = LEAST_INSET_SHARE,
    albedo: float = WHITE_PAINT,
) -> Solid:
    """Return a top on four square legs, which stand in from its border by `inset` of its shorter
    side.
    """
    top = slab((-length / 2, -width / 2, height - thickness), (length, width, thickness))
    parts = [top, *legs(length, width, height - thickness, leg, inset)]
    return joined("table", parts, albedo)


def chair(
    width: float,
    depth: float,
    seat_height: float,
    back_height: float,
    *,
    thickness: float,
    leg: float,
    albedo: float = WHITE_PAINT,
) -> Solid:
    """Return a seat on four legs with a back over its rear (+y); `back_height` is above the
    seat.
    """
    seat = slab((-width / 2, -depth / 2, seat_height - thickness), (width, depth, thickness))
    inset = LEAST_INSET_SHARE * min(width, depth)
    back = slab(
        (inset - width / 2, depth / 2 - inset - thickness, seat_height),
        (width - 2 * inset, thickness, back_height),
        without=("bottom",),
    )
    parts = [seat, back, *legs(width, depth, seat_height - thickness, leg)]
    return joined("chair", parts, albedo)


def slab(
    low: tuple[float, float, float],
    sides: tuple[float, float, float],
    *,
    without: Iterable[str] = (),
) -> Part:
    """Return a rectangular piece from its lowest corner, without the faces that touch another
    piece.

    Faces are bottom, top, front (-y), right (+x), back (+y) and left (-x).
    """
    x, y, z = sides
    block = cuboid(x, y, z)
    hidden = {SIDES.index(side) for side in without}
    faces = [face for i, face in enumerate(block.faces) if i not in hidden]
    return block.vertices + np.array(low) + np.array([x / 2, y / 2, 0.0]), faces


def legs(
    length: float, width: float, height: float, side: float, inset: float = LEAST_INSET_SHARE
) -> tuple[Part, ...]:
    """Return four square legs below the corners of a rectangle, `inset` of its shorter side
    within it."""
    shift = inset * min(length, width)
    x, y = length / 2 - shift, width / 2 - shift
    corners = [(-x, -y), (x - side, -y), (x - side, y - side), (-x, y - side)]
    return tuple(slab((u, v, 0.0), (side, side, height), without=("top",)) for u, v in corners)


def joined(name: str, parts: Iterable[Part], albedo: float = WHITE_PAINT) -> Solid:
    """Return one solid of all pieces, each with its own vertices."""
    vertices: list[FloatArray] = []
    faces: Loops = []
    count = 0
    for points, loops in parts:
        vertices.append(points)
        faces += [tuple(i + count for i in loop) for loop in loops]
        count += len(points)
    return _solid(name, np.concatenate(vertices), faces, albedo)


def _solid(name: str, vertices: FloatArray, faces: Loops, albedo: float) -> Solid:
    sides = np.ptp(np.asarray(vertices, dtype=np.float64), axis=0)
    return Solid(
        name,
        vertices,
        tuple(faces),
        (albedo,) * len(faces),
        size=(float(sides[0]), float(sides[1]), float(sides[2])),
    )
