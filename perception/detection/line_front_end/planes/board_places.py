"""Possible places of a level board: between two upright faces that stand opposite each other."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.planes.outlined_face import OutlinedFace
from facetlog.perception.detection.line_front_end.planes.parallel import (
    PARALLEL_COSINE,
    UPRIGHT_SINE,
)
from facetlog.perception.flat_faces import cross
from facetlog.perception.polygons import find_intersection, make_polygon
from facetlog.perception.types import FloatArray

# Two faces stand opposite each other where so much of the smaller does.
OPPOSITE_SHARE = 0.5


@dataclass(frozen=True, eq=False, slots=True)
class BoardPlaces:
    """Outlines `rings` (t, 4, 3) of boards, counter-clockwise from above, about a pixel apart.

    Their first and third sides are free, the other two lie on faces; `pair` (t,) numbers the two
    faces that they lie between. Those of one pair follow one another from below.
    """

    rings: FloatArray
    pair: NDArray[np.intp]

    @property
    def free_sides(self) -> FloatArray:
        """The two free sides (t, 2, 2, 3) of each."""
        return np.stack([self.rings[:, :2], self.rings[:, 2:]], axis=1)


def board_places(
    faces: Sequence[OutlinedFace], up: FloatArray, pixel: float, least: float
) -> BoardPlaces:
    """Return the places between each two of the faces; `up` (3,) is across what is level.

    As deep as the lower, or the less deep, of the two faces. `least` is how far apart they are at
    least, and how deep a board. Two sides of one board make no places of their own.
    """
    found: list[FloatArray] = []
    upright = [face for face in faces if abs(face.normal @ up) < UPRIGHT_SINE]
    for rings in _list_opposite_pairs(upright, up, pixel, least):
        if not any(_same(rings, known, least) for known in found):
            found.append(rings)
    if not found:
        return BoardPlaces(np.zeros((0, 4, 3)), np.zeros(0, np.intp))
    return BoardPlaces(
        np.concatenate(found), np.repeat(np.arange(len(found)), [len(rings) for rings in found])
    )


def _list_opposite_pairs(
    upright: Sequence[OutlinedFace], up: FloatArray, pixel: float, least: float
) -> Iterator[FloatArray]:
    for one, other in combinations(upright, 2):
        cosine = float(one.normal @ other.normal)
        if abs(cosine) < PARALLEL_COSINE:
            continue
        across = one.normal + np.sign(cosine) * other.normal
        across = across - (across @ up) * up
        across = across / np.linalg.norm(across)
        apart = float((other.corners.mean(axis=0) - one.corners.mean(axis=0)) @ across)
        if abs(apart) < least:
            continue
        across = np.sign(apart) * across
        deep = cross(up, across)
        flat = np.stack([deep, up], axis=1)
        drawn = [make_polygon(face.corners @ flat) for face in (one, other)]
        both = find_intersection(*drawn)
        if both.area < OPPOSITE_SHARE * min(polygon.area for polygon in drawn):
            continue
        low, high, heights = _chords(both, pixel, least)
        if not len(heights):
            continue
        corners = [
            _on_plane(face, across, where[:, None] * deep + heights[:, None] * up)
            for face, where in ((one, low), (other, low), (other, high), (one, high))
        ]
        yield np.stack(corners, axis=1)


def _chords(region: shapely.Geometry, pixel: float, least: float) -> FloatArray:
    # From where to where a region of the plane reaches, and at which heights: (3, n).
    if region.is_empty:
        return np.zeros((3, 0))
    left, bottom, right, top = region.bounds
    # Clear of both ends, where rounding would decide.
    count = max(round((top - bottom) / pixel), 1)
    heights = bottom + (np.arange(count) + 0.5) * (top - bottom) / count
    lines = shapely.linestrings([[(left - pixel, h), (right + pixel, h)] for h in heights])
    cut = shapely.bounds(find_intersection(region, lines))
    chords = np.stack([cut[:, 0], cut[:, 2], heights])
    # Of no chord the bounds are NaN.
    return np.asarray(chords[:, chords[1] - chords[0] >= least])


def _on_plane(face: OutlinedFace, way: FloatArray, points: FloatArray) -> FloatArray:
    # Where lines from points (n, 3) along a way (3,) meet the plane of a face.
    ahead = (face.corners.mean(axis=0) - points) @ face.normal / (way @ face.normal)
    return np.asarray(points + ahead[:, None] * way)


def _same(rings: FloatArray, others: FloatArray, near: float) -> bool:
    # Whether the lowest and the highest of some places are those of others.
    ends, known = rings[[0, -1]], others[[0, -1]]
    turned = np.roll(known, 2, axis=1)
    return bool(
        any((np.linalg.norm(ends - those, axis=2) < near).all() for those in (known, turned))
    )
