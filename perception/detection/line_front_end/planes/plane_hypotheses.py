"""Planes that several 3-D segments share: seeded by segments that meet, fitted to all on them."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.stable_order import descending
from facetlog.perception.types import FloatArray

# Two segments meet when their lines pass within this many px, and near both segments.
MEET_PX = 4.0
MEET_BEYOND = 0.35  # of a segment's length, beyond its end
MIN_CROSSING_SINE = np.sin(np.radians(15.0))
# A segment lies on a plane when both ends are within this many px of it, or within SDS standard
# deviations where their depth is less well known, but never farther than MAX_OFF_PX.
ON_PLANE_PX = 3.0
SDS = 3.0
MAX_OFF_PX = 15.0
MIN_LINES = 3
# Two planes are one when they agree this well over the segments that they share.
SAME_SHARE = 0.7


@dataclass(frozen=True, eq=False, slots=True)
class PlaneHypothesis:
    """Plane normal · x = distance and the indices of the segments that lie on it.

    `texture` (m, 3) are texture points known to lie on it, `texture_variance` (m,) their variances
    across it.
    """

    normal: FloatArray
    distance: float
    lines: NDArray[np.intp]
    texture: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    texture_variance: FloatArray = field(default_factory=lambda: np.zeros(0))


def plane_hypotheses(
    segments: FloatArray, end_covs: FloatArray, support: FloatArray, pixel: float
) -> tuple[PlaneHypothesis, ...]:
    """Return planes through pairs of segments (n, 2, 3) that meet, best supported first.

    `end_covs` (n, 2, 3, 3) are the covariances of the ends, `pixel` is the length of one pixel at
    the object. A plane needs MIN_LINES segments as inliers.
    """
    first, second = _find_meeting_pairs(segments, end_covs, pixel)
    if not len(first):
        return ()
    along = segments[:, 1] - segments[:, 0]
    length = np.linalg.norm(along, axis=1)
    unit = along / length[:, None]
    normal = np.cross(unit[first], unit[second])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    middle = (segments[first].sum(axis=1) + segments[second].sum(axis=1)) / 4
    distance = np.einsum("pk,pk->p", normal, middle)
    on = _on_planes(segments, end_covs, normal, distance, pixel)
    score = on @ (support * length)
    count = on.sum(axis=1)
    planes: list[PlaneHypothesis] = []
    used = np.zeros(
        (0, len(segments))
    )  # 1 where a segment lies on a plane, to count shared inliers
    for p in descending(score):
        if count[p] < MIN_LINES:
            continue
        pair = on[p, first[p]] and (used[:, first[p]] * used[:, second[p]]).any()
        if pair and (used @ on[p]).max() >= SAME_SHARE * count[p]:
            continue
        fit, members = _fit(segments, end_covs, on[p], pixel)
        if members.sum() >= MIN_LINES:
            planes.append(PlaneHypothesis(fit[:3], float(fit[3]), np.nonzero(members)[0]))
            used = np.concatenate([used, members[None]])
    return tuple(planes)


def _on_planes(
    segments: FloatArray,
    end_covs: FloatArray,
    normal: FloatArray,
    distance: FloatArray,
    pixel: float,
) -> NDArray[np.bool_]:
    # (planes, segments): whether both ends are as near to the plane as they are known.
    away = np.abs(normal @ segments.reshape(-1, 3).T - distance[:, None])
    squares = (normal[:, :, None] * normal[:, None]).reshape(-1, 9)
    variance = squares @ end_covs.reshape(-1, 9).T
    limit = np.hypot(ON_PLANE_PX * pixel, SDS * np.sqrt(np.maximum(variance, 0.0)))
    near = away < np.minimum(limit, MAX_OFF_PX * pixel)
    return near[:, 0::2] & near[:, 1::2]


def _find_meeting_pairs(
    segments: FloatArray, end_covs: FloatArray, pixel: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    a = segments[:, 0]
    along = segments[:, 1] - a
    length = np.linalg.norm(along, axis=1)
    u = along / length[:, None]
    # Nearest points of lines a_i + s u_i and a_j + t u_j.
    cosine = u @ u.T
    between = a[None] - a[:, None]  # a_j - a_i
    on_i = np.einsum("ijk,ik->ij", between, u)
    on_j = np.einsum("ijk,jk->ij", between, u)
    square = 1 - cosine**2
    crossing = square > MIN_CROSSING_SINE**2
    safe = np.where(crossing, square, 1.0)
    s = (on_i - cosine * on_j) / safe
    t = (cosine * on_i - on_j) / safe
    gap = np.linalg.norm(between + t[..., None] * u[None] - s[..., None] * u[:, None], axis=-1)
    near_i = (s > -MEET_BEYOND * length[:, None]) & (s < (1 + MEET_BEYOND) * length[:, None])
    near_j = (t > -MEET_BEYOND * length) & (t < (1 + MEET_BEYOND) * length)
    close = gap < MAX_OFF_PX * pixel
    i, j = np.nonzero(np.triu(crossing & near_i & near_j & close, 1))
    across = np.cross(u[i], u[j])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    variance = sum(
        np.einsum("pk,pekl,pl->pe", across, end_covs[n], across).max(axis=1) for n in (i, j)
    )
    limit = np.hypot(MEET_PX * pixel, SDS * np.sqrt(np.maximum(variance, 0.0)))
    meets = gap[i, j] < limit
    return i[meets], j[meets]


def _fit(
    segments: FloatArray, end_covs: FloatArray, on: NDArray[np.bool_], pixel: float
) -> tuple[FloatArray, NDArray[np.bool_]]:
    # Total least squares through the ends, weighted by their variances across the plane found
    # before; the inliers are chosen anew after each fit.
    fit = np.zeros(4)
    for _ in range(3):
        points = segments[on].reshape(-1, 3)
        covs = end_covs[on].reshape(-1, 3, 3)
        variance = np.einsum("k,nkl,l->n", fit[:3], covs, fit[:3])
        w = 1.0 / (pixel**2 + variance)
        centre = (w[:, None] * points).sum(axis=0) / w.sum()
        _, _, vt = np.linalg.svd((points - centre) * np.sqrt(w)[:, None], full_matrices=False)
        fit = np.append(vt[2], vt[2] @ centre)
        refreshed = _on_planes(segments, end_covs, fit[None, :3], fit[None, 3], pixel)[0]
        if refreshed.sum() < MIN_LINES:
            break
        on = refreshed
    return fit, on


def plane_basis(normal: FloatArray) -> FloatArray:
    """Return two unit vectors (3, 2) that span the plane across `normal`."""
    return make_plane_axes(normal, np.eye(3)[int(np.argmin(np.abs(normal)))]).T
