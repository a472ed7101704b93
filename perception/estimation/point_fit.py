"""Maximum-likelihood points from weighted views: linear start, then re-linearised passes.

The recursion of equations (3) to (5) with every view linearised at one shared point is a linear
Kalman filter, so its result does not depend on the order of the views; in information form it is a
sum over the views (S⁻¹ = S0⁻¹ + Σ Mᵀ W⁻¹ M). Passes are repeated, each with a fresh S0, until the
shared point converges: that is the Gauss-Newton iteration, and its limit the maximum of the
likelihood. All in the neutral frame of `Cameras`; views that do not count have zero information.
Sums over views are matrix products of the pixels' contributions with the products of the
projections' rows, so that all points share them.
"""

from dataclasses import dataclass

import numpy as np

from facetlog.perception.estimation.point_views import Cameras
from facetlog.perception.types import FloatArray

# Standard deviation of the fresh S0, in distances from the cameras to the point: "a large S0". At
# the most uncertain depth that is accepted it adds 1e-5 of the information; a larger one would cost
# the recursion more digits by cancellation than that.
START_SD = 1e2
# The implicit weight 1/depth² is kept from growing without bound: least depth as a share of the
# distance to the camera (a point 3° off the plane of the pinhole).
LEAST_DEPTH_SHARE = 0.05
# Depths are kept this far from zero (unit: spread of the cameras) so that no division fails.
LEAST_DEPTH = 1e-12
# The passes end when none moves a point by more than this (unit: its own standard deviation); as
# each shrinks the error some hundredfold, what remains is smaller still.
CONVERGED_SD = 1e-3
MAX_PASSES = 25
# Damping after a pass that made the fit worse (Levenberg-Marquardt; share of the diagonal).
FIRST_DAMPING = 1e-3
# The chi-square of a view that has the point behind it: beyond every gate.
BEHIND_CHI2 = 1e300
# Share of the trace that is added to a system's diagonal, as parallel rays leave it singular: it
# then has a huge solution, which callers see by its size, in place of an exception for all others.
RIDGE = 1e-13
# What is added to a matrix of zeros; its reciprocal may still be squared.
ZERO_RIDGE = 1e-100


@dataclass(frozen=True, eq=False, slots=True)
class Fit:
    """Points (n, 3), their information (n, 3, 3), depths (n, V) and pixels' chi-squares (n, V).

    `information` is without any S0; `chi2` is zero for views that were given no weight.
    """

    points: FloatArray
    information: FloatArray
    depth: FloatArray
    chi2: FloatArray

    def covariances(self, distance: FloatArray) -> FloatArray:
        """Return S (n, 3, 3) after one pass from a fresh S0 for points at these distances (n,)."""
        fresh = (START_SD * np.maximum(distance, np.finfo(np.float64).eps)) ** -2.0
        S = np.linalg.inv(_add_ridge(self.information + fresh[:, None, None] * np.eye(3)))
        return np.asarray((S + S.swapaxes(1, 2)) / 2)


def _add_ridge(H: FloatArray) -> FloatArray:
    ridge = RIDGE * np.trace(H, axis1=1, axis2=2) + ZERO_RIDGE
    return np.asarray(H + ridge[:, None, None] * np.eye(3))


def solve_points(H: FloatArray, g: FloatArray) -> FloatArray:
    """Solve H x = g for positive semidefinite H (n, 3, 3) and g (n, 3); large where H is singular.

    >>> solve_points(np.diag([2.0, 4.0, 8.0])[None], np.ones((1, 3))).round(9).tolist()
    [[0.5, 0.25, 0.125]]
    """
    return np.asarray(np.linalg.solve(_add_ridge(H), g[:, :, None])[:, :, 0])


