"""Exact scenes of furniture, trays and stairs, as polyhedra.py has them of solids.

All are in metres, stand on the ground, and have no face where two pieces lie against each other.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.polyhedra import (
    CUBOID_SIDES,
    boxes,
    polyhedron,
    table,
    without_faces,
)

__all__ = ["RIM_SHARE", "bench", "cabinet", "desk", "shelf", "stairs", "stool", "tray"]

RIM_SHARE = 0.05
"""What stands under or between other pieces is in from their rim by this share of the shorter side
of the plan, so that no two pieces have a face in one plane."""
# A desk's rear panel hangs this share of its height, and this share of its depth from the rear.
MODESTY_SHARE = 0.5
MODESTY_INSET_SHARE = 0.15
SD_M = 0.001


@dataclass(frozen=True, slots=True)
class _Piece:
    """An upright cuboid from its lowest to its highest corner; `hidden` sides have no face."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    hidden: tuple[str, ...] = ()


def tray(
    width: float = 0.4,
    depth: float = 0.3,
    height: float = 0.05,
    *,
    thickness: float = 0.005,
    sd: float = SD_M,
) -> Scene:
    """An open box with walls and a floor of that thickness; `height` is the whole."""
    t = thickness
    shells = (
        ((0.0, 0.0, 0.0), (width, depth, height)),
        ((t, t, t), (width - t, depth - t, height)),
    )
    points = [
        (x, y, z)
        for low, high in shells
        for z in (low[2], high[2])
        for x, y in ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1]))
    ]
    sides = [(i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i) for i in range(4)]
    outer = [(3, 2, 1, 0), *sides]
    inner = [(8, 9, 10, 11), *(tuple(8 + i for i in reversed(side)) for side in sides)]
    rim = len(outer) + len(inner)
    loops = [*outer, *inner, (4, 5, 6, 7)]
    return polyhedron(points, loops, sd=sd, name="tray", holes={rim: [(15, 14, 13, 12)]})


def desk(
    length: float = 1.4,
    width: float = 0.7,
    height: float = 0.74,
    *,
    thickness: float = 0.03,
    panel: float = 0.03,
    block: float = 0.03,
    sd: float = SD_M,
) -> Scene:
    """A top on two side panels, tied by a panel at the rear (+y) that does not reach the ground.

    At the right end (+x) stands a drawer block instead, if `block` is wider than a panel.
    """
    under = height - thickness
    rim = RIM_SHARE * min(length, width)
    left, right = rim + panel, length - rim - max(panel, block)
    rear = (1 - MODESTY_INSET_SHARE) * width
    near, far = rim, width - rim
    pieces = (
        _Piece((0.0, 0.0, under), (length, width, height)),
        _Piece((rim, near, 0.0), (left, far, under), ("top",)),
        _Piece((right, near, 0.0), (length - rim, far, under), ("top",)),
        _Piece(
            (left, rear - panel, under - MODESTY_SHARE * height),
            (right, rear, under),
            ("top", "left", "right"),
        ),
    )
    return _scene(pieces, sd, "desk")


def stool(
    width: float = 0.35,
    depth: float = 0.35,
    height: float = 0.45,
    *,
    thickness: float = 0.03,
    leg: float = 0.04,
    sd: float = SD_M,
) -> Scene:
    """A small seat without a back on four square legs."""
    rim = RIM_SHARE * min(width, depth)
    return replace(
        table(width, depth, height, thickness=thickness, leg=leg, inset=rim, sd=sd), name="stool"
    )


def bench(
    length: float = 1.2,
    width: float = 0.35,
    height: float = 0.45,
    *,
    thickness: float = 0.04,
    panel: float = 0.04,
    sd: float = SD_M,
) -> Scene:
    """A long low seat on two panels across it."""
    under = height - thickness
    rim = RIM_SHARE * min(length, width)
    supports = (
        _Piece((x, rim, 0.0), (x + panel, width - rim, under), ("top",))
        for x in (rim, length - rim - panel)
    )
    seat = _Piece((0.0, 0.0, under), (length, width, height))
    return _scene((seat, *supports), sd, "bench")


def shelf(
    width: float = 0.8,
    depth: float = 0.3,
    height: float = 1.8,
    boards: int = 5,
    *,
    thickness: float = 0.02,
    sd: float = SD_M,
) -> Scene:
    """So many level boards between two sides, evenly from foot to top, open in front and behind."""
    rim = RIM_SHARE * min(width, depth)
    inside = (thickness, width - thickness)
    levels = np.linspace(rim, height - rim - thickness, boards).tolist()
    pieces = (
        _Piece((0.0, 0.0, 0.0), (thickness, depth, height)),
        _Piece((width - thickness, 0.0, 0.0), (width, depth, height)),
        *(
            _Piece((inside[0], rim, z), (inside[1], depth - rim, z + thickness), ("left", "right"))
            for z in levels
        ),
    )
    return _scene(pieces, sd, "shelf")


def cabinet(
    width: float = 0.8,
    depth: float = 0.4,
    height: float = 1.2,
    *,
    foot: float = 0.08,
    sd: float = SD_M,
) -> Scene:
    """A closed block on a plinth `foot` high."""
    rim = RIM_SHARE * min(width, depth)
    pieces = (
        _Piece((0.0, 0.0, foot), (width, depth, height)),
        _Piece((rim, rim, 0.0), (width - rim, depth - rim, foot), ("top",)),
    )
    return _scene(pieces, sd, "cabinet")


def stairs(
    steps: int = 4,
    width: float = 0.9,
    rise: float = 0.18,
    going: float = 0.28,
    *,
    sd: float = SD_M,
) -> Scene:
    """A solid flight of steps, each `rise` high and `going` deep, that climbs along x."""
    treads = [(going * i, rise * (i + k)) for i in range(steps) for k in (0, 1)]
    # Anticlockwise seen from -y, where x points to the right and z up.
    profile = [(0.0, 0.0), (going * steps, 0.0), (going * steps, rise * steps), *treads[:0:-1]]
    n = len(profile)
    points = [(x, y, z) for y in (0.0, width) for x, z in profile]
    loops = [tuple(range(n)), tuple(range(2 * n - 1, n - 1, -1))]
    loops += [(i, n + i, n + (i + 1) % n, (i + 1) % n) for i in range(n)]
    return polyhedron(points, loops, sd=sd, name="stairs")


def _scene(pieces: Sequence[_Piece], sd: float, name: str) -> Scene:
    count = len(CUBOID_SIDES)
    hidden = (
        count * index + CUBOID_SIDES.index(side)
        for index, piece in enumerate(pieces)
        for side in piece.hidden
    )
    return without_faces(boxes([(p.low, p.high) for p in pieces], sd, name), hidden)
