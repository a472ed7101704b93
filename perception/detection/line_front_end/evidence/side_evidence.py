"""Evidence for the sides of outlines from the edges of all views, and where the sides run.

A log-likelihood ratio weighs each hit against the density of edges of its direction right beside
the side: on a carpet a hit is weak evidence.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.detection.edge_maps import EdgeMap, encode_direction
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import plane_basis
from facetlog.perception.detection.line_front_end.segments_3d.line_support import (
    project_to_views,
    segment_samples,
)
from facetlog.perception.flat_faces import crossing
from facetlog.perception.stable_order import ascending, at_least
from facetlog.perception.types import FloatArray, View

SAMPLES = 12
# Samples nearer together than this, px, hit or miss together: an edge is dilated by 2 px.
INDEPENDENT_PX = 8.0
# Probability that a true side is found at a place where the view shows the face.
HIT = 0.85
# Two edges are distinct from twice their reach on: pose errors may move either by its reach.
APART_REACHES = 2.0
# How far beside a side the density of edges is measured, px, and its range.
BESIDE_PX = (-11.0, -7.0, 7.0, 11.0)
CHANCE_RANGE = (0.02, 0.7)
# A side is searched this far from where a region ends, px at either end: an edge reaches 2 px. The
# smallest move comes first, since of equally good ones the first is taken.
STEPS_PX = 3.0 * np.arange(-3, 4)
MOVES_PX = np.stack(np.meshgrid(STEPS_PX, STEPS_PX), axis=-1).reshape(-1, 2)
MOVES_PX = MOVES_PX[ascending((MOVES_PX**2).sum(axis=1))]
# A side is placed by so many views, evenly from those that face it.
MAX_VIEWS = 12
# Two sides meet where they cross, and not farther off than this, px.
MAX_OFF_PX = 27.0


@dataclass(frozen=True, eq=False, slots=True)
class SideEvidence:
    """Samples (v, k, m) of k sides in v views: `found` on an edge, `there` in sight.

    `ratio` (v, k) is the log-likelihood ratio of each side in each view.
    """

    found: NDArray[np.bool_]
    there: NDArray[np.bool_]
    ratio: FloatArray


class SideJudge:
    """Judges sides by the views' edges; `weight` (V,) is how much each view counts."""

    def __init__(self, views: Sequence[View], maps: Sequence[EdgeMap], weight: FloatArray) -> None:
        self._projections = np.array([view.projection for view in views])
        self._sizes = np.array([view.image.shape[::-1] for view in views])
        self._reach = np.array([edges.reach_px for edges in maps])
        # The masks of all views pixel by pixel, and where each begins.
        self._mask = np.concatenate([edges.mask.ravel() for edges in maps])
        self._begins = np.cumsum([0, *(edges.mask.size for edges in maps)])[:-1]
        self._weight = weight

    @property
    def edges_abreast(self) -> float:
        """Largest number of parallel edges that a picture could show as distinct."""
        sizes = np.linalg.norm(self._sizes.reshape(-1, 2), axis=1)
        return float((sizes / (2.0 * self._reach + 1.0)).max(initial=1.0))

    def score(self, segments: FloatArray) -> FloatArray:
        """Return the log-likelihood ratio (n,) of segments (n, 2, 3) as sides, over the views in
        favour.
        """
        ratio = self.evidence(np.arange(len(self._weight)), segments).ratio
        score: FloatArray = self._weight @ np.maximum(ratio, 0.0)
        return score

    def evidence(
        self,
        views: NDArray[np.intp],
        sides: FloatArray,
        bare: NDArray[np.bool_] | None = None,
        joined: NDArray[np.bool_] | None = None,
    ) -> SideEvidence:
        """Return the evidence of the chosen views (v,) for sides (k, 2, 3).

        `bare` (v, k, SAMPLES) are the samples that are not occluded, all of them if it is None.
        Where a side is `joined` (k, SAMPLES) to a known face, surfaces of one shade may meet: there
        a missing edge says nothing.
        """
        hit, inside, reach = self._hits(views, sides, (0.0, *BESIDE_PX))
        found, there = hit[0], inside[0]
        if bare is not None:
            found, there = found & bare, there & bare
        if joined is not None:
            there = there & (found | ~joined)
        # Half a hit in one more sample is added: few samples never make a probability of 0 or 1.
        beside = (hit[1:].sum(axis=(0, 3)) + 0.5) / (inside[1:].sum(axis=(0, 3)) + 1.0)
        chance = np.clip(beside, *CHANCE_RANGE)[..., None]
        ratio = np.where(found, np.log(HIT / chance), np.log((1 - HIT) / (1 - chance)))
        # The samples stand for all of a side, however long: cut in two it has the same evidence.
        return SideEvidence(found, there, (ratio * there).mean(axis=2) * (reach / INDEPENDENT_PX))

    def apart(
        self, views: NDArray[np.intp], sides: FloatArray, others: FloatArray
    ) -> NDArray[np.bool_]:
        """Return samples (v, k, SAMPLES) of sides (k, 2, 3) that views (v,) see apart from other
        sides.

        Such a sample is too far from the line of the other side (k, 2, 3) for one edge to be both;
        there is none where that side is not wholly in front of the camera.
        """
        shape = (len(views), len(sides), SAMPLES, 2)
        samples = segment_samples(sides, SAMPLES).reshape(-1, 3)
        uv, _ = project_to_views(self._projections[views], samples)
        ends, depth = project_to_views(self._projections[views], others.reshape(-1, 3))
        ends = ends.reshape(len(views), len(sides), 2, 2)
        before = (depth.reshape(len(views), len(sides), 2) > 0).all(axis=2, keepdims=True)
        start, along = ends[:, :, :1], ends[:, :, 1:] - ends[:, :, :1]
        off = uv.reshape(shape) - start
        across = np.abs(along[..., 0] * off[..., 1] - along[..., 1] * off[..., 0])
        length = np.maximum(np.linalg.norm(along, axis=-1), 1e-9)
        reach = self._reach[views, None, None]
        away: NDArray[np.bool_] = across / length > APART_REACHES * reach
        return away & before

    def snap_to_edges(
        self, views: NDArray[np.intp], corners: FloatArray, normal: FloatArray, pixel: float
    ) -> FloatArray:
        """Return a polygon (k, 3) with each side where most edges of the chosen views (v,) run.

        It stays as it is where its sides then cross one another.
        """
        if len(views) > MAX_VIEWS:
            views = views[np.linspace(0, len(views) - 1, MAX_VIEWS).round().astype(int)]
        basis = plane_basis(normal)
        flat = corners @ basis
        along = np.roll(flat, -1, axis=0) - flat
        length = np.linalg.norm(along, axis=1, keepdims=True)
        if not len(views) or not length.all():
            return corners
        across = np.stack([-along[:, 1], along[:, 0]], axis=1) / length
        ends = np.stack([flat, flat + along], axis=1)
        moved = ends[:, None] + MOVES_PX[:, :, None] * pixel * across[:, None, None]
        foot = normal * float(normal @ corners.mean(axis=0))
        hit, _, _ = self._hits(views, (moved @ basis.T + foot).reshape(-1, 2, 3), (0.0,))
        score = (self._weight[views] @ hit[0].sum(axis=2)).reshape(len(corners), -1)
        best = at_least(score, score.max(axis=1, keepdims=True)).argmax(axis=1)
        placed = _meetings(moved[np.arange(len(corners)), best], MAX_OFF_PX * pixel)
        ring: FloatArray = placed @ basis.T + foot
        return ring if shapely.Polygon(placed).is_valid else corners

    def _hits(
        self, views: NDArray[np.intp], sides: FloatArray, beside: Sequence[float]
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_], FloatArray]:
        # Which samples (b, v, k, m), so many px beside the sides (k, 2, 3), lie on an edge of the
        # side's direction, and which in the picture; the sides' lengths (v, k), px.
        samples = segment_samples(sides, SAMPLES)
        shape = (len(views), len(sides), SAMPLES)
        uv, depth = project_to_views(self._projections[views], samples.reshape(-1, 3))
        # Across and down separately: numpy is slow where the last axis has only two entries.
        u, v = (uv[..., axis].reshape(shape) for axis in (0, 1))
        du, dv = u[..., -1:] - u[..., :1], v[..., -1:] - v[..., :1]
        reach = np.maximum(np.hypot(du, dv), 1e-9)
        bits = encode_direction(np.arctan2(dv, du))

        off = np.array(beside)[:, None, None, None]
        column, row = np.rint(u + off * (-dv / reach)), np.rint(v + off * (du / reach))
        width, height = self._sizes[views].T[:, :, None, None]
        inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
        inside &= (depth > 0).reshape(shape)
        begins = self._begins[views, None, None]
        at = np.where(inside, row * width + column + begins, 0).astype(np.intp)
        hit = (self._mask.take(at) & bits) != 0
        return hit & inside, inside, reach[..., 0]


def _meetings(sides: FloatArray, most: float) -> FloatArray:
    # Where each side (k, 2, 2) meets the one before it, (k, 2); between their ends where they do
    # not cross, or farther off than `most`.
    placed = np.empty((len(sides), 2))
    for k, (before, after) in enumerate(zip(np.roll(sides, 1, axis=0), sides, strict=True)):
        between = (before[1] + after[0]) / 2
        meeting = crossing((before[0], before[1] - before[0]), (after[0], after[1] - after[0]))
        near = meeting is not None and np.linalg.norm(meeting - between) < most
        placed[k] = meeting if near else between
    return placed
