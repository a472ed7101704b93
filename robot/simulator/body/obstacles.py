"""What stands in the robot's way: the world's solids as high as the robot, seen from above."""

import math
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from facetlog.perception.types import FloatArray
from facetlog.robot.rendering.world import Solid
from facetlog.robot.simulator.body.dynamics import Contact

__all__ = ["Obstacles", "footprint"]

# Places of the arc of a sector: of 30 degrees its chords are a two-thousandth of its radius off.
ARC = 9


def footprint(solid: Solid, height: float) -> BaseGeometry:
    """The part of a solid between the floor and `height` (its unit), seen from above.

    Walls are lines in it, level faces areas: what comes from outside meets one or the other.
    """
    pieces: list[BaseGeometry] = []
    for face in solid.faces:
        corners = _between(solid.vertices[list(face)], 0.0, height)
        if len(corners) == 0:
            continue
        flat = corners[:, :2]
        ring = np.vstack([flat, flat[:1]])
        pieces.append(shapely.linestrings(ring))
        if len(flat) >= 3:
            pieces.append(shapely.make_valid(shapely.polygons(ring)))
    return shapely.union_all(pieces)


def _between(corners: FloatArray, low: float, high: float) -> FloatArray:
    """The part of a polygon (n, 3) with z in [low, high] (Sutherland and Hodgman, 1974)."""
    for sign, limit in ((1.0, low), (-1.0, -high)):
        inside = sign * corners[:, 2] - limit
        kept: list[FloatArray] = []
        for i in range(len(corners)):
            a, b = inside[i - 1], inside[i]
            if (a < 0) != (b < 0):
                share = a / (a - b)
                kept.append(corners[i - 1] + share * (corners[i] - corners[i - 1]))
            if b >= 0:
                kept.append(corners[i])
        corners = np.array(kept).reshape(-1, 3)
    return corners


@dataclass(frozen=True, eq=False, slots=True)
class Obstacles:
    """Footprints of all that the robot, a circle of `radius` about its middle, can run into."""

    shape: BaseGeometry
    radius: float

    @classmethod
    def of(cls, solids: tuple[Solid, ...], *, radius: float, height: float) -> "Obstacles":
        """The solids' parts below the robot's `height`, in their unit."""
        shape = shapely.union_all([footprint(solid, height) for solid in solids])
        shapely.prepare(shape)
        return cls(shape, radius)

    def nearest(self, x: float, y: float) -> Contact | None:
        """The nearest point of any solid; the gap is negative where the circle overlaps it."""
        if self.shape.is_empty:
            return None
        line = shapely.shortest_line(shapely.Point(x, y), self.shape)
        (x0, y0), (x1, y1) = shapely.get_coordinates(line)
        gap = math.hypot(x1 - x0, y1 - y0) - self.radius
        return Contact(gap, math.atan2(y1 - y0, x1 - x0))

    def distance(self, x: float, y: float, heading: float, half: float, reach: float) -> float:
        """How far the nearest solid is from (x, y) in the directions from `heading` - `half` to
        `heading` + `half`; `reach` if none is so near.
        """
        here = shapely.Point(x, y)
        if not shapely.dwithin(self.shape, here, reach):
            return reach
        angles = heading + half * np.linspace(-1.0, 1.0, ARC)
        arc = np.array([x, y]) + reach * np.column_stack([np.cos(angles), np.sin(angles)])
        met = shapely.intersection(shapely.polygons(np.vstack([[x, y], arc])), self.shape)
        return reach if met.is_empty else min(float(met.distance(here)), reach)
