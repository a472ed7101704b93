"""Line drawings: points of a picture, straight lines between them, and types of junctions.

A. Guzmán, "Decomposition of a visual scene into three-dimensional bodies", 1968, sorts the vertices
of a line drawing by how many lines meet there and by the angles between them; D. A. Huffman and
M. B. Clowes (both 1971) label the lines of a drawing by these types (rules/line_labels.pl).
"""

from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.polygons import find_union
from facetlog.perception.types import FloatArray, frozen

# Two lines are one straight line if their directions are opposite within so many deviations.
COLLINEAR_SDS = 3.0
# What rounding leaves of a direction, radians: lines without any error are no surer than this.
ROUNDING_SD = 1e-6


class Junction(StrEnum):
    """How lines meet at a vertex of a drawing."""

    END = "end"
    """One line, which ends alone: mostly at the picture's border."""
    STRAIGHT = "straight"
    """Two lines that go on along each other."""
    L = "l"
    """Two lines at an angle."""
    FORK = "fork"
    """Three lines, each two less than a straight angle apart; also called Y."""
    ARROW = "arrow"
    """Three lines within less than a straight angle; also called W."""
    T = "t"
    """Three lines, two of them along each other."""
    K = "k"
    """Four lines, two of them along each other and the others on one side of these."""
    X = "x"
    """Four lines, two of them along each other and the others on either side of these."""
    PEAK = "peak"
    """Four lines or more within less than a straight angle."""
    MULTI = "multi"
    """Any other way in which four lines or more meet."""


def find_collinear(angles: FloatArray, sds: FloatArray) -> NDArray[np.bool_]:
    """Return which two of n directions (n,) of these deviations (n,), radians, are opposite: (n,
    n).
    """
    # the remainder of a straight angle, in -pi .. pi
    off = (angles[:, None] - angles[None, :]) % (2 * np.pi) - np.pi
    variance = sds[:, None] ** 2 + sds[None, :] ** 2 + 2 * ROUNDING_SD**2
    return np.asarray(off**2 <= COLLINEAR_SDS**2 * variance, dtype=np.bool_)


def sort_rays(angles: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
    """Return the directions (n,) as indices in ascending order, and the gap (n,) behind each,
    radians.

    The widest gap comes last: it is that from the last direction to the first. Of gaps that are
    equal but for rounding it is the first one from 0 on.

    >>> order, gaps = sort_rays(np.deg2rad([10.0, 200.0, 100.0]))
    >>> order.tolist(), np.rad2deg(gaps).round().tolist()
    ([0, 2, 1], [90.0, 100.0, 170.0])
    """
    turned = angles % (2 * np.pi)
    order = np.argsort(turned, kind="stable")
    ascending = turned[order]
    gaps = np.append(ascending[1:], ascending[:1] + 2 * np.pi) - ascending
    widest = np.flatnonzero(gaps >= gaps.max(initial=0.0) - ROUNDING_SD)
    first = (int(widest[0]) + 1) % len(angles) if len(angles) else 0
    return np.roll(order, -first), np.roll(gaps, -first)


def classify_junction(angles: FloatArray, sds: FloatArray) -> Junction:
    """Return the type of a junction from the directions (n,) of its lines and their deviations,
    radians.

    Directions point away from the vertex; it makes no difference which way they are counted, or
    from where. ValueError for no line at all.

    >>> classify_junction(np.deg2rad([0.0, 90.0, 180.5]), np.deg2rad([0.5, 0.5, 0.5])).value
    't'
    >>> classify_junction(np.deg2rad([0.0, 90.0, 180.5]), np.deg2rad([0.1, 0.1, 0.1])).value
    'fork'
    """
    count = len(angles)
    if not count:
        raise ValueError("a junction has at least one line")
    if count == 1:
        return Junction.END
    straight = find_collinear(angles, sds)
    if count == 2:
        return Junction.STRAIGHT if straight[0, 1] else Junction.L
    order, gaps = sort_rays(angles)
    within = bool(gaps[-1] > np.pi)
    if count == 3:
        if straight.any():
            return Junction.T
        return Junction.ARROW if within else Junction.FORK
    if count == 4 and straight.any():
        # between which places of the order the straight line runs
        places = np.nonzero(straight[np.ix_(order, order)])
        across = any(abs(int(a - b)) == 2 for a, b in zip(*places, strict=True))
        return Junction.X if across else Junction.K
    return Junction.PEAK if within and not straight.any() else Junction.MULTI


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
        """Return the drawing whose lines are directed as their ends say."""
        points, lines = np.reshape(points, (-1, 2)), np.reshape(lines, (-1, 2))
        du, dv = (points[lines[:, 1]] - points[lines[:, 0]]).T
        return cls(points, lines, np.arctan2(-dv, du), np.broadcast_to(sds, len(lines)).copy())

    @cached_property
    def rays(self) -> tuple[Rays | None, ...]:
        """The lines that meet at each point; None where no line ends."""
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
            order, _ = sort_rays(angle[own])
            kind = classify_junction(angle[own], self.sds[number[own]])
            found.append(Rays(number[own[order]], far[own[order]], kind))
        return tuple(found)

    def contour(self) -> tuple[tuple[int, int], ...]:
        """Return the lines round what is drawn, as (from, to): what is drawn lies to their right.

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
