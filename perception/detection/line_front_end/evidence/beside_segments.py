"""Evidence beside 3-D segments: on which side a plane is a surface, and pictures' exposures.

Half-planes follow Baillard & Zisserman, "Automatic reconstruction of piecewise planar models from
multiple views" (CVPR 1999), who turn a half-plane about a line until the pictures beside the line
agree. A camera with automatic exposure shows the same surface at a different level in each picture.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.photo_consistency import (
    AGREES_SDS,
    LIGHT_SHARE,
)
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SAMPLES
from facetlog.perception.detection.line_front_end.segments_3d.line_support import (
    project_points,
    segment_samples,
)
from facetlog.perception.types import FloatArray, View

# This far beside a side, px, its own edge ends.
CLEAR_PX = 5.0
# A surface has at least this mean log-likelihood ratio, and this share of it is consistent.
MIN_INSIDE, MIN_CONSISTENT = 2.0, 0.75
# Distinct views that must agree.
MIN_WEIGHT = 2.0
EXPOSURE_SAMPLES = 6
# Medians of rows and columns in turn settle quickly.
STEPS = 10
# Exposures differ if compensating for them makes this many times as many places agree: 2.6 times
# for a camera with automatic exposure, .97 to 1.11 on 30 sets without.
BETTER = 1.5


def exposures(segments: FloatArray, use: NDArray[np.bool_], views: Sequence[View]) -> FloatArray:
    """Return the factor (V,) by which each view is brighter than usual.

    `use` (n, V) says which view shows which of the 3-D segments (n, 2, 3). Medians over places
    beside them and over views in turn (Tukey's median polish): at a border one side of a segment is
    background, a different one in each view, and that is brighter as often as darker.
    """
    levels = _log_levels(segments, use, views)
    levels = levels[np.isfinite(levels).sum(axis=1) > 1]
    shown = np.isfinite(levels).any(axis=0)
    if not shown.any():
        return np.ones(len(views))
    brighter = np.zeros(len(views))
    for _ in range(STEPS):
        surface = np.nanmedian(levels - brighter, axis=1, keepdims=True)
        middle = np.nanmedian((levels - surface)[:, shown], axis=0)
        before = brighter[shown]
        brighter[shown] = middle - np.median(middle)
        if (brighter[shown] == before).all():
            break
    better = _agreeing(levels - brighter) > BETTER * _agreeing(levels)
    return np.exp(brighter) if better else np.ones(len(views))


def _agreeing(levels: FloatArray) -> int:
    # How many levels (m, V) are those of their surface, up to changes of light with the view.
    apart = np.abs(levels - np.nanmedian(levels, axis=1, keepdims=True))
    return int((apart < AGREES_SDS * LIGHT_SHARE).sum())


def _log_levels(segments: FloatArray, use: NDArray[np.bool_], views: Sequence[View]) -> FloatArray:
    # Logarithms (m, V) of the levels at places to either side of the segments; NaN where not seen.
    points = segment_samples(segments, EXPOSURE_SAMPLES)
    found = np.full((2, *points.shape[:2], len(views)), np.nan)
    for k, view in enumerate(views):
        uv, depth = project_points(view.projection, points)
        along = uv[:, -1] - uv[:, 0]
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        across /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
        off = CLEAR_PX * np.array([-1.0, 1.0])[:, None, None, None]
        at = np.rint(uv + off * across[:, None])
        seen = ((at >= 0) & (at < view.image.shape[::-1])).all(axis=-1)
        seen &= (depth > 0) & use[:, k, None]
        column, row = at[seen].astype(np.intp).T
        # A black pixel has no logarithm.
        found[seen, k] = np.log(np.maximum(view.image[row, column], 1))
    return found.reshape(-1, len(views))


def find_surface_beside(
    photos: PhotometricViews, normal: FloatArray, segments: FloatArray, pixel: float
) -> NDArray[np.bool_]:
    """Return whether a plane is surface right beside its segments (n, 2, 3), on either side: (2,
    n).

    First as seen from its front, then from its back; `pixel` is the length of a pixel there.
    """
    across = np.cross(normal, segments[:, 1] - segments[:, 0])
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
    step = CLEAR_PX * pixel * across[:, None]
    samples = segment_samples(segments, SAMPLES)
    points = np.stack([samples - step, samples + step]).reshape(-1, 3)
    found = np.zeros((2, len(segments)), dtype=np.bool_)
    for facing, row in zip((normal, -normal), found, strict=True):
        views = photos.facing(segments.mean(axis=(0, 1)), facing)
        if photos.weight[views].sum() < MIN_WEIGHT:
            continue
        ratio = photos.agree(views, points)[0].ratio.reshape(2, len(segments), SAMPLES)
        surface = ratio.mean(axis=2) > MIN_INSIDE
        surface &= (ratio > 0).mean(axis=2) >= MIN_CONSISTENT
        row[:] = surface.any(axis=0)
    return found
