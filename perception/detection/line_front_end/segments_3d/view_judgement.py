"""Outlier views: a gross pose error, or a picture that belongs to another pose or to another thing.

A view is tested against the 3-D segments of the others. Those that it helped to find explain it in
part, however wrong it is: so views that agree less than usual are tested against segments found
without them. Where the pose is wrong or the picture foreign, these explain no more of its straight
edges, and it shows no more of them, than chance would have it: than the same picture at the poses
of the others. A right view may have many edges of its own, as of grain that others see from
another side; but it shows about as many of the segments as others do.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.edge_maps import EdgeMap
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import (
    MIN_SUPPORT,
    SUPPORTED,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_support import coverage
from facetlog.perception.detection.line_front_end.segments_3d.pose_consistency import (
    MIN_VIEWS,
    measure_explained_length,
)
from facetlog.perception.detection.tracked_faces import TrackedFaces
from facetlog.perception.types import FloatArray, View

FindLines: TypeAlias = Callable[[Sequence[int]], FloatArray]
"""The 3-D segments (m, 2, 3) of some of the views (indices) alone."""

# A view is tested without it where so much less than usual is explained or shown: one in nine of
# 509 views of 30 true sets is.
DOUBTFUL = 0.75
# The share of n segments is known to 1 / 2 sqrt(n) at worst; one that lacks less than so many
# standard deviations of what is usual may have fallen short by chance.
SHORT_SDS = 3.0
# What chance explains or shows: this quantile over the poses of all others, of which a few
# neighbours' may be almost its own.
CHANCE = 0.9
# A view contradicts the others if not even this share of the way from chance to the usual is
# reached, neither in what is explained nor in what is shown: foreign pictures reach a twentieth. On
# ten rendered sets it was not chosen on (8 to 24 views; dark, bright) it named 102 of 108 foreign
# pictures and gross poses, 8 of 14 that are turned by 2 or 5 degrees, and none of 132 right views
# (most of these before YARDSTICKS was introduced); on sets of six views, half of them parts of sets
# that it was chosen on, 23 of 30 and none of 48.
MIN_ABOVE_CHANCE = 0.2
# Where much is explained by chance, as by the joints of a floor, a right view may be no better: one
# of which half of the usual is explained is no contradiction.
MOST_EXPLAINED = 0.5
# Number of other views that give the usual share by which a view is judged: the share of each that
# segments found without it explain. With six views it is .3 to .4, with its own help .6.
YARDSTICKS = 5


@dataclass(frozen=True, slots=True)
class Contradiction:
    """A view (index), the share of its straight edges that the others explain, the usual share."""

    view: int
    explained: float
    usual: float


def find_contradicting_views(
    segments_3d: FloatArray,
    supported: NDArray[np.bool_],
    weight: FloatArray,
    views: Sequence[View],
    maps: Sequence[EdgeMap],
    segments_2d: Sequence[FloatArray],
    find_lines: FindLines,
) -> tuple[Contradiction, ...]:
    """Return the views that the others contradict; none where these are not a small minority.

    `supported` (m, V) says which 3-D segments (m, 2, 3) are seen in which view, `weight` (V,) how
    much a view counts beside those almost like it; `maps` and `segments_2d`, each (n, 4), are the
    views' own.
    """
    if len(views) < MIN_VIEWS or not len(segments_3d):
        return ()
    support = (supported * weight).sum(axis=1)
    shares, shown = np.full(len(views), np.nan), np.zeros(len(views))
    for k, (view, found) in enumerate(zip(views, segments_2d, strict=True)):
        of_others = support - supported[:, k] * weight[k] >= MIN_SUPPORT
        shown[k] = supported[of_others, k].mean() if of_others.any() else 0.0
        shares[k] = _measure_explained_share(segments_3d[of_others], view, found)
    judged = np.isfinite(shares)
    if judged.sum() < MIN_VIEWS:
        return ()
    usual, usually_shown = float(np.median(shares[judged])), float(np.median(shown[judged]))
    least = np.minimum(shares / max(usual, 1e-300), shown / max(usually_shown, 1e-300))
    doubtful = np.flatnonzero(judged & (least < DOUBTFUL)).tolist()
    doubtful.sort(key=lambda k: (least[k], k))
    if not doubtful:
        return ()
    blind = _Blind(views, maps, segments_2d, find_lines)
    # First without all of them at once, which is quick, then each alone: what only a few neighbours
    # show is missing where these are left out together. Of a few views each is tried alone at once.
    most = max(len(views) - MIN_VIEWS, 1)
    together = frozenset(doubtful if len(doubtful) <= most else ())
    wrong = [k for k in doubtful if blind.contradicts(k, together or frozenset((k,)), usual)]
    others = [k for k in np.flatnonzero(judged).tolist() if k not in wrong]
    if not wrong or not others:
        return ()
    usual = blind.estimate_usual_share(others)
    alone = (blind.contradicts(k, frozenset((k,)), usual) for k in wrong)
    named = [each for each in alone if each][:most]
    return tuple(sorted(named, key=lambda each: each.view))


@dataclass(frozen=True, eq=False, slots=True)
class _Blind:
    """Views tested against 3-D segments that were found without them."""

    views: Sequence[View]
    maps: Sequence[EdgeMap]
    segments_2d: Sequence[FloatArray]
    find_lines: FindLines
    lines: dict[frozenset[int], tuple[FloatArray, float]] = field(default_factory=dict)

    def estimate_usual_share(self, among: Sequence[int]) -> float:
        """Return which share of views' edges segments found without them usually explain."""
        some = np.linspace(0, len(among) - 1, min(len(among), YARDSTICKS)).round().astype(int)
        shares = []
        for k in (among[n] for n in some):
            lines, _ = self._find_lines_without(frozenset((k,)))
            shares.append(_measure_explained_share(lines, self.views[k], self.segments_2d[k]))
        return float(np.median(shares))

    def contradicts(self, k: int, left_out: frozenset[int], usual: float) -> Contradiction | None:
        """Return by what a view contradicts the others than those left out, or None."""
        lines, usually_shown = self._find_lines_without(left_out)
        view, edges, found = self.views[k], self.maps[k], self.segments_2d[k]
        share = _measure_explained_share(lines, view, found)
        short = usual - share > SHORT_SDS / (2.0 * np.sqrt(_count_independent(found)))
        if not len(lines) or not short:
            return None
        there = [replace(view, pose=v.pose) for j, v in enumerate(self.views) if j not in left_out]
        chance = [_measure_explained_share(lines, each, found) for each in there]
        by_chance = [_shown_share(lines, each, edges) for each in there]
        if share >= min(_least(chance, usual), MOST_EXPLAINED * usual):
            return None
        if _shown_share(lines, view, edges) >= _least(by_chance, usually_shown):
            return None
        return Contradiction(k, share, usual)

    def _find_lines_without(self, left_out: frozenset[int]) -> tuple[FloatArray, float]:
        # The segments, and which share of them the views usually show.
        if left_out not in self.lines:
            kept = [k for k in range(len(self.views)) if k not in left_out]
            lines = self.find_lines(kept)
            shown = np.array([_shown_share(lines, self.views[k], self.maps[k]) for k in kept])
            shown = shown[np.isfinite(shown)]
            self.lines[left_out] = lines, float(np.median(shown)) if len(shown) else 0.0
        return self.lines[left_out]


