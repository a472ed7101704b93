"""Large planes of a mesh that lie across a known direction, whatever its triangles are joined to.

A scanned floor and what stands on it are one surface, and rough: no edge bends where the floor
ends, and no two triangles are in one plane. So a plane begins where most surface is at one height
(the half-sample mode), and grows by its own roughness.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.ragged import Indices
from facetlog.perception.shapes.meshes.clean_mesh import RESOLUTION, Surface
from facetlog.perception.shapes.meshes.surface_fit import Moments
from facetlog.perception.types import FloatArray

__all__ = ["LargePlane", "iter_planes"]

# Triangles within 20 degrees of the direction lie across it (cosine).
ACROSS = float(np.cos(np.deg2rad(20.0)))
# A plane has this share of all surface that lies across the direction, ...
LEAST_SHARE = 0.1
# ... and begins with so much of it.
CORE_SHARE = 0.05
# 99.7 % of a rough plane's corners are within so many times their rms from it.
SDS = 3.0
# A plane that begins with 5 % of its surface has grown to all of it after so many steps of √3.
MOST_STEPS = 20
MOST_PLANES = 6


@dataclass(frozen=True, eq=False, slots=True)
class LargePlane:
    """The plane n · x = offset, n along the direction that was given, and how far its own surface
    departs from it (3 rms of its corners). `triangles` (m,) are those that lie in it.
    """

    normal: FloatArray
    offset: float
    slack: float
    triangles: NDArray[np.bool_]

    def heights(self, points: FloatArray) -> FloatArray:
        """Distances (n,) of points (n, 3) from the plane, along its normal."""
        heights: FloatArray = points @ self.normal - self.offset
        return heights


def iter_planes(
    surface: Surface, direction: FloatArray, within: NDArray[np.bool_] | None = None
) -> Iterator[LargePlane]:
    """The large planes across a unit vector (3,), those with most surface first; of the triangles
    (m,) `within`, else of all.
    """
    across = np.abs(surface.normals @ direction) >= ACROSS
    if within is not None:
        across &= within
    rows = np.flatnonzero(across)
    total = float(surface.areas[rows].sum())
    for _ in range(MOST_PLANES):
        if not surface.areas[rows].sum() > LEAST_SHARE * total:
            return
        heights = surface.corners[rows].mean(axis=1) @ direction
        core = rows[_mode(heights, surface.areas[rows], CORE_SHARE * total)]
        plane = _grown(surface, rows, core, direction)
        if float(surface.areas[rows[plane.triangles[rows]]].sum()) >= LEAST_SHARE * total:
            yield plane
        taken = plane.triangles.copy()
        taken[core] = True
        rows = rows[~taken[rows]]


def _mode(heights: FloatArray, weights: FloatArray, least: float) -> Indices:
    """Where heights (n,) are densest: the indices of those within the shortest interval that holds
    half of all weight, and half of that, until no more than `least` is left.
    """
    order = np.argsort(heights, kind="stable")
    while True:
        sums = np.concatenate(([0.0], np.cumsum(weights[order])))
        half = 0.5 * sums[-1]
        if half < least or len(order) < 2:
            return order.astype(np.int64)
        last = np.searchsorted(sums, sums[:-1] + half * (1.0 - 1e-9))
        fits = np.flatnonzero(last < len(sums))
        widths = heights[order[last[fits] - 1]] - heights[order[fits]]
        best = int(fits[int(np.argmin(widths))])
        if int(last[best]) - best == len(order):
            return order.astype(np.int64)
        order = order[best : int(last[best])]


def _grown(surface: Surface, rows: Indices, core: Indices, direction: FloatArray) -> LargePlane:
    """The plane of the core, and of all else of these rows that is within its roughness."""
    corners = surface.corners[rows]
    least = RESOLUTION * surface.size
    inside = core
    for _ in range(MOST_STEPS):
        fits = Moments.of(surface, inside, np.zeros(len(inside), dtype=np.int64), 1).fits()
        normal = fits.normals[0]
        normal = normal if float(normal @ direction) > 0.0 else -normal
        offset = float(normal @ fits.middles[0])
        # of corners: between them a rough surface is nearer to its plane
        off = surface.corners[inside] @ normal - offset
        rms = np.sqrt(np.average((off**2).mean(axis=1), weights=surface.areas[inside]))
        slack = max(SDS * float(rms), least)
        found = rows[(np.abs(corners @ normal - offset) <= slack).all(axis=1)]
        if len(found) == len(inside) or not len(found):
            break
        inside = found
    triangles = np.zeros(len(surface.triangles), dtype=bool)
    triangles[inside] = True
    return LargePlane(normal, offset, slack, triangles)
