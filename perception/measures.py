"""What one face measures, and what it measures against its thing; each with its 1σ.

Standard deviations are first-order, from the covariances of vertices and planes, which are taken
as independent of each other. Lengths are in the scene's unit, areas in its square.
"""

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from facetlog.perception.flat_faces import (
    Estimate,
    FlatFace,
    area_gradient,
    hull_indices,
    plane_axes,
    vector_area,
    vertex_sd,
)
from facetlog.perception.tolerance import Tolerance
from facetlog.perception.types import FloatArray, Plane

__all__ = [
    "FaceSize",
    "distances",
    "face_size",
    "least_rectangle",
    "outer_members",
    "protrusion",
    "share",
    "thing_box",
    "tilt_sd",
]

# Rectangles this much larger than the least one count as equal, and the longest of them is taken:
# all three round a triangle are of one size, and rounding must not choose. A 1 % difference in
# area is what an error of 0.5 % in each side gives.
RECTANGLE_TIE = 0.01
# Faces this close in area count as equally large; well below any measuring error.
AREA_TIE = 1e-6
# In 3-D, hulls of fewer points than this are not worth Qhull's call.
FEW_POINTS = 20


@dataclass(frozen=True, slots=True)
class FaceSize:
    """Area without holes, sides of the least rectangle round the outline, and area over its."""

    area: Estimate
    length: Estimate
    width: Estimate
    fill: Estimate