def _project(
    cameras: Cameras, points: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return coordinates at depth 1 of points (n, 3), two (n, V), their depths, and 1 / depth."""
    P = cameras.projections.swapaxes(0, 1).reshape(-1, 4)
    homogeneous = np.ones((len(points), 4))
    homogeneous[:, :3] = points
    h = (homogeneous @ P.T).reshape(len(points), 3, len(cameras.centres))
    depth = h[:, 2]
    flat = np.abs(depth) < LEAST_DEPTH
    reciprocal = 1.0 / (np.where(flat, LEAST_DEPTH, depth) if flat.any() else depth)
    return h[:, 0] * reciprocal, h[:, 1] * reciprocal, depth, reciprocal


def _compute_contributions(
    x: FloatArray, y: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray
) -> FloatArray:
    """Return coefficients (n, 6 V) of products: Σ Nᵀ [a b; b c] N with N = p12 - (x, y) p3."""
    n, views = x.shape
    k = np.empty((n, 6, views))
    k[:, 0], k[:, 1], k[:, 2] = a, b, c
    k[:, 3] = -(a * x + b * y)
    k[:, 4] = -(b * x + c * y)
    k[:, 5] = -(k[:, 3] * x + k[:, 4] * y)
    return k.reshape(n, 6 * views)


def solve_linear_start(cameras: Cameras, xy: FloatArray, info: FloatArray) -> FloatArray:
    """Return points (n, 3) nearest to the rays through xy (n, 2, V), then weighed by information,
    depth.

    The first solution needs no depth; the second one is of the paper's implicit equations,
    (p12 - (x, y) p3) a = 0, with W = depth² Λ taken at the solution before.
    """
    x, y = xy[:, 0], xy[:, 1]
    weight = (info[:, 0] > 0) / (1.0 + x * x + y * y)
    # Σ (I - d dᵀ) (a - c) = 0 over the unit rays d, as I - d dᵀ = Nᵀ (N Nᵀ)⁻¹ N
    k = _compute_contributions(
        x, y, weight * (1.0 + y * y), -weight * x * y, weight * (1.0 + x * x)
    )
    points = _nearest(cameras, k)
    p3 = cameras.projections[:, 2]
    depth = points @ p3[:, :3].T + p3[:, 3]
    least = np.maximum(LEAST_DEPTH_SHARE * cameras.distances(points), LEAST_DEPTH)
    weights = info / (np.maximum(np.abs(depth), least) ** 2)[:, None]
    k = _compute_contributions(x, y, weights[:, 0], weights[:, 1], weights[:, 2])
    return _nearest(cameras, k)


def _nearest(cameras: Cameras, k: FloatArray) -> FloatArray:
    G = (k @ cameras.products).reshape(-1, 3, 4)
    return solve_points(G[..., :3], -G[..., 3])


def _linearise(
    cameras: Cameras, xy: FloatArray, info: FloatArray, points: FloatArray
) -> tuple[FloatArray, Fit, FloatArray]:
    """Return cost (n,), infinite behind a camera that counts, the fit there, and g (n, 3)."""
    n, views = len(points), len(cameras.centres)
    x, y, depth, reciprocal = _project(cameras, points)
    a, b, c = info[:, 0], info[:, 1], info[:, 2]
    rx, ry = xy[:, 0] - x, xy[:, 1] - y
    ex, ey = a * rx + b * ry, b * rx + c * ry
    chi2 = ex * rx + ey * ry
    cost = chi2.sum(axis=1)
    behind = depth <= 0
    if behind.any():
        cost[(behind & (a > 0)).any(axis=1)] = np.inf
    # ∂(x, y)/∂(point) = (p12 - (x, y) p3) / depth
    e = np.empty((n, 3, views))
    np.multiply(ex, reciprocal, out=e[:, 0])
    np.multiply(ey, reciprocal, out=e[:, 1])
    e[:, 2] = -(e[:, 0] * x + e[:, 1] * y)
    g = e.reshape(n, 3 * views) @ cameras.projections.swapaxes(0, 1).reshape(-1, 4)[:, :3]
    weight = reciprocal * reciprocal
    k = _compute_contributions(x, y, a * weight, b * weight, c * weight)
    H = (k @ cameras.products).reshape(-1, 3, 4)[..., :3]
    return cost, Fit(points, H, depth, chi2), g


def fit_points(
    cameras: Cameras,
    xy: FloatArray,
    info: FloatArray,
    start: FloatArray,
    *,
    hopeless: FloatArray | None = None,
) -> Fit:
    """Return the maximum-likelihood points of pixels with information, from `start` (n, 3).

    A start behind one of its cameras is not moved: the caller sees it by the depths. Nor is a point
    whose chi-square would still be above `hopeless` (n,) after the next pass.
    """
    cost, fit, g = _linearise(cameras, xy, info, start)
    points, H, depth, chi2 = start.copy(), fit.information, fit.depth, fit.chi2
    damping = np.zeros(len(points))
    moving = np.flatnonzero(np.isfinite(cost))
    if hopeless is not None:
        # What a pass gains, to first order: gᵀ H⁻¹ g
        gain = (solve_points(H, g) * g).sum(axis=1)
        moving = moving[(cost - gain <= hopeless)[moving]]
    for _ in range(MAX_PASSES):
        if not moving.size:
            break
        # Almost always all points move together: no need to copy what is theirs.
        rows = slice(None) if moving.size == len(points) else moving
        here, slack = H[rows].copy(), damping[rows]
        move = solve_points(here * (1.0 + slack[:, None, None] * np.eye(3)), g[rows])
        new_cost, new, new_g = _linearise(cameras, xy[rows], info[rows], points[rows] + move)
        better = new_cost <= cost[rows]
        if better.all() and moving.size == len(points):
            points, cost, H, g = new.points, new_cost, new.information, new_g
            depth, chi2 = new.depth, new.chi2
        else:
            taken = moving[better]
            points[taken], cost[taken], g[taken] = (
                new.points[better],
                new_cost[better],
                new_g[better],
            )
            H[taken], depth[taken] = new.information[better], new.depth[better]
            chi2[taken] = new.chi2[better]
        lowered = slack / 10
        damping[rows] = np.where(
            better,
            np.where(lowered < FIRST_DAMPING, 0.0, lowered),
            np.maximum(10 * slack, FIRST_DAMPING),
        )
        moving = moving[np.einsum("ni,nij,nj->n", move, here, move) >= CONVERGED_SD**2]
    return Fit(points, H, depth, chi2)


def compute_view_chi2(
    cameras: Cameras, xy: FloatArray, info: FloatArray, points: FloatArray
) -> FloatArray:
    """Return the squared Mahalanobis distances (n, V) of pixels from where points (n, 3) appear.

    Huge behind a camera.
    """
    x, y, depth, _ = _project(cameras, points)
    rx, ry = np.subtract(xy[:, 0], x, out=x), np.subtract(xy[:, 1], y, out=y)
    chi2 = info[:, 0] * rx + (2.0 * info[:, 1]) * ry
    chi2 *= rx
    ry *= ry
    ry *= info[:, 2]
    chi2 += ry
    chi2[depth <= 0] = BEHIND_CHI2
    return np.asarray(chi2)


def innovation_chi2(
    cameras: Cameras, xy: FloatArray, info: FloatArray, points: FloatArray, covs: FloatArray
) -> FloatArray:
    """Return `compute_view_chi2` for views that had no part in the points (covs (n, 3, 3))."""
    x, y, depth, reciprocal = _project(cameras, points)
    # p1ᵀ S p1, 2 p1ᵀ S p2, p2ᵀ S p2, 2 p1ᵀ S p3, 2 p2ᵀ S p3, p3ᵀ S p3 of each view
    of_points = cameras.products.reshape(-1, 3, 4)[..., :3].reshape(-1, 9)
    s = covs.reshape(-1, 9) @ of_points.T
    s00, s01, s11, s02, s12, s22 = s.reshape(len(points), 6, len(cameras.centres)).swapaxes(0, 1)
    # J S Jᵀ of J = (p12 - (x, y) p3) / depth
    weight = reciprocal * reciprocal
    j00 = (s00 - x * s02 + x * x * s22) * weight
    j01 = (0.5 * (s01 - x * s12 - y * s02) + x * y * s22) * weight
    j11 = (s11 - y * s12 + y * y * s22) * weight
    a, b, c = info[:, 0], info[:, 1], info[:, 2]
    rx, ry = xy[:, 0] - x, xy[:, 1] - y
    # With D the pixel's covariance: (D + J)⁻¹ = (I + D⁻¹ J)⁻¹ D⁻¹
    m00, m01 = 1.0 + a * j00 + b * j01, a * j01 + b * j11
    m10, m11 = b * j00 + c * j01, 1.0 + b * j01 + c * j11
    ex, ey = a * rx + b * ry, b * rx + c * ry
    # The determinant is at least 1 + trace(D⁻¹ J), which rounding must not hide.
    determinant = np.maximum(m00 * m11 - m01 * m10, np.maximum(m00 + m11 - 1.0, 1.0))
    chi2 = (rx * (m11 * ex - m01 * ey) + ry * (m00 * ey - m10 * ex)) / determinant
    chi2[depth <= 0] = BEHIND_CHI2
    return np.asarray(chi2)
