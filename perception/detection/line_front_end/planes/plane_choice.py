"""Choice of the plane hypotheses to search: each edge bounds two faces, not a dozen.

A line supports a plane only where the pictures are consistent, right beside it, with that plane.
"""

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_basis,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.stable_order import descending
from facetlog.perception.types import FloatArray

# Two hypotheses are one plane within this angle where their lines lie this near, px, by this share.
SAME_COSINE = np.cos(np.radians(4.0))
SAME_PX, SAME_SHARE = 3.0, 0.9
# Share of a line's score that is left for the next plane.
PASSED_ON = 0.5
# Standard deviation px of a line beyond its ends' covariance: edges are dilated by 2 px where it is
# sought. A plane that lines leave open is known to this slope and px.
LINE_SD_PX = 1.0
OPEN_SLOPE, OPEN_PX = 0.05, 15.0


@dataclass(frozen=True, eq=False, slots=True)
class ChosenPlane:
    """A plane and the upper `bound` of an outline's score there, seen from the `sides` (±1).

    `spans` (n, 2, 3) are the segments that a face there is sought about.
    """

    plane: PlaneHypothesis
    bound: float
    sides: tuple[float, ...]
    spans: FloatArray


def choose_planes(
    planes: Sequence[PlaneHypothesis],
    cloud: LineCloud,
    score: FloatArray,
    ground: Ground | None,
    surface: Callable[[PlaneHypothesis], NDArray[np.bool_]],
    least: float,
) -> tuple[ChosenPlane, ...]:
    """Return planes that may hold a face, by descending upper bound of its score.

    `score` (n,) is the log-likelihood ratio of the cloud's lines as sides of faces. Equal planes
    are taken once. Each line counts half as much for the next plane as for the one before, and not
    at all where it lies on the ground or the plane beside it is no `surface` (2, its lines) from
    either of its sides: a plane with a bound below `least` is left out.
    """
    if ground is not None:
        low = ground.holds(cloud.segments.reshape(-1, 3)).reshape(-1, 2).all(axis=1)
        score = np.where(low, 0.0, score)
    distinct = _distinct(planes, cloud)
    left = score.copy()
    lines = [plane.lines for plane in distinct]
    sides: dict[int, tuple[float, ...]] = {}
    queue = [(-float(score[on].sum()), k) for k, on in enumerate(lines)]
    heapq.heapify(queue)
    chosen = []
    while queue and -queue[0][0] > least:
        known, k = heapq.heappop(queue)
        if k not in sides:
            beside = surface(distinct[k])
            seen_from = zip((1.0, -1.0), beside @ score[lines[k]], strict=True)
            sides[k] = tuple(side for side, bound in seen_from if bound > least)
            lines[k] = lines[k][beside.any(axis=0)]
        now = -float(left[lines[k]].sum())
        if not sides[k]:
            continue
        if now > known:
            heapq.heappush(queue, (now, k))
        elif -now > least:
            spans = cloud.segments[distinct[k].lines]
            chosen.append(ChosenPlane(distinct[k], float(score[lines[k]].sum()), sides[k], spans))
            left[lines[k]] *= PASSED_ON
    return tuple(chosen)


def _distinct(planes: Sequence[PlaneHypothesis], cloud: LineCloud) -> list[PlaneHypothesis]:
    # Of equal planes, the one with most support.
    length = np.linalg.norm(cloud.segments[:, 1] - cloud.segments[:, 0], axis=1)
    support = cloud.support * length
    kept: list[PlaneHypothesis] = []
    for best in descending(np.array([support[p.lines].sum() for p in planes])).tolist():
        ends = cloud.segments[planes[best].lines].reshape(-1, 3)
        if not find_same_planes(planes[best], ends, kept, cloud.pixel).any():
            kept.append(planes[best])
    return kept


def find_same_planes(
    plane: PlaneHypothesis, points: FloatArray, others: Sequence[PlaneHypothesis], pixel: float
) -> NDArray[np.bool_]:
    """Return which other planes (m,) are one with a plane, over points (n, 3) of it."""
    normals = np.array([other.normal for other in others]).reshape(-1, 3)
    same: NDArray[np.bool_] = np.abs(normals @ plane.normal) >= SAME_COSINE
    alike = np.nonzero(same)[0]
    away = points @ normals[alike].T - [others[k].distance for k in alike.tolist()]
    same[alike] = (np.abs(away) < SAME_PX * pixel).mean(axis=0) > SAME_SHARE
    return same


def plane_cov(
    plane: PlaneHypothesis, cloud: LineCloud, points: FloatArray, slope: float
) -> FloatArray:
    """Return the covariance (k, k) of a plane's heights at points (k, 3) of it, from its lines and
    texture.

    Where they leave the tilt open it has a prior of `slope` (OPEN_SLOPE if nothing else bounds it).
    """
    basis, middle = plane_basis(plane.normal), points.mean(axis=0)

    def design(x: FloatArray) -> FloatArray:
        return np.column_stack([(x - middle) @ basis, np.ones(len(x))])

    known = design(np.concatenate([cloud.segments[plane.lines].reshape(-1, 3), plane.texture]))
    covs = cloud.end_covs[plane.lines].reshape(-1, 3, 3)
    variance = np.einsum("i,nij,j->n", plane.normal, covs, plane.normal)
    variance += (LINE_SD_PX * cloud.pixel) ** 2
    variance = np.concatenate([variance, plane.texture_variance])
    prior = np.diag([slope, slope, OPEN_PX * cloud.pixel]) ** 2
    cov = np.linalg.inv(np.linalg.inv(prior) + (known.T / variance) @ known)
    there = design(points)
    at_points: FloatArray = there @ cov @ there.T
    return at_points
