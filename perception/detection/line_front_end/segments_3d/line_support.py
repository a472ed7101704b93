"""The coverage of 3-D segments: the share of each that a view shows as edges."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.edge_maps import EdgeMap, encode_direction
from facetlog.perception.types import FloatArray, View

# A view that has less than this share of a segment in the picture is no evidence about it.
MIN_VISIBLE = 0.6


def segment_samples(segments: FloatArray, count: int) -> FloatArray:
    """Return points (n, count, 3) evenly inside segments (n, 2, 3), ends left out."""
    t = (np.arange(count) + 0.5) / count
    return segments[:, None, 0] + t[:, None] * (segments[:, None, 1] - segments[:, None, 0])


def project_points(projection: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return pixels (..., 2) and depths (...) of points (..., 3); depth <= 0 behind the camera."""
    # One product of two flat matrices: a stack of small ones is ten times slower.
    h = projection[:, :3] @ points.reshape(-1, 3).T + projection[:, 3:]
    safe = np.where(h[2] > 0, h[2], np.inf)
    uv = (h[:2] / safe).T.reshape(*points.shape[:-1], 2)
    return uv, h[2].reshape(points.shape[:-1])


def project_to_views(projections: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return pixels (v, n, 2) and depths (v, n) of points (n, 3) by projections (v, 3, 4)."""
    h = projections[:, :, :3] @ points.T + projections[:, :, 3:]
    depth = h[:, 2]
    safe = np.where(depth > 0, depth, np.inf)
    return (h[:, :2] / safe[:, None]).transpose(0, 2, 1), depth


def hits(view: View, edges: EdgeMap, samples: FloatArray) -> tuple[NDArray[np.bool_], ...]:
    """Return which samples (n, m, 3) lie on an edge of their direction, and which are in view."""
    uv, depth = project_points(view.projection, samples)
    height, width = view.image.shape
    column, row = np.rint(uv[..., 0]), np.rint(uv[..., 1])
    inside = (depth > 0) & (column >= 0) & (column < width) & (row >= 0) & (row < height)
    along = uv[:, -1] - uv[:, 0]
    bits = encode_direction(np.arctan2(along[:, 1], along[:, 0]))
    at = np.where(inside, row * width + column, 0).astype(np.intp)
    return inside & ((edges.mask.take(at) & bits[:, None]) != 0), inside


def coverage(
    segments: FloatArray, views: Sequence[View], maps: Sequence[EdgeMap], samples: int = 12
) -> FloatArray:
    """Return the share (n, V) of each segment (n, 2, 3) found in each view; NaN where it is out of
    view.
    """
    points = segment_samples(segments, samples)
    result = np.full((len(segments), len(views)), np.nan)
    for k, (view, edges) in enumerate(zip(views, maps, strict=True)):
        found, inside = hits(view, edges, points)
        visible = inside.mean(axis=1) >= MIN_VISIBLE
        result[visible, k] = found[visible].sum(axis=1) / inside[visible].sum(axis=1)
    return result
