"""Correspondence of vertices between pictures: by label and by epipolar geometry.

Section 5.3 of the paper matches successive pictures by label alone. Here every two pictures propose
points (a pair of vertices on each other's epipolar lines), all other pictures vote on them, and the
label is evidence in the vote. A point is accepted if chance would not bring so many vertices
together (an a-contrario test: Moulon, Monasse and Marlet 2012 use it the same way), so missing,
false and mislabelled vertices do no harm, and the order of the pictures has no effect.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import gammaln
from scipy.stats import chi2

from facetlog.perception.detection.block_front_end.position_labels import LabelledVertex
from facetlog.perception.detection.block_front_end.triangulation import (
    PointFit,
    epipolar_chi_square,
    fundamental_matrix,
    linear_points,
    point_fit,
)
from facetlog.perception.types import FloatArray, Observation, PositionLabel, Track, View

__all__ = ["POSE_SD_PX", "track_vertices"]

# Effect of a pose's error in the picture, px. Odometry is worse, a calibrated rig better.
POSE_SD_PX = 0.5
# Gates: a true pair or observation is rejected once in a thousand times.
GATE_SHARE = 0.999
EPIPOLAR_GATE = float(chi2.ppf(GATE_SHARE, 1))
POINT_GATE = float(chi2.ppf(GATE_SHARE, 2))
# At most one position label in a hundred is taken to be wrong (on the rendered tour none is), so
# one that contradicts costs -2 ln .01 in chi-square.
LABEL_ERROR = 0.01
LABEL_COST = -2.0 * float(np.log(LABEL_ERROR))
# A junction may change where a side comes into sight, or an edge was not found: one in twenty is
# assumed. So a mark makes a poor pair fail, not a good one.
MARK_ERROR = 0.05
MARK_COST = -2.0 * float(np.log(MARK_ERROR))
# Rays that meet at less than this angle determine no depth to vote on, radians.
LEAST_PARALLAX = np.deg2rad(2.0)
# A track is kept if this many are expected by chance in all, or fewer (Desolneux et al. 2000).
MOST_FALSE_TRACKS = 0.1
# Chance of two vertices of a block to have the same label.
SAME_LABEL = 1.0 / len(PositionLabel)
# Each picture is paired with at most this many others, those of the best parallax.
MOST_PARTNERS = 16
BEST_PARALLAX = np.deg2rad(60.0)


@dataclass(frozen=True, eq=False, slots=True)
class _Sightings:
    """All vertices of all views: view (n,), uv (n, 2), cov (n, 2, 2), label index or -1 (n,).

    `among` (n,) and `mark` (n,) are -1 where there is none, else alike where they are the same:
    marks can be compared among vertices that might be one.
    """

    view: np.ndarray[tuple[int, ...], np.dtype[np.intp]]
    uv: FloatArray
    cov: FloatArray
    label: np.ndarray[tuple[int, ...], np.dtype[np.intp]]
    among: np.ndarray[tuple[int, ...], np.dtype[np.intp]]
    mark: np.ndarray[tuple[int, ...], np.dtype[np.intp]]


def _sightings(features: tuple[tuple[LabelledVertex, ...], ...], pose_sd_px: float) -> _Sightings:
    names = list(PositionLabel)
    flat = [(index, found) for index, per_view in enumerate(features) for found in per_view]
    marks = [found.mark for _, found in flat]
    groups = {mark[0]: i for i, mark in enumerate(marks) if mark is not None}
    kinds = {mark: i for i, mark in enumerate(marks) if mark is not None}
    return _Sightings(
        np.array([index for index, _ in flat], dtype=np.intp),
        np.array([f.vertex.uv for _, f in flat]).reshape(-1, 2),
        np.array([f.vertex.cov for _, f in flat]).reshape(-1, 2, 2) + pose_sd_px**2 * np.eye(2),
        np.array(
            [-1 if f.block_label is None else names.index(f.block_label) for _, f in flat],
            dtype=np.intp,
        ),
        np.array([-1 if mark is None else groups[mark[0]] for mark in marks], dtype=np.intp),
        np.array([-1 if mark is None else kinds[mark] for mark in marks], dtype=np.intp),
    )


def _view_pairs(views: tuple[View, ...], middle: FloatArray) -> list[tuple[int, int]]:
    """Pairs of views that see `middle` (3,) at different angles, each view's best partners."""
    rays = middle - np.array([view.pose.centre for view in views])
    rays /= np.maximum(np.linalg.norm(rays, axis=1, keepdims=True), np.finfo(np.float64).tiny)
    angles = np.arccos(np.clip(rays @ rays.T, -1.0, 1.0))
    cost = np.abs(angles - BEST_PARALLAX)
    np.fill_diagonal(cost, np.inf)
    cost[angles < LEAST_PARALLAX] = np.inf
    pairs = set()
    for i, row in enumerate(cost):
        for j in np.argsort(row, kind="stable")[:MOST_PARTNERS]:
            if np.isfinite(row[j]):
                pairs.add((min(i, int(j)), max(i, int(j))))
    return sorted(pairs)


