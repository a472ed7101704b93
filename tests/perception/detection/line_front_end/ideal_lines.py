"""Exact polygons in space: their sides as 3-D segments, with profiles as pictures would give."""

import numpy as np

from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import PlaneHypothesis
from facetlog.perception.detection.line_front_end.segments_3d.line_extent import (
    MARGIN,
    SAMPLES,
    LineProfiles,
)
from facetlog.perception.types import FloatArray

PIXEL = 0.01
SQUARE = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
TRIANGLE = np.array([[0.0, 0], [1.2, 0], [0.5, 0.9]])
PENTAGON = np.array([[np.cos(a), np.sin(a)] for a in np.arange(5) * 0.4 * np.pi])
HEXAGON = np.array([[np.cos(a), np.sin(a)] for a in np.arange(6) * np.pi / 3])
L_SHAPE = np.array([[0.0, 0], [2, 0], [2, 0.8], [0.9, 0.8], [0.9, 2], [0, 2]])


def placed(flat: FloatArray, rotation: FloatArray, scale: float = 1.0) -> FloatArray:
    """Corners (k, 3) of a polygon (k, 2), turned, scaled and away from the origin."""
    space = np.column_stack([flat, np.zeros(len(flat))])
    return scale * (space @ rotation.T + np.array([0.3, -1.0, 2.0]))


def sides_of(corners: FloatArray) -> FloatArray:
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def exact_ends(segments: FloatArray) -> FloatArray:
    """Covariances (n, 2, 3, 3) of ends that are known exactly."""
    return np.zeros((len(segments), 2, 3, 3))


def plane_of(corners: FloatArray, lines: int) -> PlaneHypothesis:
    """The plane of a polygon that runs counter-clockwise, with that many segments on it."""
    normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    normal = normal / np.linalg.norm(normal)
    return PlaneHypothesis(normal, float(normal @ corners[0]), np.arange(lines))


def exact_profiles(segments: FloatArray, covered: FloatArray | None = None) -> LineProfiles:
    """Profiles of segments (n, 2, 3) covered from end to end (or by a share), and not beyond."""
    share = np.ones(len(segments)) if covered is None else covered
    along = segments[:, 1] - segments[:, 0]
    length = np.linalg.norm(along, axis=1)
    step = (1 + 2 * MARGIN) * length / SAMPLES
    begin = -MARGIN * length
    # How much of each sample lies on the segment, exactly.
    low = begin[:, None] + np.arange(SAMPLES) * step[:, None]
    inside = np.minimum(low + step[:, None], length[:, None]) - np.maximum(low, 0.0)
    cover = np.clip(inside / step[:, None], 0.0, 1.0) * share[:, None]
    cumulated = np.concatenate([np.zeros((len(segments), 1)), cover.cumsum(axis=1)], axis=1)
    return LineProfiles(segments[:, 0], along / length[:, None], begin, step, cumulated)


def same_ring(found: FloatArray, true: FloatArray, tolerance: float = 1e-6) -> bool:
    """Whether two polygons (k, 3) are one, whichever corner comes first and way they run."""
    if found.shape != true.shape:
        return False
    rings = [np.roll(r, k, axis=0) for r in (true, true[::-1]) for k in range(len(true))]
    return min(float(np.abs(found - r).max()) for r in rings) < tolerance
