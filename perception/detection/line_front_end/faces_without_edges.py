"""Faces that are not found by their edges: implied by neighbours, or shown by texture alone.

A face is found where views agree on what it shows; a side that one view sees, or none, is not. But
where two faces meet along a side, what lies between their next sides is most likely the third face
of a corner; and what is bounded above often stands on the ground. Where a view or two see such a
face, its own edges must be there; where it is hidden from all that it is turned to, it is implied,
and no more. What no view is turned to is not proposed: a table has no bottom.

A wall that goes on beyond the pictures, a roof, a cloth: there is no outline whose sides lie on
edges. But where texture points lie on a plane, and the views show the same texture between the
points, too, the plane is a face at least as far as the points reach.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.candidate_faces import SelectedFace
from facetlog.perception.detection.line_front_end.evidence.beside_segments import (
    MIN_CONSISTENT,
    MIN_WEIGHT,
)
from facetlog.perception.detection.line_front_end.evidence.face_conflicts import (
    MAX_BLOCKED,
    blocked,
    overlap,
)
from facetlog.perception.detection.line_front_end.evidence.face_evidence import (
    MIN_COVERAGE,
    SEEN_SHARE,
    inner_points,
)
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SideJudge
from facetlog.perception.detection.line_front_end.evidence.texture_correlation import (
    MIN_CORRELATION,
    PIECE_PX,
    texture_correlation,
)
from facetlog.perception.detection.line_front_end.face_selection import (
    FREE_PX,
    SAME_PLANE_PX,
    TOUCH_PX,
)
from facetlog.perception.detection.line_front_end.outlines.region_outline import (
    remove_short_sides,
    remove_straight_corners,
)
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.detection.line_front_end.planes.plane_choice import OPEN_SLOPE, plane_cov
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import plane_basis
from facetlog.perception.detection.line_front_end.planes.texture_planes import (
    TexturePlane,
    to_hypothesis,
)
from facetlog.perception.detection.line_front_end.points_3d.texture_points import TexturePoints
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.flat_faces import compute_vector_area, make_ring_sides
from facetlog.perception.stable_order import descending
from facetlog.perception.types import FloatArray, View

# Faces seen in three or more distinct views were decided before.
JUDGED_WEIGHT = 3.0
# Three sides propose the fourth: with so many of them on found faces an unseen face is implied.
ENOUGH_KNOWN = 3
# Less than one in a thousand scenes may show edges so by chance.
CHANCE_PENALTY = float(np.log(1000.0))
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


@dataclass(frozen=True, eq=False, slots=True)
class _Proposal:
    ring: FloatArray  # (4, 3), counter-clockwise seen from outside
    normal: FloatArray  # (3,) outwards
    known: NDArray[np.bool_]  # (4,) which of its sides are those of found faces


def neighbouring_faces(
    faces: Sequence[SelectedFace],
    photos: PhotometricViews,
    sides: SideJudge,
    taken: Sequence[NDArray[np.uint8]],
    ground: Ground | None,
    pixel: float,
) -> tuple[SelectedFace, ...]:
    """Return the faces that found ones propose, those whose edges are shown the most clearly first.

    Of those that are implied no view shows anything. `taken` are the pixels that found faces
    explain, V pictures of 0 and 1; `pixel` is a pixel's length at the usual distance.
    """
    proposals = [
        p
        for p in _proposals(faces, ground, pixel)
        if not (ground is not None and ground.holds(p.ring).all())
        and _is_free(p, faces, photos, pixel)
    ]
    penalty = CHANCE_PENALTY + float(np.log(max(len(proposals), 1)))
    found = [_judged(p, photos, sides, taken, penalty) for p in proposals]
    judged = [each for each in found if each is not None]
    kept: list[SelectedFace] = []
    near = SAME_PLANE_PX * pixel
    for k in descending(np.array([score for _, score in judged])):
        face = judged[k][0]
        if not any(overlap(face.corners, face.normal, o.corners, o.normal, near) for o in kept):
            kept.append(face)
    return tuple(kept)


def _proposals(
    faces: Sequence[SelectedFace], ground: Ground | None, pixel: float
) -> Iterator[_Proposal]:
    near = TOUCH_PX * pixel
    for face in faces:
        ring = face.corners
        for k, end in enumerate(ring):
            start, before, after = ring[k - 1], ring[k - 2], ring[(k + 1) % len(ring)]
            others = [f.corners for f in faces if f is not face]
            if any(_shared(other, start, end, near) is not None for other in others):
                continue
            for at, beyond in ((start, before), (end, after)):
                for other in others:
                    arm = _shared(other, at, beyond, near)
                    if arm is not None:
                        yield from _proposal(start, end, arm, arm, faces, near)
            drop = _drop(start, end, ground)
            if drop is not None:
                yield from _proposal(start, end, *drop, faces, near)


def _shared(
    corners: FloatArray, at: FloatArray, beyond: FloatArray, near: float
) -> FloatArray | None:
    # Where a polygon has a side from one point to the other: its next side from the first, (3,).
    for way in (corners, corners[::-1]):
        ahead = np.roll(way, -1, axis=0)
        apart = np.maximum(np.linalg.norm(way - at, axis=1), np.linalg.norm(ahead - beyond, axis=1))
        k = int(apart.argmin())
        if apart[k] < near:
            return np.asarray(way[k - 1] - way[k])
    return None


def _drop(
    start: FloatArray, end: FloatArray, ground: Ground | None
) -> tuple[FloatArray, FloatArray] | None:
    # From both ends of a side down to the ground.
    if ground is None:
        return None
    across = np.cross(end - start, ground.normal)
    size = float(np.linalg.norm(across))
    if not size:
        return None
    ring = ground.extend_to_ground(np.array([start, end]), across / size)
    return (ring[3] - start, ring[2] - end) if len(ring) else None


def _proposal(
    start: FloatArray,
    end: FloatArray,
    from_start: FloatArray,
    from_end: FloatArray,
    faces: Sequence[SelectedFace],
    near: float,
) -> Iterator[_Proposal]:
    # A face turns clockwise about what lies beyond its own sides: there the thing bulges.
    ring = np.array([end, start, start + from_start, end + from_end])
    normal = compute_vector_area(ring)
    size = np.linalg.norm(normal)
    if not size:
        return  # a next side that runs on along this one, or back, spans nothing
    known = [
        any(_shared(f.corners, a, b, near) is not None for f in faces)
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True)
    ]
    yield _Proposal(ring, normal / size, np.array(known))


def _is_free(
    proposal: _Proposal, faces: Sequence[SelectedFace], photos: PhotometricViews, pixel: float
) -> bool:
    # It lies on no found face and hides none from the views that show it.
    ring, normal = proposal.ring, proposal.normal
    for f in faces:
        if overlap(ring, normal, f.corners, f.normal, SAME_PLANE_PX * pixel):
            return False
        centres = photos.centres[f.shown]
        hides = blocked(ring, normal, f.seen, centres, FREE_PX * pixel)
        if hides.sum() > MAX_BLOCKED * hides.size:
            return False
    return True


def _judged(
    proposal: _Proposal,
    photos: PhotometricViews,
    sides: SideJudge,
    taken: Sequence[NDArray[np.uint8]],
    penalty: float,
) -> tuple[SelectedFace, float] | None:
    # The face, if the views that it faces do not contradict it, and its score.
    ring, normal = proposal.ring, proposal.normal
    points = inner_points(ring, normal)
    views = photos.facing(ring.mean(axis=0), normal)
    if not len(views) or not len(points):
        return None
    result, seen = photos.agree(views, points, taken)
    views = views[seen.mean(axis=1) > SEEN_SHARE]
    shown = np.zeros(len(photos.weight), dtype=np.bool_)
    shown[views] = True
    if not len(views):
        implied = SelectedFace(ring, normal, shown, 0.0, points)
        return (implied, 0.0) if proposal.known.sum() >= ENOUGH_KNOWN else None
    weight = float(photos.weight[views].sum())
    if weight >= JUDGED_WEIGHT or (weight >= MIN_WEIGHT and result.ratio.mean() < 0):
        return None
    evidence = sides.evidence(views, make_ring_sides(ring))
    new = ~proposal.known if not proposal.known.all() else proposal.known
    hit = evidence.found.sum(axis=(0, 2)) / np.maximum(evidence.there.sum(axis=(0, 2)), 1)
    score = float((photos.weight[views] @ evidence.ratio)[new].sum())
    if (hit[new] < MIN_COVERAGE).any() or score < penalty:
        return None
    return SelectedFace(ring, normal, shown, float(hit.mean()), points), score