def _scene_middle(views: tuple[View, ...], seen: _Sightings) -> FloatArray:
    """The point (3,) nearest to the rays through the middles of the views' vertices."""
    normal_matrix, right = np.zeros((3, 3)), np.zeros(3)
    for index, view in enumerate(views):
        own = seen.uv[seen.view == index]
        if not len(own):
            continue
        ray = view.pose.rotation @ np.linalg.solve(view.camera.matrix, [*own.mean(axis=0), 1.0])
        ray /= np.linalg.norm(ray)
        across = np.eye(3) - np.outer(ray, ray)
        normal_matrix += across
        right += across @ view.pose.centre
    return np.asarray(np.linalg.lstsq(normal_matrix, right, rcond=None)[0], dtype=np.float64)


def _proposals(
    views: tuple[View, ...], seen: _Sightings
) -> tuple[FloatArray, np.ndarray[tuple[int, ...], np.dtype[np.intp]]]:
    """Points (n, 3) of all pairs of vertices that may be one, and the pairs (n, 2)."""
    points, pairs = [np.zeros((0, 3))], [np.zeros((0, 2), dtype=np.intp)]
    by_view = [np.flatnonzero(seen.view == i) for i in range(len(views))]
    for i, j in _view_pairs(views, _scene_middle(views, seen)):
        a, b = by_view[i], by_view[j]
        if not len(a) or not len(b):
            continue
        first, second = views[i].projection, views[j].projection
        off = epipolar_chi_square(
            fundamental_matrix(first, second), seen.uv[a], seen.cov[a], seen.uv[b], seen.cov[b]
        )
        la, lb = seen.label[a][:, None], seen.label[b][None, :]
        off = off + np.where((la != lb) & (la >= 0) & (lb >= 0), LABEL_COST, 0.0)
        ga, gb = seen.among[a][:, None], seen.among[b][None, :]
        unlike = seen.mark[a][:, None] != seen.mark[b][None, :]
        off = off + np.where((ga == gb) & (ga >= 0) & unlike, MARK_COST, 0.0)
        rows, columns = np.nonzero(off <= EPIPOLAR_GATE)
        if len(rows):
            points.append(linear_points(first, second, seen.uv[a[rows]], seen.uv[b[columns]]))
            pairs.append(np.column_stack([a[rows], b[columns]]))
    found, both = np.concatenate(points), np.concatenate(pairs)
    good = np.isfinite(found).all(axis=1)
    found, both = found[good], both[good]
    for k in range(2):
        depth = np.array([views[v].projection[2] for v in seen.view[both[:, k]]]).reshape(-1, 4)
        ahead = (depth[:, :3] * found).sum(axis=1) + depth[:, 3] > 0
        found, both = found[ahead], both[ahead]
    return found, both


