"""Candidate outlines of faces, their scores, and a face that was selected among them.

Of several nearly equal candidates the simplest is taken.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.face_conflicts import alike
from facetlog.perception.detection.line_front_end.evidence.face_evidence import FaceEvidence
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.side_evidence import MOVES_PX, SideJudge
from facetlog.perception.detection.line_front_end.outlines.region_outline import (
    remove_short_sides,
    remove_straight_corners,
)
from facetlog.perception.detection.line_front_end.planes.plane_choice import OPEN_SLOPE, plane_cov
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_basis,
)
from facetlog.perception.detection.line_front_end.planes.square_planes import (
    is_square,
    project_to_plane,
    propose_square_normals,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.flat_faces import make_ring_sides
from facetlog.perception.stable_order import largest
from facetlog.perception.types import FloatArray

# Each side is chosen among some twenty, a moved one also among its moves, on one of up to a
# thousand planes: the log-likelihood ratio of the sides must exceed what the best of so many
# choices has by chance, by so much more that chance makes less than one face in a thousand scenes.
SIDE_PENALTY, MOVED_PENALTY = float(np.log(20.0)), float(np.log(20.0 * len(MOVES_PX)))
PLANE_PENALTY = float(np.log(1000.0 * 1000.0))
LEAST_PENALTY = PLANE_PENALTY + 3 * SIDE_PENALTY  # of a triangle
# A shorter side, px, is only a blunt corner of two others. A corner nearer to the line past it than
# an edge is wide, px, is none.
MIN_SIDE_PX, MIN_TURN_PX = 4.0, 1.0
# Scores count as equal from this share on: three standard deviations of some 200 samples.
AS_GOOD = 0.85
# An outline with more corners is a curve, and is not simplified.
MAX_SIMPLIFIED = 16
# A plane is not rotated by more than the uncertainty of its lines at any corner.
KNOWN_SDS = 3.0
# A face has a neighbour at each side that is this share of its ring's length: curves have none.
LONG_SIDE = 0.08


@dataclass(frozen=True, eq=False, slots=True)
class SelectedFace:
    """An outline judged a face, its corners counter-clockwise seen from the side that views see.

    `shown` (V,) says which views show it; `support` is the share of its sides on edges in those,
    `seen` (n, 3) are points of its inside, none in its `holes` (k, 3), which run clockwise.
    `plane_cov` is the covariance of its plane's heights at its corners, then at those of the holes,
    where it has one of its own. Where it has no edges its outline is only its known extent.
    """

    corners: FloatArray
    normal: FloatArray
    shown: NDArray[np.bool_]
    support: float
    seen: FloatArray
    plane_cov: FloatArray | None = None
    holes: tuple[FloatArray, ...] = ()
    has_edges: bool = True

    @property
    def long_sides(self) -> FloatArray:
        """The sides (n, 2, 3) of its outline and its holes at which it may have a neighbour."""
        long = []
        for ring in (self.corners, *self.holes):
            sides = make_ring_sides(ring)
            length = np.linalg.norm(sides[:, 1] - sides[:, 0], axis=1)
            long.append(sides[length >= LONG_SIDE * length.sum()])
        return np.concatenate(long)


@dataclass(frozen=True, eq=False, slots=True)
class Candidate:
    """An outline (k, 3) with its evidence, on the plane hypothesis of number `plane`.

    `moved` says that its sides were moved onto edges, `after` how many faces there were when it was
    judged, `square` that its plane is perpendicular or parallel to what was found before.
    """

    corners: FloatArray
    normal: FloatArray
    evidence: FaceEvidence
    plane: int
    moved: bool
    after: int
    square: bool = False

    @property
    def score(self) -> float:
        """The sides' ratio, reduced where part of the inside or some views contradict the face."""
        e = self.evidence
        sides = e.sides - penalty(self.corners, moved=self.moved)
        return sides * (4 * e.consistent - 3) * float(np.sqrt(e.share))


Judge: TypeAlias = Callable[[FloatArray, Candidate], Candidate | None]
"""From other corners (k, 3), on a plane of their own, and a candidate to one in its place that has
those; None where they are no face."""


def penalty(corners: FloatArray, *, moved: bool) -> float:
    """Return the penalty that the log-likelihood ratio of an outline's (k, 3) sides must exceed."""
    return PLANE_PENALTY + (MOVED_PENALTY if moved else SIDE_PENALTY) * len(corners)


