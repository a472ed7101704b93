"""Things of which each has a side of the same board: they are one.

Of a thin board pictures often show both sides and no rim between them, so that no edge says that
they belong together. But two faces that lie back to back, with no room for anything between them,
are the sides of one board.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import shapely

from facetlog.perception.attached_edges import MAX_GAP_SHARE, MIN_DEPTH_SHARE
from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.polygons import find_intersection, make_polygon
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.things import Thing
from facetlog.perception.types import FloatArray

__all__ = ["one_board"]

# The two sides of a board look away from each other within this angle.
OPPOSITE = float(np.cos(np.deg2rad(10.0)))
# They cover each other by this share of the smaller one.
SHARED = 0.5


def one_board(table: FaceTable, things: Sequence[Thing]) -> Iterator[tuple[int, int]]:
    """Pairs of things, by their numbers, that have the two sides of a board.

    The table is of one scene.
    """
    owners = np.full(len(table), -1, dtype=np.intp)
    for number, thing in enumerate(things):
        owners[list(thing.faces)] = number
    normals = table.planes.normals
    usable = np.flatnonzero((owners >= 0) & (table.areas > 0.0))
    for one in usable.tolist():
        apart = owners[usable] != owners[one]
        opposite = usable[(usable > one) & apart & (normals[usable] @ normals[one] < -OPPOSITE)]
        for other in opposite.tolist():
            if _back_to_back(
                _outline(table, one), _outline(table, other), normals[one], normals[other]
            ):
                yield int(owners[one]), int(owners[other])


def _outline(table: FaceTable, face: int) -> FloatArray:
    outline: FloatArray = table.points[table.outlines[face, table.there[face]]]
    return outline


def _back_to_back(
    one: FloatArray, other: FloatArray, normal: FloatArray, other_normal: FloatArray
) -> bool:
    """Whether outlines (k, 3), (l, 3) cover each other, the second a board's thickness behind."""
    middle = one.mean(axis=0)
    axes = plane_axes(normal, one[1] - one[0])
    first, second = (make_polygon((ring - middle) @ axes.T) for ring in (one, other))
    least = min(first.area, second.area)
    shared = find_intersection(first, second)
    if shared.area < SHARED * least:
        return False
    place = middle + shapely.get_coordinates(shared.centroid)[0] @ axes
    depth = float((place - other.mean(axis=0)) @ other_normal) / float(normal @ other_normal)
    size = float(np.sqrt(least))
    return -MIN_DEPTH_SHARE * size < depth < MAX_GAP_SHARE * size
