"""Angles between planes, with their standard deviation, and how likely an angle is as wanted.

First-order propagation of the normals' covariances: calibrated for angles surer than about 7°; from
an sd of 10-15° on "unknown" is the honest word. At 0° and 180° the first order breaks down: there
any error of a normal makes the angle between two parallel planes larger (or smaller), none leaves
it. `sd` is therefore the root mean square error of the measured angle about the true one, with the
second-order part of the error across the plane of the two normals added; it tends to the
first-order value away from 0° and 180° and to the length of the two-dimensional tilt error there,
and in between, at one to three sd from them, it is up to a fifth on the safe side.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from facetlog.perception.batch_linalg import dots, quadratic_forms
from facetlog.perception.flat_faces import cross
from facetlog.perception.ragged import Indices
from facetlog.perception.scene import Plane
from facetlog.perception.types import FloatArray

__all__ = ["angle_between", "angles_between", "pairwise_angles", "probability_within"]

# Angles and sds below this are rounding (rad).
LEAST_SINE = 1e-9
# Twice the mean of |x| for a standard normal x.
MEAN_FOLD = 2.0 * np.sqrt(2.0 / np.pi)


def _angles(
    normals: FloatArray, covs: FloatArray, one: Indices, two: Indices
) -> tuple[FloatArray, FloatArray]:
    """Angles and sds (p,) between `one` and `two` (p,) of unit normals with covariances."""
    n, m = normals[one], normals[two]
    product = cross(n, m)
    sine = np.sqrt(dots(product, product))
    cosine = dots(n, m)
    angle = np.arctan2(sine, cosine)
    # Of parallel normals every direction across them will do: the sum of both variances counts.
    axis = np.eye(3)[np.argmin(np.abs(n), axis=-1)]
    some = cross(n, axis)
    parallel = (sine < LEAST_SINE)[..., None]
    across = np.where(parallel, some, product)
    across = across / np.sqrt(dots(across, across))[:, None]
    n_way, m_way = cross(across, n), cross(m, across)

    # dθ = -n_way · dn - m_way · dm, with the ways towards the other normal.
    within = quadratic_forms(n_way, covs, one) + quadratic_forms(m_way, covs, two)
    # An error e across, with sd s, adds e² cot θ / 2 to the angle: with t = |tan θ| a mean square
    # of 3/4 s⁴ / t² far from 0° and 180°, and of s² - 2 √(2/π) s t close to them. Both are in
    # s⁴ / (s² + 2 √(2/π) s t + 4/3 t²), here times cos² above and below, for the right angle.
    s2 = quadratic_forms(across, covs, one) + quadratic_forms(across, covs, two)
    c = np.abs(cosine)
    below = s2 * c * c + MEAN_FOLD * np.sqrt(s2) * sine * c + 4.0 / 3.0 * sine * sine
    extra = np.divide(s2 * s2 * c * c, below, out=np.zeros_like(s2), where=below > 0)
    return angle, np.sqrt(within + extra)


def angle_between(p: Plane, q: Plane) -> tuple[float, float]:
    """Angle between the normals, in [0, π] rad, and its standard deviation (rad).

    Takes the errors of the two planes to be independent; planes that share vertices are not quite.
    """
    normals, covs = np.array([p.normal, q.normal]), np.array([p.cov[:3, :3], q.cov[:3, :3]])
    angle, sd = _angles(normals, covs, np.array([0]), np.array([1]))
    return float(angle[0]), float(sd[0])


def angles_between(
    normals: FloatArray, covs: FloatArray, one: Indices, two: Indices
) -> tuple[FloatArray, FloatArray]:
    """Angles (p,) and standard deviations (p,), rad, between the normals `one` and `two` (p,).

    `normals` (n, 3) have covariances (n, 3, 3).
    """
    first = _angles(normals, covs, one, two)
    # The same either way round: of parallel normals the direction across is that of the first.
    second = _angles(normals, covs, two, one)
    return (first[0] + second[0]) / 2, (first[1] + second[1]) / 2


def pairwise_angles(planes: Sequence[Plane]) -> tuple[FloatArray, FloatArray]:
    """Angles (n, n) and standard deviations (n, n) between all normals, rad; 0 on the diagonal."""
    count = len(planes)
    angles, sds = np.zeros((2, count, count))
    if count:
        one, two = np.triu_indices(count, 1)
        normals = np.array([p.normal for p in planes])
        covs = np.array([p.cov[:3, :3] for p in planes])
        found = angles_between(normals, covs, one, two)
        for table, values in zip((angles, sds), found, strict=True):
            table[one, two] = table[two, one] = values
    return angles, sds


def probability_within(
    angle: ArrayLike, sd: ArrayLike, target: ArrayLike, tolerance: ArrayLike
) -> FloatArray:
    """P(|true angle - target| <= tolerance), for an angle measured with this sd; all in rad.

    The true angle is normal about the measured one, folded back at 0 and π (a tilt through zero
    is a tilt to the other side). With sd = 0 it is 0 or 1. Within 2 sd of 0 or π the tilt is really
    two-dimensional and the result a sketch: off by up to 0.2 where the tolerance is below the sd,
    by less than 0.05 where it is above two.

    >>> right = np.radians(90.0)
    >>> round(float(probability_within(right, np.radians(15.0), right, np.radians(15.0))), 3)
    0.683
    """
    from scipy.special import ndtr  # no fact needs it, and it takes long to load

    theta, s = np.asarray(angle, dtype=np.float64), np.asarray(sd, dtype=np.float64)
    middle, width = np.asarray(target, dtype=np.float64), np.asarray(tolerance, dtype=np.float64)
    low, high = np.maximum(middle - width, 0.0), np.minimum(middle + width, np.pi)
    noisy = s > LEAST_SINE
    spread = np.where(noisy, s, 1.0)

    def mass(a: FloatArray, b: FloatArray) -> FloatArray:
        return np.asarray(ndtr((b - theta) / spread) - ndtr((a - theta) / spread))

    folded = mass(low, high) + mass(-high, -low) + mass(2 * np.pi - high, 2 * np.pi - low)
    sure = np.abs(theta - middle) <= width
    return np.asarray(np.where(noisy, np.clip(folded, 0.0, 1.0), sure), dtype=np.float64)
