"""Views brought into agreement by the straight edges that they show, so that faces can be found.

Poses that err one by one by some tenths of a degree leave edges off by more than a search across
them reaches. In a small picture, and with edges that reach further, they are off by less; so views
and 3-D segments are fitted together from coarse pictures to fine ones. Poses in agreement need not
be the right ones, only good enough to tell what belongs together: what is measured then is weighed
with the poses that were given (bundle_adjustment/).
"""

from collections.abc import Sequence

import numpy as np

from facetlog.perception.detection.edge_maps import EdgeMap
from facetlog.perception.detection.view_graph import view_graph
from facetlog.perception.estimation.pose_refinement.fitting import fitted, lines_of, smaller
from facetlog.perception.estimation.pose_refinement.line_alignment import DriftingViews
from facetlog.perception.estimation.pose_refinement.pose_chain import SinglePoses, of_twist
from facetlog.perception.types import FloatArray, View

__all__ = ["in_agreement"]

POSE_SD = np.radians(1.0)
"""Of turns, and of places as seen from the cameras' distance: about how far poses may be off. Large
enough to leave the say to the pictures."""
WELL_EXPLAINED = 0.9
"""Where so much of the pictures' segments lies on 3-D segments nothing is tried: right poses of
rendered worlds have .87 to 1, poses off by .3 degrees .7 to .8."""
LEVELS = (
    ((1 / 3, None), (1 / 2, None), (1.0, None)),
    ((1 / 4, 4.0), (1 / 4, None), (1 / 3, None), (1 / 2, None), (1.0, None)),
)
"""Shares of the pictures' size, and how far edges reach there (px); the coarser way is gone where
the finer one does not lead to agreement."""
SEARCH_PX = (4.0, 3.0, 2.0, 2.0, 2.0)
"""Width searched across projected segments in successive fits."""
GAIN = 0.02
"""Of the explained share, for which poses are moved."""


def in_agreement(
    views: Sequence[View],
    maps: Sequence[EdgeMap],
    segments: Sequence[FloatArray],
) -> tuple[View, ...]:
    """The views at poses at which their straight segments (n, 4) agree; as given if they do so."""
    graph = view_graph(views)
    cov = POSE_SD**2 * np.diag([graph.distance**2] * 3 + [1.0] * 3)
    covs = np.array([of_twist(v.pose, cov, graph.focus) for v in views])
    prior = SinglePoses(graph.focus, covs)
    full = DriftingViews(tuple(views), tuple(maps), tuple(segments), prior)
    best = np.zeros((len(views), 6))
    given = most = lines_of(full, best).explained
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
    return full.at(range(len(views)), best)
