"""Pixel errors caused by pose errors: from residuals, or propagated from a pose covariance."""

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.estimation.point_filter import estimate_points
from facetlog.perception.types import FloatArray, View

__all__ = ["pixel_covs", "pose_noise_px"]

# Start of the search for the pose error in the picture: typical of real poses, px.
START_NOISE_PX = 1.0
# Median of a chi-square with two degrees of freedom, over its mean.
MEDIAN_OVER_MEAN = 2 * np.log(2) / 2


def pose_noise_px(
    uv: FloatArray, cov: FloatArray, seen: NDArray[np.bool_], projections: FloatArray
) -> float:
    """Standard deviation in px, per axis, of residuals beyond the corners' own noise.

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


def pixel_covs(view: View, points: FloatArray) -> FloatArray:
    """Covariances (n, 2, 2), px², that the view's `pose_cov` gives the pixels of points (n, 3) in
    front of it; 0 where nothing is stated. They are those of each point by itself.
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
