"""Maximum-likelihood points from the views in a mask: linear start, then re-linearised passes.

The recursion of equations (3) to (5) with every view made linear at one shared point is a linear
Kalman filter, so its result does not depend on the order of the views; in information form it is
a sum over the views (S⁻¹ = S0⁻¹ + Σ Mᵀ W⁻¹ M). Passes are repeated, each with a fresh S0, until
the shared point stands still: that is the Gauss-Newton iteration, and its limit the maximum of the
likelihood. All in the neutral frame of `Cameras`.
"""

from dataclasses import dataclass

import numpy as np

from facetlog.perception.point_views import (
    BoolArray,
    Cameras,
    IndexArray,
    Sightings,
    normal_equations,
    whiten,
)
from facetlog.perception.types import FloatArray

__all__ = ["START_SD", "Fit", "assess", "fit_points", "linear_start", "view_chi2"]

# Standard deviation of the fresh S0, in distances from the cameras to the point: "a large S0". At
# the vaguest depth that passes for a point it weighs 1e-5 of the information; a larger one would
# cost the recursion more digits by cancellation than that.
START_SD = 1e2
# Passes of the implicit measurement that weigh each view by its depth, before the explicit ones;
# after three the weights move by less than the noise (accuracy_estimation.py).
WEIGHTING_PASSES = 3
# The implicit weight 1/depth² is kept from growing without bound: least depth as a share of the
# distance to the camera (a point 3° off the plane of the pinhole).
LEAST_DEPTH_SHARE = 0.05
# The passes end when none moves a point by more than this (unit: its own standard deviation); as
# each shrinks the error some hundredfold, what remains is smaller still.
CONVERGED_SD = 1e-4
MAX_PASSES = 25
# Damping after a pass that made the fit worse (Levenberg-Marquardt; share of the diagonal).
FIRST_DAMPING = 1e-3


@dataclass(frozen=True, eq=False, slots=True)
class Fit:
    """Points (n, 3), covariances (n, 3, 3), depths (n, V), whitened residuals (n, 2, V) and
    Jacobians (n, 3, 2, V), for all views, in the mask or not."""

    points: FloatArray
    covs: FloatArray
    depth: FloatArray
    residual: FloatArray
    jacobian: FloatArray

    @property
    def arrays(self) -> tuple[FloatArray, ...]:
        """The fields in order, each with the points along its first axis."""
        return self.points, self.covs, self.depth, self.residual, self.jacobian

    def put(self, index: IndexArray, other: "Fit", rows: BoolArray) -> None:
        """Overwrite the points `index` by the `rows` of another fit."""
        for mine, theirs in zip(self.arrays, other.arrays, strict=True):
            mine[index] = theirs[rows]


def _regular(H: FloatArray) -> FloatArray:
    # Parallel rays leave H singular; the ridge keeps the solution finite and far away.
    trace = np.trace(H, axis1=1, axis2=2)[:, None, None]
    ridge: FloatArray = (1e-12 * trace + np.finfo(np.float64).tiny) * np.eye(3)
    return H + ridge


def linear_start(
    cameras: Cameras,
    seen: Sightings,
    views: IndexArray | None = None,
    owner: IndexArray | None = None,
) -> FloatArray:
    """Points nearest to the rays of what was seen, then weighed by their depths.

    One point (n, 3) for each of the sightings, from all its views; or with `owner` (q,) and `views`
    (q, w) points (q, 3), each from w views (none twice) of the sighting that it names.

    The first solution needs no depth; the later ones are the paper's implicit equations,
    (p12 - uv p3) a = -(p124 - uv p34), with W = depth² Λ taken at the solution before.
    """
    P = cameras.projections.transpose(2, 1, 0)
    rays = cameras.rays(seen.uv) * seen.seen[:, None]
    implicit = whiten(seen.factors, P[:, :2] - seen.uv[:, None] * P[:, 2:])
    implicit *= seen.seen[:, None, None]
    p3, centres = P[None, :, 2], cameras.centres.T[None]
    if views is not None and owner is not None:
        rows = owner[:, None]
        rays = rays.transpose(0, 2, 1)[rows, views].transpose(0, 2, 1)
        implicit = implicit.transpose(0, 3, 1, 2)[rows, views].transpose(0, 2, 3, 1)
        p3 = cameras.projections[views, 2].transpose(0, 2, 1)
        centres = cameras.centres[views].transpose(0, 2, 1)
    # Σ (I - d dᵀ) (a - c) = 0 over the unit rays d
    lengths = (rays * rays).sum(axis=1)
    H = lengths.sum(axis=1)[:, None, None] * np.eye(3) - rays @ rays.transpose(0, 2, 1)
    along = (rays * centres).sum(axis=1)
    b = (centres * lengths[:, None] - rays * along[:, None]).sum(axis=2)
    points = np.linalg.solve(_regular(H), b[:, :, None])[:, :, 0]
    rows4 = implicit.reshape(*implicit.shape[:2], 2 * implicit.shape[3])
    for _ in range(WEIGHTING_PASSES):
        depth = (points[:, :, None] * p3[:, :3]).sum(axis=1) + p3[:, 3]
        away2 = ((points[:, :, None] - centres) ** 2).sum(axis=1)
        least2 = LEAST_DEPTH_SHARE**2 * away2 + np.finfo(np.float64).eps ** 2
        weight = np.tile(1.0 / np.maximum(depth * depth, least2), 2)
        G = (rows4 * weight[:, None]) @ rows4.transpose(0, 2, 1)
        points = np.linalg.solve(_regular(G[:, :3, :3]), -G[:, :3, 3:])[:, :, 0]
    return points


