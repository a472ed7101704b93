"""3-D segments that bound no face but belong to one: they lie behind it within its outline, or rise
from its rim.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.attached_edges import (
    find_risen_segments,
    find_segments_behind,
    find_segments_inside,
)
from facetlog.perception.detection.line_front_end.evidence.face_conflicts import (
    MAX_BLOCKED,
    blocked,
)
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import plane_basis
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.detection.line_front_end.segments_3d.line_extent import (
    LineProfiles,
    find_covered_extents,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_support import segment_samples
from facetlog.perception.detection.line_front_end.selected_face import SelectedFace
from facetlog.perception.types import FloatArray, View

# A segment this near to a face, in px, lies on it: texture, or the face's own border.
ON_FACE_PX = 6.0
# Samples along an edge that the views must see.
SIGHT_SAMPLES = 8
# A segment this near to the line of a side, in px, is that side again or its shadow.
ALONG_SIDE_PX = 10.0
# Loose edges shorter than this many px are dropped.
MIN_LENGTH_PX = 15.0
# A bar has two outlines, at least this many px apart, and at most this share of their length; they
# differ in direction by no more than this.
BAR_PX, SLENDER, PARALLEL = 3.0, 0.35, float(np.cos(np.deg2rad(10.0)))


def find_loose_edges(
    cloud: LineCloud,
    profiles: LineProfiles,
    faces: Sequence[SelectedFace],
    loops: Sequence[Sequence[int]],
    views: Sequence[View],
    seen: NDArray[np.bool_],
    up: FloatArray | None,
) -> tuple[FloatArray, NDArray[np.intp]]:
    """Return loose edges (m, 2, 3) and the segments of the cloud that they come from (m,).

    `loops` are the faces' corners, as numbers that they share. `seen` (segments, V) says which
    views show which segment: one seen through a face, as of texture at a wrong depth, is dropped.
    """
    extents = find_covered_extents(cloud.segments, profiles)
    keep = np.linalg.norm(extents[:, 1] - extents[:, 0], axis=1) > MIN_LENGTH_PX * cloud.pixel
    for face in faces:
        keep &= ~_lies_on(extents, face, ON_FACE_PX * cloud.pixel)
        keep &= ~_runs_along(extents, face, ALONG_SIDE_PX * cloud.pixel)
    # The ends are the least certain: whether a segment is inside is decided by its middle part.
    cores = segment_samples(extents, 5)[:, [1, 3]]
    belongs = np.zeros(len(extents), np.bool_)
    if up is not None:
        kept = np.flatnonzero(keep)
        bars = _are_bars(extents[kept], cloud.pixel)
        for face in faces:
            belongs[kept] |= find_risen_segments(extents[kept], face.corners, face.normal, up, bars)
    for k, face in enumerate(faces):
        inside = find_segments_behind(extents, face.corners, face.normal)
        beside = (n for n in range(len(faces)) if n != k and _share_a_side(loops[k], loops[n]))
        for other in (faces[n] for n in beside if _is_convex(face, faces[n])):
            # A segment behind two sides of one solid at once would be seen inside it; one before
            # the other side is not part of the solid.
            depth = (extents - other.corners.mean(axis=0)) @ other.normal
            inside &= (depth < ON_FACE_PX * cloud.pixel).all(axis=1)
            inside &= ~find_segments_inside(cores, other.corners, other.normal)
        belongs |= inside
    margin = ON_FACE_PX * cloud.pixel
    centres = np.array([v.pose.centre for v in views])
    for k in np.nonzero(keep & belongs)[0].tolist():
        targets = segment_samples(extents[k : k + 1], SIGHT_SAMPLES)[0]
        shares = (
            blocked(f.corners, f.normal, targets, centres[seen[k]], margin, f.holes).mean()
            for f in faces
        )
        keep[k] = max(shares) <= MAX_BLOCKED
    chosen = np.nonzero(keep & belongs)[0]
    return extents[chosen], chosen


def _are_bars(segments: FloatArray, pixel: float) -> NDArray[np.bool_]:
    """Return which segments (n, 2, 3) are an outline of a bar: another runs along them beside."""
    span = segments[:, 1] - segments[:, 0]
    length = np.linalg.norm(span, axis=1)
    unit = span / length[:, None]
    middles = segments.mean(axis=1)
    between = middles[None] - middles[:, None]
    along = (between * unit[:, None]).sum(axis=-1)
    away = np.sqrt(np.maximum((between**2).sum(axis=-1) - along**2, 0.0))
    shorter = np.minimum(length[:, None], length)
    beside = np.abs(along) < np.maximum(length[:, None], length) / 2.0
    parallel = np.abs(unit @ unit.T) > PARALLEL
    apart = (away > BAR_PX * pixel) & (away < SLENDER * shorter)
    found: NDArray[np.bool_] = (parallel & beside & apart).any(axis=1)
    return found


def _lies_on(segments: FloatArray, face: SelectedFace, tolerance: float) -> NDArray[np.bool_]:
    middle = face.corners.mean(axis=0)
    basis = plane_basis(face.normal)
    near = np.abs((segments - middle) @ face.normal) < tolerance
    flat = (segments - middle) @ basis
    polygon = shapely.Polygon((face.corners - middle) @ basis).buffer(tolerance)
    inside = shapely.contains_xy(polygon, flat[..., 0], flat[..., 1])
    lies: NDArray[np.bool_] = np.logical_and(near, inside).all(axis=1)
    return lies


def _runs_along(segments: FloatArray, face: SelectedFace, tolerance: float) -> NDArray[np.bool_]:
    # Both ends near the line of one side: the side itself again, or the shadow at its foot.
    along = np.zeros(len(segments), np.bool_)
    for start, end in zip(face.corners, np.roll(face.corners, -1, axis=0), strict=True):
        unit = (end - start) / np.linalg.norm(end - start)
        relative = segments - start
        away = relative - (relative @ unit)[..., None] * unit
        along |= (np.linalg.norm(away, axis=-1) < tolerance).all(axis=1)
    return along


def _share_a_side(loop: Sequence[int], other: Sequence[int]) -> bool:
    sides = {frozenset(pair) for pair in zip(loop, (*loop[1:], loop[0]), strict=True)}
    return any(frozenset(pair) in sides for pair in zip(other, (*other[1:], other[0]), strict=True))


def _is_convex(face: SelectedFace, other: SelectedFace) -> bool:
    # Each lies behind the other.
    away = other.corners.mean(axis=0) - face.corners.mean(axis=0)
    return bool(away @ face.normal < 0 < away @ other.normal)
