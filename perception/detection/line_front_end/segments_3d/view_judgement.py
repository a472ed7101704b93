"""Outlier views: a gross pose error, or a picture that belongs to another pose.

A view is tested against the 3-D segments that three of the other views show: they explain about as
much of its straight edges as of the others' edges, and hardly anything where its pose is wrong. The
threshold follows from the spread of the other views, and from the share explained by chance, that
of the same edges at the poses of the other pictures. A right view may have many edges of its own,
as of grain that others see from another side; but it shows about as many of the segments as others
do, and a wrong one hardly any.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import MIN_SUPPORT
from facetlog.perception.detection.line_front_end.segments_3d.pose_consistency import (
    MIN_VIEWS,
    explained_length,
)
from facetlog.perception.detection.tracked_faces import TrackedFaces
from facetlog.perception.types import FloatArray, View

__all__ = ["Contradiction", "contradicting_views", "without_them"]

# Robust standard deviations below the median of all: one right view of 700 is that far off.
OUTLIER_SDS = 3.0
MEDIAN_OF_NORMAL = 0.6745
# The share of a picture explained by chance: this quantile over the poses of all others, of which a
# few neighbours' may be almost its own.
CHANCE = 0.9
# A view contradicts the others if not even this share of the way from chance to the usual is
# explained. Views off by 3 degrees and more stay below .23, true ones of 15 sets at .44 and above.
MIN_ABOVE_CHANCE = 1 / 3
# It must also show less than this share of the segments that views usually show. Views with another
# view's pose show .3 of that at most, right ones .7 and more.
MIN_SHOWN = 0.5


@dataclass(frozen=True, slots=True)
class Contradiction:
    """A view (index), the share of its straight edges that the others explain, the usual share."""

    view: int
    explained: float
    usual: float


def contradicting_views(
    segments_3d: FloatArray,
    supported: NDArray[np.bool_],
    weight: FloatArray,
    views: Sequence[View],
    segments_2d: Sequence[FloatArray],
) -> tuple[Contradiction, ...]:
    """The views that the others contradict; none where these are not a small minority.

    `supported` (m, V) says which 3-D segments (m, 2, 3) are seen in which view, `weight` (V,) how
    much a view counts beside those almost like it; `segments_2d` are the views' own, each (n, 4).
    """
    if len(views) < MIN_VIEWS or not len(segments_3d):
        return ()
    support = (supported * weight).sum(axis=1)
    shares, shown = np.full(len(views), np.nan), np.zeros(len(views))
    for k, (view, found) in enumerate(zip(views, segments_2d, strict=True)):
        of_others = support - supported[:, k] * weight[k] >= MIN_SUPPORT
        shown[k] = supported[of_others, k].mean() if of_others.any() else 0.0
        explained, total = explained_length(segments_3d[of_others], view, found)
        if total > 0.0:
            shares[k] = explained / total
    judged = np.isfinite(shares)
    if judged.sum() < MIN_VIEWS:
        return ()
    usual = float(np.median(shares[judged]))
    spread = float(np.median(np.abs(shares[judged] - usual))) / MEDIAN_OF_NORMAL
    # The share of n segments is known to 1 / 2√n at worst.
    sds = np.sqrt(spread**2 + 0.25 / np.maximum(_independent(segments_2d), 1.0))
    strange = np.nan_to_num(shares, nan=np.inf) < usual - OUTLIER_SDS * sds
    low = np.flatnonzero(strange & (shown < MIN_SHOWN * np.median(shown[judged])))
    found_wrong = [
        Contradiction(k, float(shares[k]), usual)
        for k in low.tolist()
        if shares[k] < _least(_chance(k, segments_3d, views, segments_2d[k]), usual)
    ]
    return tuple(found_wrong) if len(views) - len(found_wrong) >= MIN_VIEWS else ()


def _independent(segments_2d: Sequence[FloatArray]) -> FloatArray:
    """As how many segments of one length those of each view (n, 4) count: (Σ l)² / Σ l², (V,)."""
    lengths = [np.linalg.norm(found[:, 2:] - found[:, :2], axis=1) for found in segments_2d]
    return np.array([own.sum() ** 2 / max(float(own @ own), 1e-300) for own in lengths])


def _least(chance: float, usual: float) -> float:
    return chance + MIN_ABOVE_CHANCE * (usual - chance)


def _chance(k: int, segments_3d: FloatArray, views: Sequence[View], found: FloatArray) -> float:
    """The share of view k's segments (n, 4) explained by chance, at the poses of the others."""
    shares = []
    for j, other in enumerate(views):
        if j != k:
            there = replace(views[k], pose=other.pose)
            explained, total = explained_length(segments_3d, there, found)
            shares.append(explained / total)
    return float(np.quantile(shares, CHANCE))


def without_them(
    wrong: Sequence[Contradiction],
    views: Sequence[View],
    track: Callable[[Sequence[int]], TrackedFaces],
) -> TrackedFaces:
    """What `track` finds in the other views (indices), with a warning for each left out."""
    out = {c.view for c in wrong}
    kept = [k for k in range(len(views)) if k not in out]
    rest = track(kept)
    warnings = (
        f"{views[c.view].name}: pose and picture contradict the other views, left out: "
        f"{c.explained:.0%} of its straight edges agree with theirs, usual are {c.usual:.0%}; "
        "check that the pose is this picture's"
        for c in wrong
    )
    used = kept if rest.used is None else [kept[k] for k in rest.used]
    return replace(rest, used=tuple(used), warnings=(*warnings, *rest.warnings))
