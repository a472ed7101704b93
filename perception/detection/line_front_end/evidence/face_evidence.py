"""Evidence of all views for an outline: photo-consistency of its inside, edges along its sides.

Occluded views are left out, and of the others the occluded parts.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.beside_segments import (
    CLEAR_PX,
    MIN_CONSISTENT,
    MIN_INSIDE,
    MIN_WEIGHT,
)
from facetlog.perception.detection.line_front_end.evidence.face_conflicts import blocked
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import FREE_LEVEL
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.side_evidence import (
    BESIDE_PX,
    SAMPLES,
    SideJudge,
)
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.detection.line_front_end.segments_3d.line_support import (
    project_to_views,
    segment_samples,
)
from facetlog.perception.flat_faces import cross, make_plane_axes, make_ring_sides
from facetlog.perception.polygons import make_polygon
from facetlog.perception.stable_order import largest
from facetlog.perception.types import FloatArray

Joins: TypeAlias = Callable[[FloatArray, FloatArray], NDArray[np.bool_]]
"""Which points (..., 3) of an outline of that normal (3,) lie on sides of found faces, too."""
Clear: TypeAlias = Callable[[FloatArray], NDArray[np.bool_]]
"""Of which points (n, 3) which view has a clear sight (V, n)."""

# Least share of the views that could see a face and do show it, and of its sides on edges.
MIN_SHARE, MIN_COVERAGE = 0.5, 0.6
# About so many points inside an outline are compared, and no fewer than this.
INNER_POINTS, MIN_INNER = 60, 8
# A view shows the face when it sees SEEN_SHARE of the points, and agrees at AGREES_SHARE of these.
AGREES_SHARE, SEEN_SHARE = 0.5, 0.4
# A view that sees a face less broad than this, px, says nothing of its sides: the edges beside one
# of them, by which it is judged, are the other.
MIN_WIDTH_PX = BESIDE_PX[-2]
# Some true sides are too faint for any view: the evidence against a side is limited to this.
FAINT_PENALTY = float(np.log(1e3))
# A surface goes on beyond a side where most of what lies there agrees at odds of 20 to 1, and half
# as well as the inside does. An edge within a surface may be texture: it counts half as much as a
# border, and where there is none, there is no border either.
GOES_ON_SHARE, GOES_ON_RATIO, GOES_ON_AS_INSIDE = 0.8, float(np.log(20.0)), 0.5
TEXTURE_SHARE = 0.5
# A supposed face is the ground if the ground explains more than a third of its pixels better.
MOST_GROUND = 1 / 3


def compute_ground_ratio(
    photos: PhotometricViews,
    ground: Ground,
    corners: FloatArray,
    normal: FloatArray,
    points: FloatArray,
    shown: NDArray[np.bool_],
    taken: Sequence[NDArray[np.uint8]],
) -> FloatArray:
    """Return the log-likelihood ratio (n,) that the views `shown` (V,) see the ground at points (n,
    3).

    The points lie on a supposed face (k, 3). A pattern of the ground repeats itself: some views see
    one tile where others see the next; and one sees through between legs. So each view's pixels are
    compared with the ground that they would show, whose level is taken from the other views that
    see it past the face; or from all others, with a penalty, since they may see the face there.
    `taken` are each view's pixels that show a face found already.
    """
    everyone, showing = np.arange(len(photos.weight)), np.nonzero(shown)[0]
    total = np.zeros((2, len(points)))
    for k in showing.tolist():
        behind, meets = ground.behind(photos.centres[k], points)
        others = everyone[everyone != k]
        past = ~blocked(corners, normal, behind, photos.centres[others])
        agreements = photos.compare_clear_views(others, behind, taken, past)
        for by_level, found in zip(total, agreements, strict=True):
            ratio = photos.judge_known_surface(k, behind, found.level)
            by_level += photos.weight[k] * np.where(meets & (found.ratio > 0), ratio, 0.0)
    best: FloatArray = np.maximum(total[0], total[1] - FREE_LEVEL)
    return best


@dataclass(frozen=True, eq=False, slots=True)
class FaceEvidence:
    """The views' evidence for an outline seen from one side.

    `ratio` (n,): log-likelihood ratio at the `points` (n, 3) of its inside; `consistent`: share of
    its area where it is above 0; `sides`: summed log-likelihood ratio of its sides; `coverage`:
    share of the sides that lie on edges, where nothing hides them; `shown` (V,): views that show
    it; `share`: these among the views that face it and see it, by weight.
    """

    ratio: FloatArray
    consistent: float
    sides: float
    coverage: float
    shown: NDArray[np.bool_]
    share: float
    points: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class _Inside:
    # The part of `FaceEvidence` about an outline's inside, and the views (v,) that show it.
    ratio: FloatArray
    inside: float
    consistent: float
    share: float
    showing: NDArray[np.intp]
    points: FloatArray


class FaceJudge:
    """Judges outlines by all views."""

    def __init__(self, photos: PhotometricViews, sides: SideJudge, ground: Ground | None) -> None:
        self._photos = photos
        self._weight = photos.weight
        self._sides = sides
        self._ground = ground

    def judge(
        self,
        corners: FloatArray,
        normal: FloatArray,
        taken: Sequence[NDArray[np.uint8]],
        least: float = -np.inf,
        joins: Joins | None = None,
    ) -> FaceEvidence | None:
        """Return the evidence for a polygon (k, 3) seen from the side that its normal points to.

        None where too few views face it, its inside contradicts it, too little of its sides is
        covered, or their score cannot exceed `least`. `taken` as in `RegionFinder.outlines`;
        `joins` says where a side may lack an edge, for it joins a found face.
        """
        found = self._inside(corners, normal, taken)
        along = None if found is None else self._along(found, corners, normal, taken, least, joins)
        if found is None or along is None:
            return None
        sides, coverage = along
        shown = np.zeros(len(self._weight), dtype=np.bool_)
        shown[found.showing] = True
        return FaceEvidence(
            found.ratio,
            found.consistent,
            sides,
            coverage,
            shown,
            found.share,
            found.points,
        )

    def is_surface_inside(
        self, corners: FloatArray, normal: FloatArray, taken: Sequence[NDArray[np.uint8]]
    ) -> bool:
        """Return whether the inside of a polygon (k, 3) is a surface, wherever its sides are."""
        return self._inside(corners, normal, taken) is not None

    def judge_clear_inside(
        self, corners: FloatArray, normal: FloatArray, clear: Clear
    ) -> FaceEvidence | None:
        """Return the evidence for the inside of a polygon (k, 3) alone, where sight of it is
        `clear`.

        None where that contradicts it; nothing is said of its sides.
        """
        found = self._inside(corners, normal, None, clear)
        if found is None:
            return None
        shown = np.zeros(len(self._weight), dtype=np.bool_)
        shown[found.showing] = True
        return FaceEvidence(
            found.ratio, found.consistent, 0.0, 0.0, shown, found.share, found.points
        )

    def _inside(
        self,
        corners: FloatArray,
        normal: FloatArray,
        taken: Sequence[NDArray[np.uint8]] | None,
        clear: Clear | None = None,
    ) -> _Inside | None:
        views = self._photos.facing(corners.mean(axis=0), normal)
        views = views[self._widths(views, corners) > MIN_WIDTH_PX]
        weight = self._weight[views]
        if weight.sum() < MIN_WEIGHT:
            return None
        points = inner_points(corners, normal)
        if len(points) < MIN_INNER:
            return None
        in_clear = None if clear is None else clear(points)[views]
        result, seen = self._photos.agree(views, points, taken, in_clear)
        in_sight = seen.mean(axis=1) > SEEN_SHARE
        shows = in_sight & (result.agrees.sum(axis=1) > AGREES_SHARE * seen.sum(axis=1))
        share = float(weight[shows].sum() / max(weight[in_sight].sum(), 1e-300))
        inside, consistent = float(result.ratio.mean()), float((result.ratio > 0).mean())
        if weight[shows].sum() < MIN_WEIGHT or share < MIN_SHARE:
            return None
        if inside < MIN_INSIDE or consistent < MIN_CONSISTENT:
            return None
        return _Inside(result.ratio, inside, consistent, share, views[shows], points)

    def shows_ground(
        self,
        corners: FloatArray,
        normal: FloatArray,
        evidence: FaceEvidence,
        taken: Sequence[NDArray[np.uint8]],
    ) -> bool:
        """Return whether the pixels that show a face (k, 3) are better explained by the ground
        behind it.

        The face's own `evidence` and `taken` as in `judge`.
        """
        if self._ground is None:
            return False
        points, shown = evidence.points, evidence.shown
        face = self._photos, self._ground, corners, normal
        by_ground = compute_ground_ratio(*face, points, shown, taken)
        return bool((by_ground > evidence.ratio).mean() > MOST_GROUND)

    def _widths(self, views: NDArray[np.intp], corners: FloatArray) -> FloatArray:
        # How broad a polygon (k, 3) appears in the chosen views (v,), px: a sliver's width.
        uv, depth = project_to_views(self._photos.projections[views], corners)
        following = np.roll(uv, -1, axis=1)
        twice = uv[..., 0] * following[..., 1] - uv[..., 1] * following[..., 0]
        round_it = np.linalg.norm(following - uv, axis=-1).sum(axis=1)
        width: FloatArray = np.abs(twice.sum(axis=1)) / np.maximum(round_it, 1e-300)
        return np.where((depth > 0).all(axis=1), width, np.inf)

    def _along(
        self,
        found: _Inside,
        corners: FloatArray,
        normal: FloatArray,
        taken: Sequence[NDArray[np.uint8]],
        least: float,
        joins: Joins | None,
    ) -> tuple[float, float] | None:
        # The sides' summed ratio and their coverage; None as of `judge`.
        views = found.showing
        sides = make_ring_sides(corners)
        length = np.linalg.norm(sides[:, 1] - sides[:, 0], axis=1)
        # Where the inside next to a side is hidden, or taken by another face, so is the side.
        samples, inwards = self._inwards(views, sides, normal)
        within, seen = self._photos.agree(views, (samples + inwards).reshape(-1, 3), taken)
        bare = within.agrees | (seen & (within.ratio <= 0))
        bare = bare.reshape(len(views), len(sides), SAMPLES)
        joined = None if joins is None else joins(samples, normal)
        edges = self._sides.evidence(views, sides, bare, joined)
        weight = self._weight[views]
        hit = float(weight @ edges.found.sum(axis=2) @ length)
        possible = float(weight @ edges.there.sum(axis=2) @ length)
        coverage = hit / max(possible, 1e-300)
        ratio = weight @ edges.ratio
        faint = np.maximum(ratio, -FAINT_PENALTY)
        # What lies beyond can only lower the score: most outlines are rejected without it.
        if coverage < MIN_COVERAGE or faint.sum() <= least:
            return None

        beyond = (samples - inwards).reshape(-1, 3)
        surface, _ = self._photos.agree(views, beyond, taken)
        same = surface.ratio > max(GOES_ON_RATIO, GOES_ON_AS_INSIDE * found.inside)
        if self._ground is not None:
            same &= self._ground.above(beyond) > 0
        goes_on = same.reshape(len(sides), SAMPLES).mean(axis=1) > GOES_ON_SHARE

        texture = np.where(ratio > 0, TEXTURE_SHARE * ratio, ratio)
        return float(np.where(goes_on, texture, faint).sum()), coverage

    def _inwards(
        self, views: NDArray[np.intp], sides: FloatArray, normal: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        # Points (k, SAMPLES, 3) of sides (k, 2, 3), and the offset inwards (k, 1, 3) beyond which,
        # seen from the chosen views, their edges end.
        inward = cross(normal, sides[:, 1] - sides[:, 0])
        inward /= np.maximum(np.linalg.norm(inward, axis=1, keepdims=True), 1e-300)
        away = np.linalg.norm(self._photos.centres[views] - sides[:, 0].mean(axis=0), axis=1)
        step = CLEAR_PX * float(np.median(away)) / self._photos.focal
        return segment_samples(sides, SAMPLES), step * inward[:, None]


def inner_points(corners: FloatArray, normal: FloatArray) -> FloatArray:
    """Return about INNER_POINTS points (n, 3) spread evenly over the inside of a flat polygon (k,
    3).
    """
    # Along the longest side: independent of the world frame.
    along = np.roll(corners, -1, axis=0) - corners
    length = np.linalg.norm(along, axis=1)
    if not length.any():
        return np.zeros((0, 3))
    basis = make_plane_axes(normal, along[largest(length)]).T
    polygon = make_polygon(corners @ basis)
    if polygon.is_empty:
        return np.zeros((0, 3))
    low, high = np.array(polygon.bounds).reshape(2, 2)
    # A thin or winding outline fills little of its box: the finer the lattice must be.
    filled = polygon.area / max(float(np.prod(high - low)), 1e-300)
    count = int(np.ceil(np.sqrt(INNER_POINTS / np.clip(filled, 0.01, 1.0))))
    steps = (np.arange(count) + 0.5) / count
    grid = low + np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2) * (high - low)
    shapely.prepare(polygon)
    inside = grid[shapely.contains_xy(polygon, grid)]
    points: FloatArray = normal * float(normal @ corners.mean(axis=0)) + inside @ basis.T
    return points
