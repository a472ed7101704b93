"""The 3-D segments of a scene: candidates from view pairs, selected by support, merged, fitted."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.edge_maps import EdgeMap
from facetlog.perception.detection.line_front_end.segments_3d.line_refine import refine_segments
from facetlog.perception.detection.line_front_end.segments_3d.line_support import (
    coverage,
    project_points,
)
from facetlog.perception.detection.view_graph import ViewGraph, view_graph
from facetlog.perception.stable_order import TIE, at_least, descending, ranks
from facetlog.perception.types import FloatArray, View

# The two views' parts of the 3-D segment overlap by this share of the shorter one.
MIN_OVERLAP = 0.5
# Sine of the least angle between the two planes: below, half a pixel is 10 % of the depth.
MIN_PLANE_SINE = 0.03


def propose_segments(
    first: View, segments_1: FloatArray, second: View, segments_2: FloatArray
) -> tuple[FloatArray, NDArray[np.intp]]:
    """Return all 3-D segments (n, 2, 3) that a segment of each view could show, and which two (n,
    2).

    The plane through a pinhole and a segment (n, 4: u0, v0, u1, v1, of some length) holds the 3-D
    segment; two planes meet in its line. Kept are those before both cameras whose parts overlap.
    """
    if not len(segments_1) or not len(segments_2):
        return np.zeros((0, 2, 3)), np.zeros((0, 2), dtype=np.intp)
    plane_1, rays_1 = _plane_and_rays(first, segments_1)
    plane_2, rays_2 = _plane_and_rays(second, segments_2)
    c1, c2 = first.pose.centre, second.pose.centre

    cosine = plane_1[:, :3] @ plane_2[:, :3].T
    # The rays of one segment's ends pierce the other's plane at c + s d, s = height / fall, if s is
    # positive; both (end, i, j).
    height_1 = plane_2[:, :3] @ c1 + plane_2[:, 3]
    height_2 = (plane_1[:, :3] @ c2 + plane_1[:, 3])[:, None]
    fall_1 = -(rays_1.transpose(1, 0, 2) @ plane_2[:, :3].T)
    fall_2 = -(plane_1[:, :3] @ rays_2.transpose(1, 2, 0))
    good = (fall_1 * height_1 > 0).all(axis=0) & (fall_2 * height_2 > 0).all(axis=0)
    i, j = np.nonzero(good & (cosine**2 < 1.0 - MIN_PLANE_SINE**2))
    # Axis by axis, (end, 3, n): numpy is slow where the last axis has two or three entries.
    pairs = i * len(segments_2) + j
    away_1, away_2 = (fall.reshape(2, -1).take(pairs, axis=1)[:, None] for fall in (fall_1, fall_2))
    x1 = rays_1.transpose(1, 2, 0).take(i, axis=2) * (height_1.take(j) / away_1) + c1[:, None]
    x2 = rays_2.transpose(1, 2, 0).take(j, axis=2) * (height_2.take(i) / away_2) + c2[:, None]

    along = x1[1] - x1[0]
    length = np.sqrt((along * along).sum(axis=0))
    unit = along / np.where(length > 0, length, 1.0)
    start, end = ((x2 - x1[0]) * unit).sum(axis=1)
    low, high = np.minimum(start, end), np.maximum(start, end)
    overlap = np.minimum(length, high) - np.maximum(low, 0.0)
    keep = (length > 0) & (overlap > MIN_OVERLAP * np.minimum(length, high - low))
    ends = np.stack([np.minimum(low, 0.0), np.maximum(length, high)], axis=1)[keep]
    origin, unit = x1[0, :, keep], unit[:, keep].T
    return origin[:, None] + ends[..., None] * unit[:, None], np.stack([i, j], axis=1)[keep]


def _plane_and_rays(view: View, segments: FloatArray) -> tuple[FloatArray, FloatArray]:
    ends = np.stack([segments[:, :2], segments[:, 2:]], axis=1)
    homogeneous = np.concatenate([ends, np.ones((*ends.shape[:2], 1))], axis=-1)
    lines = np.cross(homogeneous[:, 0], homogeneous[:, 1])
    planes = lines @ view.projection
    planes /= np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
    rays = homogeneous @ np.linalg.inv(view.camera.matrix).T @ view.pose.rotation.T
    return planes, rays


# A view supports a segment when it shows this share of it.
SUPPORTED = 0.6
# The mean square of the share that a view shows of a candidate is .2 for the wrong ones among lines
# all over, as of tiled floors, and more than twice that for right ones, hidden ones included: what
# lies far below this speaks against a candidate. Where each is seen in few views, as at the border
# of a scene, the right ones come out on top by that (half as many again, docs/decisions.md).
BY_CHANCE = 0.3
# Support by this many distinct views, since the two that made the candidate prove nothing; or, for
# views from a narrow arc, by more than two and this share of all.
MIN_SUPPORT, TOO_FEW, NEARLY_ALL = 3.0, 2.0, 0.8
# Candidates are screened on this many distinct views before all are tested.
SCREEN_VIEWS = 10
# Cameras stand near enough to see the object: depths beyond this many distances are background.
MAX_DEPTH = 4.0
# The longest segments of a view take part in matching; all views' edges give support.
MAX_SEGMENTS = 250
# That bounds the time; with fewer pairs of views than this more segments are matched.
FULL_PAIRS = 24
# Matches of one segment in one other view that are looked at in all views.
BEST_OF_PAIR = 4
# 3-D segments kept in the end, the best supported ones: bounds the time on cluttered scenes.
MAX_LINES = 600
# So many are fitted: of a tiled floor nearly all are better supported than what is beside a thing.
MAX_FITTED = 2 * MAX_LINES
# A candidate whose score is so near to the best one's, as a share of what views show of it, is as
# good: scores carry noise.
NEARLY_BEST = 0.97
# Two candidates are one line when they lie within this many px of each other in these views.
MERGE_PX = 3.0
MERGE_VIEWS = 5
# Finer, after the fit.
MERGE_FITTED_PX = 1.5
# Beyond this rms residual the "line" is an apparent contour of a curved surface, or chance.
MAX_RMS_PX = 1.5


@dataclass(frozen=True, eq=False, slots=True)
class LineCloud:
    """3-D segments (n, 2, 3), the covariance of their ends across themselves (n, 2, 3, 3), their
    support (n,) in distinct views, rms residual px (n,).
    """

    segments: FloatArray
    end_covs: FloatArray
    support: FloatArray
    rms: FloatArray
    pixel: float  # length of one pixel at the focus, in the world's unit


def reconstruct_lines(
    views: Sequence[View],
    maps: Sequence[EdgeMap],
    segments: Sequence[FloatArray],
    graph: ViewGraph,
) -> LineCloud:
    """Return the 3-D segments that MIN_SUPPORT distinct views show, or nearly all of fewer."""
    pixel = graph.distance / float(np.median([v.camera.fx for v in views]))
    candidates, owners = _screen_candidates(views, maps, segments, graph)
    cover = coverage(candidates, views, maps)
    support = ((np.nan_to_num(cover) > SUPPORTED) * graph.weight).sum(axis=1)
    score = agreement(cover, graph.weight)
    shown = np.nansum(cover**2 * graph.weight, axis=1)
    least = float(np.clip(NEARLY_ALL * graph.weight.sum(), TOO_FEW, MIN_SUPPORT))
    keep = np.logical_and(at_least(support, least), keep_best_of_owners(score, shown, owners))
    candidates, cover = candidates[keep], cover[keep]

    score = shown[keep] * np.sqrt(_lengths(candidates))
    apart = [views[k] for k in _choose_distinct_views(graph.weight, MERGE_VIEWS)]
    chosen = _merge(candidates, score, apart, MERGE_PX, MAX_FITTED)
    use = np.nan_to_num(cover[chosen]) > SUPPORTED
    fitted, end_covs, rms = refine_segments(candidates[chosen], views, maps, use, graph.weight)
    cover = coverage(fitted, views, maps)
    support = ((np.nan_to_num(cover) > SUPPORTED) * graph.weight).sum(axis=1)
    good = at_least(support, least) & (rms < MAX_RMS_PX)
    fitted, end_covs, support, rms = fitted[good], end_covs[good], support[good], rms[good]
    chosen = _merge(fitted, support * np.sqrt(_lengths(fitted)), apart, MERGE_FITTED_PX, MAX_LINES)
    return LineCloud(fitted[chosen], end_covs[chosen], support[chosen], rms[chosen], pixel)


def find_shown_lines(
    views: Sequence[View], maps: Sequence[EdgeMap], segments: Sequence[FloatArray]
) -> tuple[LineCloud, NDArray[np.bool_]]:
    """Return the 3-D segments of the views, n of them, and which view shows which (n, V)."""
    cloud = reconstruct_lines(views, maps, segments, view_graph(views))
    return cloud, np.nan_to_num(coverage(cloud.segments, views, maps)) > SUPPORTED


def count_matched_segments(pairs: int) -> int:
    """Return how many segments of a view are matched, so that as many are compared as of
    FULL_PAIRS.

    >>> count_matched_segments(40), count_matched_segments(3)
    (250, 707)
    """
    return int(MAX_SEGMENTS * np.sqrt(max(FULL_PAIRS / max(pairs, 1), 1.0)))


def _screen_candidates(
    views: Sequence[View],
    maps: Sequence[EdgeMap],
    segments: Sequence[FloatArray],
    graph: ViewGraph,
) -> tuple[FloatArray, NDArray[np.intp]]:
    # Candidates (n, 2, 3) that some third view supports, and the numbers (n, 2) of the 2-D
    # segments, counted through all views, that made each.
    first_number = np.cumsum([0, *map(len, segments)])
    found, owners = [np.zeros((0, 2, 3))], [np.zeros((0, 2), dtype=np.intp)]
    screen = _choose_distinct_views(graph.weight, SCREEN_VIEWS)
    most = count_matched_segments(len(graph.pairs))
    for i, j in graph.pairs:
        c, made_of = propose_segments(views[i], segments[i][:most], views[j], segments[j][:most])
        near = np.linalg.norm(c.mean(axis=1) - graph.focus, axis=1) < MAX_DEPTH * graph.distance
        c, made_of = c[near], made_of[near]
        others = [k for k in screen if k not in (i, j)]
        seen = coverage(c, [views[k] for k in others], [maps[k] for k in others], samples=6)
        promise = agreement(seen, np.ones(len(others)))
        keep = np.logical_and(
            (np.nan_to_num(seen) > SUPPORTED).any(axis=1), _among_best(promise, made_of)
        )
        found.append(c[keep])
        owners.append(made_of[keep] + first_number[[i, j]])
    return np.concatenate(found), np.concatenate(owners)


def _among_best(promise: FloatArray, made_of: NDArray[np.intp]) -> NDArray[np.bool_]:
    # Of all candidates of one view's segment with the other view's, the few most promising.
    kept = np.ones(len(promise), np.bool_)
    for owner in made_of.T:
        order = np.lexsort((ranks(-promise), owner))
        first = np.searchsorted(owner[order], owner[order])
        kept[order] &= np.arange(len(order)) - first < BEST_OF_PAIR
    return kept


def agreement(cover: FloatArray, weight: FloatArray) -> FloatArray:
    """Return how much more of candidates (n,) is shown by views of this weight (V,) than by chance,
    from what each shows (n, V): NaN of what is out of view.
    """
    found: FloatArray = np.nansum((cover**2 - BY_CHANCE) * weight, axis=1)
    return found


def keep_best_of_owners(
    score: FloatArray, shown: FloatArray, owners: NDArray[np.intp]
) -> NDArray[np.bool_]:
    """Return which candidates (n,) have the best score, or nearly, among those of both of their
    `owners`.

    These (n, 2) are 2-D segments, of which each shows one 3-D segment. `shown` (n,) is what views
    show of each in all.
    """
    best = np.full(owners.max(initial=-1) + 1, -np.inf)
    np.maximum.at(best, owners.ravel(), np.repeat(score, 2))
    nearly: NDArray[np.bool_] = score + (1.0 - NEARLY_BEST) * shown >= best[owners].max(axis=1)
    return nearly


def _choose_distinct_views(weight: FloatArray, count: int) -> list[int]:
    # Evenly through the cumulated weight: crowded views are skipped. A view whose weight ends just
    # where one is wanted, as with many equal weights, counts as reaching it.
    position = np.cumsum(weight) / weight.sum()
    wanted = (np.arange(count) + 0.5) / count
    return sorted({int(np.searchsorted(position, w - TIE)) for w in wanted})


def _lengths(segments: FloatArray) -> FloatArray:
    lengths: FloatArray = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    return lengths


def _merge(
    segments: FloatArray,
    score: FloatArray,
    views: Sequence[View],
    tolerance_px: float,
    most: int,
) -> NDArray[np.intp]:
    # Non-maximum suppression: the best stays, those that lie on its line in all of these views, and
    # mostly beside it, are dropped. In pictures, not in space: where the views hardly differ, depth
    # is uncertain.
    uv = np.stack([project_points(v.projection, segments)[0] for v in views], axis=1)
    first = uv[:, 0].T  # in the first view, (2, ends, n)
    left = np.ones(len(segments), dtype=np.bool_)
    chosen: list[int] = []
    for best in descending(score).tolist():
        if not left[best]:
            continue
        if len(chosen) == most:
            break
        chosen.append(best)
        left[best] = False
        along = uv[best, :, 1] - uv[best, :, 0]
        length = np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-9)
        unit = along / length[:, None]
        # Few lie on its line in one view: all else is asked of these.
        (u, v), (x, y) = first - uv[best, 0, 0][:, None, None], unit[0]
        near = (np.abs(u * y - v * x) < tolerance_px).all(axis=0)
        others = np.flatnonzero(near & left)
        relative = uv[others] - uv[best, :, :1]  # (n, views, ends, 2)
        off = relative[..., 0] * unit[:, None, 1] - relative[..., 1] * unit[:, None, 0]
        near = (np.abs(off) < tolerance_px).all(axis=(1, 2))
        t = np.sort((relative * unit[:, None]).sum(axis=-1), axis=-1)
        overlap = np.minimum(t[..., 1], length) - np.maximum(t[..., 0], 0.0)
        beside = (overlap > 0.5 * (t[..., 1] - t[..., 0])).all(axis=1)
        left[others[near & beside]] = False
    return np.array(chosen, dtype=np.intp)
