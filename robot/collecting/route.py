"""Shortest routes on the floor round keep-out circles.

The shortest path among obstacles runs from corner to corner of them (de Berg et al., Computational
Geometry, section 15.1): circles become polygons, and of all lines that cross none of them the
shortest chain is taken (Dijkstra).
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra

from facetlog.perception.types import FloatArray

Point = tuple[float, float]
Route = tuple[Point, ...]

# Corners of the polygon that stands for a circle: its sides cut 0.2 % of the radius off the
# circle, 2 mm of a metre.
CORNERS = 48
# Metres by which the polygons are shrunk to ask whether a line crosses one: along a side is free.
TOUCH = 1e-6


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle on the floor, metres."""

    x: float
    y: float
    radius: float

    def distance(self, point: Point) -> float:
        """Return the distance of a point from the circle's middle."""
        return math.hypot(point[0] - self.x, point[1] - self.y)

    def grown(self, margin: float) -> "Circle":
        """Return the circle with its radius enlarged (or reduced)."""
        return Circle(self.x, self.y, self.radius + margin)


def measure_distance_to(circles: tuple[Circle, ...], point: Point) -> float:
    """Return how far a point is from the nearest rim, negative inside; infinite without circles."""
    return min((c.distance(point) - c.radius for c in circles), default=math.inf)


def measure_route(route: Route) -> float:
    """Return the metres from the first to the last point."""
    return sum(math.dist(a, b) for a, b in pairwise(route))


@lru_cache(maxsize=256)  # a plan asks for the same ones again when it compares headings
def find_shortest_route(start: Point, end: Point, circles: tuple[Circle, ...]) -> Route | None:
    """Return the shortest route from start to end that enters no circle, both ends included.

    A circle in which the start or the end lies is shrunk until they are on its rim: callers that
    must refuse such points check `measure_distance_to` before. None if there is no route.

    >>> len(find_shortest_route((0.0, 0.0), (1.0, 0.0), (Circle(0.5, 2.0, 1.0),)))
    2
    """
    shrunk = tuple(
        Circle(c.x, c.y, min(c.radius, c.distance(start), c.distance(end))) for c in circles
    )
    corners, between = _build_graph(shrunk)
    ends = np.array([start, end])
    to_corners = _free(np.repeat(ends, len(corners), axis=0), np.tile(corners, (2, 1)), shrunk)
    straight = bool(_free(ends[:1], ends[1:], shrunk)[0])
    if straight:
        return start, end
    count = len(corners)
    weights = np.zeros((count + 2, count + 2))
    weights[:count, :count] = between
    for i, point in enumerate(ends):
        away = np.linalg.norm(corners - point, axis=1)
        # Zero is "no line" to the search: a corner where the start lies is this far at least.
        weights[count + i, :count] = np.where(
            to_corners.reshape(2, -1)[i], np.maximum(away, TOUCH), 0.0
        )
    weights = np.maximum(weights, weights.T)
    lengths, before = dijkstra(weights, indices=[count], return_predecessors=True)
    if not np.isfinite(lengths[0, count + 1]):
        return None
    places = np.vstack([corners, ends])
    route: list[Point] = []
    node = count + 1
    while node >= 0:
        route.append((float(places[node, 0]), float(places[node, 1])))
        node = int(before[0, node])
    return tuple(reversed(route))


@lru_cache(maxsize=256)
def _build_graph(circles: tuple[Circle, ...]) -> tuple[FloatArray, FloatArray]:
    """Return corners (n, 2) of all polygons, and the lengths (n, n) of the free lines between
    them."""
    corners = np.concatenate(
        [_list_corners(c) for c in circles if c.radius > TOUCH] or [np.empty((0, 2))]
    )
    count = len(corners)
    first, second = np.triu_indices(count, 1)
    free = _free(corners[first], corners[second], circles)
    lengths = np.zeros((count, count))
    lengths[first[free], second[free]] = np.linalg.norm(
        corners[first[free]] - corners[second[free]], axis=1
    )
    return corners, lengths + lengths.T


def _list_corners(circle: Circle) -> FloatArray:
    angles = 2 * np.pi * np.arange(CORNERS) / CORNERS
    return np.column_stack(
        [circle.x + circle.radius * np.cos(angles), circle.y + circle.radius * np.sin(angles)]
    )


def _free(a: FloatArray, b: FloatArray, circles: tuple[Circle, ...]) -> NDArray[np.bool_]:
    """Return whether each of the lines from a (n, 2) to b (n, 2) crosses no polygon."""
    free = np.ones(len(a), dtype=np.bool_)
    if not len(a):
        return free
    lines = shapely.linestrings(np.stack([a, b], axis=1))
    for circle in circles:
        if circle.radius > TOUCH:
            inner = shapely.polygons(_list_corners(circle)).buffer(-TOUCH)
            shapely.prepare(inner)
            free &= ~shapely.intersects(inner, lines)
    return free
