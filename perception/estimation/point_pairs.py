"""Points proposed by pairs of views, and their support over all views.

Pairs are chosen by the places of the cameras alone, each view with partners from near to far, so
neither the order of the views nor the observations matter; few views make all their pairs. A
proposal is scored by a truncated log likelihood ratio over all views against chance: an outlier may
lie anywhere in its picture.
"""

import numpy as np

from facetlog.perception.estimation.point_fit import view_chi2
from facetlog.perception.estimation.point_views import BoolArray, Cameras, IndexArray, Sightings
from facetlog.perception.types import FloatArray

__all__ = ["GATE_CHI2", "pair_points", "pairs", "support", "view_gain"]

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
BLOCK = 512


def view_gain(seen: Sightings) -> FloatArray:
    """The most that each view (n, V) can add to twice the log likelihood ratio of a point.

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
    """Row in `seen` (n, V), first and second view of each pair that proposes.

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


def pair_points(
    cameras: Cameras, seen: Sightings, owner: IndexArray, i: IndexArray, j: IndexArray
) -> tuple[FloatArray, BoolArray]:
    """Points (q, 3) halfway between the rays of two views each, and whether (q,) the rays meet.

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
    """Twice the log likelihood (q,) of proposed points against chance, over all views."""
    scores = np.empty(len(owner))
    for first in range(0, len(owner), BLOCK):
        part = slice(first, first + BLOCK)
        rows = owner[part]
        chi2 = view_chi2(cameras, seen.xy[rows], seen.info[rows], points[part])
        chi2 /= PAIR_VARIANCE
        gain = view_gains[rows] - chi2
        gain *= chi2 <= GATE_CHI2
        scores[part] = gain.sum(axis=1)
    return scores
