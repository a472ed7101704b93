"""How far things are from each other: the least distance between their faces and loose edges.

A distance is found between two points that are weighted means of vertices (nearest_points.py).
Moving a vertex of weight w changes it by w u, u being the unit vector from one point to the other,
for to first order the points slide along what they lie on. So var d = Σ w² uᵀ C u over the
vertices.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.facts.gaps.nearest_points import (
    Parts,
    Witnesses,
    find_crossed_faces,
    find_feet_on_faces,
    find_nearest_on_sides,
    joined,
    passing,
)
from facetlog.perception.flat_faces import Estimate
from facetlog.perception.ragged import Indices
from facetlog.perception.surfaces.components import components
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.things import Thing
from facetlog.perception.surfaces.tolerance import Tolerance
from facetlog.perception.types import FloatArray

PAIRS_AT_ONCE = 2_000
"""Pairs of things worked on in one go: of blocks some 100 MB."""


class Gap(NamedTuple):
    """The least distance between two things, by their numbers, `first` < `second`."""

    first: int
    second: int
    distance: Estimate


def gaps(table: FaceTable, edges: Indices, things: Sequence[Thing]) -> tuple[Gap, ...]:
    """Return the least distance of every two things, 0 where they touch or go through each other.

    `edges` (e, 2) are vertices. Where several witnesses are as near
    within 3 sd, as between two faces that are parallel, the distance is their mean: the least alone
    would be low by its noise.
    """
    if len(things) < 2:
        return ()
    covs, tolerance = table.covs, table.tolerance
    parts = Parts.of(table, edges, things)
    count = len(things)
    noise = _noise(parts, count, tolerance)
    # Each pair once: other ways round, the reach is NaN, which nothing is within.
    later = np.triu(np.ones((count, count), dtype=np.bool_), 1)
    reach = np.where(later, _compute_vertex_distances(parts, count) + noise, np.nan)
    step = max(1, PAIRS_AT_ONCE // count)
    found: list[Gap] = []
    for low in range(0, count - 1, step):
        one, rest = parts.between(low, low + step), parts.between(low + 1, count)
        near = _find_witnesses(one, rest, reach, tolerance.finest)
        pairs = low + np.argwhere(later[low : low + step, low:])
        number = np.zeros((count, count), dtype=np.intp)
        number[pairs[:, 0], pairs[:, 1]] = np.arange(len(pairs))
        pair = number[np.minimum(near.one, near.two), np.maximum(near.one, near.two)]
        order = np.lexsort((near.rank, pair))
        distances = _average_distances(
            near.take(order), pair[order], noise[pairs[:, 0], pairs[:, 1]], covs, tolerance
        )
        found.extend(
            Gap(i, j, distance) for (i, j), distance in zip(pairs.tolist(), distances, strict=True)
        )
    return tuple(found)


def _noise(parts: Parts, count: int, tolerance: Tolerance) -> FloatArray:
    """Return the difference of distances between things [i, j] that is still within 3 sd."""
    worst = np.zeros(count)
    np.maximum.at(worst, parts.vertex_of, tolerance.vertex_sds[parts.vertices])
    return tolerance.within(np.hypot(worst[:, None], worst))


def _compute_vertex_distances(parts: Parts, count: int) -> FloatArray:
    """Return the least distances between vertices of the things [i, j]: no two are further
    apart.
    """
    from scipy.spatial.distance import cdist  # loaded only now: one thing alone has no gaps

    least = np.zeros((count, count))
    starts = np.searchsorted(parts.vertex_of, np.arange(count))
    for i in range(count):
        apart = cdist(parts.between(i, i + 1).at, parts.at).min(axis=0)
        least[i] = np.minimum.reduceat(apart, starts)
    return least


def _find_witnesses(one: Parts, rest: Parts, reach: FloatArray, slack: float) -> Witnesses:
    """Return all witnesses within reach of a thing and others; the nearest of each pair is among
    them.
    """
    return joined(
        [
            find_nearest_on_sides(one, rest, reach, slack),
            find_nearest_on_sides(rest, one, reach.T, slack),
            passing(one, rest, reach, slack),
            find_feet_on_faces(one, rest, reach, slack),
            find_feet_on_faces(rest, one, reach.T, slack),
            find_crossed_faces(one, rest, reach, slack),
            find_crossed_faces(rest, one, reach.T, slack),
        ]
    )


def _average_distances(
    found: Witnesses, pair: Indices, noise: FloatArray, covs: FloatArray, tolerance: Tolerance
) -> list[Estimate]:
    """Return the distance of each pair of things: `noise` (p,) is theirs, `pair` (c,) says whose is
    what.

    Witnesses come with the lowest ranks first.
    """
    count = len(noise)
    least = np.full(count, np.inf)
    np.minimum.at(least, pair, found.far)
    touching = least <= tolerance.finest
    keep = found.far <= np.where(touching, tolerance.finest, least + noise)[pair]
    found, pair = found.take(keep), pair[keep]
    equal = _equal(found, pair, touching, covs, tolerance)
    found, pair = found.take(equal), pair[equal]

    along = _along(found, touching[pair])
    share = 1.0 / np.bincount(pair, minlength=count)
    values = np.where(touching, 0.0, np.bincount(pair, found.far, minlength=count) * share)
    free = ~touching[pair]
    slopes = (share[pair, None] * found.weights)[:, :, None] * along[:, None]
    variances = _sum_variances(found.vertices[free], slopes[free], pair[free], covs, count)
    # Where things touch there is no one direction: the mean of what each place says.
    at_contact = np.bincount(pair, _sds(found, along, covs) ** 2, minlength=count) * share
    sds = np.sqrt(np.where(touching, at_contact, np.maximum(variances, 0.0)))
    return [Estimate(value, sd) for value, sd in zip(values.tolist(), sds.tolist(), strict=True)]


def _along(found: Witnesses, touching: NDArray[np.bool_]) -> FloatArray:
    """Return unit vectors (c, 3) from one point to the other, or across things that touch (c,)."""
    span = (found.first - found.second) / np.where(touching, 1.0, found.far)[:, None]
    return np.where(touching[:, None], found.across, span)


def _equal(
    found: Witnesses,
    pair: Indices,
    touching: NDArray[np.bool_],
    covs: FloatArray,
    tolerance: Tolerance,
) -> Indices:
    """Return the witnesses as near as the nearest of their pair within 3 sd, one at each place.

    Of these only the highest rank counts: beside a vertex that is over a face, others that are not
    over it are nearly as near, aslant. At one place the lowest rank stands for all, since rounding
    has no say in it. Of pairs that are `touching` (p,), all that are given touch.
    """
    from scipy.spatial import cKDTree  # loaded only now: one thing alone has no gaps

    far, sds = found.far, _sds(found, _along(found, touching[pair]), covs)
    nearest = np.zeros(len(touching), dtype=np.intp)
    descending = np.lexsort((far, pair))[::-1]
    nearest[pair[descending]] = descending  # the last assignment, the nearest, stays
    nearest = nearest[pair]
    within = far - far[nearest] <= tolerance.within(np.hypot(sds, sds[nearest]))
    rows = np.flatnonzero(touching[pair] | within)
    swapped = (found.one > found.two)[:, None]
    places = np.column_stack(
        [
            np.where(swapped, found.second, found.first),
            np.where(swapped, found.first, found.second),
            pair * (1.0 + 2.0 * tolerance.finest),
        ]
    )
    close = cKDTree(places[rows]).query_pairs(tolerance.finest)
    place = np.array(components(len(rows), close), dtype=np.intp)
    rank = np.zeros(len(rows), dtype=np.intp)
    np.maximum.at(rank, place, found.rank[rows])
    highest = np.zeros(len(touching), dtype=np.intp)
    np.maximum.at(highest, pair[rows], rank[place])
    first = np.zeros(len(rows), dtype=np.bool_)
    first[np.unique(place, return_index=True)[1]] = True
    return np.asarray(rows[first & (rank[place] == highest[pair[rows]])], dtype=np.intp)


def _sds(found: Witnesses, along: FloatArray, covs: FloatArray) -> FloatArray:
    """Return 1σ (c,) of each witness along its direction (c, 3); the worst one where that
    is NaN.
    """
    # A vertex that both things have counts once, with the sum of its weights.
    same = found.vertices[:, :, None] == found.vertices[:, None]
    total = (same @ found.weights[:, :, None])[:, :, 0]
    joint = ((found.weights * total)[:, :, None, None] * covs[found.vertices]).sum(axis=1)
    known = np.isfinite(along[:, 0])
    variances = np.empty(len(along))
    variances[known] = np.einsum("ci,cij,cj->c", along[known], joint[known], along[known])
    variances[~known] = np.linalg.eigvalsh(joint[~known])[:, -1]
    return np.sqrt(np.maximum(variances, 0.0))


def _sum_variances(
    vertices: Indices, slopes: FloatArray, pair: Indices, covs: FloatArray, count: int
) -> FloatArray:
    """Return variances (p,) of sums over a pair's witnesses, with slopes (c, k, 3) at vertices (c,
    k).
    """
    keys, row = np.unique(pair[:, None] * len(covs) + vertices, return_inverse=True)
    total = np.zeros((len(keys), 3))
    np.add.at(total, row.ravel(), slopes.reshape(-1, 3))
    owner, vertex = np.divmod(keys, len(covs))
    parts = np.einsum("ni,nij,nj->n", total, covs[vertex], total)
    return np.bincount(owner, parts, minlength=count).astype(np.float64)
