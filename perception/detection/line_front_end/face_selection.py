"""Which outlines are faces: the best first, and each pixel of a picture shows one of them only.

Candidates are judged by all views. The best is a face; the pixels that show it say nothing of what
would lie before or behind it, so candidates that lived on them are judged anew without, and their
planes are searched again. What remains unexplained decides on the next.
"""

import heapq
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.face_conflicts import (
    MAX_BLOCKED,
    alike,
    blocked,
    lies_within,
    overlap,
    touch,
)
from facetlog.perception.detection.line_front_end.evidence.face_evidence import (
    FaceEvidence,
    FaceJudge,
)
from facetlog.perception.detection.line_front_end.evidence.half_planes import surface_beside
from facetlog.perception.detection.line_front_end.evidence.see_through import LinesBehind
from facetlog.perception.detection.line_front_end.evidence.side_evidence import MOVES_PX, SideJudge
from facetlog.perception.detection.line_front_end.evidence.witnesses import Witnesses
from facetlog.perception.detection.line_front_end.hole_search import HoleFinder
from facetlog.perception.detection.line_front_end.outlines.outline_search import find_outlines
from facetlog.perception.detection.line_front_end.outlines.parallelograms import parallelograms
from facetlog.perception.detection.line_front_end.outlines.plane_regions import (
    ON_PLANE_PX,
    RegionFinder,
)
from facetlog.perception.detection.line_front_end.outlines.region_outline import (
    without_short_sides,
    without_straight_corners,
)
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.detection.line_front_end.planes.plane_choice import (
    OPEN_SLOPE,
    ChosenPlane,
    choose_planes,
    plane_cov,
    same_plane,
)
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_basis,
)
from facetlog.perception.detection.line_front_end.planes.print_choice import with_print_planes
from facetlog.perception.detection.line_front_end.planes.print_planes import PrintPlane
from facetlog.perception.detection.line_front_end.planes.square_planes import (
    SQUARE_SLOPE,
    is_square,
    seen_on_plane,
    square_normals,
)
from facetlog.perception.detection.line_front_end.points_3d.print_points import PrintPoints
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.detection.line_front_end.segments_3d.line_extent import (
    LineProfiles,
    covered_extents,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.flat_faces import vector_area
from facetlog.perception.ties import largest
from facetlog.perception.types import FloatArray, View

__all__ = ["SelectedFace", "select_faces"]

# Least coverage of the sides of a face when it is as plain as may be.
MIN_FINAL = 0.75
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
# Smaller faces (root of the area, px) are below what edges can bound.
MIN_SIZE_PX = 6.0
# A candidate that loses so much of its worth to the faces before it has its plane searched again.
STILL_WORTH = 0.6
# Coplanar faces lie this near to one plane, px.
SAME_PLANE_PX = 8.0
# A plane is not turned by more than its lines leave open at any corner.
KNOWN_SDS = 3.0
# Faces touch within so many px, and their corners become one.
TOUCH_PX = 8.0
# Lines that pass this near to a face's outline or end this near to its plane, px, go free.
FREE_PX = 4.0
# A face has a neighbour at each side that is so much of its way round: curves have none.
LONG_SIDE = 0.08
# Pixels at a face's rim belong to its neighbours too: half this width, px. What is left between two
# faces belongs to both.
RIM, BETWEEN = np.ones((5, 5), dtype=np.uint8), np.ones((7, 7), dtype=np.uint8)


@dataclass(frozen=True, eq=False, slots=True)
class SelectedFace:
    """An outline judged a face, its corners counter-clockwise seen from the side that views see.

    `shown` (V,) tells which views show it; `support` is the share of its sides on edges in those,
    `seen` (n, 3) are points of its inside; `holes` (k, 3) run clockwise. `plane_cov` says how far
    its plane may be off at its corners, then at those of the holes, where it is known by itself.
    Where it has no edges its outline is only how far it is known to reach.
    """

    corners: FloatArray
    normal: FloatArray
    shown: NDArray[np.bool_]
    support: float
    seen: FloatArray
    plane_cov: FloatArray | None = None
    holes: tuple[FloatArray, ...] = ()
    has_edges: bool = True


@dataclass(frozen=True, eq=False, slots=True)
class _Candidate:
    corners: FloatArray
    normal: FloatArray
    evidence: FaceEvidence
    plane: int  # number of the hypothesis
    moved: bool  # its sides were moved onto edges
    after: int  # how many faces there were when it was judged
    square: bool = False  # to what was found before it

    @property
    def worth(self) -> float:
        # The sides' ratio, less where part of the inside or some of the views speak against it.
        e = self.evidence
        sides = e.sides - _price(self.corners, moved=self.moved)
        return sides * (4 * e.consistent - 3) * float(np.sqrt(e.share))


def _price(corners: FloatArray, *, moved: bool) -> float:
    # What the sides of an outline must be worth.
    return PLANE_PRICE + (MOVED_PRICE if moved else SIDE_PRICE) * len(corners)


def select_faces(
    planes: Sequence[PlaneHypothesis],
    cloud: LineCloud,
    worth: FloatArray,
    views: Sequence[View],
    profiles: LineProfiles,
    ground: Ground | None,
    witnesses: Witnesses,
    sides: SideJudge,
    prints: PrintPoints | None = None,
    patches: Sequence[PrintPlane] = (),
) -> tuple[tuple[SelectedFace, ...], tuple[NDArray[np.uint8], ...]]:
    """Faces on the planes, the best first, and in each view the pixels (H, W) that they explain, 1.

    None of them is the ground. Of the cloud's lines `worth` (n,) is their log-likelihood ratio, and
    `profiles` say how far they are covered. The `patches` of points of print propose planes, too.
    """
    selection = _Selection(planes, cloud, worth, views, profiles, ground, witnesses, sides)
    if prints is not None:
        selection.add_planes_of_print(patches, prints)
    return selection.run()


class _Selection:
    def __init__(
        self,
        planes: Sequence[PlaneHypothesis],
        cloud: LineCloud,
        worth: FloatArray,
        views: Sequence[View],
        profiles: LineProfiles,
        ground: Ground | None,
        witnesses: Witnesses,
        sides: SideJudge,
    ) -> None:
        self._cloud = cloud
        self._profiles = profiles
        self._extents = covered_extents(cloud.segments, profiles)
        self._views = views
        self._pixel = cloud.pixel
        self._sides = sides
        self._ground = ground
        self._witnesses = witnesses
        self._judge = FaceJudge(self._witnesses, self._sides, ground)
        self._behind = LinesBehind(
            witnesses, sides, self._extents, cloud.end_covs.mean(axis=1), cloud.pixel
        )
        self._holes = HoleFinder(witnesses, sides, cloud, profiles, self._behind)
        chosen = choose_planes(planes, cloud, worth, ground, self._beside, LEAST_PRICE)
        self._planes = list(chosen)
        self._finder = RegionFinder(
            views, witnesses.levels, witnesses.weight, cloud.segments, ground, cloud.pixel
        )
        self._taken = [np.zeros(view.image.shape, dtype=np.uint8) for view in views]
        self._faces: list[SelectedFace] = []
        self._number = count()
        # Outlines by their worth, and numbers of planes by what an outline there could be worth.
        self._queue: list[tuple[float, int, _Candidate | int]] = []

    def _beside(self, plane: PlaneHypothesis) -> NDArray[np.bool_]:
        lines = self._cloud.segments[plane.lines]
        return surface_beside(self._witnesses, plane.normal, lines, self._pixel)

    def add_planes_of_print(self, patches: Sequence[PrintPlane], prints: PrintPoints) -> None:
        """Look over the planes of print, too."""
        self._planes = list(with_print_planes(self._planes, patches, prints, self._cloud))

    def run(self) -> tuple[tuple[SelectedFace, ...], tuple[NDArray[np.uint8], ...]]:
        for plane, chosen in enumerate(self._planes):
            self._push(chosen.promise - LEAST_PRICE, plane)
        searched: dict[tuple[int, float], int] = {}
        while self._queue:
            worth, _, best = heapq.heappop(self._queue)
            if isinstance(best, int):
                self._look_over(best)
                for side in (1.0, -1.0):
                    searched[best, side] = len(self._faces)
                continue
            if any(self._contradicts(best, f) for f in self._faces[best.after :]):
                continue
            if best.after == len(self._faces):
                plain = self._square(self._simplest(best))
                shown = plain.evidence.coverage >= MIN_FINAL
                if shown and not self._judge.shows_ground(
                    plain.corners, plain.normal, plain.evidence, self._taken
                ):
                    self._accept(plain)
                continue
            again = self._judged(best.corners, best.normal, best.plane, moved=best.moved)
            if again is not None and again.worth >= -STILL_WORTH * worth:
                self._push(again.worth, again)
                continue
            plane = best.plane
            side = float(np.sign(best.normal @ self._planes[plane].plane.normal))
            # A plane that still waits in the queue is looked over when its turn comes.
            if searched.get((plane, side), len(self._faces)) < len(self._faces):
                searched[plane, side] = len(self._faces)
                self._search(plane, side)
        return tuple(self._faces), tuple(self._taken)

    def _look_over(self, plane: int) -> None:
        hypothesis = self._planes[plane].plane
        # Print divides a face into regions; its own lines go all the way round.
        for outline in find_outlines(hypothesis, self._cloud, self._profiles):
            for normal in (outline.normal, -outline.normal):
                corners = _counter_clockwise(outline.corners, normal)
                self._propose(corners, normal, plane, moved=False)
        self._complete(plane)
        for side in self._planes[plane].sides:
            self._search(plane, side)

    def _complete(self, plane: int) -> None:
        # Two or three sides that meet propose the others, where the pictures show them best.
        hypothesis = self._planes[plane].plane
        near = ON_PLANE_PX * self._pixel
        known = [self._extents[hypothesis.lines]]
        for face in self._faces:
            sides = np.stack([face.corners, np.roll(face.corners, -1, axis=0)], axis=1)
            off = np.abs(sides @ hypothesis.normal - hypothesis.distance)
            known.append(sides[(off < near).all(axis=1)])
        for ring in parallelograms(np.concatenate(known), hypothesis, self._pixel):
            self._propose_rough(ring, hypothesis.normal, plane)

    def _propose_moved(self, corners: FloatArray, normal: FloatArray, plane: int) -> None:
        views = self._witnesses.facing(corners.mean(axis=0), normal)
        moved = self._sides.onto_edges(views, corners, normal, self._pixel)
        self._propose(moved, normal, plane, moved=True)

    def _search(self, plane: int, side: float) -> None:
        hypothesis = self._planes[plane].plane
        normal = side * hypothesis.normal
        for corners, rough in self._finder.outlines(
            hypothesis, self._planes[plane].spans, side, self._taken
        ):
            if rough:
                self._propose_moved(corners, normal, plane)
            else:
                self._propose(corners, normal, plane, moved=False)

    def _propose(self, corners: FloatArray, normal: FloatArray, plane: int, *, moved: bool) -> None:
        if self._ground is not None:
            corners = self._ground.clipped(corners)
            if len(corners) < 3 or self._ground.holds(corners).all():
                return
        basis = plane_basis(normal)
        flat = without_short_sides(corners @ basis, MIN_SIDE_PX * self._pixel)
        flat = without_straight_corners(flat, MIN_TURN_PX * self._pixel)
        corners = flat @ basis.T + normal * float(normal @ corners[0])
        found = self._judged(corners, normal, plane, moved=moved)
        if found is not None and not any(self._contradicts(found, f) for f in self._faces):
            self._push(found.worth, found)

    def _push(self, worth: float, what: "_Candidate | int") -> None:
        # Faces of a ring that are worth the same but for rounding come in the order given.
        heapq.heappush(self._queue, (-round(worth, 6), next(self._number), what))

    def _judged(
        self, corners: FloatArray, normal: FloatArray, plane: int, *, moved: bool
    ) -> _Candidate | None:
        size = np.sqrt(shapely.Polygon(corners @ plane_basis(normal)).area)
        if size < MIN_SIZE_PX * self._pixel:
            return None
        e = self._judge.judge(corners, normal, self._taken, _price(corners, moved=moved))
        if e is None:
            return None
        candidate = _Candidate(corners, normal, e, plane, moved, len(self._faces))
        return candidate if candidate.worth > 0 else None

    def _simplest(self, candidate: _Candidate) -> _Candidate:
        # Without the corners that make it worth less: regions grow spurs along their lines.
        candidate = self._plainest(candidate)
        while 3 < len(candidate.corners) <= MAX_SIMPLIFIED:
            c = candidate
            fewer = [np.delete(c.corners, k, axis=0) for k in range(len(c.corners))]
            judged = [self._judged(f, c.normal, c.plane, moved=c.moved) for f in fewer]
            worths = np.array([0.0 if j is None else j.worth for j in judged])
            best = judged[largest(worths)]
            if best is None or best.worth <= c.worth:
                break
            candidate = best
        return candidate

    def _square(self, candidate: _Candidate) -> _Candidate:
        # Where its lines leave a plane open, of those worth as much the one that is square to the
        # ground and to the faces that it touches: another thing may stand askew.
        near = TOUCH_PX * self._pixel
        known = [] if self._ground is None else [self._ground.normal]
        known += [f.normal for f in self._faces if touch(candidate.corners, f.corners, near)]
        plane = self._planes[candidate.plane].plane
        cov = plane_cov(plane, self._cloud, candidate.corners, OPEN_SLOPE)
        sds = np.sqrt(np.diagonal(cov))
        centre = self._witnesses.centres[candidate.evidence.shown].mean(axis=0)
        for normal in square_normals(candidate.normal, known):
            if is_square(candidate.normal, normal):
                return replace(candidate, square=True)
            ring = seen_on_plane(candidate.corners, plane, normal, self._cloud, centre)
            moved_by = np.abs((ring - candidate.corners) @ candidate.normal)
            if (moved_by > KNOWN_SDS * sds).any():
                continue
            views = self._witnesses.facing(ring.mean(axis=0), normal)
            moved = self._sides.onto_edges(views, ring, normal, self._pixel)
            for corners in (ring, moved):
                again = self._judged(corners, normal, candidate.plane, moved=candidate.moved)
                if again is not None and again.worth >= AS_WORTH * candidate.worth:
                    return replace(again, square=True)
        return candidate

    def _plainest(self, best: _Candidate) -> _Candidate:
        # Of outlines of nearly the same region and worth the one with fewest corners: print beside
        # a border gives edges enough for any notch.
        plainer = [
            c
            for _, _, c in sorted(self._queue, key=lambda entry: entry[:2])
            if isinstance(c, _Candidate)
            and c.plane == best.plane
            and c.normal @ best.normal > 0
            and len(c.corners) < len(best.corners)
            and c.worth >= AS_WORTH * best.worth
            and alike(c.corners, best.corners, best.normal)
        ]
        for c in sorted(plainer, key=lambda c: len(c.corners)):
            again = self._judged(c.corners, c.normal, c.plane, moved=c.moved)
            if again is not None and again.worth >= AS_WORTH * best.worth:
                return again
        return best

    def _accept(self, candidate: _Candidate) -> None:
        e = candidate.evidence
        known = self._planes[candidate.plane].plane
        slope = SQUARE_SLOPE if candidate.square else OPEN_SLOPE
        corners, normal = candidate.corners, candidate.normal
        flat = PlaneHypothesis(normal, float(normal @ corners[0]), known.lines)
        holes = self._holes.holes(corners, flat, e.shown, self._taken)
        if self._behind.seen_through(corners, normal, np.nonzero(e.shown)[0], holes):
            return
        rings = np.concatenate([corners, *holes])
        cov = plane_cov(known, self._cloud, rings, slope)
        seen = e.points[~lies_within(holes, normal, e.points)]
        face = SelectedFace(corners, normal, e.shown, e.coverage, seen, cov, holes)
        self._faces.append(face)
        for k in np.nonzero(e.shown)[0].tolist():
            projection = self._views[k].projection
            drawn = [project_points(projection, ring) for ring in (corners, *holes)]
            if all((depth > 0).all() for _, depth in drawn):
                filled = np.zeros_like(self._taken[k])
                cv2.fillPoly(filled, [np.rint(uv).astype(np.int32) for uv, _ in drawn], 1)
                taken = cv2.bitwise_or(self._taken[k], cv2.erode(filled, RIM))
                closed = cv2.morphologyEx(taken, cv2.MORPH_CLOSE, BETWEEN)
                self._taken[k] = np.asarray(closed, dtype=np.uint8)
        self._propose_neighbours(face, candidate.worth)

    def _propose_neighbours(self, face: SelectedFace, worth: float) -> None:
        # Most things have right angles: a plane through each side across the face.
        ends = np.stack([face.corners, np.roll(face.corners, -1, axis=0)], axis=1)
        length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        for side, reach in zip(ends, length, strict=True):
            if reach < LONG_SIDE * length.sum():
                continue
            normal = np.cross(face.normal, (side[1] - side[0]) / reach)
            distance = float(normal @ side.mean(axis=0))
            away = np.abs(self._cloud.segments @ normal - distance).max(axis=1)
            plane = PlaneHypothesis(
                normal, distance, np.nonzero(away < ON_PLANE_PX * self._pixel)[0]
            )
            same = same_plane(plane, side, [p.plane for p in self._planes], self._pixel)
            number = int(same.argmax()) if same.any() else len(self._planes)
            if number == len(self._planes):
                across = np.array([-0.5, 0.5])[:, None, None] * reach * face.normal
                self._planes.append(ChosenPlane(plane, worth, (1.0, -1.0), side + across))
                self._push(worth, number)
            self._propose_down(side, number)

    def _propose_down(self, side: FloatArray, number: int) -> None:
        # What is bounded above often stands on the ground.
        normal = self._planes[number].plane.normal
        if self._ground is not None:
            ring = self._ground.down_from(side, normal)
            if len(ring):
                self._propose_rough(ring, normal, number)

    def _propose_rough(self, ring: FloatArray, normal: FloatArray, plane: int) -> None:
        for outwards in (normal, -normal):
            corners = _counter_clockwise(ring, outwards)
            if self._judge.agrees_inside(corners, outwards, self._taken):
                self._propose_moved(corners, outwards, plane)

    def _contradicts(self, candidate: _Candidate, face: SelectedFace) -> bool:
        # They overlap in one plane, where holes are no surface either; or the candidate hides the
        # face from views that show it.
        corners, normal = candidate.corners, candidate.normal
        near = SAME_PLANE_PX * self._pixel
        if overlap(corners, normal, face.corners, face.normal, near):
            return True
        centres, free = self._witnesses.centres[face.shown], FREE_PX * self._pixel
        hides = blocked(corners, normal, face.seen, centres, free)
        return bool(hides.mean() > MAX_BLOCKED)


def _counter_clockwise(corners: FloatArray, normal: FloatArray) -> FloatArray:
    return corners if vector_area(corners) @ normal > 0 else corners[::-1].copy()
