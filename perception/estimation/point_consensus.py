"""The inlier views of a point: all of them, or else those that the likeliest point explains.

Wrong matches bias a filter however large the others' number (10 % of them: 88 % of points lost
without a gate, 18 % with a gate that only looks back). So where all views together do not fit,
hypotheses are tested as in RANSAC, scored by a truncated likelihood as in MLESAC (Torr and
Zisserman 2000), but without random sampling: pairs of views each propose a point, the likeliest
proposal is fitted to its inliers until these no longer change, and the recursion runs over them. A
few pairs are enough where the inliers outweigh whatever the other views might still agree on; else
all pairs propose, and the winner must be far likelier than any other point. So the result is that
of the likelihood, whichever pairs propose, and depends neither on the order of the views nor on
rounding.

Pairs are chosen by the places of the cameras alone, each view with partners from near to far; few
views make all their pairs. A proposal is scored by a truncated log likelihood ratio over all views
against chance: an outlier may lie anywhere in its picture.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.special import chdtri

from facetlog.perception.estimation.point_fit import (
    Fit,
    compute_view_chi2,
    fit_points,
    innovation_chi2,
    solve_linear_start,
    solve_points,
)
from facetlog.perception.estimation.point_views import BoolArray, Cameras, IndexArray, Sightings
from facetlog.perception.types import FloatArray

# An observation belongs to a point up to this squared Mahalanobis distance: chi-square with 2
# degrees of freedom, 99.9 %.
GATE_CHI2 = 13.815510557964274
# Where a wrong match may lie: a picture about a radian wide and high, on the plane at depth 1.
PICTURE_AREA = 1.0
# A point of two views errs about as much as a pixel, seen from a view between them.
PAIR_VARIANCE = 2.0
# Rays whose directions differ by less than this many radians have no point in double precision.
LEAST_PARALLAX = 1e-9
# Proposals that are scored at once: what belongs to them stays in the processor's cache.
SCORED_AT_ONCE = 512


def compute_view_gain(seen: Sightings) -> FloatArray:
    """Return the most that each view (n, V) can add to twice the log likelihood ratio of a point.

    2 log of the density of the pixel's noise at its middle over that of an outlier; zero where a
    view did not see the point. Never less than the gate: an inlier, however uncertain, never lowers
    a point's score.
    """
    a, b, c = seen.info[:, 0], seen.info[:, 1], seen.info[:, 2]
    determinant = np.where(seen.seen, a * c - b * b, 1.0)
    density = 2.0 * np.log(PICTURE_AREA / (2.0 * np.pi)) + np.log(determinant)
    return np.where(seen.seen, np.maximum(density, GATE_CHI2), 0.0)


def pairs(
    cameras: Cameras, seen: BoolArray, partners: int
) -> tuple[IndexArray, IndexArray, IndexArray]:
    """Return the row in `seen` (n, V), first and second view of each pair that proposes.

    Each view that saw the point makes pairs with so many others that did, evenly spread over their
    ranks of distance from it; one partner is that of the middle rank.
    """
    centres = cameras.centres
    apart = ((centres[:, None] - centres) ** 2).sum(axis=2)
    np.fill_diagonal(apart, -1.0)
    order = np.argsort(apart, axis=1)[:, 1:]
    # Points that the same views saw have the same pairs.
    packed = np.packbits(seen, axis=1)
    _, sample, like = np.unique(
        packed.view(np.dtype((np.void, packed.shape[1])))[:, 0],
        return_index=True,
        return_inverse=True,
    )
    patterns = seen[sample]
    others = patterns[:, order]
    rank = np.cumsum(others, axis=2)
    count = rank[:, :, -1:]
    at = rank * min(partners, seen.shape[1]) + count // 2
    chosen = others & (at // np.maximum(count, 1) > (at - partners) // np.maximum(count, 1))
    both = np.zeros((*patterns.shape, seen.shape[1]), dtype=np.bool_)
    both[:, np.arange(seen.shape[1])[:, None], order] = chosen
    both &= patterns[:, :, None]
    both |= both.swapaxes(1, 2)
    pattern, i, j = np.nonzero(np.triu(both))
    # Each point takes those of its pattern.
    number = np.bincount(pattern, minlength=len(patterns))
    end = np.cumsum(number[like])
    owner = np.repeat(np.arange(len(seen)), number[like])
    row = np.arange(owner.size) + (np.cumsum(number)[like] - end)[owner]
    return owner, i[row], j[row]


def triangulate_view_pairs(
    cameras: Cameras, seen: Sightings, owner: IndexArray, i: IndexArray, j: IndexArray
) -> tuple[FloatArray, BoolArray]:
    """Return points (q, 3) halfway between the rays of two views each, and whether (q,) the rays
    meet.

    They meet where they pass each other before both cameras within the gate of the pixels' noise.
    """
    R = cameras.projections[:, :, :3].transpose(1, 2, 0)[:, :, None]
    x, y = seen.xy[:, 0], seen.xy[:, 1]
    rays = (x * R[0] + y * R[1] + R[2]) / np.sqrt(1.0 + x * x + y * y)
    # The widest variance of each pixel: 1 / the least eigenvalue of its information.
    a, b, c = seen.info[:, 0], seen.info[:, 1], seen.info[:, 2]
    root = np.sqrt((a - c) ** 2 + 4.0 * b * b)
    widest = (a + c + root) / np.where(seen.seen, 2.0 * (a * c - b * b), 1.0)
    di, dj = rays[:, owner, i], rays[:, owner, j]
    ci, cj = cameras.centres.T[:, i], cameras.centres.T[:, j]
    between = cj - ci
    cosine = _dot(di, dj)
    sine2 = np.maximum(1.0 - cosine * cosine, LEAST_PARALLAX**2)
    along_i, along_j = _dot(di, between), _dot(dj, between)
    s = (along_i - cosine * along_j) / sine2
    t = (cosine * along_i - along_j) / sine2
    gap = s * di - t * dj - between
    noise = s * s * widest[owner, i] + t * t * widest[owner, j]
    meet = (s > 0) & (t > 0) & (_dot(gap, gap) <= GATE_CHI2 * noise)
    return (ci + s * di - 0.5 * gap).T, meet


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    # Of vectors (3, q); numpy's sums over an axis of three are slow.
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def support(
    cameras: Cameras,
    seen: Sightings,
    view_gains: FloatArray,
    owner: IndexArray,
    points: FloatArray,
) -> FloatArray:
    """Return twice the log likelihood (q,) of proposed points against chance, over all views."""
    scores = np.empty(len(owner))
    for first in range(0, len(owner), SCORED_AT_ONCE):
        part = slice(first, first + SCORED_AT_ONCE)
        rows = owner[part]
        chi2 = compute_view_chi2(cameras, seen.xy[rows], seen.info[rows], points[part])
        chi2 /= PAIR_VARIANCE
        gain = view_gains[rows] - chi2
        gain *= chi2 <= GATE_CHI2
        scores[part] = gain.sum(axis=1)
    return scores


# All views are taken together unless a fit this bad would come up less often than once in 1,000.
WHOLE_FIT_PROBABILITY = 1e-3
# A fit of all views is given up where it would end at this many times the permitted chi-square.
HOPELESS = 10.0
# Pairs that propose where views are many: with 60 % outliers some 40 of them are still right.
PAIRS = 276
# Partners of each view at least, also where there are many views.
LEAST_PARTNERS = 6
# Two views that agree on a point which a third view contradicts prove nothing.
LEAST_VIEWS = 3
# A point is taken if it is 1,000 times as likely as any other (2 log of that).
CLEAR_LEAD = 2.0 * np.log(1e3)
# Points nearer to each other than so many standard deviations are one, seen by views whose stated
# covariances are too small, as with wrong poses: the likelier is taken.
ONE_POINT_SD = 20.0
# In so many rounds views join or leave a candidate, in as many more they only leave; with 10 %
# wrong matches in 24 views two rounds do.
ROUNDS = 5
# Views times views of all the points that are worked on at once: some 500 points of 24 views, few
# enough for the processor's cache.
BLOCK = 300_000
FEWEST_VIEWS_OF_A_BLOCK = 24


@dataclass(frozen=True, eq=False, slots=True)
class Consensus:
    """Points (n, 3), their covariances (n, 3, 3) and their inliers among the views (n, V).

    `behind` (n,) says which lie behind one of these views; `gain` (n,) is twice the log likelihood
    ratio against chance. There are no inliers where there is no consensus. Neutral frame.
    """

    points: FloatArray
    covs: FloatArray
    inliers: BoolArray
    behind: BoolArray
    gain: FloatArray

    @classmethod
    def none(cls, points: int, views: int) -> Self:
        """Return so many points without inliers."""
        return cls(
            np.zeros((points, 3)),
            np.zeros((points, 3, 3)),
            np.zeros((points, views), dtype=np.bool_),
            np.zeros(points, dtype=np.bool_),
            np.zeros(points),
        )

    def take(self, rows: IndexArray) -> Self:
        """Return the consensus of some of the points."""
        return type(self)(
            self.points[rows],
            self.covs[rows],
            self.inliers[rows],
            self.behind[rows],
            self.gain[rows],
        )

    def put(self, rows: IndexArray | slice, other: "Consensus") -> None:
        """Overwrite some of the points."""
        self.points[rows], self.covs[rows], self.gain[rows] = other.points, other.covs, other.gain
        self.inliers[rows], self.behind[rows] = other.inliers, other.behind

    @property
    def stands(self) -> BoolArray:
        """Whether (n,) there are enough inliers to prove a point against others."""
        return np.asarray(self.inliers.sum(axis=1) >= LEAST_VIEWS)


def find_agreeing_views(cameras: Cameras, seen: Sightings) -> Consensus:
    """Return the consensus of the views of n points."""
    n, views = seen.seen.shape
    step = max(1, BLOCK // (views * max(views, FEWEST_VIEWS_OF_A_BLOCK)))
    agreed = Consensus.none(n, views)
    for first in range(0, n, step):
        part = slice(first, first + step)
        agreed.put(part, _fit_all_views(cameras, seen.take(part)))
    # A point behind the cameras stays, to be reported, unless pairs find one in front of them.
    contested = np.flatnonzero(
        (~agreed.inliers.any(axis=1) | agreed.behind) & (seen.seen.sum(axis=1) >= LEAST_VIEWS)
    )
    for first in range(0, contested.size, step):
        rows = contested[first : first + step]
        found = _find_by_pairs(cameras, seen.take(rows))
        better = np.flatnonzero(found.stands)
        agreed.put(rows[better], found.take(better))
    return agreed


def _find_by_pairs(cameras: Cameras, seen: Sightings) -> Consensus:
    """Return the consensus of most views: by few pairs where that is clear, else by all of them."""
    view_gains = compute_view_gain(seen)
    found = _find_likeliest(cameras, seen, view_gains, partners=1)
    rest = np.flatnonzero(~_clear(found, view_gains))
    if rest.size:
        found.put(rest, _of_all_pairs(cameras, seen.take(rest), view_gains[rest]))
    return found


def _fit_all_views(cameras: Cameras, seen: Sightings) -> Consensus:
    """Return the fit of all views together; without inliers where they do not agree on it."""
    dof = np.maximum(2 * np.arange(seen.seen.shape[1] + 1) - 3, 1)
    limit = chdtri(dof, WHOLE_FIT_PROBABILITY)[seen.seen.sum(axis=1)]
    start = solve_linear_start(cameras, seen.xy, seen.info)
    fit = fit_points(cameras, seen.xy, seen.info, start, hopeless=HOPELESS * limit)
    total = fit.chi2.sum(axis=1)
    fits = (fit.chi2 <= GATE_CHI2).all(axis=1) & (total <= limit)
    inliers = seen.seen & fits[:, None]
    return _build_consensus(cameras, fit, seen.seen, inliers, -total)


def _build_consensus(
    cameras: Cameras, fit: Fit, fitted: BoolArray, inliers: BoolArray, gain: FloatArray
) -> Consensus:
    distance = (cameras.distances(fit.points) * fitted).sum(axis=1) / np.maximum(
        fitted.sum(axis=1), 1
    )
    behind: BoolArray = np.any((fit.depth <= 0) & fitted, axis=1)
    return Consensus(fit.points, fit.covariances(distance), inliers, behind, gain)


def _clear(found: Consensus, view_gains: FloatArray) -> BoolArray:
    """Return whether (n,) no other point could come near, whatever the other views agree on."""
    others = (view_gains * ~found.inliers).sum(axis=1)
    return np.asarray(found.stands & (found.gain - others >= CLEAR_LEAD))


def _of_all_pairs(cameras: Cameras, seen: Sightings, view_gains: FloatArray) -> Consensus:
    """Return the likeliest points of all pairs of views; without inliers where another is as
    likely.
    """
    views = seen.seen.shape[1]
    partners = max(LEAST_PARTNERS, -(-2 * PAIRS // views))
    found = _find_likeliest(cameras, seen, view_gains, partners)
    doubted = np.flatnonzero(found.stands & ~_clear(found, view_gains))
    if doubted.size:
        first, part = found.take(doubted), seen.take(doubted)
        rival = _find_likeliest(cameras, part, view_gains[doubted], partners, outside=first.inliers)
        between = rival.points - first.points
        square = (between * solve_points(rival.covs + first.covs, between)).sum(axis=1)
        close = np.abs(rival.gain - first.gain) < CLEAR_LEAD
        likelier = np.flatnonzero(rival.stands & (rival.gain > first.gain))
        first.put(likelier, rival.take(likelier))
        first.inliers[rival.stands & close & (square > ONE_POINT_SD**2)] = False
        found.put(doubted, first)
    return found


def _find_likeliest(
    cameras: Cameras,
    seen: Sightings,
    view_gains: FloatArray,
    partners: int,
    outside: BoolArray | None = None,
) -> Consensus:
    """Return the likeliest points that pairs of views propose, by none of the views in a mask."""
    may = seen.seen if outside is None else seen.seen & ~outside
    owner, i, j = pairs(cameras, may, partners)
    points, meet = triangulate_view_pairs(cameras, seen, owner, i, j)
    owner, points = owner[meet], points[meet]
    score = support(cameras, seen, view_gains, owner, points)
    # A table of the scores with a row a point; owners come in order.
    count = np.bincount(owner, minlength=len(view_gains))
    first = np.cumsum(count) - count
    table = np.full((len(view_gains), max(1, int(count.max(initial=0)))), -np.inf)
    table[owner, np.arange(owner.size) - first[owner]] = score
    rows = np.flatnonzero(count)
    start = points[(first + np.argmax(table, axis=1))[rows]]
    found = Consensus.none(*seen.seen.shape)
    found.put(rows, _settle_inliers(cameras, seen.take(rows), view_gains[rows], start))
    return found


def _settle_inliers(
    cameras: Cameras, seen: Sightings, view_gains: FloatArray, start: FloatArray
) -> Consensus:
    """Return points fitted to their inliers, which are chosen anew until none changes."""
    inliers = seen.seen & (
        compute_view_chi2(cameras, seen.xy, seen.info, start) <= PAIR_VARIANCE * GATE_CHI2
    )
    settled = Consensus.none(*inliers.shape)
    points = start.copy()
    # Less than three views are no consensus, and their point may be anywhere.
    rows = np.flatnonzero(inliers.sum(axis=1) >= LEAST_VIEWS)
    for turn in range(2 * ROUNDS):
        if not rows.size:
            break
        part, mask = seen.take(rows), inliers[rows]
        fit = fit_points(cameras, part.xy, part.info * mask[:, None], points[rows])
        gain = ((view_gains[rows] - fit.chi2) * mask).sum(axis=1)
        new = _build_consensus(cameras, fit, mask, mask, gain)
        innovation = innovation_chi2(cameras, part.xy, part.info, fit.points, new.covs)
        agrees = np.where(mask, fit.chi2, innovation) <= GATE_CHI2
        agrees &= part.seen & (fit.depth > 0)
        if turn >= ROUNDS:
            agrees &= mask
        same = (agrees == mask).all(axis=1)
        settled.put(rows[same], new.take(np.flatnonzero(same)))
        points[rows] = fit.points
        inliers[rows] = agrees
        rows = rows[~same & (agrees.sum(axis=1) >= LEAST_VIEWS)]
    return settled
