"""Faces that contradict each other (they overlap in one plane, or one occludes what is seen), and
which touch."""

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import plane_basis
from facetlog.perception.polygons import find_intersection, find_union, make_polygon
from facetlog.perception.types import FloatArray

# Within ten degrees faces count as in one plane or opposite each other, and one as upright.
PARALLEL_COSINE, UPRIGHT_SINE = float(np.cos(np.radians(10.0))), float(np.sin(np.radians(10.0)))
# Overlap of two coplanar faces, as a share of the smaller.
MAX_OVERLAP = 0.15
# Two outlines of one plane are alike from this intersection over union on.
ALIKE = 0.85
# Share of the sight lines to what was seen that a face may block.
MAX_BLOCKED = 0.25


def overlap(
    corners: FloatArray,
    normal: FloatArray,
    others: FloatArray,
    other_normal: FloatArray,
    near: float,
) -> bool:
    """Return whether a polygon (k, 3) covers part of another (l, 3) of nearly the same plane."""
    if abs(normal @ other_normal) < PARALLEL_COSINE:
        return False
    apart = np.abs((corners - others.mean(axis=0)) @ other_normal)
    if apart.min() > near:
        return False
    a, b = _in_plane(corners, other_normal), _in_plane(others, other_normal)
    return bool(find_intersection(a, b).area > MAX_OVERLAP * min(a.area, b.area))


def back_to_back(
    corners: FloatArray,
    normal: FloatArray,
    others: FloatArray,
    other_normal: FloatArray,
    known: float,
) -> bool:
    """Return whether two polygons (k, 3), (l, 3) of one plane may be the sides of a board.

    They face away from each other, and neither lies before the other; planes are `known` so well.
    """
    before = (corners - others.mean(axis=0)) @ other_normal
    return bool(normal @ other_normal < 0 and before.mean() < known)


def alike(one: FloatArray, other: FloatArray, normal: FloatArray) -> bool:
    """Return whether two polygons (k, 3) of one plane cover nearly the same of it."""
    a, b = _in_plane(one, normal), _in_plane(other, normal)
    return bool(find_intersection(a, b).area > ALIKE * find_union([a, b]).area)


def blocked(
    corners: FloatArray,
    normal: FloatArray,
    targets: FloatArray,
    centres: FloatArray,
    margin: float = 0.0,
    holes: Sequence[FloatArray] = (),
) -> NDArray[np.bool_]:
    """Return which sight lines (c, s) from centres (c, 3) to targets (s, 3) a polygon (k, 3)
    blocks.

    Not blocked are lines that pass within `margin` of its outline, end within `margin` of its
    plane, or go through one of its `holes` (m, 3).
    """
    offset = normal @ corners.mean(axis=0)
    before = centres @ normal - offset  # (c,)
    behind = targets @ normal - offset  # (s,)
    crosses: NDArray[np.bool_] = (before[:, None] * behind < 0) & (np.abs(behind) > margin)
    if not crosses.any():
        return crosses
    t = before[:, None] / np.where(crosses, before[:, None] - behind, 1.0)
    at = centres[:, None] + t[..., None] * (targets - centres[:, None])
    crosses &= _well_within(corners, normal, at, margin, holes)
    return crosses


def touch(one: FloatArray, other: FloatArray, near: float) -> bool:
    """Return whether a corner of one of two polygons (k, 3), (l, 3) lies nearer than that to the
    other's sides.
    """
    return bool(min(_from_sides(one, other), _from_sides(other, one)) < near)


def _from_sides(points: FloatArray, corners: FloatArray) -> float:
    # How near the nearest of the points (n, 3) is to a side of a polygon (k, 3).
    along = np.roll(corners, -1, axis=0) - corners
    off = points[:, None] - corners
    square = np.maximum((along**2).sum(axis=1), np.finfo(np.float64).tiny)
    share = np.clip((off * along).sum(axis=2) / square, 0.0, 1.0)
    return float(np.linalg.norm(off - share[..., None] * along, axis=2).min())


def find_points_within(
    rings: Sequence[FloatArray], normal: FloatArray, points: FloatArray
) -> NDArray[np.bool_]:
    """Return which points (n, 3) of a plane lie within one of its polygons (k, 3)."""
    within = np.zeros(len(points), dtype=np.bool_)
    for ring in rings:
        within |= _well_within(ring, normal, points, 0.0)
    return within


def _in_plane(
    corners: FloatArray, normal: FloatArray, holes: Sequence[FloatArray] = ()
) -> shapely.Geometry:
    basis = plane_basis(normal)
    return make_polygon(corners @ basis, [hole @ basis for hole in holes])


def _well_within(
    corners: FloatArray,
    normal: FloatArray,
    points: FloatArray,
    margin: float,
    holes: Sequence[FloatArray] = (),
) -> NDArray[np.bool_]:
    # Which points (..., 3), seen across it, lie in a polygon (k, 3) farther than `margin` from its
    # outline and its `holes` (m, 3).
    inner = _in_plane(corners, normal, holes).buffer(-margin)
    shapely.prepare(inner)
    flat = points @ plane_basis(normal)
    within: NDArray[np.bool_] = shapely.contains_xy(inner, flat[..., 0], flat[..., 1])
    return within
