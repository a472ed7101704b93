"""Sides of an outline that are also sides of a face found before.

Two faces that meet show an edge between them only where their shades differ, which those of a
thing of one colour in the shade often do not. A missing edge says nothing there; anywhere else a
face ends in the air, and its edge stands before what lies behind.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.planes.outlined_face import OutlinedFace
from facetlog.perception.flat_faces import make_ring_sides
from facetlog.perception.types import FloatArray

# What meets at a smaller angle is one surface, and the two sides of a board have no side in common.
LEAST_TURN_COSINE = float(np.cos(np.radians(30.0)))


def joined_sides(normal: FloatArray, faces: Iterable[OutlinedFace]) -> FloatArray:
    """Return the sides (n, 2, 3) of the faces that a plane of that normal (3,) may meet."""
    sides = [
        make_ring_sides(face.corners)
        for face in faces
        if abs(normal @ face.normal) < LEAST_TURN_COSINE
    ]
    return np.concatenate(sides) if sides else np.zeros((0, 2, 3))


def find_points_on_segments(
    points: FloatArray, segments: FloatArray, near: float
) -> NDArray[np.bool_]:
    """Return which points (..., 3) are nearer than that to one of the segments (n, 2, 3).

    >>> level = np.array([[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]])
    >>> find_points_on_segments(np.array([[1.0, 0.1, 0.0], [3.0, 0.0, 0.0]]), level, 0.5)
    array([ True, False])
    """
    if not len(segments):
        return np.zeros(points.shape[:-1], dtype=np.bool_)
    along = segments[:, 1] - segments[:, 0]
    off = points[..., None, :] - segments[:, 0]
    square = np.maximum((along**2).sum(axis=-1), np.finfo(np.float64).tiny)
    share = np.clip((off * along).sum(axis=-1) / square, 0.0, 1.0)
    away = np.linalg.norm(off - share[..., None] * along, axis=-1)
    close: NDArray[np.bool_] = (away < near).any(axis=-1)
    return close
