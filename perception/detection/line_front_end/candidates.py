"""Outlines that may be faces, what they are worth, and the plainest form of one among many."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from facetlog.perception.detection.line_front_end.evidence.face_conflicts import alike
from facetlog.perception.detection.line_front_end.evidence.face_evidence import FaceEvidence
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.side_evidence import MOVES_PX, SideJudge
from facetlog.perception.detection.line_front_end.outlines.region_outline import (
    without_short_sides,
    without_straight_corners,
)
from facetlog.perception.detection.line_front_end.planes.plane_choice import OPEN_SLOPE, plane_cov
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_basis,
)
from facetlog.perception.detection.line_front_end.planes.square_planes import (
    is_square,
    seen_on_plane,
    square_normals,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.ties import largest
from facetlog.perception.types import FloatArray

__all__ = ["LEAST_PRICE", "Candidate", "Judge", "price", "simplest", "square", "tidy"]

# Each side is chosen among some twenty, a moved one among its moves besides, on one of up to a
# thousand planes: so much the sides must speak for an outline before it is as likely as the best of
# those that chance offers, and so much more that it is less than one face in a thousand scenes.
SIDE_PRICE, MOVED_PRICE = float(np.log(20.0)), float(np.log(20.0 * len(MOVES_PX)))
PLANE_PRICE = float(np.log(1000.0 * 1000.0))
LEAST_PRICE = PLANE_PRICE + 3 * SIDE_PRICE  # of a triangle
# A shorter side, px, is where two others meet: corners are blunt. A corner nearer to the line past
# it than an edge is wide, px, is none.
MIN_SIDE_PX, MIN_TURN_PX = 4.0, 1.0
# Worths are as good as equal from this share on: three standard deviations of some 200 samples.
AS_WORTH = 0.85
# Of an outline with more corners none is tried without: it is a curve.
MAX_SIMPLIFIED = 16
# A plane is not turned by more than its lines leave open at any corner.
KNOWN_SDS = 3.0


@dataclass(frozen=True, eq=False, slots=True)
class Candidate:
    """An outline (k, 3) with its evidence, on the plane hypothesis of that number.

    `moved` says that its sides were moved onto edges, `after` how many faces there were when it was
    judged, `square` that its plane is square to what was found before.
    """

    corners: FloatArray
    normal: FloatArray
    evidence: FaceEvidence
    plane: int
    moved: bool
    after: int
    square: bool = False

    @property
    def worth(self) -> float:
        """The sides' ratio, less where part of the inside or some views speak against it."""
        e = self.evidence
        sides = e.sides - price(self.corners, moved=self.moved)
        return sides * (4 * e.consistent - 3) * float(np.sqrt(e.share))


Judge: TypeAlias = Callable[[FloatArray, Candidate], Candidate | None]
"""From other corners (k, 3), on a plane of their own, and a candidate to one in its place that has
those; None where they are no face."""


def price(corners: FloatArray, *, moved: bool) -> float:
    """What the sides of an outline (k, 3) must be worth."""
    return PLANE_PRICE + (MOVED_PRICE if moved else SIDE_PRICE) * len(corners)


def tidy(corners: FloatArray, normal: FloatArray, pixel: float) -> FloatArray:
    """An outline (k, 3) across a normal without what is no side and no corner at that `pixel`."""
    basis = plane_basis(normal)
    flat = without_short_sides(corners @ basis, MIN_SIDE_PX * pixel)
    flat = without_straight_corners(flat, MIN_TURN_PX * pixel)
    tidied: FloatArray = flat @ basis.T + normal * float(normal @ corners[0])
    return tidied


def simplest(candidate: Candidate, others: Sequence[Candidate], judge: Judge) -> Candidate:
    """The candidate without corners that make it worth less: regions grow spurs along their lines.

    Of the `others`, the best first, one with fewer corners that is nearly the same takes its place.
    """
    candidate = _plainest(candidate, others, judge)
    while 3 < len(candidate.corners) <= MAX_SIMPLIFIED:
        fewer = (np.delete(candidate.corners, k, axis=0) for k in range(len(candidate.corners)))
        judged = [judge(corners, candidate) for corners in fewer]
        worths = np.array([0.0 if j is None else j.worth for j in judged])
        best = judged[largest(worths)]
        if best is None or best.worth <= candidate.worth:
            break
        candidate = best
    return candidate


def _plainest(best: Candidate, others: Sequence[Candidate], judge: Judge) -> Candidate:
    # Of outlines of nearly the same region and score the one with fewest corners: texture beside
    # a border has edges enough for any notch.
    plainer = [
        c
        for c in others
        if c.plane == best.plane
        and c.normal @ best.normal > 0
        and len(c.corners) < len(best.corners)
        and c.worth >= AS_WORTH * best.worth
        and alike(c.corners, best.corners, best.normal)
    ]
    for c in sorted(plainer, key=lambda c: len(c.corners)):
        again = judge(c.corners, c)
        if again is not None and again.worth >= AS_WORTH * best.worth:
            return again
    return best


def square(
    candidate: Candidate,
    known: Sequence[FloatArray],
    plane: PlaneHypothesis,
    cloud: LineCloud,
    photos: PhotometricViews,
    sides: SideJudge,
    judge: Judge,
) -> Candidate:
    """The candidate on a plane parallel or square to `known` normals (3,), where it may be.

    Its lines leave it open within KNOWN_SDS, and it is worth as much there: another thing may
    stand askew. `plane` is the candidate's.
    """
    cov = plane_cov(plane, cloud, candidate.corners, OPEN_SLOPE)
    centre = photos.centres[candidate.evidence.shown].mean(axis=0)
    for normal in square_normals(candidate.normal, known):
        if is_square(candidate.normal, normal):
            return replace(candidate, square=True)
        ring = seen_on_plane(candidate.corners, plane, normal, cloud, centre)
        moved_by = np.abs((ring - candidate.corners) @ candidate.normal)
        if (moved_by > KNOWN_SDS * np.sqrt(np.diagonal(cov))).any():
            continue
        views = photos.facing(ring.mean(axis=0), normal)
        moved = sides.onto_edges(views, ring, normal, cloud.pixel)
        for corners in (ring, moved):
            again = judge(corners, replace(candidate, normal=normal))
            if again is not None and again.worth >= AS_WORTH * candidate.worth:
                return replace(again, square=True)
    return candidate