def _measure_explained_share(segments_3d: FloatArray, view: View, found: FloatArray) -> float:
    """Return the share by length of a view's segments (n, 4) that 3-D ones explain; NaN without
    any.
    """
    explained, total = measure_explained_length(segments_3d, view, found)
    return explained / total if total > 0.0 else np.nan


def _shown_share(segments_3d: FloatArray, view: View, edges: EdgeMap) -> float:
    """Return the share of the 3-D segments in a view's picture that it shows; NaN where none is in
    it.
    """
    cover = coverage(segments_3d, [view], [edges])[:, 0]
    cover = cover[np.isfinite(cover)]
    return float((cover > SUPPORTED).mean()) if len(cover) else np.nan


def _count_independent(found: FloatArray) -> float:
    """Return how many segments of one length weigh as much as these (n, 4): (sum l)^2 / sum l^2."""
    lengths = np.linalg.norm(found[:, 2:] - found[:, :2], axis=1)
    return float(lengths.sum() ** 2 / max(float(lengths @ lengths), 1e-300))


def _least(by_chance: Sequence[float], usual: float) -> float:
    known = np.array(by_chance)[np.isfinite(by_chance)]
    chance = float(np.quantile(known, CHANCE)) if len(known) else 0.0
    return chance + MIN_ABOVE_CHANCE * (usual - chance)


def track_without(
    wrong: Sequence[Contradiction],
    views: Sequence[View],
    track: Callable[[Sequence[int]], TrackedFaces],
) -> TrackedFaces:
    """Return what `track` finds in the other views (indices), with a warning for each left out."""
    out = {c.view for c in wrong}
    kept = [k for k in range(len(views)) if k not in out]
    rest = track(kept)
    warnings = (
        f"{views[c.view].name}: pose and picture contradict the other views, left out: "
        f"{c.explained:.0%} of its straight edges agree with theirs, usual are {c.usual:.0%}; "
        "check that the pose is this picture's"
        for c in wrong
    )
    used = kept if rest.used is None else [kept[k] for k in rest.used]
    return replace(rest, used=tuple(used), warnings=(*warnings, *rest.warnings))
