"""Rays that meet: epipolar distances, two-view points and the points of whole tracks.

Hartley and Zisserman, Multiple View Geometry (2nd ed.): fundamental matrix from two projections
(9.1), its first-order (Sampson) error (11.4), linear triangulation (12.2).
"""

from dataclasses import dataclass

import numpy as np

from facetlog.perception.types import FloatArray, Observation

GAUSS_NEWTON_STEPS = 6


@dataclass(frozen=True, eq=False, slots=True)
class PointFit:
    """A point (3,), its covariance (3, 3) and the chi-square of its observations."""

    point: FloatArray
    cov: FloatArray
    chi_square: float


def _cross(vector: FloatArray) -> FloatArray:
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def fundamental_matrix(first: FloatArray, second: FloatArray) -> FloatArray:
    """F (3, 3) with x2ᵀ F x1 = 0 for projections (3, 4) of two views; 0 if they share a centre."""
    _, _, vt = np.linalg.svd(first)
    epipole = second @ vt[-1]
    matrix: FloatArray = _cross(epipole) @ second @ np.linalg.pinv(first)
    return matrix


def epipolar_chi_square(
    fundamental: FloatArray,
    uv1: FloatArray,
    cov1: FloatArray,
    uv2: FloatArray,
    cov2: FloatArray,
) -> FloatArray:
    """Chi-square (n, m), 1 degree of freedom, of pixels uv1 (n, 2) and uv2 (m, 2) corresponding.

    The algebraic distance x2ᵀ F x1 over its variance by first-order propagation of both
    covariances (n, 2, 2) and (m, 2, 2).
    """
    x1 = np.column_stack([uv1, np.ones(len(uv1))])
    x2 = np.column_stack([uv2, np.ones(len(uv2))])
    lines2 = x1 @ fundamental.T  # (n, 3): epipolar lines in the second view
    lines1 = x2 @ fundamental  # (m, 3): epipolar lines in the first
    distance = lines2 @ x2.T
    variance = np.einsum("mi,nij,mj->nm", lines1[:, :2], cov1, lines1[:, :2])
    variance += np.einsum("ni,mij,nj->nm", lines2[:, :2], cov2, lines2[:, :2])
    tiny = np.finfo(np.float64).tiny
    chi_square: FloatArray = distance**2 / np.maximum(variance, tiny)
    return chi_square


def linear_points(
    first: FloatArray, second: FloatArray, uv1: FloatArray, uv2: FloatArray
) -> FloatArray:
    """Points (n, 3) of n pairs of pixels (n, 2) in two views, by the linear method.

    Not finite where the rays are parallel.
    """
    rows = np.stack(
        [
            uv1[:, :1] * first[2] - first[0],
            uv1[:, 1:] * first[2] - first[1],
            uv2[:, :1] * second[2] - second[0],
            uv2[:, 1:] * second[2] - second[1],
        ],
        axis=1,
    )
    rows /= np.linalg.norm(rows, axis=2, keepdims=True)
    _, _, vt = np.linalg.svd(rows)
    with np.errstate(divide="ignore", invalid="ignore"):
        points: FloatArray = vt[:, -1, :3] / vt[:, -1, 3:]
    return points


def point_fit(
    observations: tuple[Observation, ...],
    projections: tuple[FloatArray, ...],
    start: FloatArray,
) -> PointFit | None:
    """The most likely point of observations (each in its view), from `start` (3,); None if the
    rays do not fix one or it falls behind a camera.

    Gauss-Newton on the reprojection errors, weighted by the observations' covariances.
    """
    P = np.array([projections[o.view] for o in observations])
    uv = np.array([o.uv for o in observations])
    weights = np.linalg.inv(np.array([o.cov for o in observations]))
    point = np.array(start, dtype=np.float64)
    for _ in range(GAUSS_NEWTON_STEPS):
        projected = P[:, :, :3] @ point + P[:, :, 3]
        depth = projected[:, 2]
        if not (depth > 0).all():
            return None
        pixel = projected[:, :2] / depth[:, None]
        jacobian = (P[:, :2, :3] - pixel[:, :, None] * P[:, None, 2, :3]) / depth[:, None, None]
        residual = uv - pixel
        information = np.einsum("nia,nij,njb->ab", jacobian, weights, jacobian)
        gradient = np.einsum("nia,nij,nj->a", jacobian, weights, residual)
        values = np.linalg.eigvalsh(information)
        if not values[0] > np.finfo(np.float64).eps * 1e2 * values[-1]:
            return None
        point = point + np.linalg.solve(information, gradient)
    projected = P[:, :, :3] @ point + P[:, :, 3]
    if not (projected[:, 2] > 0).all():
        return None
    residual = uv - projected[:, :2] / projected[:, 2:]
    chi_square = float(np.einsum("ni,nij,nj->", residual, weights, residual))
    return PointFit(point, np.linalg.inv(information), chi_square)
