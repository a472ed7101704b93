"""Things taken off the floor and the walls that they were one surface with, and closed there.

What a scanner sees of a box on a floor is one surface, which has no bottom. Where the floor is
taken away the box is left open; it stood on the floor, so its outline there is its bottom.
"""

from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.polygons import find_enclosed_area, triangulate
from facetlog.perception.ragged import Indices, by_group, joined
from facetlog.perception.shapes.meshes.clean_mesh import RESOLUTION, Surface, rebuilt
from facetlog.perception.shapes.meshes.mesh_planes import LargePlane
from facetlog.perception.types import FloatArray

__all__ = ["cut_off"]

# What borders on a rough plane is within so many of its roughnesses.
NEAR_SLACKS = 3.0


def cut_off(
    surface: Surface, taken: NDArray[np.bool_], planes: tuple[LargePlane, ...]
) -> tuple[Surface, NDArray[np.bool_]]:
    """The surface with the triangles `taken` (m,) apart from the others, those closed in the planes
    where they were cut; and which triangles of that are taken.
    """
    cut = _cut_edges(surface, taken)
    if not len(cut):
        return surface, taken
    surface, caps = _capped(surface, ~taken, cut, planes)
    # the taken ones get corners of their own
    names, place = np.unique(surface.triangles[taken], return_inverse=True)
    triangles = surface.triangles.copy()
    triangles[taken] = len(surface.points) + place.reshape(-1, 3)
    apart = replace(surface, points=np.concatenate([surface.points, surface.points[names]]))
    closed = rebuilt(apart, np.concatenate([triangles, caps]))
    return closed, np.concatenate([taken, np.zeros(len(caps), dtype=bool)])


def _cut_edges(surface: Surface, taken: NDArray[np.bool_]) -> Indices:
    """Edges (k, 2) that one triangle of the others has, and one that is taken."""
    own, other = (_edges(surface.triangles[rows]) for rows in (~taken, taken))
    count = len(surface.points)
    key, uses = np.unique(own[:, 0] * count + own[:, 1], return_counts=True)
    cut = key[(uses == 1) & np.isin(key, other[:, 0] * count + other[:, 1])]
    return np.column_stack([cut // count, cut % count])


def _edges(triangles: Indices) -> Indices:
    """The edges (3 m, 2) of triangles, the lower end first."""
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return np.sort(pairs, axis=1)


def _capped(
    surface: Surface, left: NDArray[np.bool_], cut: Indices, planes: tuple[LargePlane, ...]
) -> tuple[Surface, Indices]:
    """The surface with its cut edges moved onto the planes, and triangles (k, 3) that close each
    piece of what is left there.
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
            _cap(points, cut[on][rows], plane.normal) for rows in by_group(groups[cut[on, 0]])
        )
    return replace(surface, points=points), np.concatenate(found)


def _cap(points: FloatArray, edges: Indices, normal: FloatArray) -> Indices:
    """Triangles (k, 3) over the loops that edges (e, 2) make across a plane's normal."""
    names, place = np.unique(edges, return_inverse=True)
    place = place.reshape(-1, 2)
    # a chain that ends at two other planes is closed along the line where these meet
    ends = np.flatnonzero(np.bincount(place.ravel(), minlength=len(names)) % 2 == 1)
    if len(ends) == 2:
        place = np.concatenate([place, ends[None]])
    flat = points[names] @ plane_axes(normal, np.eye(3)[int(np.argmin(np.abs(normal)))]).T
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
