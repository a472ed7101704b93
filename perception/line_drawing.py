"""A line drawing: points of a picture, straight lines between them, and how these meet."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.junctions import Junction, junction_type, rays_in_order
from facetlog.perception.polygons import find_union
from facetlog.perception.types import FloatArray, frozen

__all__ = ["LineDrawing", "Rays"]


@dataclass(frozen=True, eq=False, slots=True)
class Rays:
    """The lines at one vertex, counter-clockwise as one sees the picture; the widest gap is last.

    `line` (k,) are the lines, `far` (k,) the vertices at their other ends.
    """

    line: NDArray[np.intp]
    far: NDArray[np.intp]
    type: Junction


@dataclass(frozen=True, eq=False)
class LineDrawing:
    """Points (n, 2), px, and lines between them as pairs (m, 2) of points.

    `angles` (m,) are the lines' directions from their first point, radians, counter-clockwise as
    one sees the picture (v runs down), `sds` (m,) their deviations: what is known of a line may be
    more than its ends tell. No two lines join the same points, and none a point with itself.
    """

    points: FloatArray
    lines: NDArray[np.intp]
    angles: FloatArray
    sds: FloatArray

    def __post_init__(self) -> None:
        lines = np.array(self.lines, dtype=np.intp).reshape(-1, 2)
        lines.setflags(write=False)
        object.__setattr__(self, "points", frozen(self.points, len(self.points), 2))
        object.__setattr__(self, "lines", lines)
        object.__setattr__(self, "angles", frozen(self.angles, len(lines)))
        object.__setattr__(self, "sds", frozen(self.sds, len(lines)))
        ends = {frozenset(pair) for pair in lines.tolist()}
        if len(ends) != len(lines) or any(len(pair) != 2 for pair in ends):
            raise ValueError("lines join two points each, and no two lines the same")

    @classmethod
    def between(
        cls, points: FloatArray, lines: NDArray[np.intp], sds: FloatArray | float = 0.0
    ) -> "LineDrawing":
        """The drawing whose lines are directed as their ends say."""
        points, lines = np.reshape(points, (-1, 2)), np.reshape(lines, (-1, 2))
        du, dv = (points[lines[:, 1]] - points[lines[:, 0]]).T
        return cls(points, lines, np.arctan2(-dv, du), np.broadcast_to(sds, len(lines)).copy())

    @cached_property
    def rays(self) -> tuple[Rays | None, ...]:
        """What meets at each point; None where no line ends."""
        ends = np.concatenate([self.lines[:, 0], self.lines[:, 1]])
        far = np.concatenate([self.lines[:, 1], self.lines[:, 0]])
        number = np.tile(np.arange(len(self.lines)), 2)
        angle = np.concatenate([self.angles, self.angles + np.pi])
        found: list[Rays | None] = []
        for point in range(len(self.points)):
            own = np.flatnonzero(ends == point)
            if not len(own):
                found.append(None)
                continue
            order, _ = rays_in_order(angle[own])
            kind = junction_type(angle[own], self.sds[number[own]])
            found.append(Rays(number[own[order]], far[own[order]], kind))
        return tuple(found)

    def contour(self) -> tuple[tuple[int, int], ...]:
        """The lines round what is drawn, as (from, to): what is drawn lies to their right.

        Lines that end alone bound nothing.

        >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        >>> sides = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])
        >>> LineDrawing.between(square, sides).contour()
        ((0, 1), (1, 2), (2, 3), (3, 0))
        """
        if not len(self.lines):
            return ()
        drawn = shapely.linestrings(self.points[self.lines])
        whole = find_union(shapely.get_parts(shapely.polygonize(drawn)))
        index = {tuple(point): i for i, point in enumerate(self.points.tolist())}
        known = {frozenset(pair) for pair in self.lines.tolist()}
        found = []
        for polygon in shapely.get_parts(whole):
            # In pixels (v down) a ring of positive area runs clockwise as one sees it.
            ring = shapely.get_exterior_ring(polygon)
            at = shapely.get_coordinates(ring).tolist()
            if not shapely.is_ccw(ring):
                at.reverse()
            walk = [index.get(tuple(point), -1) for point in at]
            found += [(a, b) for a, b in pairwise(walk) if frozenset((a, b)) in known]
        return tuple(sorted(found))
