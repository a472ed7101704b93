"""Things that a cloud's sensor stands in: what it saw of them from there is not their outside.

A room, too, goes all round the sensor. It is told from a thing by what stands in it. Of a shell in
which nothing stands nothing tells which it is: an empty room and a carton differ in size alone. It
counts as a thing.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from facetlog.perception.shapes.clouds.all_sides import even_directions
from facetlog.perception.shapes.clouds.lines_of_sight import MOST_PLACES
from facetlog.perception.space.empty_shells import is_empty_shell
from facetlog.perception.space.flooding import OPEN_SHARE
from facetlog.perception.types import FloatArray

__all__ = ["things_round_a_sensor"]

# Directions that are looked along, 20 degrees apart: a thing is closed in those in which it has
# points.
DIRECTIONS = 96


def things_round_a_sensor(
    points: FloatArray,
    bodies: NDArray[np.intp],
    seen_from: FloatArray | None,
    up: FloatArray | None,
) -> tuple[int, ...]:
    """The numbers of the things that go round a place from which points (n, 3) were seen.

    `bodies` (n,) is the object of each, -1 for none; `seen_from` (n, 3) as of a Cloud. The ground
    closes a thing below where `up` (3,) is known.
    """
    if seen_from is None:
        return ()
    known = np.isfinite(seen_from).all(axis=1)
    places = np.unique(seen_from[known], axis=0)
    if len(places) > MOST_PLACES:
        return ()
    found = []
    for body in range(int(bodies.max(initial=-1)) + 1):
        own = points[bodies == body]
        low, high = own.min(axis=0), own.max(axis=0)
        within = places[((places > low) & (places < high)).all(axis=1)]
        if any(_goes_round(own, points, place, up) for place in within):
            found.append(body)
    return tuple(found)


def _goes_round(
    own: FloatArray, points: FloatArray, place: FloatArray, up: FloatArray | None
) -> bool:
    """Whether a thing, of its `own` points (k, 3) of all, and no room, goes round a place."""
    rays = own - place
    ways = rays / np.maximum(np.linalg.norm(rays, axis=1), 1e-300)[:, None]
    directions = even_directions(DIRECTIONS)
    asked = np.ones(len(directions), dtype=bool) if up is None else directions @ up > 0.0
    closed = np.zeros(len(directions), dtype=bool)
    closed[cKDTree(directions).query(ways)[1]] = True
    if not asked.any() or float((~closed[asked]).mean()) > OPEN_SHARE:
        return False
    return is_empty_shell(own, points, place)
