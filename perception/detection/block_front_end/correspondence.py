"""Correspondence of vertices between pictures: by label and by epipolar geometry.

Section 5.3 of the paper matches successive pictures by label alone. Here every two pictures propose
points (a pair of vertices on each other's epipolar lines), all other pictures vote on them, and the
label is evidence in the vote. A point is accepted if chance would not bring so many vertices
together (an a-contrario test: Moulon, Monasse and Marlet 2012 use it the same way), so missing,
false and mislabelled vertices do no harm, and the order of the pictures has no effect.

Hartley and Zisserman, Multiple View Geometry (2nd ed.): fundamental matrix from two projections
(9.1), its first-order (Sampson) error (11.4), linear triangulation (12.2).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln
from scipy.stats import chi2

from facetlog.perception.detection.block_front_end.position_labels import LabelledVertex
from facetlog.perception.types import FloatArray, Observation, PositionLabel, Track, View

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
# Rounds in which a point gathers its sightings anew.
MOST_ROUNDS = 5
GAUSS_NEWTON_STEPS = 6

IndexArray = NDArray[np.intp]


def track_vertices(
    features: tuple[tuple[LabelledVertex, ...], ...], views: tuple[View, ...]
) -> tuple[Track, ...]:
    """Return tracks of the vertices seen in at least two views, best supported first.

    `features` are the labelled vertices of each view. A track holds at most one vertex a view; a
    vertex belongs to at most one track. Its label is the one that most of its vertices have.
    Of two views alone, pairs with the same label or mark stand. ValueError if the numbers differ.
    """
    if len(features) != len(views):
        raise ValueError(f"features of {len(features)} views, but {len(views)} views")
    seen = _Sightings(features, views)
    if len(seen.view) < 2 or len(views) < 2:
        return ()
    points, pairs = seen.propose_points()
    if not len(points):
        return ()
    # The points of two views are as uncertain as these: twice the variance in the vote.
    spread = float(np.sqrt(np.median(np.trace(seen.cov, axis1=1, axis2=2)) / 2.0))
    off = seen.compute_chi_squares(points, spread)
    off += seen.label_costs(seen.label[pairs].max(axis=1)[:, None])
    used = np.zeros(len(seen.view))
    tracks: list[Track] = []
    while len(points):
        within = np.where(off + used <= POINT_GATE, 1.0 - (off + used) / POINT_GATE, 0.0)
        best = np.stack(
            [within[:, seen.view == k].max(axis=1, initial=0.0) for k in range(len(views))]
        )
        top = int(np.argmax(np.where(best > 0, 1.0 + best, 0.0).sum(axis=0)))
        alive = np.ones(len(points), dtype=np.bool_)
        if not used[pairs[top]].any():
            members = seen.grow(points[top], sorted(pairs[top].tolist()), used)
            if len(members) >= 2 and seen.is_no_chance(members, len(points)):
                tracks.append(seen.track(members))
                used[members] = np.inf
            alive = np.isfinite(used[pairs].max(axis=1))
        alive[top] = False
        points, pairs, off = points[alive], pairs[alive], off[alive]
    # Only the best supported of the tracks with one label keeps it.
    given: set[PositionLabel | None] = {None}
    result = []
    for track in sorted(tracks, key=lambda track: -len(track.observations)):
        result.append(Track(track.observations) if track.label in given else track)
        given.add(track.label)
    return tuple(result)


class _Sightings:
    """All vertices of all views: `view` (n,), `uv` (n, 2), `cov` (n, 2, 2), `label` index (n,).

    `side` and `mark` (n,) number the marks; marks can be compared where the side is the same. What
    a vertex does not have is -1.
    """

    def __init__(
        self, features: tuple[tuple[LabelledVertex, ...], ...], views: tuple[View, ...]
    ) -> None:
        self.views = views
        self.projections = np.array([view.projection for view in views]).reshape(-1, 3, 4)
        self.found = [vertex for per_view in features for vertex in per_view]
        self.view: IndexArray = np.repeat(np.arange(len(views)), [len(f) for f in features])
        self.uv = np.array([f.vertex.uv for f in self.found]).reshape(-1, 2)
        cov = np.array([f.vertex.cov for f in self.found]).reshape(-1, 2, 2)
        self.cov = cov + POSE_SD_PX**2 * np.eye(2)
        self.label = _numbered([f.block_label for f in self.found])
        self.side = _numbered([f.mark and f.mark[0] for f in self.found])
        self.mark = _numbered([f.mark for f in self.found])

    def label_costs(self, label: IndexArray | int) -> FloatArray:
        """Return what each sighting's label (n,) costs in chi-square beside a label (..., 1)."""
        unlike = (np.asarray(label) >= 0) & (self.label >= 0) & (self.label != label)
        return np.where(unlike, LABEL_COST, 0.0)

    def propose_points(self) -> tuple[FloatArray, IndexArray]:
        """Return points (m, 3) of all pairs of vertices that may be one, and the pairs (m, 2)."""
        points, pairs = [np.zeros((0, 3))], [np.zeros((0, 2), dtype=np.intp)]
        for i, j in self._choose_view_pairs():
            a, b = np.flatnonzero(self.view == i), np.flatnonzero(self.view == j)
            if not len(a) or not len(b):
                continue
            first, second = self.projections[[i, j]]
            off = compute_epipolar_chi_square(
                compute_fundamental_matrix(first, second),
                self.uv[a],
                self.cov[a],
                self.uv[b],
                self.cov[b],
            )
            of_a, of_b = np.ix_(a, b)
            unlike = (self.label[of_a] != self.label[of_b]) & (self.label[of_a] >= 0)
            off += np.where(unlike & (self.label[of_b] >= 0), LABEL_COST, 0.0)
            unlike = (self.side[of_a] == self.side[of_b]) & (self.mark[of_a] != self.mark[of_b])
            off += np.where(unlike & (self.side[of_a] >= 0), MARK_COST, 0.0)
            rows, columns = np.nonzero(off <= EPIPOLAR_GATE)
            if len(rows):
                uv = self.uv[a[rows]], self.uv[b[columns]]
                points.append(triangulate_pairs(first, second, *uv))
                pairs.append(np.column_stack([a[rows], b[columns]]))
        found, both = np.concatenate(points), np.concatenate(pairs)
        third = self.projections[self.view[both], 2]
        ahead = (third[..., :3] * found[:, None]).sum(axis=-1) + third[..., 3] > 0
        good = np.isfinite(found).all(axis=1) & ahead.all(axis=1)
        return found[good], both[good]

    def _choose_view_pairs(self) -> list[tuple[int, int]]:
        """Return pairs of views that see the scene at different angles, each's best partners."""
        rays = self._middle() - np.array([view.pose.centre for view in self.views])
        rays /= np.maximum(np.linalg.norm(rays, axis=1, keepdims=True), np.finfo(np.float64).tiny)
        angles = np.arccos(np.clip(rays @ rays.T, -1.0, 1.0))
        cost = np.abs(angles - BEST_PARALLAX)
        np.fill_diagonal(cost, np.inf)
        cost[angles < LEAST_PARALLAX] = np.inf
        partners = np.argsort(cost, axis=1, kind="stable")[:, :MOST_PARTNERS]
        return sorted(
            {
                (min(i, j), max(i, j))
                for i, row in enumerate(partners.tolist())
                for j in row
                if np.isfinite(cost[i, j])
            }
        )

    def _middle(self) -> FloatArray:
        """Return the point (3,) nearest to the rays through the middles of the views' vertices."""
        normal_matrix, right = np.zeros((3, 3)), np.zeros(3)
        for k in np.unique(self.view):
            view, middle = self.views[k], self.uv[self.view == k].mean(axis=0)
            ray = view.pose.rotation @ np.linalg.solve(view.camera.matrix, [*middle, 1.0])
            ray /= np.linalg.norm(ray)
            across = np.eye(3) - np.outer(ray, ray)
            normal_matrix += across
            right += across @ view.pose.centre
        return np.asarray(np.linalg.lstsq(normal_matrix, right)[0])

    def compute_chi_squares(self, points: FloatArray, spread_px: float = 0.0) -> FloatArray:
        """Return the chi-square (m, n) of m points as each sighting; infinite behind a camera.

        `spread_px` is the points' own uncertainty in the picture.
        """
        P = self.projections[self.view]
        h = np.einsum("nij,mj->mni", P[:, :, :3], points) + P[:, :, 3]
        ahead = h[..., 2] > 0
        residual = self.uv - h[..., :2] / np.where(ahead, h[..., 2], 1.0)[..., None]
        weights = np.linalg.inv(self.cov + spread_px**2 * np.eye(2))
        off = np.einsum("mni,nij,mnj->mn", residual, weights, residual)
        return np.where(ahead, off, np.inf)

    def grow(self, start: FloatArray, members: list[int], used: FloatArray) -> list[int]:
        """Return the members that a point settles on when it gathers its sightings in turn.

        At most one of each view, that of least chi-square within the gate; `used` (n,) is infinite
        for those of other tracks. Return an empty list where the members determine no point.
        """
        for _ in range(MOST_ROUNDS):
            projections = self.projections[self.view[members]]
            point = fit_point(projections, self.uv[members], self.cov[members], start)
            if point is None:
                return []
            start = point
            off = (
                self.compute_chi_squares(point[None])[0]
                + self.label_costs(self._find_common_label(members))
                + used
            )
            best: dict[int, int] = {}
            for k in np.argsort(off, kind="stable").tolist():
                if not off[k] <= POINT_GATE:
                    break
                best.setdefault(int(self.view[k]), k)
            gathered = sorted(best.values())
            if gathered == members or len(gathered) < 2:
                break
            members = gathered
        return members

    def _find_common_label(self, members: Sequence[int]) -> int:
        labels = self.label[members]
        return int(np.bincount(labels[labels >= 0]).argmax()) if (labels >= 0).any() else -1

    def is_no_chance(self, members: list[int], proposals: int) -> bool:
        """Return whether chance would hardly give a track that is as well supported.

        Expected are N · C(V - 2, k - 2) · p^(k - 2), times the chance that the labels agree; p is
        the chance of a vertex of another view to fall in the gate: the gate's area over that of the
        object, per vertex.
        """
        count, k = len(self.views), len(members)
        first, second = members[:2]
        if count == 2 and any(x[first] == x[second] >= 0 for x in (self.label, self.mark)):
            return True
        shares = []
        for index in range(count):
            own = self.view == index
            if own.sum() < 2:
                continue
            area = max(float(np.prod(np.ptp(self.uv[own], axis=0))), 1.0)
            gates = np.pi * POINT_GATE * np.sqrt(np.linalg.det(self.cov[own]))
            shares.append(min(1.0, float(gates.sum()) / area))
        share = max(float(np.mean(shares)) if shares else 1.0, 1e-6)
        combinations = gammaln(count - 1) - gammaln(k - 1) - gammaln(count - k + 1)
        labels = self.label[members]
        labels = labels[labels >= 0]
        alike = int(np.bincount(labels).max()) if len(labels) else 0
        unlike = len(labels) - alike
        log_chance = (
            np.log(max(1, proposals))
            + combinations
            + (k - 2) * np.log(share)
            + (max(0, alike - 1) - unlike) * np.log(SAME_LABEL)
        )
        return bool(log_chance <= np.log(MOST_FALSE_TRACKS))

    def track(self, members: list[int]) -> Track:
        """Return the track of these sightings, with their own covariances, and their label."""
        label = self._find_common_label(members)
        vertices = [self.found[k].vertex for k in members]
        views = self.view[members].tolist()
        observations = (Observation(k, v.uv, v.cov) for k, v in zip(views, vertices, strict=True))
        return Track(tuple(observations), None if label < 0 else list(PositionLabel)[label])


