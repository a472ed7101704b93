"""Tracks into points, with the poses adjusted to what all tracks show together (adjust.py).

Inliers cannot be chosen before the poses are right, nor poses be estimated from wrong matches. So
all observations of a point take part at first, with a robust weight; then the inliers are chosen
anew at the adjusted poses, and only these are used.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.estimation.bundle_adjustment.adjust import Adjusted, adjust
from facetlog.perception.estimation.bundle_adjustment.error_sizes import LEAST_PX
from facetlog.perception.estimation.bundle_adjustment.normal_equations import Tracks
from facetlog.perception.estimation.point_filter import estimate_points
from facetlog.perception.estimation.pose_noise import (
    pose_noise_px,
    shared_error_factor,
    view_groups,
)
from facetlog.perception.types import FloatArray, PoseErrors, View


def without_common_motion(points: FloatArray, own: FloatArray, shared: FloatArray) -> FloatArray:
    """Return covariances (n, 3, 3) of points (n, 3) after the best rigid alignment of all with the
    truth.

    Before it the errors of points i and j have the covariance δij own_i + shared_iᵀ shared_j, with
    `own` (n, 3, 3) and `shared` (n, m, 3). The alignment weights points by their precision.
    """
    covs: FloatArray = own + shared.transpose(0, 2, 1) @ shared
    if not len(points):
        return covs
    weight = 1.0 / np.trace(covs, axis1=1, axis2=2)
    arm = points - weight @ points / weight.sum()
    arm = arm / max(float(np.abs(arm).max()), np.finfo(np.float64).tiny)
    # A shift, and a rotation vector, which moves a point by rotation × arm.
    x, y, z = arm.T
    by_motion = np.zeros((len(points), 3, 6))
    by_motion[:, :, :3] = np.eye(3)
    by_motion[:, 0, 4], by_motion[:, 0, 5] = z, -y
    by_motion[:, 1, 3], by_motion[:, 1, 5] = -z, x
    by_motion[:, 2, 3], by_motion[:, 2, 4] = y, -x
    weighted = by_motion * weight[:, None, None]
    # One or two points leave some rotations undetermined: these are set to zero.
    solve = np.linalg.pinv(np.einsum("nia,nib->ab", weighted, by_motion), hermitian=True)
    motion = weighted @ solve  # (n, 3, 6): the best motion is its sum over the errors
    of_shared = np.einsum("nmi,nia->ma", shared, motion)
    with_motion = own @ motion + shared.transpose(0, 2, 1) @ of_shared
    of_motion = np.einsum("nia,nib->ab", motion, with_motion)
    cross = with_motion @ by_motion.transpose(0, 2, 1)
    return np.asarray(
        covs
        - cross
        - cross.transpose(0, 2, 1)
        + by_motion @ of_motion @ by_motion.transpose(0, 2, 1)
    )


LEAST_POINTS = 4
"""Fewer points do not constrain six unknowns a view and three a point."""
CHOICES = 2
"""Choices of inliers, each at better poses."""


@dataclass(frozen=True, eq=False, slots=True)
class AdjustedPoints:
    """Views adjusted in pose and focal length; points (n, 3), covs (n, 3, 3), used (n, V), ok (n,).

    As of `estimate_points`, pose errors included, and `shape_covs` (n, 3, 3) without the common
    motion of all points (common_motion.py); `extra_px` is the pixel noise beyond the pixels' own
    covariances, `factor` by how much all these variances are too small because neighbouring views
    share errors. `adjusted` is None where there were too few points to adjust poses.
    """

    views: tuple[View, ...]
    points: FloatArray
    covs: FloatArray
    shape_covs: FloatArray
    used: NDArray[np.bool_]
    ok: NDArray[np.bool_]
    extra_px: float
    factor: float = 1.0
    adjusted: Adjusted | None = None


def adjusted_points(
    tracks: Tracks,
    views: Sequence[View],
    errors: PoseErrors | None = None,
    lens_is_off: bool = False,
) -> AdjustedPoints:
    """Return the points of tracks whose `used` says what was seen; not adjusted where these are too
    few.

    `errors` are the stated errors of the views' poses; `lens_is_off` as of `adjust`. Residuals
    weighted by the corners' own covariances are too small where the most certain corners are
    overconfident; so the pixel noise is at least that of the unweighted residuals (pose_noise.py).
    """
    extra_px = _pose_noise_px(tracks, views)
    found = _estimated(tracks, views, extra_px)
    used = tracks.used & found.ok[:, None] & _in_front(found)
    done: Adjusted | None = None
    least_px = LEAST_PX
    for choice in range(1 + CHOICES):
        chosen = np.flatnonzero(found.ok & (used.sum(axis=1) >= 2))
        if len(chosen) < LEAST_POINTS:
            break
        of_chosen = replace(tracks, used=used).rows(chosen)
        start = found.points[chosen]
        done = adjust(of_chosen, views, start, errors, extra_px, done, least_px, lens_is_off)
        straight = done.undistorted(tracks)
        found = _estimated(straight, done.views, done.sizes.extra_px)
        before, used = used, found.used
        if choice and (used == before).all():
            break
        least_px = max(_pose_noise_px(straight, done.views), LEAST_PX)
    straight = tracks if done is None else done.undistorted(tracks)
    projections = np.array([v.projection for v in found.views])
    groups = view_groups(np.array([v.pose.centre for v in found.views]))
    noise = tracks.noise(found.extra_px)
    factor = shared_error_factor(straight.uv, noise, found.used, projections, found.covs, groups)
    return _honest(tracks, replace(found, factor=factor, adjusted=done))


def points_at(tracks: Tracks, at: AdjustedPoints) -> AdjustedPoints:
    """Return the points of tracks at the adjusted poses, with the errors of these in their
    covariances.
    """
    straight = tracks if at.adjusted is None else at.adjusted.undistorted(tracks)
    found = _estimated(straight, at.views, at.extra_px)
    return _honest(tracks, replace(found, factor=at.factor, adjusted=at.adjusted))


def _honest(tracks: Tracks, found: AdjustedPoints) -> AdjustedPoints:
    # The points with covariances that include pose errors and errors that views share.
    covs, ok = found.factor * found.covs, found.ok
    shape_covs = covs.copy()
    if found.adjusted is not None:
        of_ok, points = replace(tracks, used=found.used).rows(ok), found.points[ok]
        own, shared = found.adjusted.errors_at(of_ok, points, found.factor)
        covs[ok] = own + shared.transpose(0, 2, 1) @ shared
        shape_covs[ok] = without_common_motion(points, own, shared)
    return replace(found, covs=covs, shape_covs=shape_covs)


def _pose_noise_px(tracks: Tracks, views: Sequence[View]) -> float:
    projections = np.array([v.projection for v in views])
    return pose_noise_px(tracks.uv, tracks.cov, tracks.used, projections)


def _estimated(tracks: Tracks, views: Sequence[View], extra_px: float) -> AdjustedPoints:
    projections = np.array([v.projection for v in views])
    cov = tracks.noise(extra_px)
    points, covs, used, ok = estimate_points(tracks.uv, cov, tracks.used, projections)
    return AdjustedPoints(tuple(views), points, covs, covs, used, ok, extra_px)


def _in_front(found: AdjustedPoints) -> NDArray[np.bool_]:
    third = np.array([v.projection[2] for v in found.views])
    depth = np.nan_to_num(found.points) @ third[:, :3].T + third[:, 3]
    return np.asarray(depth > 0)
