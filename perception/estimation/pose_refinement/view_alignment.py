"""Views with independent pose errors, aligned coarse to fine by their straight edges.

Pose errors of some tenths of a degree leave edges off by more than a search across them reaches. In
a small picture, and with edges that reach further, they are off by fewer pixels; so views and 3-D
segments are fitted together from coarse pictures to fine ones. The aligned poses need not be right,
only consistent enough to find correspondences: the measurements are then weighted with the given
poses (bundle_adjustment/).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.edge_maps import EdgeMap
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.detection.line_front_end.segments_3d.pose_consistency import (
    measure_share_explained,
)
from facetlog.perception.detection.view_graph import view_graph
from facetlog.perception.estimation.pose_refinement.line_alignment import (
    DriftingViews,
    align,
    fitted,
    lines_of,
    smaller,
)
from facetlog.perception.estimation.pose_refinement.pose_chain import (
    TwistPrior,
    convert_to_twist_cov,
)
from facetlog.perception.types import FloatArray, View

POSE_SD = np.radians(1.0)
"""Prior standard deviation of rotations, and of places as seen from the cameras' distance. Large
enough that the pictures decide."""
WELL_EXPLAINED = 0.9
"""Explained share of the pictures' segments from which on views stay as they are: right poses of
rendered worlds have .87 to 1, poses off by .3 degrees .7 to .8."""
LEVELS = (
    ((1 / 3, None), (1 / 2, None), (1.0, None)),
    ((1 / 4, 4.0), (1 / 4, None), (1 / 3, None), (1 / 2, None), (1.0, None)),
)
"""Scales of the pictures, and how far edges reach there (px); the coarser scales are used where the
finer ones do not lead to alignment."""
SEARCH_PX = (4.0, 3.0, 2.0, 2.0, 2.0)
"""Width searched across projected segments in successive fits."""
MOVED_SHARE, MOVED = 0.2, 0.5
"""Views also stay as they are where a fit to the present segments moves less than a fifth of them
by half of what edges reach, 1 px: sets with right poses (eight path-traced, three photographed)
moved by .25 to .99 px, own worlds off by .1 to 1 degree by 1.1 to 3.4."""
GAIN = 0.02
"""Least gain of the explained share for which poses are changed."""


def align_views(
    views: Sequence[View],
    maps: Sequence[EdgeMap],
    segments: Sequence[FloatArray],
    lines: FloatArray,
    use: NDArray[np.bool_],
) -> tuple[View, ...] | None:
    """Return the views at poses where their straight segments (n, 4) agree; None where they already
    do.

    `lines` (n, 2, 3) are the 3-D segments at the poses given, `use` (n, V) which view shows which.
    """
    given = most = measure_share_explained(lines, use, views, segments)
    if given >= WELL_EXPLAINED or not len(lines):
        return None
    graph = view_graph(views)
    cov = POSE_SD**2 * np.diag([graph.distance**2] * 3 + [1.0] * 3)
    covs = np.array([convert_to_twist_cov(v.pose, cov, graph.focus) for v in views])
    prior = TwistPrior(graph.focus, covs, chain=False)
    full = DriftingViews(tuple(views), tuple(maps), tuple(segments), prior)
    best = np.zeros((len(views), 6))
    twists, _ = align(full, best, lines, use, SEARCH_PX[0])
    if not _moved(full, twists, lines, use):
        return None
    for levels in LEVELS:
        if most >= WELL_EXPLAINED:
            break
        twists = np.zeros_like(best)
        for share, reach_px in levels:
            there = full if share == 1.0 else smaller(full, share, reach_px)
            twists, _ = fitted(there, twists, SEARCH_PX)
        explained = lines_of(full, twists).explained
        if explained > max(most, given + GAIN):
            best, most = twists, explained
    return full.at(range(len(views)), best) if best.any() else None


def _moved(
    full: DriftingViews, twists: FloatArray, lines: FloatArray, use: NDArray[np.bool_]
) -> bool:
    """Return whether the 3-D segments move significantly in the pictures of many views."""
    motion = []
    for k, view in enumerate(full.at(range(len(full.views)), twists)):
        ends = lines[use[:, k]]
        if len(ends):
            before, _ = project_points(full.views[k].projection, ends)
            after, _ = project_points(view.projection, ends)
            shift = float(np.median(np.linalg.norm(after - before, axis=-1)))
            motion.append(shift / full.maps[k].reach_px)
    return bool(motion) and float(np.quantile(motion, 1 - MOVED_SHARE)) > MOVED
