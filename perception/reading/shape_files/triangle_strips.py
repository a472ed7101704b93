"""Triangles of strips and fans of vertices, as PLY, glTF and COLLADA write them."""

from collections.abc import Sequence

import numpy as np

from facetlog.perception.grouped import Indices

__all__ = ["fan_triangles", "strip_triangles"]


def strip_triangles(corners: Sequence[int] | Indices) -> Indices:
    """Return the triangles (n - 2, 3) of a strip; every other one is turned round.

    >>> strip_triangles([0, 1, 2, 3]).tolist()
    [[0, 1, 2], [2, 1, 3]]
    """
    strip = np.asarray(corners, dtype=np.int64)
    triangles = np.stack((strip[:-2], strip[1:-1], strip[2:]), axis=1) if len(strip) > 2 else None
    if triangles is None:
        return np.zeros((0, 3), dtype=np.int64)
    triangles[1::2, :2] = triangles[1::2, 1::-1]
    return triangles


def fan_triangles(corners: Sequence[int] | Indices) -> Indices:
    """Return the triangles (n - 2, 3) round the first corner.

    >>> fan_triangles([4, 5, 6, 7]).tolist()
    [[4, 5, 6], [4, 6, 7]]
    """
    fan = np.asarray(corners, dtype=np.int64)
    if len(fan) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    return np.stack((np.full(len(fan) - 2, fan[0]), fan[1:-1], fan[2:]), axis=1)