def _off(
    views: tuple[View, ...], seen: _Sightings, points: FloatArray, spread_px: float
) -> FloatArray:
    """Chi-square (n, m) of n points as each of the m sightings; infinite behind a camera.

    `spread_px` is the points' own uncertainty in the picture.
    """
    off = np.full((len(points), len(seen.view)), np.inf)
    for index, view in enumerate(views):
        own = np.flatnonzero(seen.view == index)
        if not len(own):
            continue
        projected = points @ view.projection[:, :3].T + view.projection[:, 3]
        ahead = projected[:, 2] > 0
        pixel = projected[ahead, :2] / projected[ahead, 2:]
        residual = seen.uv[own][None, :, :] - pixel[:, None, :]
        weights = np.linalg.inv(seen.cov[own] + spread_px**2 * np.eye(2))
        off[np.ix_(ahead, own)] = np.einsum("nmi,mij,nmj->nm", residual, weights, residual)
    return off


def _best_each_view(
    off: FloatArray, view: np.ndarray[tuple[int, ...], np.dtype[np.intp]], free: FloatArray
) -> list[int]:
    """The sighting of least chi-square in each view among those within the gate."""
    best: dict[int, int] = {}
    for k in np.argsort(off + free, kind="stable"):
        if not off[k] + free[k] <= POINT_GATE:
            break
        best.setdefault(int(view[k]), int(k))
    return sorted(best.values())


def _label_costs(seen: _Sightings, members: list[int]) -> tuple[FloatArray, int]:
    """Chi-square (m,) that each sighting's label costs beside the members', and their label."""
    labels = seen.label[members]
    labels = labels[labels >= 0]
    if not len(labels):
        return np.zeros(len(seen.view)), -1
    label = int(np.bincount(labels).argmax())
    return np.where((seen.label >= 0) & (seen.label != label), LABEL_COST, 0.0), label


def _grown(
    views: tuple[View, ...],
    seen: _Sightings,
    start: FloatArray,
    members: list[int],
    used: FloatArray,
) -> tuple[list[int], PointFit] | None:
    """The members a point settles on when it is fitted and gathers its sightings in turn."""
    projections = tuple(view.projection for view in views)
    fit: PointFit | None = None
    for _ in range(5):
        observations = tuple(
            Observation(int(seen.view[k]), seen.uv[k], seen.cov[k]) for k in members
        )
        fit = point_fit(observations, projections, start)
        if fit is None:
            return None
        start = fit.point
        costs, _ = _label_costs(seen, members)
        off = _off(views, seen, fit.point[None, :], 0.0)[0]
        gathered = _best_each_view(off, seen.view, costs + used)
        if gathered == members or len(gathered) < 2:
            break
        members = gathered
    return (members, fit) if fit is not None else None


def _expected_by_chance(
    views: tuple[View, ...], seen: _Sightings, members: list[int], proposals: int
) -> float:
    """Number of tracks as well supported as this one that chance would give.

    N · C(V - 2, k - 2) · p^(k - 2), times the chance that the labels agree; p is the chance of a
    vertex of another view to fall in the gate: the gate's area over that of the object, per vertex.
    """
    count = len(views)
    shares = []
    for index in range(count):
        own = np.flatnonzero(seen.view == index)
        if len(own) < 2:
            continue
        extent = np.ptp(seen.uv[own], axis=0)
        area = max(float(extent[0] * extent[1]), 1.0)
        gates = np.pi * POINT_GATE * np.sqrt(np.linalg.det(seen.cov[own]))
        shares.append(min(1.0, float(gates.sum()) / area))
    share = max(float(np.mean(shares)) if shares else 1.0, 1e-6)
    k = len(members)
    combinations = gammaln(count - 1) - gammaln(k - 1) - gammaln(count - k + 1)
    labels = seen.label[members]
    labels = labels[labels >= 0]
    alike = int(np.bincount(labels).max()) if len(labels) else 0
    unlike = len(labels) - alike
    log_chance = (
        np.log(max(1, proposals))
        + combinations
        + (k - 2) * np.log(share)
        + max(0, alike - 1) * np.log(SAME_LABEL)
        - unlike * np.log(SAME_LABEL)
    )
    return float(np.exp(min(log_chance, 1.0)))  # more than one is too many, whatever the number


