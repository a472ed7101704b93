"""Which views of a point agree: all of them, or else those that the best pair of views predicts.

Wrong matches pull a filter away however large the others' number (10 % of them: 88 % of points
lost without a gate, 18 % with a gate that only looks back). So where all views together do not
fit, pairs of views with wide parallax each propose a point, all views vote, and the recursion runs
over those that agree. Neither the pairs nor the votes depend on the order of the views.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from facetlog.perception.point_fit import Fit, assess, fit_points, linear_start, view_chi2
from facetlog.perception.point_views import BoolArray, Cameras, IndexArray, Sightings
from facetlog.perception.types import FloatArray

__all__ = ["GATE_CHI2", "agreeing_views"]

# An observation belongs to a point up to this squared Mahalanobis distance: chi-square with 2
# degrees of freedom, 99.9 %.
GATE_CHI2 = 13.815510557964274
# All views are taken together unless a fit this bad would come up less often than once in 1,000.
WHOLE_FIT_PROBABILITY = 1e-3
# Pairs that propose: each view with so many partners of widest parallax. With 40 % wrong matches
# in 24 views still some 20 of the pairs are right.
PARTNERS = 3
# A fit that suits all but this share of its views needs no vote.
TRIMMED_SHARE = 0.25
# Proposals that are worked out in full, best votes first.
CANDIDATES = 3
# Views join or leave a candidate at most so often; in 24 views with 10 % wrong two rounds do.
ROUNDS = 5
# Pair-views per block of work, to bound memory (some 100 bytes each).
BLOCK = 100_000


@dataclass(frozen=True, eq=False, slots=True)
class _Proposals:
    owner: IndexArray
    points: FloatArray
    masks: BoolArray


def agreeing_views(cameras: Cameras, seen: Sightings) -> tuple[Fit, BoolArray]:
    """Fits of n points, and the views (n, V) that each was made from and that agree with it."""
    masks = seen.seen.copy()
    count = masks.sum(axis=1)
    fit = fit_points(cameras, seen, masks, linear_start(cameras, seen))
    fits, agrees = _judge(fit, masks)
    _trim(cameras, seen, fit, masks, fits, agrees)
    behind = ((fit.depth <= 0) & masks).any(axis=1)
    # A fit behind the cameras stays, to be named as such, unless voting finds one before them.
    masks[~fits] = False
    contested = np.flatnonzero((~fits | behind) & (count >= 3))
    views = masks.shape[1]
    block = max(1, BLOCK // max(1, PARTNERS * views * views))
    for first in range(0, contested.size, block):
        part = contested[first : first + block]
        voted, agreed = _vote(cameras, seen.take(part))
        found: BoolArray = np.any(agreed, axis=1)
        masks[part[found]] = agreed[found]
        fit.put(part[found], voted, found)
    return fit, masks


def _judge(fit: Fit, masks: BoolArray) -> tuple[BoolArray, BoolArray]:
    """Whether each fit (n,) suits all its masked views, and which views (n, V) agree with it."""
    chi2, _ = view_chi2(fit, masks)
    agrees: BoolArray = np.less_equal(chi2, GATE_CHI2)
    total = (chi2 * masks).sum(axis=1)
    dof = np.maximum(2 * masks.sum(axis=1) - 3, 1)
    fits: BoolArray = np.greater_equal(chdtrc(dof, total), WHOLE_FIT_PROBABILITY)
    return fits & np.all(agrees | ~masks, axis=1), agrees


def _trim(
    cameras: Cameras,
    seen: Sightings,
    fit: Fit,
    masks: BoolArray,
    fits: BoolArray,
    agrees: BoolArray,
) -> None:
    """Settle the points that fit once a few views are left out; changes fit, masks and fits.

    Of 40 right views one in 25 points has one beyond the gate by chance: no need for a vote.
    """
    kept = masks & agrees
    few_left_out = kept.sum(axis=1) >= (1.0 - TRIMMED_SHARE) * masks.sum(axis=1)
    part = np.flatnonzero(~fits & few_left_out & (kept.sum(axis=1) >= 3))
    if not part.size:
        return
    trimmed = fit_points(cameras, seen.take(part), kept[part], fit.points[part])
    settled, again = _judge(trimmed, kept[part])
    # A view that was left out of a pulled fit and agrees with this one has a right to a vote.
    settled = settled & np.all(again & seen.seen[part] == kept[part], axis=1)
    masks[part[settled]] = kept[part[settled]]
    fits[part[settled]] = True
    fit.put(part[settled], trimmed, settled)


def _pairs(cameras: Cameras, seen: Sightings) -> tuple[IndexArray, IndexArray]:
    """Owner (q,) and two views (q, 2) of the pairs that propose."""
    rays = cameras.rays(seen.uv)
    sine2 = 1.0 - (rays.swapaxes(1, 2) @ rays) ** 2
    views = seen.seen.shape[1]
    both = np.logical_and(seen.seen[:, :, None], seen.seen[:, None, :])
    both &= ~np.eye(views, dtype=np.bool_)
    sine2[~both] = -1.0
    partners = min(PARTNERS, views)
    widest = np.argpartition(-sine2, partners - 1, axis=2)[:, :, :partners]
    chosen = np.zeros_like(both)
    np.put_along_axis(chosen, widest, True, axis=2)
    chosen &= both
    chosen |= chosen.swapaxes(1, 2)
    owner, i, j = np.nonzero(np.triu(chosen))
    return owner, np.stack([i, j], axis=1)


def _propose(cameras: Cameras, seen: Sightings) -> _Proposals:
    """The candidates with the best votes, their points and the views that agree with them."""
    owner, views = _pairs(cameras, seen)
    part = seen.take(owner)
    pair = np.zeros_like(part.seen)
    np.put_along_axis(pair, views, True, axis=1)
    fit = assess(cameras, part, pair, linear_start(cameras, seen, views, owner))
    chi2, volume = view_chi2(fit, pair)
    agrees = (chi2 <= GATE_CHI2) & (fit.depth > 0) & part.seen
    sound: BoolArray = np.all(agrees | ~pair, axis=1)
    # -2 log likelihood against the noise alone: a vague point does not collect votes by vagueness.
    votes = np.where(agrees, np.minimum(chi2 + volume, GATE_CHI2), GATE_CHI2)
    score = np.where(part.seen, votes, 0.0).sum(axis=1)
    order = np.lexsort((score, ~sound, owner))
    ranked = owner[order]
    rank = np.arange(order.size) - np.searchsorted(ranked, ranked)
    best = order[(rank < CANDIDATES) & sound[order]]
    return _Proposals(owner[best], fit.points[best], agrees[best])


def _vote(cameras: Cameras, seen: Sightings) -> tuple[Fit, BoolArray]:
    """The best candidate's fit and views of each point; no view where no candidate stands."""
    proposals = _propose(cameras, seen)
    owner, masks = proposals.owner, proposals.masks
    part = seen.take(owner)
    start = proposals.points
    for _ in range(ROUNDS):
        fit = fit_points(cameras, part, masks, start)
        chi2, _ = view_chi2(fit, masks)
        agrees = (chi2 <= GATE_CHI2) & (fit.depth > 0) & part.seen
        if (agrees == masks).all():
            break
        start, masks = fit.points, agrees
    else:
        fit = fit_points(cameras, part, masks, start)
        chi2, _ = view_chi2(fit, masks)
    # Two views that agree with each other alone prove nothing once a third contradicts them.
    masks = masks & (masks.sum(axis=1) >= 3)[:, None]
    score = np.where(masks, np.minimum(chi2, GATE_CHI2), GATE_CHI2 * part.seen).sum(axis=1)
    order = np.lexsort((score, owner))
    heads, first = np.unique(owner[order], return_index=True)
    winner = order[first]
    agreed = np.zeros_like(seen.seen)
    agreed[heads] = masks[winner]
    # Points without a candidate keep the first row's place; no view of theirs agrees.
    row = np.zeros(len(seen.seen), dtype=np.intp)
    row[heads] = winner
    chosen = (
        Fit(*(a[row] for a in fit.arrays))
        if owner.size
        else assess(cameras, seen, seen.seen, linear_start(cameras, seen))
    )
    return chosen, agreed
