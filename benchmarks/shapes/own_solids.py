"""Solids as meshes, and what people's meshes do to them: what our own shapes are put together of.

All are `trimesh.Trimesh` with z upwards. Boards and bars that touch overlap or share a face, as in
models drawn by hand; nothing is merged.
"""

from collections.abc import Sequence

import numpy as np
import shapely
import trimesh
from numpy.typing import ArrayLike

from facetlog.perception.types import FloatArray

BALL_SUBDIVISIONS = 2  # 162 corners of a rounded block's edges' balls


def block(low: Sequence[float], high: Sequence[float]) -> trimesh.Trimesh:
    """Return a cuboid from its lowest to its highest corner."""
    return trimesh.creation.box(bounds=[low, high])


def bar(
    start: ArrayLike, end: ArrayLike, radius: float, *, sections: int = 16, square: bool = False
) -> trimesh.Trimesh:
    """Return a round bar from one point to another, or a square one that is 2 `radius` thick."""
    if not square:
        return trimesh.creation.cylinder(
            radius, segment=np.array([start, end], dtype=np.float64), sections=sections
        )
    a, b = (np.asarray(p, dtype=np.float64) for p in (start, end))
    across = np.array([[1.0, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]]) * radius
    return hull(np.concatenate([a + across, b + across]))


def hull(points: ArrayLike) -> trimesh.Trimesh:
    """Return the convex hull of points (n, 3)."""
    return trimesh.convex.convex_hull(np.asarray(points, dtype=np.float64))


def rectangle(low: Sequence[float], high: Sequence[float]) -> shapely.Polygon:
    """Return an upright rectangle of a plan."""
    return shapely.box(low[0], low[1], high[0], high[1])


def extruded(plan: shapely.Polygon, low: float, high: float) -> trimesh.Trimesh:
    """Return the prism over a polygon, which may have holes, between two heights; closed."""
    plan = _ccw(plan)
    rings = [plan.exterior, *plan.interiors]
    flat = [shapely.get_coordinates(ring)[:-1] for ring in rings]
    corners = np.concatenate(flat)
    number = {tuple(xy): i for i, xy in enumerate(corners.tolist())}
    caps = [
        [number[tuple(xy)] for xy in shapely.get_coordinates(_ccw(t))[:-1].tolist()]
        for t in shapely.get_parts(shapely.constrained_delaunay_triangles(plan))
    ]
    count, first = len(corners), 0
    triangles = [*([a, c, b] for a, b, c in caps), *([count + i for i in cap] for cap in caps)]
    for ring in flat:
        following = np.roll(np.arange(len(ring)), -1)
        for i, j in zip(range(len(ring)), following.tolist(), strict=True):
            a, b = first + i, first + j
            triangles += [[a, b, count + b], [a, count + b, count + a]]
        first += len(ring)
    levels = [np.column_stack([corners, np.full(count, z)]) for z in (low, high)]
    return trimesh.Trimesh(np.concatenate(levels), triangles, process=False)


def _ccw(polygon: shapely.Polygon) -> shapely.Polygon:
    return shapely.geometry.polygon.orient(polygon)


def make_ring_points(radius: float, count: int, height: float, *, phase: float = 0.0) -> FloatArray:
    """Return points (count, 3) evenly round a level circle."""
    turn = phase + 2.0 * np.pi * np.arange(count) / count
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(count, height)])


def make_rounded_block(size: ArrayLike, radius: float) -> trimesh.Trimesh:
    """Return a cuboid of that size with its low corner at 0, its edges rounded off."""
    extent = np.asarray(size, dtype=np.float64)
    ball = trimesh.creation.icosphere(BALL_SUBDIVISIONS, radius).vertices
    corners = np.array(np.meshgrid(*([radius, e - radius] for e in extent))).reshape(3, -1).T
    return hull((corners[:, None] + ball).reshape(-1, 3))


def tapered(size: ArrayLike, cut: float) -> trimesh.Trimesh:
    """Return a cuboid of that size with its low corner at 0, its edges cut off at 45 degrees."""
    extent = np.asarray(size, dtype=np.float64)
    points = []
    for axis in range(3):
        steps = [[cut, e - cut] for e in extent]
        steps[axis] = [0.0, float(extent[axis])]
        points.append(np.array(np.meshgrid(*steps)).reshape(3, -1).T)
    return hull(np.concatenate(points))


def joined(*parts: trimesh.Trimesh) -> trimesh.Trimesh:
    """Return all parts in one mesh, as they are."""
    return trimesh.util.concatenate(list(parts))


def moved(part: trimesh.Trimesh, by: Sequence[float]) -> trimesh.Trimesh:
    """Return a part elsewhere."""
    return trimesh.Trimesh(
        part.vertices + np.asarray(by, dtype=np.float64), part.faces, process=False
    )
