"""What one face measures, and what it measures against its thing; each with its 1σ.

Standard deviations are first-order, from the covariances of vertices and planes, which are taken
as independent of each other. Lengths are in the scene's unit, areas in its square.
"""

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from facetlog.perception.outlines import (
    Estimate,
    FlatFace,
    area_gradient,
    hull_indices,
    plane_axes,
    vector_area,
    vertex_variance,
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

Gradient = dict[int, FloatArray]


@dataclass(frozen=True, slots=True)
class FaceSize:
    """Area without holes, sides of the least rectangle round the outline, and area over its."""

    area: Estimate
    length: Estimate
    width: Estimate
    fill: Estimate


def _add(total: Gradient, index: int, row: FloatArray) -> None:
    total[index] = total[index] + row if index in total else row


def _area_gradient(face: FlatFace, points: FloatArray) -> Gradient:
    gradient: Gradient = {}
    for ring in face.rings:
        rows = area_gradient(points[list(ring)], face.normal)
        for i, row in zip(ring, rows, strict=True):
            _add(gradient, i, row)
    return gradient


def _combined(*weighted: tuple[float, Gradient]) -> Gradient:
    total: Gradient = {}
    for weight, gradient in weighted:
        for i, row in gradient.items():
            _add(total, i, weight * row)
    return total


def _sides(flat: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Unit directions (m, 2) of the hull's sides, and the extents along and across each (m,)."""
    hull = hull_indices(flat)
    corners = flat[hull]
    sides = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(sides, axis=1)
    directions = sides[lengths > 0.0] / lengths[lengths > 0.0, None]
    if not len(directions):
        directions = np.array([[1.0, 0.0]])
    across = directions @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    return (
        directions,
        np.ptp(corners @ directions.T, axis=0),
        np.ptp(corners @ across.T, axis=0),
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


def _extent_gradient(
    face: FlatFace, flat: FloatArray, direction: FloatArray, size: float
) -> Gradient:
    """Gradient of the extent along `direction`, which is held, shared among points that tie."""
    reach = flat @ direction
    slack = RECTANGLE_TIE * size
    low = np.flatnonzero(reach <= reach.min() + slack)
    high = np.flatnonzero(reach >= reach.max() - slack)
    axis = direction @ face.axes
    gradient: Gradient = {}
    for rows, sign in ((high, 1.0), (low, -1.0)):
        for i in rows.tolist():
            _add(gradient, face.outline[i], sign / len(rows) * axis)
    return gradient


def face_size(face: FlatFace, points: FloatArray, covs: FloatArray) -> FaceSize:
    """Area, length, width and fill of a face; vertices are `points` (n, 3), `covs` (n, 3, 3)."""
    area_slope = _area_gradient(face, points)
    flat = face.flatten(points[list(face.outline)])
    direction, length, width = least_rectangle(flat)
    across = np.array([-direction[1], direction[0]])
    length_slope = _extent_gradient(face, flat, direction, length)
    width_slope = _extent_gradient(face, flat, across, width)

    def estimate(value: float, gradient: Gradient) -> Estimate:
        return Estimate(value, float(np.sqrt(max(vertex_variance(gradient, covs), 0.0))))

    if length * width > 0.0:
        # R = A / (l w):  dR = R (dA / A - dl / l - dw / w), written without dividing by A
        fill = face.area / (length * width)
        slope = _combined(
            (1.0 / (length * width), area_slope),
            (-fill / length, length_slope),
            (-fill / width, width_slope),
        )
        filled = estimate(min(fill, 1.0), slope)
    else:
        filled = Estimate(0.0, 1.0)
    return FaceSize(
        estimate(face.area, area_slope),
        estimate(length, length_slope),
        estimate(width, width_slope),
        filled,
    )


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
    face: FlatFace, plane: Plane, others: NDArray[np.intp], points: FloatArray, covs: FloatArray
) -> Estimate:
    """How far the vertices `others` (indices) of the face's thing reach in front of its plane."""
    outside = _without(others, face)
    if not len(outside):
        return Estimate(0.0, float(distances(plane, face.middle[None])[1][0]))
    signed, plane_sds = distances(plane, points[outside])
    top = int(np.argmax(signed))
    variance = plane_sds[top] ** 2 + plane.normal @ covs[outside[top]] @ plane.normal
    return Estimate(max(float(signed[top]), 0.0), float(np.sqrt(max(float(variance), 0.0))))


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
    flat = face.flatten(points[others])
    # What shows within 3 sd of the face does not reach beyond it: vertices stacked along the
    # normal would otherwise each push the silhouette out by their noise.
    depth = plane.distance(points[others])
    own = tolerance.vertex_sds[list(face.outline)].max()
    sds = np.hypot(np.hypot(tolerance.vertex_sds[others], own), tilt_sd(plane) * depth)
    beyond = shapely.distance(shapely.points(flat), face.polygon) > tolerance.within(sds)
    candidates = np.concatenate([np.array(face.outline), others[beyond]])
    hull = candidates[hull_indices(face.flatten(points[candidates]))]
    loop = points[hull]
    vector = vector_area(loop)
    silhouette = float(vector @ face.normal)
    if silhouette <= 0.0:
        return Estimate(0.0, 1.0)
    ratio = face.area / silhouette
    hull_slope = dict(zip(hull.tolist(), area_gradient(loop, face.normal), strict=True))
    slope = _combined(
        (1.0 / silhouette, _area_gradient(face, points)), (-ratio / silhouette, hull_slope)
    )
    leaning = (ratio / silhouette) * (vector - silhouette * face.normal)
    variance = vertex_variance(slope, covs) + leaning @ plane.cov[:3, :3] @ leaning
    return Estimate(min(ratio, 1.0), float(np.sqrt(max(float(variance), 0.0))))


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
