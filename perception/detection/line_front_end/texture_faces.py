"""Faces found by texture alone, where no straight edges bound them.

A wall that goes on beyond the pictures, a roof, a cloth: there is no outline whose sides lie on
edges. But where texture points lie on a plane, and the views show the same texture between the
points, too, the plane is a face at least as far as the points reach.
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
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.texture_correlation import (
    MIN_CORRELATION,
    PIECE_PX,
    texture_correlation,
)
from facetlog.perception.detection.line_front_end.face_selection import FREE_PX, SAME_PLANE_PX
from facetlog.perception.detection.line_front_end.outlines.region_outline import (
    remove_short_sides,
    remove_straight_corners,
)
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.detection.line_front_end.planes.plane_choice import OPEN_SLOPE, plane_cov
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import plane_basis
from facetlog.perception.detection.line_front_end.planes.texture_choice import to_hypothesis
from facetlog.perception.detection.line_front_end.planes.texture_planes import TexturePlane
from facetlog.perception.detection.line_front_end.points_3d.texture_points import TexturePoints
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.detection.line_front_end.selected_face import SelectedFace
from facetlog.perception.flat_faces import compute_vector_area
from facetlog.perception.stable_order import descending
from facetlog.perception.types import FloatArray, View

# A patch is as broad as two of the pieces that are correlated, or it is one piece alone.
MIN_AREA_PX = (2 * PIECE_PX) ** 2
# Anything shorter than half a piece, px, is no side: the points end anywhere.
MIN_SIDE_PX, MIN_TURN_PX = PIECE_PX / 2, PIECE_PX / 4


def texture_faces(
    patches: Sequence[TexturePlane],
    texture: TexturePoints,
    faces: Sequence[SelectedFace],
    views: Sequence[View],
    photos: PhotometricViews,
    taken: Sequence[NDArray[np.uint8]],
    ground: Ground | None,
    cloud: LineCloud,
) -> tuple[SelectedFace, ...]:
    """Return the texture patches that are faces beside those found, the likeliest first.

    The outline of each is the hull of its points; none of its sides is an edge. `taken` are the
    pixels that found faces explain, V pictures of 0 and 1.
    """
    found: list[SelectedFace] = []
    for k in descending(np.array([patch.score for patch in patches])):
        ring = _hull(texture.points[patches[k].points], patches[k].normal, cloud.pixel)
        if shapely.Polygon(ring @ plane_basis(patches[k].normal)).area < (
            MIN_AREA_PX * cloud.pixel**2
        ):
            continue
        if ground is not None and ground.holds(ring).all():
            continue
        plane = to_hypothesis(patches[k], texture, cloud)
        for normal in (side * plane.normal for side in patches[k].sides):
            corners = ring if compute_vector_area(ring) @ normal > 0 else ring[::-1].copy()
            if any(_contradicts(corners, normal, f, photos, cloud.pixel) for f in (*faces, *found)):
                continue
            inside = inner_points(corners, normal)
            shown = _showing(inside, normal, views, photos, taken, cloud.pixel)
            if shown.any():
                cov = plane_cov(plane, cloud, corners, OPEN_SLOPE)
                found.append(
                    SelectedFace(corners, normal, shown, 0.0, inside, cov, has_edges=False)
                )
    return tuple(found)


def _hull(points: FloatArray, normal: FloatArray, pixel: float) -> FloatArray:
    basis = plane_basis(normal)
    hull = cv2.convexHull((points @ basis).astype(np.float32))[:, 0].astype(np.float64)
    flat = remove_short_sides(hull, MIN_SIDE_PX * pixel)
    flat = remove_straight_corners(flat, MIN_TURN_PX * pixel)
    return np.asarray(flat @ basis.T + normal * float((points @ normal).mean()))


def _showing(
    inside: FloatArray,
    normal: FloatArray,
    views: Sequence[View],
    photos: PhotometricViews,
    taken: Sequence[NDArray[np.uint8]],
    pixel: float,
) -> NDArray[np.bool_]:
    # The views (V,) that see the points (n, 3) inside a patch; none where they do not agree there.
    shown = np.zeros(len(views), dtype=np.bool_)
    which = photos.facing(inside.mean(axis=0), normal) if len(inside) else np.zeros(0, np.intp)
    if photos.weight[which].sum() < MIN_WEIGHT:
        return shown
    _, seen = photos.agree(which, inside, taken)
    which = which[seen.mean(axis=1) > SEEN_SHARE]
    like = texture_correlation(views, which, inside, normal, pixel) > MIN_CORRELATION
    if photos.weight[which].sum() >= MIN_WEIGHT and like.mean() >= MIN_CONSISTENT:
        shown[which] = True
    return shown


def _contradicts(
    corners: FloatArray,
    normal: FloatArray,
    face: SelectedFace,
    photos: PhotometricViews,
    pixel: float,
) -> bool:
    # They overlap in one plane, or the patch hides the face from views that show it.
    if overlap(corners, normal, face.corners, face.normal, SAME_PLANE_PX * pixel):
        return True
    hides = blocked(corners, normal, face.seen, photos.centres[face.shown], FREE_PX * pixel)
    return bool(hides.sum() > MAX_BLOCKED * hides.size)