def track_vertices(
    features: tuple[tuple[LabelledVertex, ...], ...],
    views: tuple[View, ...],
    *,
    pose_sd_px: float = POSE_SD_PX,
    most_false: float = MOST_FALSE_TRACKS,
) -> tuple[Track, ...]:
    """Tracks of the vertices seen in at least two views, best supported first.

    `features` are the labelled vertices of each view. A track holds at most one vertex a view; a
    vertex belongs to at most one track. Its label is the one that most of its vertices have.
    Of two views alone, pairs with the same label or mark stand. ValueError if the numbers differ.
    """
    if len(features) != len(views):
        raise ValueError(f"features of {len(features)} views, but {len(views)} views")
    seen = _sightings(features, pose_sd_px)
    if len(seen.view) < 2 or len(views) < 2:
        return ()
    points, pairs = _proposals(views, seen)
    if not len(points):
        return ()
    # The points of two views are as uncertain as these: twice the variance in the vote.
    spread = float(np.sqrt(np.median(np.trace(seen.cov, axis1=1, axis2=2)) / 2.0))
    off = _off(views, seen, points, spread)
    same = seen.label[pairs].max(axis=1)[:, None]
    off = off + np.where((same >= 0) & (seen.label >= 0) & (seen.label != same), LABEL_COST, 0.0)
    used = np.zeros(len(seen.view))
    tracks: list[Track] = []
    while len(points):
        within = np.where(off + used <= POINT_GATE, 1.0 - (off + used) / POINT_GATE, 0.0)
        votes = np.zeros(len(points))
        for index in range(len(views)):
            own = seen.view == index
            if own.any():
                best = within[:, own].max(axis=1)
                votes += np.where(best > 0, 1.0 + best, 0.0)
        top = int(np.argmax(votes))
        members = [int(k) for k in pairs[top]]
        if used[members].any():
            alive = np.ones(len(points), dtype=np.bool_)
            alive[top] = False
        else:
            found = _grown(views, seen, points[top], sorted(members), used)
            if found is not None and len(found[0]) >= 2:
                chance = _expected_by_chance(views, seen, found[0], len(points))
                if chance <= most_false or _labelled_pair(views, seen, found[0]):
                    tracks.append(_track(features, seen, found[0]))
                    used[found[0]] = np.inf
            alive = np.isfinite(used[pairs].max(axis=1))
            alive[top] = False
        points, pairs, off = points[alive], pairs[alive], off[alive]
    return _each_label_once(sorted(tracks, key=lambda track: -len(track.observations)))


def _each_label_once(tracks: list[Track]) -> tuple[Track, ...]:
    """The tracks, best supported first; of those with one label only the first keeps it."""
    given: set[PositionLabel] = set()
    result = []
    for track in tracks:
        if track.label is not None and track.label in given:
            result.append(Track(track.observations))
        else:
            result.append(track)
            if track.label is not None:
                given.add(track.label)
    return tuple(result)


def _labelled_pair(views: tuple[View, ...], seen: _Sightings, members: list[int]) -> bool:
    """Whether two views are all there is and the label or mark of both vertices is the same."""
    first, second = members[:2]
    same = any(of[first] == of[second] and of[first] >= 0 for of in (seen.label, seen.mark))
    return len(views) == 2 and bool(same)


def _track(
    features: tuple[tuple[LabelledVertex, ...], ...], seen: _Sightings, members: list[int]
) -> Track:
    """The track of these sightings, with the vertices' own covariances and the majority's label."""
    flat = [found for per_view in features for found in per_view]
    _, label = _label_costs(seen, members)
    observations = tuple(
        Observation(int(seen.view[k]), flat[k].vertex.uv, flat[k].vertex.cov) for k in members
    )
    return Track(observations, None if label < 0 else list(PositionLabel)[label])
