"""Faces that print shows by itself, where no straight edges bound them.

A wall that goes on beyond the pictures, a roof, a cloth: there is no outline whose sides edges
speak for. But where points of print lie on a plane, and all the views show one and the same print
between them, too, the plane is a face at least as far as the points reach.
"""

from collections.abc import Sequence

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.face_conflicts import (
    MAX_BLOCKED,
    blocked,
    overlap,
)
from facetlog.perception.detection.line_front_end.evidence.face_evidence import (
    SEEN_SHARE,
    inner_points,
)
from facetlog.perception.detection.line_front_end.evidence.half_planes import (
    MIN_CONSISTENT,
    MIN_WEIGHT,
)
from facetlog.perception.detection.line_front_end.evidence.print_likeness import (
    MIN_LIKENESS,
    PIECE_PX,
    print_likeness,
)
from facetlog.perception.detection.line_front_end.evidence.witnesses import Witnesses
from facetlog.perception.detection.line_front_end.face_selection import (
    FREE_PX,
    SAME_PLANE_PX,
    SelectedFace,
)
from facetlog.perception.detection.line_front_end.outlines.region_outline import (
    without_short_sides,
    without_straight_corners,
)
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.detection.line_front_end.planes.plane_choice import OPEN_SLOPE, plane_cov
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import plane_basis
from facetlog.perception.detection.line_front_end.planes.print_choice import as_hypothesis
from facetlog.perception.detection.line_front_end.planes.print_planes import PrintPlane
from facetlog.perception.detection.line_front_end.points_3d.print_points import PrintPoints
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.flat_faces import vector_area
from facetlog.perception.ties import descending
from facetlog.perception.types import FloatArray, View

__all__ = ["print_faces"]

# A patch is as broad as two of the pieces by which print is compared, or it is one piece alone.
MIN_AREA_PX = (2 * PIECE_PX) ** 2
# What is shorter than half a piece, px, is nobody's side: points end anywhere.
MIN_SIDE_PX, MIN_TURN_PX = PIECE_PX / 2, PIECE_PX / 4


def print_faces(
    patches: Sequence[PrintPlane],
    prints: PrintPoints,
    faces: Sequence[SelectedFace],
    views: Sequence[View],
    witnesses: Witnesses,
    taken: Sequence[NDArray[np.uint8]],
    ground: Ground | None,
    cloud: LineCloud,
) -> tuple[SelectedFace, ...]:
    """The patches of print that are faces beside those found, the likeliest first.

    Each has the hull of its points for an outline, none of whose sides is an edge. `taken` are the
    pixels that found faces explain, V pictures of 0 and 1.
    """
    found: list[SelectedFace] = []
    for k in descending(np.array([patch.worth for patch in patches])):
        ring = _hull(prints.points[patches[k].points], patches[k].normal, cloud.pixel)
        if shapely.Polygon(ring @ plane_basis(patches[k].normal)).area < (
            MIN_AREA_PX * cloud.pixel**2
        ):
            continue
        if ground is not None and ground.holds(ring).all():
            continue
        plane = as_hypothesis(patches[k], prints, cloud)
        for normal in (side * plane.normal for side in patches[k].sides):
            corners = ring if vector_area(ring) @ normal > 0 else ring[::-1].copy()
            if any(
                _contradicts(corners, normal, f, witnesses, cloud.pixel) for f in (*faces, *found)
            ):
                continue
            inside = inner_points(corners, normal)
            shown = _showing(inside, normal, views, witnesses, taken, cloud.pixel)
            if shown.any():
                cov = plane_cov(plane, cloud, corners, OPEN_SLOPE)
                found.append(
                    SelectedFace(corners, normal, shown, 0.0, inside, cov, has_edges=False)
                )
    return tuple(found)


def _hull(points: FloatArray, normal: FloatArray, pixel: float) -> FloatArray:
    basis = plane_basis(normal)
    hull = cv2.convexHull((points @ basis).astype(np.float32))[:, 0].astype(np.float64)
    flat = without_short_sides(hull, MIN_SIDE_PX * pixel)
    flat = without_straight_corners(flat, MIN_TURN_PX * pixel)
    return np.asarray(flat @ basis.T + normal * float((points @ normal).mean()))


def _showing(
    inside: FloatArray,
    normal: FloatArray,
    views: Sequence[View],
    witnesses: Witnesses,
    taken: Sequence[NDArray[np.uint8]],
    pixel: float,
) -> NDArray[np.bool_]:
    # The views (V,) that see the points (n, 3) inside a patch; none where they do not agree there.
    shown = np.zeros(len(views), dtype=np.bool_)
    which = witnesses.facing(inside.mean(axis=0), normal) if len(inside) else np.zeros(0, np.intp)
    if witnesses.weight[which].sum() < MIN_WEIGHT:
        return shown
    _, seen = witnesses.agree(which, inside, taken)
    which = which[seen.mean(axis=1) > SEEN_SHARE]
    like = print_likeness(views, which, inside, normal, pixel) > MIN_LIKENESS
    if witnesses.weight[which].sum() >= MIN_WEIGHT and like.mean() >= MIN_CONSISTENT:
        shown[which] = True
    return shown


def _contradicts(
    corners: FloatArray,
    normal: FloatArray,
    face: SelectedFace,
    witnesses: Witnesses,
    pixel: float,
) -> bool:
    # They overlap in one plane, or the patch hides the face from views that show it.
    if overlap(corners, normal, face.corners, face.normal, SAME_PLANE_PX * pixel):
        return True
    hides = blocked(corners, normal, face.seen, witnesses.centres[face.shown], FREE_PX * pixel)
    return bool(hides.sum() > MAX_BLOCKED * hides.size)
