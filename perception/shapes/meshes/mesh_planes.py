"""Large planes of a mesh that lie across a known direction, whatever its triangles are joined to.

A scanned floor and what stands on it are one surface, and rough: no edge bends where the floor
ends, and no two triangles are in one plane. So a plane begins where most surface is at one height
(the half-sample mode), and grows by its own roughness.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.polygons import find_enclosed_area, triangulate
from facetlog.perception.ragged import Indices, iter_groups, joined
from facetlog.perception.shapes.meshes.clean_mesh import RESOLUTION, Surface, rebuild_surface
from facetlog.perception.shapes.meshes.surface_fit import Moments
from facetlog.perception.types import FloatArray

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

    def flipped(self) -> "LargePlane":
        """Return the plane with the opposite normal."""
        return LargePlane(-self.normal, -self.offset, self.slack, self.triangles)

    def heights(self, points: FloatArray) -> FloatArray:
        """Return distances (n,) of points (n, 3) from the plane, along its normal."""
        heights: FloatArray = points @ self.normal - self.offset
        return heights


def iter_planes(
    surface: Surface, direction: FloatArray, within: NDArray[np.bool_] | None = None
) -> Iterator[LargePlane]:
    """Yield the large planes across a unit vector (3,), those with most surface first; of the
    triangles (m,) `within`, else of all.
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
        core = rows[_find_mode(heights, surface.areas[rows], CORE_SHARE * total)]
        plane = _grown(surface, rows, core, direction)
        if float(surface.areas[rows[plane.triangles[rows]]].sum()) >= LEAST_SHARE * total:
            yield plane
        taken = plane.triangles.copy()
        taken[core] = True
        rows = rows[~taken[rows]]


def _find_mode(heights: FloatArray, weights: FloatArray, least: float) -> Indices:
    """Return where heights (n,) are densest: the indices of those within the shortest interval that
    holds half of all weight, and half of that, until no more than `least` is left.
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
    """Return the plane of the core, and of all else of these rows that is within its roughness."""
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


# What a scanner sees of a box on a floor is one surface, which has no bottom. Where the floor is
# taken away the box is left open; it stood on the floor, so its outline there is its bottom.

# What borders on a rough plane is within so many of its roughnesses.
NEAR_SLACKS = 3.0


def cut_off(
    surface: Surface, taken: NDArray[np.bool_], planes: tuple[LargePlane, ...]
) -> tuple[Surface, NDArray[np.bool_]]:
    """Return the surface with the triangles `taken` (m,) apart from the others, those closed in the
    planes where they were cut; and which triangles of that are taken.
    """
    cut = _cut_edges(surface, taken)
    if not len(cut):
        return surface, taken
    surface, caps = _close_cuts(surface, ~taken, cut, planes)
    # the taken ones get corners of their own
    names, place = np.unique(surface.triangles[taken], return_inverse=True)
    triangles = surface.triangles.copy()
    triangles[taken] = len(surface.points) + place.reshape(-1, 3)
    apart = replace(surface, points=np.concatenate([surface.points, surface.points[names]]))
    closed = rebuild_surface(apart, np.concatenate([triangles, caps]))
    return closed, np.concatenate([taken, np.zeros(len(caps), dtype=bool)])


def _cut_edges(surface: Surface, taken: NDArray[np.bool_]) -> Indices:
    """Return edges (k, 2) that one triangle of the others has, and one that is taken."""
    own, other = (_edges(surface.triangles[rows]) for rows in (~taken, taken))
    count = len(surface.points)
    key, uses = np.unique(own[:, 0] * count + own[:, 1], return_counts=True)
    cut = key[(uses == 1) & np.isin(key, other[:, 0] * count + other[:, 1])]
    return np.column_stack([cut // count, cut % count])


def _edges(triangles: Indices) -> Indices:
    """Return the edges (3 m, 2) of triangles, the lower end first."""
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return np.sort(pairs, axis=1)


def _close_cuts(
    surface: Surface, left: NDArray[np.bool_], cut: Indices, planes: tuple[LargePlane, ...]
) -> tuple[Surface, Indices]:
    """Return the surface with its cut edges moved onto the planes, and triangles (k, 3) that close
    each piece of what is left there.
    """
    points = surface.points.copy()
    own = surface.triangles[left]
    groups = joined(len(surface.points), np.concatenate((own[:, :2], own[:, 1:])))[1]
    found = [np.zeros((0, 3), dtype=np.int64)]
    for plane in planes:
        slack = max(NEAR_SLACKS * plane.slack, RESOLUTION * surface.size)
        on = (np.abs(plane.heights(points[cut])) <= slack).all(axis=1)
        rim = np.unique(cut[on])
        points[rim] -= np.outer(plane.heights(points[rim]), plane.normal)
        found += (
            _make_cap(points, cut[on][rows], plane.normal)
            for rows in iter_groups(groups[cut[on, 0]])
        )
    return replace(surface, points=points), np.concatenate(found)


def _make_cap(points: FloatArray, edges: Indices, normal: FloatArray) -> Indices:
    """Return triangles (k, 3) over the loops that edges (e, 2) make across a plane's normal."""
    names, place = np.unique(edges, return_inverse=True)
    place = place.reshape(-1, 2)
    # a chain that ends at two other planes is closed along the line where these meet
    ends = np.flatnonzero(np.bincount(place.ravel(), minlength=len(names)) % 2 == 1)
    if len(ends) == 2:
        place = np.concatenate([place, ends[None]])
    flat = points[names] @ make_plane_axes(normal, np.eye(3)[int(np.argmin(np.abs(normal)))]).T
    # rough loops cross themselves where they are looked at along the normal
    noded = shapely.get_parts(shapely.node(shapely.multilinestrings(flat[place])))
    area = find_enclosed_area(np.array([line.coords for line in noded]))
    if area is None or area.is_empty:
        return np.zeros((0, 3), dtype=np.int64)
    corners = triangulate(area).reshape(-1, 2)
    nearest = np.asarray(cKDTree(flat).query(corners)[1]).reshape(-1, 3)
    a, b, c = nearest.T
    triangles: Indices = names[nearest[(a != b) & (b != c) & (c != a)]].astype(np.int64)
    return triangles