def _sides(flat: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Unit directions (m, 2) of the hull's sides, and the extents along and across each (m,)."""
    hull = hull_indices(flat)
    corners = flat[hull]
    sides = np.concatenate((corners[1:], corners[:1])) - corners
    lengths = np.sqrt((sides * sides).sum(axis=1))
    directions = sides[lengths > 0.0] / lengths[lengths > 0.0, None]
    if not len(directions):
        directions = np.array([[1.0, 0.0]])
    across = directions @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    along, aside = corners @ directions.T, corners @ across.T
    return (
        directions,
        along.max(axis=0) - along.min(axis=0),
        aside.max(axis=0) - aside.min(axis=0),
    )


def least_rectangle(flat: FloatArray) -> tuple[FloatArray, float, float]:
    """Direction (2,) of the longer side, and both sides, of the least rectangle round (n, 2).

    Of the rectangles with a side on the hull and within 1 % of the least area, it is the longest.
    """
    directions, along, across = _sides(flat)
    size = along * across
    long = np.where(size <= size.min() * (1.0 + RECTANGLE_TIE), np.maximum(along, across), -1.0)
    best = int(np.argmax(long))
    direction = directions[best]
    if along[best] < across[best]:
        return np.array([-direction[1], direction[0]]), float(across[best]), float(along[best])
    return direction, float(along[best]), float(across[best])


def _extent(
    face: FlatFace, flat: FloatArray, direction: FloatArray, tolerance: Tolerance
) -> tuple[float, FloatArray]:
    """Extent of the outline along a direction (2,), which is held, and its gradient (m, 3).

    It runs from the mean of the lowest vertices to that of the highest, by 3 sd.
    """
    outline = np.array(face.outline, dtype=np.intp)
    reach = flat @ direction
    weights = np.zeros(len(face.members))
    for sign in (1.0, -1.0):
        equal = tolerance.highest(outline, sign * reach)
        weights[equal] += sign / len(equal)
    return float(weights[: len(outline)] @ reach), np.outer(weights, direction @ face.axes)


def face_size(
    face: FlatFace, points: FloatArray, covs: FloatArray, tolerance: Tolerance
) -> FaceSize:
    """Area, length, width and fill of a face; vertices are `points` (n, 3), `covs` (n, 3, 3)."""
    own = covs[list(face.members)]
    flat = face.flatten(points[list(face.outline)])
    direction, _, _ = least_rectangle(flat)
    across = np.array([-direction[1], direction[0]])
    length, length_slope = _extent(face, flat, direction, tolerance)
    width, width_slope = _extent(face, flat, across, tolerance)
    if length * width > 0.0:
        # R = A / (l w):  dR = dA / (l w) - R (dl / l + dw / w)
        fill = face.area / (length * width)
        slope = face.area_slope / (length * width)
        slope -= fill * (length_slope / length + width_slope / width)
        filled = Estimate(min(fill, 1.0), vertex_sd(slope, own))
    else:
        filled = Estimate(0.0, 1.0)
    sides = sorted(
        (
            Estimate(length, vertex_sd(length_slope, own)),
            Estimate(width, vertex_sd(width_slope, own)),
        )
    )
    area = Estimate(face.area, vertex_sd(face.area_slope, own))
    return FaceSize(area, sides[1], sides[0], filled)


def tilt_sd(plane: Plane) -> float:
    """Worst 1σ tilt of the normal, in radians: the largest root of its covariance."""
    return float(np.sqrt(max(float(np.linalg.eigvalsh(plane.cov[:3, :3])[-1]), 0.0)))


def distances(plane: Plane, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Signed distances (n,) of points (n, 3) from a plane, and what the plane adds to their 1σ.

    d = n · p + offset, so var d = (p, 1) C (p, 1)ᵀ with the plane's covariance C.
    """
    levers = np.column_stack([points, np.ones(len(points))])
    variance = np.einsum("ni,ij,nj->n", levers, plane.cov, levers)
    return plane.distance(points), np.sqrt(np.maximum(variance, 0.0))


def _without(vertices: NDArray[np.intp], face: FlatFace) -> NDArray[np.intp]:
    own = set(face.members)
    return np.array([i for i in vertices.tolist() if i not in own], dtype=np.intp)


def protrusion(
    face: FlatFace,
    plane: Plane,
    others: NDArray[np.intp],
    points: FloatArray,
    covs: FloatArray,
    tolerance: Tolerance,
) -> Estimate:
    """How far the vertices `others` (indices) of the face's thing reach in front of its plane."""
    outside = _without(others, face)
    if not len(outside):
        return Estimate(0.0, float(distances(plane, face.middle[None])[1][0]))
    farthest = outside[tolerance.highest(outside, plane.distance(points[outside]))]
    middle = points[farthest].mean(axis=0)
    signed, plane_sd = distances(plane, middle[None])
    own = plane.normal @ covs[farthest].sum(axis=0) @ plane.normal / len(farthest) ** 2
    sd = float(np.sqrt(plane_sd[0] ** 2 + max(float(own), 0.0)))
    return Estimate(max(float(signed[0]), 0.0), sd)


def outer_members(members: NDArray[np.intp], points: FloatArray) -> NDArray[np.intp]:
    """Those of a thing's vertices that lie on its convex hull: no silhouette needs the others."""
    if len(members) > FEW_POINTS:
        try:
            corners: NDArray[np.intp] = members[ConvexHull(points[members]).vertices]
        except QhullError:  # all in one plane
            return members
        return corners
    return members


def share(
    face: FlatFace,
    plane: Plane,
    outer: NDArray[np.intp],
    points: FloatArray,
    covs: FloatArray,
    tolerance: Tolerance,
) -> Estimate:
    """Area of the face over the silhouette of its thing along the face's normal, 0..1.

    The silhouette is the convex hull of the thing's vertices, loose edges' ends too, projected
    along the normal. So it does not ask which faces were seen: each face of a block has 1, even
    if its back is unknown, and a table's rim has little, because the legs reach far down, whether
    they are faces or mere edges. Holes count as silhouette, and a hollow (an L's notch) as well.
    With A = n · S, S = ½ Σ pi × pi+1 over the hull: ∂A/∂n = S, across the normal.
    """
    others = _without(outer, face)
    # What shows within 3 sd of the face does not reach beyond it: vertices stacked along the
    # normal would otherwise each push the silhouette out by their noise.
    depth = plane.distance(points[others])
    own = tolerance.vertex_sds[list(face.outline)].max()
    sds = np.hypot(np.hypot(tolerance.vertex_sds[others], own), tilt_sd(plane) * depth)
    dots = shapely.points(face.flatten(points[others]))
    beyond = shapely.distance(dots, face.polygon) > tolerance.within(sds)
    candidates = np.concatenate([np.array(face.members, dtype=np.intp), others[beyond]])
    where = points[candidates]
    flat = face.flatten(where)
    corners = flat[hull_indices(flat, tolerance.finest)]
    # Vertices stacked along the normal make one corner together: their mean.
    gaps = corners[:, None] - flat
    stacked = ((gaps * gaps).sum(axis=2) <= tolerance.finest**2).astype(np.float64)
    stacked /= stacked.sum(axis=1, keepdims=True)
    loop = stacked @ where
    vector = vector_area(loop)
    silhouette = float(vector @ face.normal)
    if silhouette <= 0.0:
        return Estimate(0.0, 1.0)
    # R = A / H:  dR = (dA - R dH) / H
    ratio = face.area / silhouette
    slope = -ratio * (stacked.T @ area_gradient(loop, face.normal))
    slope[: len(face.members)] += face.area_slope
    leaning = ratio * (vector - silhouette * face.normal)
    by_vertices = vertex_sd(slope / silhouette, covs[candidates])
    by_normal = math.sqrt(max(float(leaning @ plane.cov[:3, :3] @ leaning), 0.0)) / silhouette
    return Estimate(min(ratio, 1.0), math.hypot(by_vertices, by_normal))


def thing_box(
    faces: tuple[FlatFace, ...], outer: NDArray[np.intp], points: FloatArray
) -> tuple[float, float, float]:
    """Sides, longest first, of the least box round a thing that is square to its largest face.

    Where several faces are the largest, the least of their boxes is taken.
    """
    largest = max(face.area for face in faces)
    boxes: list[tuple[float, float, float]] = []
    for face in faces:
        if face.area >= largest * (1.0 - AREA_TIE):
            offsets = points[outer] @ face.normal
            axes = plane_axes(face.normal, face.axes[0])
            _, length, width = least_rectangle(points[outer] @ axes.T)
            low, middle, high = sorted((length, width, float(np.ptp(offsets))))
            boxes.append((high, middle, low))
    return min(boxes, key=lambda box: (box[0] * box[1] * box[2], box))
