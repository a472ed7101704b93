"""Angles between planes, with their standard deviation, and how likely an angle is as wanted.

First-order propagation of the normals' covariances: calibrated for angles surer than about 7°; from
an sd of 10-15° on "unknown" is the honest word. At 0° and 180° the first order breaks down: there
any error of a normal makes the angle between two parallel planes larger (or smaller), none leaves
it. `sd` is therefore the root mean square error of the measured angle about the true one, with the
second-order part of the error across the plane of the two normals added; it tends to the
first-order value away from 0° and 180° and to the length of the two-dimensional tilt error there.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr

from facetlog.perception.types import FloatArray, Plane

__all__ = ["angle_between", "pairwise_angles", "probability_within"]

# Below this sine the directions in and across the plane of two normals are rounding (rad).
LEAST_SINE = 1e-9


def _angles(
    n: FloatArray, m: FloatArray, n_cov: FloatArray, m_cov: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Angles and sds (...), of unit normals (..., 3) with covariances (..., 3, 3)."""
    cross = np.cross(n, m)
    sine = np.linalg.norm(cross, axis=-1)
    cosine = (n * m).sum(axis=-1)
    angle = np.arctan2(sine, cosine)
    # Of parallel normals every direction across them will do: the sum of both variances counts.
    axis = np.eye(3)[np.argmin(np.abs(n), axis=-1)]
    some = np.cross(n, axis)
    parallel = (sine < LEAST_SINE)[..., None]
    across = np.where(parallel, some, cross)
    across = across / np.linalg.norm(across, axis=-1, keepdims=True)
    n_way, m_way = np.cross(across, n), np.cross(m, across)

    def variance(way: FloatArray, cov: FloatArray) -> FloatArray:
        return np.asarray(np.einsum("...i,...ij,...j->...", way, cov, way))

    # dθ = -n_way · dn - m_way · dm, with the ways towards the other normal.
    within = variance(n_way, n_cov) + variance(m_way, m_cov)
    # Errors e across add e² cot θ / 2 to the angle, with mean square 3/4 s⁴ cot² θ, and near 0° and
    # 180°, where that grows without bound, no more than their own mean square s².
    s2 = variance(across, n_cov) + variance(across, m_cov)
    tangent2 = np.where(
        np.abs(cosine) > LEAST_SINE, (sine / np.where(cosine == 0, 1, cosine)) ** 2, np.inf
    )
    extra = s2 * s2 / np.where(s2 + tangent2 > 0, s2 + 4.0 / 3.0 * tangent2, 1.0)
    return angle, np.sqrt(within + extra)


def angle_between(p: Plane, q: Plane) -> tuple[float, float]:
    """Angle between the normals, in [0, π] rad, and its standard deviation (rad).

    Takes the errors of the two planes to be independent; planes that share vertices are not quite.
    """
    angle, sd = _angles(p.normal, q.normal, p.cov[:3, :3], q.cov[:3, :3])
    return float(angle), float(sd)


def pairwise_angles(planes: Sequence[Plane]) -> tuple[FloatArray, FloatArray]:
    """Angles (n, n) and standard deviations (n, n) between all normals, rad; 0 on the diagonal."""
    count = len(planes)
    if not count:
        return np.zeros((0, 0)), np.zeros((0, 0))
    n = np.array([p.normal for p in planes])
    cov = np.array([p.cov[:3, :3] for p in planes])
    angle, sd = _angles(n[:, None], n[None], cov[:, None], cov[None])
    np.fill_diagonal(angle, 0.0)
    np.fill_diagonal(sd, 0.0)
    return (angle + angle.T) / 2, (sd + sd.T) / 2


def probability_within(
    angle: ArrayLike, sd: ArrayLike, target: ArrayLike, tolerance: ArrayLike
) -> FloatArray:
    """P(|true angle - target| <= tolerance), for an angle measured with this sd; all in rad.

    The true angle is normal about the measured one, folded back at 0 and π (a tilt through zero
    is a tilt to the other side). With sd = 0 it is 0 or 1.

    >>> right = np.radians(90.0)
    >>> round(float(probability_within(right, np.radians(15.0), right, np.radians(15.0))), 3)
    0.683
    """
    theta, s = np.asarray(angle, dtype=np.float64), np.asarray(sd, dtype=np.float64)
    middle, width = np.asarray(target, dtype=np.float64), np.asarray(tolerance, dtype=np.float64)
    low, high = np.maximum(middle - width, 0.0), np.minimum(middle + width, np.pi)
    spread = np.where(s > 0, s, 1.0)

    def mass(a: FloatArray, b: FloatArray) -> FloatArray:
        return np.asarray(ndtr((b - theta) / spread) - ndtr((a - theta) / spread))

    folded = mass(low, high) + mass(-high, -low) + mass(2 * np.pi - high, 2 * np.pi - low)
    sure = np.abs(theta - middle) <= width
    return np.asarray(np.where(s > 0, np.clip(folded, 0.0, 1.0), sure), dtype=np.float64)