def _numbered(values: Sequence[object]) -> IndexArray:
    # Equal values have one number; labels their place in the enumeration; None has -1.
    numbers: dict[object, int] = {label: k for k, label in enumerate(PositionLabel)}
    return np.array(
        [-1 if v is None else numbers.setdefault(v, len(numbers)) for v in values], dtype=np.intp
    )


def compute_fundamental_matrix(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return F (3, 3) with x2ᵀ F x1 = 0 for projections (3, 4) of two views; 0 for one centre."""
    x, y, z = second @ np.linalg.svd(first)[2][-1]  # the epipole
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(cross @ second @ np.linalg.pinv(first))


def compute_epipolar_chi_square(
    fundamental: FloatArray,
    uv1: FloatArray,
    cov1: FloatArray,
    uv2: FloatArray,
    cov2: FloatArray,
) -> FloatArray:
    """Return the chi-square (n, m) of pixels uv1 (n, 2) and uv2 (m, 2) corresponding.

    One degree of freedom: the algebraic distance x2ᵀ F x1 over its variance by first-order
    propagation of both covariances (n, 2, 2) and (m, 2, 2).
    """
    x1 = np.column_stack([uv1, np.ones(len(uv1))])
    x2 = np.column_stack([uv2, np.ones(len(uv2))])
    lines2 = x1 @ fundamental.T  # (n, 3): epipolar lines in the second view
    lines1 = x2 @ fundamental  # (m, 3): epipolar lines in the first
    variance = np.einsum("mi,nij,mj->nm", lines1[:, :2], cov1, lines1[:, :2])
    variance += np.einsum("ni,mij,nj->nm", lines2[:, :2], cov2, lines2[:, :2])
    return np.asarray((lines2 @ x2.T) ** 2 / np.maximum(variance, np.finfo(np.float64).tiny))


def triangulate_pairs(
    first: FloatArray, second: FloatArray, uv1: FloatArray, uv2: FloatArray
) -> FloatArray:
    """Return the points (n, 3) of pairs of pixels (n, 2) in two views, by the linear method.

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
    h = np.linalg.svd(rows)[2][:, -1]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(h[:, :3] / h[:, 3:])


def fit_point(
    projections: FloatArray, uv: FloatArray, cov: FloatArray, start: FloatArray
) -> FloatArray | None:
    """Fit a point (3,) to pixels (k, 2) with covariances (k, 2, 2), by Gauss-Newton from `start`.

    `projections` (k, 3, 4) are those of the pixels' views. None if the rays do not fix a point, or
    it falls behind a camera. All pixels count: which of them belong together is for the caller.
    """
    weights = np.linalg.inv(cov)
    point = start
    for _ in range(GAUSS_NEWTON_STEPS):
        h = projections[:, :, :3] @ point + projections[:, :, 3]
        depth = h[:, 2]
        if not (depth > 0).all():
            return None
        pixel = h[:, :2] / depth[:, None]
        jacobian = projections[:, :2, :3] - pixel[:, :, None] * projections[:, None, 2, :3]
        jacobian /= depth[:, None, None]
        information = np.einsum("nia,nij,njb->ab", jacobian, weights, jacobian)
        gradient = np.einsum("nia,nij,nj->a", jacobian, weights, uv - pixel)
        values = np.linalg.eigvalsh(information)
        if not values[0] > np.finfo(np.float64).eps * 1e2 * values[-1]:
            return None
        point = point + np.linalg.solve(information, gradient)
    return point if (projections[:, 2, :3] @ point + projections[:, 2, 3] > 0).all() else None
