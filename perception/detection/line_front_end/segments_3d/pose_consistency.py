"""Whether pictures and poses are consistent: the share of the pictures' segments explained."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.errors import InconsistentViewsError
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import MIN_SUPPORT
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.name_lists import named
from facetlog.perception.stable_order import at_least
from facetlog.perception.types import FloatArray, View

# A 2-D segment is explained by a projected 3-D one that passes this near and this parallel.
NEAR_PX = 3.0
PARALLEL_COSINE = np.cos(np.radians(6.0))
# Rendered worlds with true poses have 0.8 to 1.0 explained, with shuffled ones 0 to 0.17; real
# pictures with a background that moves by itself 0.4 (benchmarks/pictures/accuracy_no_box.py).
MIN_EXPLAINED = 0.25
# A smaller total length of segments a view, in picture diagonals, is too little evidence.
MIN_LENGTH = 0.5
# A 3-D segment needs three views: with fewer than twice as many, most segments are seen by too few
# however right the poses are.
MIN_VIEWS = 6


def measure_share_explained(
    segments_3d: FloatArray,
    supported: NDArray[np.bool_],
    views: Sequence[View],
    segments_2d: Sequence[FloatArray],
) -> float:
    """Return the share (by length) of the views' segments (n, 4) that 3-D segments (m, 2, 3)
    project onto.

    `supported` (m, V) says which 3-D segments are seen in which view. 1 where there are none.
    """
    explained, total = _lengths(segments_3d, supported, views, segments_2d).sum(axis=0)
    return float(explained / total) if total else 1.0


def _lengths(
    segments_3d: FloatArray,
    supported: NDArray[np.bool_],
    views: Sequence[View],
    segments_2d: Sequence[FloatArray],
) -> FloatArray:
    # Of each view the length that is explained, and of all its segments (V, 2).
    lengths = [
        measure_explained_length(segments_3d[supported[:, k]], view, found)
        for k, (view, found) in enumerate(zip(views, segments_2d, strict=True))
    ]
    return np.array(lengths).reshape(-1, 2)


def measure_explained_length(
    segments_3d: FloatArray, view: View, found: FloatArray
) -> tuple[float, float]:
    """Return the length in px of a view's segments (n, 4) that 3-D ones (m, 2, 3) explain, and of
    all.
    """
    along = found[:, 2:] - found[:, :2]
    length = np.hypot(along[:, 0], along[:, 1])
    if not len(segments_3d) or not len(found):
        return 0.0, float(length.sum())
    uv, _ = project_points(view.projection, segments_3d)
    span = uv[:, 1] - uv[:, 0]
    reach = np.maximum(np.hypot(span[:, 0], span[:, 1]), 1e-9)
    unit = span / reach[:, None]
    middle = (found[:, :2] + found[:, 2:]) / 2
    relative = middle[:, None] - uv[None, :, 0]
    off = np.abs(relative[..., 0] * unit[:, 1] - relative[..., 1] * unit[:, 0])
    place = (relative * unit).sum(axis=-1)
    parallel = np.abs((along / length[:, None]) @ unit.T) > PARALLEL_COSINE
    near = (off < NEAR_PX) & (place > -NEAR_PX) & (place < reach + NEAR_PX) & parallel
    return float(length[near.any(axis=1)].sum()), float(length.sum())


def check_consistency(
    segments_3d: FloatArray,
    supported: NDArray[np.bool_],
    weight: FloatArray,
    views: Sequence[View],
    segments_2d: Sequence[FloatArray],
) -> None:
    """Raise InconsistentViewsError where many segments are seen and hardly any agree in space.

    Fewer than MIN_VIEWS views are never called inconsistent, nor are views from fewer than three
    places: `weight` (V,) is how much a view counts beside those almost like it.
    """
    if len(views) < MIN_VIEWS or not at_least(weight.sum(), MIN_SUPPORT):
        return
    diagonal = float(np.mean([np.hypot(*v.image.shape) for v in views]))
    explained, total = _lengths(segments_3d, supported, views, segments_2d).T
    if total.sum() < MIN_LENGTH * diagonal * len(views):
        return
    share = explained.sum() / total.sum()
    if share < MIN_EXPLAINED:
        shares = explained / np.maximum(total, 1.0)
        least = [k for k in np.argsort(shares, kind="stable") if shares[k] < MIN_EXPLAINED]
        raise InconsistentViewsError(
            f"pictures and poses contradict each other: only {share:.0%} of the straight edges "
            f"agree between the {len(views)} views, least in "
            f"{named([views[k].name for k in least])}; "
            "check that each picture has its own pose"
        )
