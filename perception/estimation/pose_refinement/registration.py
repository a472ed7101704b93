"""Registration of a further view to the 3-D segments of the views before it.

The pose from odometry may be off by more than half the distance to the next parallel edge, where a
search across the edges ends at the wrong one. So poses are sampled from odometry's prior, those at
which the picture shows most of the segments are refined, and the best of them is taken.
"""

import numpy as np

from facetlog.perception.detection.line_front_end.segments_3d.line_support import (
    coverage,
    project_points,
)
from facetlog.perception.estimation.pose_refinement.line_alignment import DriftingViews, align_one
from facetlog.perception.types import FloatArray

__all__ = ["registered"]

DRAWN = 400
# Samples spread a little wider than the prior: covariances are estimates too.
SPREAD = 1.5
IMPROVED = 6
# Width searched, px, and share of a segment that must lie on edges, in successive steps.
STEPS = ((8.0, 0.3), (5.0, 0.3), (3.0, 0.5), (2.0, 0.5), (2.0, 0.5))
# A segment counts from this share on; by its length in the picture, up to half the usual picture:
# the floor's boards are longer than anything that stands on it.
SHOWN = 0.5
LONGEST = 0.5
# So many pixels of shown segments count as much as one unit of the prior's squared Mahalanobis
# distance.
PX_A_UNIT = 2.0


def registered(
    drifting: DriftingViews, k: int, twists: FloatArray, segments: FloatArray
) -> FloatArray:
    """The twist (6,) of view k that shows segments (n, 2, 3) best, within its prior."""
    before, step = drifting.chain.expected(k, twists)
    rng = np.random.default_rng(k)
    drawn = rng.multivariate_normal(before, SPREAD * step, DRAWN, method="eigh")
    drawn = np.vstack([before, drawn])
    shown = np.array([_shown_px(drifting, k, twist, segments) for twist in drawn])
    best, most = before, -np.inf
    belief = np.linalg.inv(step)
    for index in np.argsort(-shown, kind="stable")[:IMPROVED]:
        twist = _improved(drifting, k, drawn[index], (before, step), segments)
        off = twist - before
        score = _shown_px(drifting, k, twist, segments) - PX_A_UNIT * float(off @ belief @ off)
        if score > most:
            best, most = twist, score
    return best


def _improved(
    drifting: DriftingViews,
    k: int,
    twist: FloatArray,
    expected: tuple[FloatArray, FloatArray],
    segments: FloatArray,
) -> FloatArray:
    for search_px, least in STEPS:
        shown = _coverage(drifting, k, twist, segments) > least
        if not shown.any():
            break
        twist = align_one(drifting, k, twist, expected, segments[shown], search_px)
    return twist


def _coverage(
    drifting: DriftingViews, k: int, twist: FloatArray, segments: FloatArray
) -> FloatArray:
    view = drifting.at([k], twist[None])
    return np.nan_to_num(coverage(segments, view, [drifting.maps[k]])[:, 0])


def _shown_px(drifting: DriftingViews, k: int, twist: FloatArray, segments: FloatArray) -> float:
    (view,) = drifting.at([k], twist[None])
    share = _coverage(drifting, k, twist, segments)
    uv, _ = project_points(view.projection, segments)
    along = uv[:, 1] - uv[:, 0]
    length = np.minimum(np.hypot(along[:, 0], along[:, 1]), LONGEST * view.camera.width)
    return float((np.where(share > SHOWN, share, 0.0) ** 2 * length).sum())
