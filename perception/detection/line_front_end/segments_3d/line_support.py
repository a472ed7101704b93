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
    along = segments[:, None, 1] - segments[:, None, 0]
    return segments[:, None, 0] + _places(count)[:, None] * along


def _places(count: int) -> FloatArray:
    return (np.arange(count) + 0.5) / count


def project_points(projection: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return pixels (..., 2) and depths (...) of points (..., 3); depth <= 0 behind the camera."""
    # One product of two flat matrices: a stack of small ones is ten times slower.
    h = projection[:, :3] @ points.reshape(-1, 3).T + projection[:, 3:]
    safe = np.where(h[2] > 0, h[2], np.inf)
    uv = (h[:2] / safe).T.reshape(*points.shape[:-1], 2)
    return uv, h[2].reshape(points.shape[:-1])


def project_to_views(projections: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return pixels (v, n, 2) and depths (v, n) of points (n, 3) by projections (v, 3, 4)."""
    # One product of two flat matrices: a stack of small ones is slower.
    flat = projections[:, :, :3].reshape(-1, 3) @ points.T
    h = flat.reshape(len(projections), 3, len(points)) + projections[:, :, 3:]
    depth = h[:, 2]
    safe = np.where(depth > 0, depth, np.inf)
    return (h[:, :2] / safe[:, None]).transpose(0, 2, 1), depth


def hits(
    view: View, edges: EdgeMap, segments: FloatArray, samples: int
) -> tuple[NDArray[np.bool_], ...]:
    """Return which of so many samples (n, m), as of `segment_samples`, of segments (n, 2, 3) lie on
    an edge of their direction, and which are in view.
    """
    # Homogeneous pixels, (3, n, m), are as even along a segment as its samples.
    start, end = (
        view.projection[:, :3] @ segments[:, k].T + view.projection[:, 3:] for k in (0, 1)
    )
    x, y, depth = start[..., None] + (end - start)[..., None] * _places(samples)
    depth = np.where(depth > 0, depth, np.inf)
    u, v = x / depth, y / depth
    height, width = view.image.shape
    column, row = np.rint(u), np.rint(v)
    inside = (depth < np.inf) & (column >= 0) & (column < width) & (row >= 0) & (row < height)
    bits = encode_direction(np.arctan2(v[:, -1] - v[:, 0], u[:, -1] - u[:, 0]))
    at = np.where(inside, row * width + column, 0).astype(np.intp)
    return inside & ((edges.mask.take(at) & bits[:, None]) != 0), inside


def coverage(
    segments: FloatArray, views: Sequence[View], maps: Sequence[EdgeMap], samples: int = 12
) -> FloatArray:
    """Return the share (n, V) of each segment (n, 2, 3) found in each view; NaN where it is out of
    view.
    """
    result = np.full((len(segments), len(views)), np.nan)
    for k, (view, edges) in enumerate(zip(views, maps, strict=True)):
        found, inside = hits(view, edges, segments, samples)
        visible = inside.mean(axis=1) >= MIN_VISIBLE
        result[visible, k] = found[visible].sum(axis=1) / inside[visible].sum(axis=1)
    return result
