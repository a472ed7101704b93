"""Which plane hypotheses are worth a search: each edge bounds two faces, not a dozen."""

import heapq
from collections.abc import Sequence

import numpy as np

from facetlog.perception.detection.line_front_end.ground_plane import Ground
from facetlog.perception.detection.line_front_end.line_cloud import LineCloud
from facetlog.perception.detection.line_front_end.plane_hypotheses import PlaneHypothesis
from facetlog.perception.ties import descending
from facetlog.perception.types import FloatArray

__all__ = ["choose_planes", "same_plane"]

# Two hypotheses are one plane within this angle where their lines lie this near, px, by this share.
SAME_COSINE = np.cos(np.radians(4.0))
SAME_PX, SAME_SHARE = 3.0, 0.9
# What a line is still worth to the next plane.
PASSED_ON = 0.5


def choose_planes(
    planes: Sequence[PlaneHypothesis],
    cloud: LineCloud,
    worth: FloatArray,
    ground: Ground | None,
    least: float,
) -> tuple[tuple[PlaneHypothesis, ...], FloatArray]:
    """Planes that may hold a face, and what an outline of lines is worth at most on each.

    `worth` (n,) is the log-likelihood ratio of the cloud's lines as sides of faces. Planes that are
    one are taken once. Each line is worth half as much to the next plane as to the one before, and
    nothing where it lies on the ground: a plane worth less than `least` is left out.
    """
    if ground is not None:
        low = ground.holds(cloud.segments.reshape(-1, 3)).reshape(-1, 2).all(axis=1)
        worth = np.where(low, 0.0, worth)
    distinct = _distinct(planes, cloud)
    promise = np.array([worth[p.lines].sum() for p in distinct])
    left = worth.copy()
    queue = [(-promise[k], k) for k in range(len(distinct))]
    heapq.heapify(queue)
    chosen = []
    while queue:
        known, k = heapq.heappop(queue)
        lines = distinct[k].lines
        now = -float(left[lines].sum())
        if now > known:
            heapq.heappush(queue, (now, k))
        elif -now > least:
            chosen.append(k)
            left[lines] *= PASSED_ON
    return tuple(distinct[k] for k in chosen), promise[chosen]


def _distinct(planes: Sequence[PlaneHypothesis], cloud: LineCloud) -> list[PlaneHypothesis]:
    # Of the planes that are one, the one with most support.
    length = np.linalg.norm(cloud.segments[:, 1] - cloud.segments[:, 0], axis=1)
    support = cloud.support * length
    kept: list[PlaneHypothesis] = []
    for best in descending(np.array([support[p.lines].sum() for p in planes])):
        ends = cloud.segments[planes[best].lines].reshape(-1, 3)
        if not any(same_plane(planes[best], ends, other, cloud.pixel) for other in kept):
            kept.append(planes[best])
    return kept


def same_plane(
    plane: PlaneHypothesis, points: FloatArray, other: PlaneHypothesis, pixel: float
) -> bool:
    """Whether two planes are one, over points (n, 3) of the first."""
    if abs(plane.normal @ other.normal) < SAME_COSINE:
        return False
    near = np.abs(points @ other.normal - other.distance) < SAME_PX * pixel
    return bool(near.mean() > SAME_SHARE)
