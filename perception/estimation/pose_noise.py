"""Errors beyond the pixels' own: of the views' poses, and shared by neighbouring views."""

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.estimation.point_filter import estimate_points
from facetlog.perception.stable_order import TIE, choose_farthest_points
from facetlog.perception.types import FloatArray, View

# Start of the search for the pose error in the picture: typical of real poses, px.
START_NOISE_PX = 1.0
# Median of a chi-square with two degrees of freedom, over its mean.
MEDIAN_OVER_MEAN = 2 * np.log(2) / 2


def estimate_pose_noise_px(
    uv: FloatArray, cov: FloatArray, seen: NDArray[np.bool_], projections: FloatArray
) -> float:
    """Return the standard deviation in px, per axis, of residuals beyond the corners' own noise.

    Shapes as in `estimate_points`. Robust: from the median of the residuals over all tracks.
    """
    loose = cov + START_NOISE_PX**2 * np.eye(2)
    points, _, used, ok = estimate_points(uv, loose, seen, projections)
    used = used & ok[:, None]
    if not used.any():
        return START_NOISE_PX
    h = np.einsum("vij,nj->nvi", projections[:, :, :3], points) + projections[:, :, 3]
    with np.errstate(invalid="ignore"):
        residual = uv - h[..., :2] / h[..., 2:]
    # A point uses up three degrees of freedom of its n observations' 2 n numbers.
    freedom = np.maximum(1.0 - 1.5 / np.maximum(used.sum(axis=1), 2), 0.25)
    square = ((residual**2).sum(axis=-1) / 2 / freedom[:, None])[used]
    own = (np.trace(cov, axis1=2, axis2=3) / 2)[used]
    excess = np.median(square) / MEDIAN_OVER_MEAN - np.median(own)
    return float(np.sqrt(max(excess, 0.0)))


def compute_pixel_covs(view: View, points: FloatArray) -> FloatArray:
    """Return covariances (n, 2, 2), px², that the view's `pose_cov` gives the pixels of points (n,
    3) in front of it; 0 where nothing is stated. They are those of each point by itself.
    """
    if view.pose_cov is None:
        return np.zeros((len(points), 2, 2))
    to_camera = view.pose.rotation.T
    apart = points - view.pose.centre
    x, y, z = (apart @ to_camera.T).T
    # R = exp(ω) R0, so that Rᵀ (p - c) changes by -Rᵀ dc + Rᵀ (p - c) x dω.
    crossed = np.cross(apart[:, None], np.eye(3)).swapaxes(1, 2)
    by_pose = np.concatenate([np.tile(-np.eye(3), (len(points), 1, 1)), crossed], axis=2)
    by_place = np.zeros((len(points), 2, 3))
    by_place[:, 0, 0], by_place[:, 0, 2] = view.camera.fx / z, -view.camera.fx * x / z**2
    by_place[:, 1, 1], by_place[:, 1, 2] = view.camera.fy / z, -view.camera.fy * y / z**2
    J = by_place @ to_camera @ by_pose
    covs: FloatArray = J @ view.pose_cov @ J.swapaxes(1, 2)
    return covs


# Groups of views: enough for a variance, few enough that a group spans correlated views.
GROUPS = 8


def view_groups(centres: FloatArray, count: int = GROUPS) -> NDArray[np.intp]:
    """Return the number of the group of neighbours of each camera centre (V, 3), in any order and
    frame.

    A camera half-way between groups goes to the smallest of them.
    """
    apart = np.linalg.norm(centres[:, None] - centres[None], axis=-1)
    to_seed = apart[:, choose_farthest_points(apart, count)]
    near = to_seed <= to_seed.min(axis=1, keepdims=True) + TIE * apart.max()
    group: NDArray[np.intp] = near.argmax(axis=1)
    halfway = near.sum(axis=1) > 1
    size = np.bincount(group[~halfway], minlength=near.shape[1])
    for k in np.flatnonzero(halfway):
        group[k] = np.where(near[k], size, len(centres)).argmin()
        size[group[k]] += 1
    return group


def estimate_shared_error_factor(
    uv: FloatArray,
    cov: FloatArray,
    used: NDArray[np.bool_],
    projections: FloatArray,
    covs: FloatArray,
    groups: NDArray[np.intp],
) -> float:
    """Return by how much the points' covariances (n, 3, 3) are too small; at least 1.

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