def assess(cameras: Cameras, seen: Sightings, mask: BoolArray, points: FloatArray) -> Fit:
    """The given points, how each view sees them, and the covariance that the masked views give.

    The covariance is that of one pass of the recursion from a fresh S0, all views made linear at
    the point.
    """
    pixels, depth = cameras.project(points)
    residual = whiten(seen.factors, seen.uv - pixels)
    jacobian = whiten(seen.factors, cameras.jacobian(pixels, depth))
    H, _ = normal_equations(jacobian, residual, mask)
    away = np.linalg.norm(points[:, None, :] - cameras.centres, axis=2)
    distance = (away * mask).sum(axis=1) / np.maximum(mask.sum(axis=1), 1)
    fresh = (START_SD * np.maximum(distance, np.finfo(np.float64).eps)) ** -2.0
    covs = np.linalg.inv(H + fresh[:, None, None] * np.eye(3))
    return Fit(points, (covs + covs.transpose(0, 2, 1)) / 2, depth, residual, jacobian)


def _linearise(
    cameras: Cameras, seen: Sightings, mask: BoolArray, points: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Cost (n,), infinite behind a masked camera, and H (n, 3, 3), g (n, 3) of the next move."""
    pixels, depth = cameras.project(points)
    residual = whiten(seen.factors, seen.uv - pixels)
    jacobian = whiten(seen.factors, cameras.jacobian(pixels, depth))
    cost = ((residual**2).sum(axis=1) * mask).sum(axis=1)
    cost[((depth <= 0) & mask).any(axis=1)] = np.inf
    H, g = normal_equations(jacobian, residual, mask)
    return cost, _regular(H), g


def fit_points(cameras: Cameras, seen: Sightings, mask: BoolArray, start: FloatArray) -> Fit:
    """The maximum-likelihood points of the masked views, from `start` (n, 3).

    A start behind one of its cameras stays where it is: the caller sees it by the depths.
    """
    points = start.copy()
    cost, H, g = _linearise(cameras, seen, mask, points)
    damping = np.zeros(len(points))
    moving = np.flatnonzero(np.isfinite(cost))
    for _ in range(MAX_PASSES):
        if not moving.size:
            break
        here = H[moving]
        diagonal = damping[moving, None] * np.einsum("nii->ni", here)
        move = np.linalg.solve(here + diagonal[:, :, None] * np.eye(3), g[moving, :, None])[:, :, 0]
        trial = points[moving] + move
        new_cost, new_H, new_g = _linearise(cameras, seen.take(moving), mask[moving], trial)
        better = new_cost <= cost[moving]
        taken = moving[better]
        points[taken], cost[taken] = trial[better], new_cost[better]
        H[taken], g[taken] = new_H[better], new_g[better]
        raised = np.maximum(10 * damping[moving], FIRST_DAMPING)
        lowered = damping[moving] / 10
        damping[moving] = np.where(better, np.where(lowered < FIRST_DAMPING, 0.0, lowered), raised)
        small = np.einsum("ni,nij,nj->n", move, here, move) < CONVERGED_SD**2
        moving = moving[~small]
    return assess(cameras, seen, mask, points)


def view_chi2(fit: Fit, mask: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Chi-square (n, V) of each view's pixel, and how much its log volume exceeds the noise's.

    Of a masked view the residual counts as it is (its own share in the point makes it smaller, if
    anything); of another view it is the innovation, whose covariance has the point's added.
    """
    r0, r1 = fit.residual[:, 0], fit.residual[:, 1]
    n, _, _, views = fit.jacobian.shape
    SJ = (fit.covs @ fit.jacobian.reshape(n, 3, 2 * views)).reshape(n, 3, 2, views)
    outside = ~mask
    a = 1.0 + (fit.jacobian[:, :, 0] * SJ[:, :, 0]).sum(axis=1) * outside
    b = (fit.jacobian[:, :, 0] * SJ[:, :, 1]).sum(axis=1) * outside
    c = 1.0 + (fit.jacobian[:, :, 1] * SJ[:, :, 1]).sum(axis=1) * outside
    determinant = a * c - b * b
    chi2 = (c * r0 * r0 - 2.0 * b * r0 * r1 + a * r1 * r1) / determinant
    return chi2, np.log(determinant)
