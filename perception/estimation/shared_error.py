"""Inflation of points' covariances for errors that neighbouring views share.

Neighbouring views have nearly the same pose error, so residuals are small and the filter is
overconfident. Leaving out whole groups of neighbouring views shows it: the grouped jackknife (Shao
and Tu 1995, section 2.3) needs no model of the shared errors.
"""

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.estimation.point_filter import estimate_points
from facetlog.perception.stable_order import TIE, farthest_points
from facetlog.perception.types import FloatArray

__all__ = ["shared_error_factor", "view_groups"]

# Groups of views: enough for a variance, few enough that a group spans correlated views.
GROUPS = 8


def view_groups(centres: FloatArray, count: int = GROUPS) -> NDArray[np.intp]:
    """For each camera centre (V, 3) the number of its group of neighbours; any order, any frame.

    A camera half-way between groups goes to the smallest of them.
    """
    apart = np.linalg.norm(centres[:, None] - centres[None], axis=-1)
    to_seed = apart[:, farthest_points(apart, count)]
    near = to_seed <= to_seed.min(axis=1, keepdims=True) + TIE * apart.max()
    group: NDArray[np.intp] = near.argmax(axis=1)
    halfway = near.sum(axis=1) > 1
    size = np.bincount(group[~halfway], minlength=near.shape[1])
    for k in np.flatnonzero(halfway):
        group[k] = np.where(near[k], size, len(centres)).argmin()
        size[group[k]] += 1
    return group


def shared_error_factor(
    uv: FloatArray,
    cov: FloatArray,
    used: NDArray[np.bool_],
    projections: FloatArray,
    covs: FloatArray,
    groups: NDArray[np.intp],
) -> float:
    """By how much the points' covariances (n, 3, 3) are too small; at least 1.

    uv, cov, `used` and projections as in `estimate_points`; `groups` (V,) as by `view_groups`. The
    median over the points of the grouped jackknife's variance over the filter's.
    """
    without = []
    for group in np.unique(groups):
        points, _, _, ok = estimate_points(uv, cov, used & (groups != group), projections)
        points[~ok] = np.nan
        without.append(points)
    left_out = np.array(without)
    complete = np.isfinite(left_out).all(axis=(0, 2))
    if not complete.any() or len(left_out) < 3:
        return 1.0
    spread = left_out[:, complete] - left_out[:, complete].mean(axis=0)
    count = len(left_out)
    # In units of the filter's own covariance: squared distance over its three dimensions.
    whitened = np.einsum("gni,nij,gnj->gn", spread, np.linalg.inv(covs[complete]), spread)
    ratio = (count - 1) / count * whitened.sum(axis=0) / 3
    return float(max(1.0, np.median(ratio)))