def tidy(corners: FloatArray, normal: FloatArray, pixel: float) -> FloatArray:
    """Return an outline (k, 3) across a normal without sides and corners below the `pixel`
    resolution.
    """
    basis = plane_basis(normal)
    flat = remove_short_sides(corners @ basis, MIN_SIDE_PX * pixel)
    flat = remove_straight_corners(flat, MIN_TURN_PX * pixel)
    tidied: FloatArray = flat @ basis.T + normal * float(normal @ corners[0])
    return tidied


def simplest(
    candidate: Candidate, others: Sequence[Candidate], pixel: float, judge: Judge
) -> Candidate:
    """Return the candidate without corners that lower its score: regions grow spurs along their
    lines.

    Of the `others`, the best first, a nearly equal one with fewer corners takes its place, or one
    that is right-angled as far as a `pixel` shows (in the unit of corners).
    """
    candidate = _plainest(candidate, others, pixel, judge)
    while 3 < len(candidate.corners) <= MAX_SIMPLIFIED:
        fewer = (np.delete(candidate.corners, k, axis=0) for k in range(len(candidate.corners)))
        judged = [judge(corners, candidate) for corners in fewer]
        scores = np.array([0.0 if j is None else j.score for j in judged])
        best = judged[largest(scores)]
        if best is None or best.score <= candidate.score:
            break
        candidate = best
    return candidate


def _plainest(
    best: Candidate, others: Sequence[Candidate], pixel: float, judge: Judge
) -> Candidate:
    # Of outlines of nearly the same region and score, the one with fewest corners, and of those a
    # right-angled one: texture beside a border has edges enough for any notch or slant.
    def plainness(candidate: Candidate) -> tuple[int, bool]:
        return len(candidate.corners), not _is_right_angled(candidate.corners, pixel)

    least = plainness(best)
    plainer = [
        c
        for c in others
        if c.plane == best.plane
        and c.normal @ best.normal > 0
        and plainness(c) < least
        and c.score >= AS_GOOD * best.score
        and alike(c.corners, best.corners, best.normal)
    ]
    for _, alike_plain in groupby(sorted(plainer, key=plainness), plainness):
        judged = [judge(c.corners, c) for c in alike_plain]
        scores = np.array([0.0 if j is None else j.score for j in judged])
        again = judged[largest(scores)]
        if again is not None and again.score >= AS_GOOD * best.score:
            return again
    return best


def _is_right_angled(corners: FloatArray, pixel: float) -> bool:
    """Return whether at each corner of an outline (k, 3) the end of the shorter side is no farther
    from the perpendicular than two edges are wide: each of the two sides may be off by one.
    """
    before, after = np.roll(corners, 1, axis=0) - corners, np.roll(corners, -1, axis=0) - corners
    longer = np.maximum(np.linalg.norm(before, axis=1), np.linalg.norm(after, axis=1))
    off = np.abs((before * after).sum(axis=1)) / longer
    return bool((off <= 2 * MIN_TURN_PX * pixel).all())


def square(
    candidate: Candidate,
    known: Sequence[FloatArray],
    plane: PlaneHypothesis,
    cloud: LineCloud,
    photos: PhotometricViews,
    sides: SideJudge,
    judge: Judge,
) -> Candidate:
    """Return the candidate on a plane parallel or perpendicular to `known` normals (3,), where
    possible.

    That is where its lines allow it within KNOWN_SDS, and its score there is as good: another thing
    may stand askew. `plane` is the candidate's.
    """
    cov = plane_cov(plane, cloud, candidate.corners, OPEN_SLOPE)
    centre = photos.centres[candidate.evidence.shown].mean(axis=0)
    for normal in propose_square_normals(candidate.normal, known):
        if is_square(candidate.normal, normal):
            return replace(candidate, square=True)
        ring = project_to_plane(candidate.corners, plane, normal, cloud, centre)
        moved_by = np.abs((ring - candidate.corners) @ candidate.normal)
        if (moved_by > KNOWN_SDS * np.sqrt(np.diagonal(cov))).any():
            continue
        views = photos.facing(ring.mean(axis=0), normal)
        moved = sides.snap_to_edges(views, ring, normal, cloud.pixel)
        for corners in (ring, moved):
            again = judge(corners, replace(candidate, normal=normal))
            if again is not None and again.score >= AS_GOOD * candidate.score:
                return replace(again, square=True)
    return candidate
