"""How much brighter each picture is than the others, told by what lies beside 3-D segments.

A camera that exposes each picture by what it sees shows one surface at another level in each.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.line_support import (
    project_points,
    segment_samples,
)
from facetlog.perception.types import FloatArray, View

__all__ = ["exposures"]

SAMPLES = 6
# So far beside a segment, px, its own edge is over.
BESIDE_PX = 5.0
MEDIAN_OF_NORMAL = 0.6745
# Medians of rows and columns in turn settle quickly.
STEPS = 10
# A view is as bright as usual unless it differs by so many standard errors.
SURE_SDS = 3.0


def exposures(segments: FloatArray, use: NDArray[np.bool_], views: Sequence[View]) -> FloatArray:
    """By which factor (V,) each view is brighter than usual.

    Of 3-D segments (n, 2, 3), `use` (n, V) tells which view shows which. Medians over places beside
    them and over views in turn (Tukey's median polish): of a segment at a border one side is
    background, another in each view, which makes these brighter as often as darker.
    """
    levels = _log_levels(segments, use, views)
    levels = levels[np.isfinite(levels).sum(axis=1) > 1]
    seen = np.isfinite(levels).sum(axis=0)
    told = seen > 0
    if not told.any():
        return np.ones(len(views))
    brighter, spread = np.zeros((2, len(views)))
    for _ in range(STEPS):
        surface = np.nanmedian(levels - brighter, axis=1, keepdims=True)
        apart = (levels - surface)[:, told]
        middle = np.nanmedian(apart, axis=0)
        spread[told] = np.nanmedian(np.abs(apart - middle), axis=0) / MEDIAN_OF_NORMAL
        brighter[told] = middle - np.median(middle)
    # The samples along one side of a segment show one surface. Of a median the error is larger than
    # that of a mean by the root of half of pi.
    error = np.sqrt(np.pi / 2 * SAMPLES / np.maximum(seen, 1)) * spread
    return np.exp(np.where(np.abs(brighter) > SURE_SDS * error, brighter, 0.0))


def _log_levels(segments: FloatArray, use: NDArray[np.bool_], views: Sequence[View]) -> FloatArray:
    # Logarithms (m, V) of the levels at places to either side of the segments; NaN where not seen.
    points = segment_samples(segments, SAMPLES)
    found = np.full((2, *points.shape[:2], len(views)), np.nan)
    for k, view in enumerate(views):
        uv, depth = project_points(view.projection, points)
        along = uv[:, -1] - uv[:, 0]
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        across /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
        off = BESIDE_PX * np.array([-1.0, 1.0])[:, None, None, None]
        at = np.rint(uv + off * across[:, None])
        seen = ((at >= 0) & (at < view.image.shape[::-1])).all(axis=-1)
        seen &= (depth > 0) & use[:, k, None]
        column, row = at[seen].astype(np.intp).T
        # A black pixel has no logarithm.
        found[seen, k] = np.log(np.maximum(view.image[row, column], 1))
    return found.reshape(-1, len(views))
