"""3-D points from posed views: the paper's recursion as printed, and the estimator in its place.

The plain recursion (section 4.1) starts from the origin with a large S0 and weights each view at
the previous estimate, so its result depends on the origin and on the order of the views, and one
outlier can spoil it. `estimate_point` keeps the recursion and removes that: the inlier views are
found first (point_consensus.py), and the recursion then runs over them with every view linearised
at one shared point, the most likely one.

Covariances are honest if the pixels' covariances are, if the poses are exact, and if the errors of
different views are independent.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from facetlog.perception.estimation.ekf import (
    Linearised,
    Measurement,
    State,
    linearise,
    recursion,
    run,
)
from facetlog.perception.estimation.incidence import Incidence, measure_as_printed
from facetlog.perception.estimation.point_consensus import Consensus, find_agreeing_views
from facetlog.perception.estimation.point_fit import START_SD
from facetlog.perception.estimation.point_views import BoolArray, Cameras, IndexArray, Sightings
from facetlog.perception.types import FloatArray, Observation

# A point whose largest standard deviation exceeds this share of its distance from the nearest
# camera might as well be at infinity: infinity is then within 3 sd of its inverse depth.
MAX_RELATIVE_SD = 1.0 / 3.0
# Pinholes closer than this are one place, up to rounding (unit: the spread of all the cameras).
ONE_PLACE = 1e-9


class PointFailure(StrEnum):
    """Why there is no point."""

    FEW_VIEWS = "fewer than two views saw the point"
    INCONSISTENT = "fewer than two views agree on a point that no third contradicts"
    BEHIND = "the rays meet behind a camera"
    PARALLEL = "the rays are parallel within their noise: the depth is not bounded"
    NO_PARALLAX = "the views were taken from one place: there is no parallax"


# What the numbers of `_find_failures` stand for.
REASONS = (None, *PointFailure)


@dataclass(frozen=True, eq=False, slots=True)
class PointEstimate:
    """A point (3,) with its covariance (3, 3), and its inliers and outliers.

    `used` and `rejected` are indices into the observations given. `views_needed` is how many of the
    inliers, in the order given, brought the largest standard deviation below the limit; None
    without a limit or if it was not met. After the limit none is used.
    """

    point: FloatArray
    cov: FloatArray
    used: tuple[int, ...]
    rejected: tuple[int, ...]
    views_needed: int | None = None
    reason: None = None

    def __bool__(self) -> Literal[True]:
        return True


@dataclass(frozen=True, eq=False, slots=True)
class NoPoint:
    """No point, and why; falsy."""

    reason: PointFailure

    def __bool__(self) -> Literal[False]:
        return False


def pixel_incidence(projection: FloatArray) -> Incidence:
    """Return the constraint that points (..., 3) appear at pixels (..., 2) by projections (..., 3,
    4).

    The paper's f = (t1 - u t3) a + t14 - u t34, and the same of v, section 4.1. Pixels moved onto
    the estimate are its projection, which makes this the filter of reprojection errors.
    """

    def equations(uv: FloatArray) -> tuple[FloatArray, FloatArray]:
        T = projection[..., :2, :] - uv[..., None] * projection[..., 2:, :]
        return T[..., :3], -T[..., 3]

    def by_pixel(a: FloatArray) -> FloatArray:
        # (10)  ∂f/∂x = -(t3 a + t34) I
        depth = (projection[..., 2, :3] * a).sum(axis=-1) + projection[..., 2, 3]
        G: FloatArray = -depth[..., None, None] * np.eye(2)
        return G

    return Incidence(equations, by_pixel)


def ray_measurement(uv: ArrayLike, projection: ArrayLike, noise: ArrayLike) -> Measurement:
    """Return a pixel (2,) as the paper's measurement of a point; M does not depend on the estimate,
    but the weight of equation (10) does.
    """
    x, P, cov = (np.asarray(given, dtype=np.float64) for given in (uv, projection, noise))
    return measure_as_printed(pixel_incidence(P), x, cov)


def measure_pixel(
    uv: ArrayLike, projection: ArrayLike, noise: ArrayLike, at: FloatArray | None = None
) -> Measurement:
    """Return the pixel itself as the measurement, x - h(a) = 0, linearised at `at` (or the
    estimate).
    """
    uv, P = np.asarray(uv, dtype=np.float64), np.asarray(projection, dtype=np.float64)

    def measured(a: FloatArray) -> Linearised:
        centre = a if at is None else at
        h = P[:, :3] @ centre + P[:, 3]
        pixel = h[:2] / h[2]
        df_da = -(P[:2, :3] - np.outer(pixel, P[2, :3])) / h[2]
        return linearise(uv - pixel, df_da, np.eye(2), noise, centre)

    return measured


def run_printed_recursion(
    observations: Sequence[Observation],
    projections: Sequence[FloatArray],
    start: State,
) -> Iterator[State]:
    """Return the states of the paper's recursion as printed after each observation (section 5.3).

    With `start` at the null vector and a large covariance this is the paper's filter, kept for its
    printed figures and as a baseline; use `estimate_point`.
    """
    return recursion(
        start, (ray_measurement(o.uv, projections[o.view], o.cov) for o in observations)
    )


def estimate_point(
    observations: Sequence[Observation],
    projections: Sequence[FloatArray],
    *,
    sd_limit: float | None = None,
) -> PointEstimate | NoPoint:
    """Return the point that the observations agree on; falsy with its reason where there is none.

    `projections` (3, 4) each take the world to the pixels of a view; `observations` index them.
    With `sd_limit` (in the world's unit) the recursion stops at the first observation that brings
    the largest standard deviation below it. Which views agree, and the point at which they are
    made linear, always come from all the observations given.
    """
    if len(observations) < 2:
        return NoPoint(PointFailure.FEW_VIEWS)
    cameras = Cameras.of(np.array([projections[o.view] for o in observations]))
    seen = Sightings.of(
        cameras,
        np.array([[o.uv for o in observations]]),
        np.array([[o.cov for o in observations]]),
        np.ones((1, len(observations)), dtype=np.bool_),
    )
    found = find_agreeing_views(cameras, seen)
    reason = REASONS[_find_failures(cameras, seen, found)[0]]
    if reason is not None:
        return NoPoint(reason)
    agreed = [int(i) for i in np.flatnonzero(found.inliers[0])]
    at = found.points[0]
    distance = np.linalg.norm(at - cameras.centres[agreed], axis=1).mean()
    measurements = (
        measure_pixel(seen.xy[0, :, i], cameras.projections[i], seen.cov(0, i), at) for i in agreed
    )
    limit = None if sd_limit is None else sd_limit / cameras.scale
    try:
        ended = run(State(at, (START_SD * distance) ** 2 * np.eye(3)), measurements, limit)
    except np.linalg.LinAlgError:
        # The depth's variance is so large beside a pixel's that rounding leaves no gain.
        return NoPoint(PointFailure.PARALLEL)
    return PointEstimate(
        cameras.origin + cameras.scale * ended.state.mean,
        cameras.scale**2 * ended.state.cov,
        tuple(agreed[: ended.used]),
        tuple(int(i) for i in np.flatnonzero(~found.inliers[0])),
        ended.used if ended.reached else None,
    )


def estimate_points(
    uv: ArrayLike, cov: ArrayLike, seen: ArrayLike, projections: ArrayLike
) -> tuple[FloatArray, FloatArray, BoolArray, BoolArray]:
    """Return points (n, 3), covariances (n, 3, 3), used (n, V) and ok (n,): `estimate_point` for
    many.

    `uv` (n, V, 2) pixels, `cov` (n, V, 2, 2), `seen` (n, V), `projections` (V, 3, 4). Where ok is
    false point and covariance are NaN and no view is used; where seen is false uv and cov are not
    read. The same results as one by one, in information form.
    """
    cameras = Cameras.of(projections)
    sightings = Sightings.of(cameras, uv, cov, seen)
    found = find_agreeing_views(cameras, sightings)
    ok = _find_failures(cameras, sightings, found) == 0
    points = np.where(ok[:, None], cameras.origin + cameras.scale * found.points, np.nan)
    covs = np.where(ok[:, None, None], cameras.scale**2 * found.covs, np.nan)
    return points, covs, np.logical_and(found.inliers, ok[:, None]), ok


def _find_failures(cameras: Cameras, seen: Sightings, found: Consensus) -> IndexArray:
    """Return which of `REASONS` (n,) keeps each point from being one."""
    away = cameras.distances(found.points)
    nearest = np.where(found.inliers, away, np.inf).min(axis=1, initial=np.inf)
    # The trace is at least the largest eigenvalue, and sooner known.
    limit = (MAX_RELATIVE_SD * nearest) ** 2
    vague = ~(np.trace(found.covs, axis1=1, axis2=2) <= limit)
    near = np.flatnonzero(vague & np.isfinite(found.covs).all(axis=(1, 2)))
    vague[near] = ~(np.linalg.eigvalsh(found.covs[near])[:, 2] <= limit[near])
    few, alone = seen.seen.sum(axis=1) < 2, found.inliers.sum(axis=1) < 2
    reasons = (
        PointFailure.FEW_VIEWS,
        PointFailure.INCONSISTENT,
        PointFailure.PARALLEL,
        PointFailure.BEHIND,
    )
    failures = np.select(
        [few, alone, vague, found.behind], [REASONS.index(r) for r in reasons], default=0
    )
    for i in np.flatnonzero((failures > 0) & ~few):
        if (np.ptp(cameras.centres[seen.seen[i]], axis=0) <= ONE_PLACE).all():
            failures[i] = REASONS.index(PointFailure.NO_PARALLAX)
    return failures
