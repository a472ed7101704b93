"""The faces found, with the level boards between those that stand upright opposite each other.

A board between two sides shows few lines: its rim, in a picture some pixels above the dark beneath
it, and where it meets the rear, if the shades differ. That is no plane, and often not even a line
in space. But where two upright faces stand opposite each other, a level board between them has one
unknown, its height: all views are asked at each height for the edges that a board there would show,
and for one surface between them. The likeliest board is taken; what it hides, and the edges that it
explains, are no evidence for the next.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.candidate_faces import SelectedFace
from facetlog.perception.detection.line_front_end.evidence.beside_segments import MIN_WEIGHT
from facetlog.perception.detection.line_front_end.evidence.face_conflicts import (
    PARALLEL_COSINE,
    UPRIGHT_SINE,
    blocked,
    find_points_within,
    overlap,
)
from facetlog.perception.detection.line_front_end.evidence.face_evidence import (
    MIN_COVERAGE,
    FaceEvidence,
    FaceJudge,
)
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import (
    AGREES_SDS,
    LIGHT_SHARE,
)
from facetlog.perception.detection.line_front_end.evidence.photometric_views import (
    MIN_FACING_SINE,
    PhotometricViews,
)
from facetlog.perception.detection.line_front_end.evidence.see_through import LinesBehind
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SAMPLES, SideJudge
from facetlog.perception.detection.line_front_end.face_selection import FREE_PX
from facetlog.perception.detection.line_front_end.outlines.outline_search import MIN_SIDE_PX
from facetlog.perception.detection.line_front_end.planes.ground_plane import LEVEL_COSINE, Ground
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import plane_basis
from facetlog.perception.detection.line_front_end.planes.square_planes import SQUARE_SLOPE
from facetlog.perception.detection.line_front_end.segments_3d.line_support import segment_samples
from facetlog.perception.flat_faces import compute_vector_area, cross, make_ring_sides
from facetlog.perception.polygons import find_intersection, make_polygon
from facetlog.perception.stable_order import largest
from facetlog.perception.types import FloatArray

# Less than one in a thousand scenes may show edges so by chance.
CHANCE_PENALTY = float(np.log(1000.0))
# A true side is too faint in every second view: what is lit and what is in the shade differ from
# one side, and hardly from the other.
FAINT = 0.5
# A view shows a side at odds of 20 to 1; so many distinct views must.
SHOWS_SIDE, SIDE_WEIGHT = float(np.log(20.0)), 3.0
# An edge reaches so far to either side, px.
EDGE_PX = 2.0
# The ground about a thing is looked at so many times as far from its middle as it reaches.
AROUND = np.array([1.2, 1.5, 2.0])
# A side is one with a found face where this share of it lies on the face.
JOINED_SHARE = 0.5
# Two faces stand opposite each other where so much of the smaller does.
OPPOSITE_SHARE = 0.5


@dataclass(frozen=True, eq=False, slots=True)
class BoardPlaces:
    """Outlines `rings` (t, 4, 3) of boards, counter-clockwise from above, about a pixel apart.

    Their first and third sides are free, the other two lie on faces; `pair` (t,) numbers the two
    faces that they lie between. Those of one pair follow one another from below.
    """

    rings: FloatArray
    pair: NDArray[np.intp]

    @property
    def free_sides(self) -> FloatArray:
        """The two free sides (t, 2, 2, 3) of each."""
        return np.stack([self.rings[:, :2], self.rings[:, 2:]], axis=1)


def board_places(
    faces: Sequence[SelectedFace], up: FloatArray, pixel: float, least: float
) -> BoardPlaces:
    """Return the places between each two of the faces; `up` (3,) is across what is level.

    As deep as the lower, or the less deep, of the two faces. `least` is how far apart they are at
    least, and how deep a board. Two sides of one board make no places of their own.
    """
    found: list[FloatArray] = []
    upright = [face for face in faces if abs(face.normal @ up) < UPRIGHT_SINE]
    for rings in _list_opposite_pairs(upright, up, pixel, least):
        if not any(_same(rings, known, least) for known in found):
            found.append(rings)
    if not found:
        return BoardPlaces(np.zeros((0, 4, 3)), np.zeros(0, np.intp))
    return BoardPlaces(
        np.concatenate(found), np.repeat(np.arange(len(found)), [len(rings) for rings in found])
    )


def _list_opposite_pairs(
    upright: Sequence[SelectedFace], up: FloatArray, pixel: float, least: float
) -> Iterator[FloatArray]:
    for one, other in combinations(upright, 2):
        cosine = float(one.normal @ other.normal)
        if abs(cosine) < PARALLEL_COSINE:
            continue
        across = one.normal + np.sign(cosine) * other.normal
        across = across - (across @ up) * up
        across = across / np.linalg.norm(across)
        apart = float((other.corners.mean(axis=0) - one.corners.mean(axis=0)) @ across)
        if abs(apart) < least:
            continue
        across = np.sign(apart) * across
        deep = cross(up, across)
        flat = np.stack([deep, up], axis=1)
        drawn = [make_polygon(face.corners @ flat) for face in (one, other)]
        both = find_intersection(*drawn)
        if both.area < OPPOSITE_SHARE * min(polygon.area for polygon in drawn):
            continue
        low, high, heights = _chords(both, pixel, least)
        if not len(heights):
            continue
        corners = [
            _on_plane(face, across, where[:, None] * deep + heights[:, None] * up)
            for face, where in ((one, low), (other, low), (other, high), (one, high))
        ]
        yield np.stack(corners, axis=1)


def _chords(region: shapely.Geometry, pixel: float, least: float) -> FloatArray:
    # From where to where a region of the plane reaches, and at which heights: (3, n).
    if region.is_empty:
        return np.zeros((3, 0))
    left, bottom, right, top = region.bounds
    # Clear of both ends, where rounding would decide.
    count = max(round((top - bottom) / pixel), 1)
    heights = bottom + (np.arange(count) + 0.5) * (top - bottom) / count
    lines = shapely.linestrings([[(left - pixel, h), (right + pixel, h)] for h in heights])
    cut = shapely.bounds(find_intersection(region, lines))
    chords = np.stack([cut[:, 0], cut[:, 2], heights])
    # Of no chord the bounds are NaN.
    return np.asarray(chords[:, chords[1] - chords[0] >= least])


def _on_plane(face: SelectedFace, way: FloatArray, points: FloatArray) -> FloatArray:
    # Where lines from points (n, 3) along a way (3,) meet the plane of a face.
    ahead = (face.corners.mean(axis=0) - points) @ face.normal / (way @ face.normal)
    return np.asarray(points + ahead[:, None] * way)


def _same(rings: FloatArray, others: FloatArray, near: float) -> bool:
    # Whether the lowest and the highest of some places are those of others.
    ends, known = rings[[0, -1]], others[[0, -1]]
    turned = np.roll(known, 2, axis=1)
    return bool(
        any((np.linalg.norm(ends - those, axis=2) < near).all() for those in (known, turned))
    )


@dataclass(frozen=True, eq=False, slots=True)
class Sight:
    """Evidence of the views, and the conclusions drawn so far.

    `taken` are the pixels that found faces explain, V pictures of 0 and 1; `behind` says whether
    one sees through an outline; `pixel` is a pixel's length at the usual distance.
    """

    photos: PhotometricViews
    sides: SideJudge
    judge: FaceJudge
    behind: LinesBehind
    taken: Sequence[NDArray[np.uint8]]
    ground: Ground
    pixel: float


class BoardSearch:
    """Searches t places for boards that are seen from the side to which `normal` points.

    What the `faces` hide is no evidence.
    """

    def __init__(
        self,
        faces: Sequence[SelectedFace],
        places: BoardPlaces,
        normal: FloatArray,
        sight: Sight,
    ) -> None:
        self._places = places
        self._normal = normal
        self._sight = sight
        self._ends = places.free_sides.reshape(-1, 2, 3)
        self._samples = segment_samples(self._ends, SAMPLES)
        centres = sight.photos.centres
        self._everyone = np.arange(len(centres))
        rays = centres[:, None] - places.rings.mean(axis=1)
        facing = rays @ normal > MIN_FACING_SINE * np.linalg.norm(rays, axis=2)
        # Which samples (V, 2 t, SAMPLES) of the free sides each view sees, past what was found and
        # apart from its sides; which (2 t, SAMPLES) lie on it, and which places (t,) are left.
        self._bare = np.repeat(facing, 2, axis=1)[..., None] & np.ones(SAMPLES, np.bool_)
        self._joined = np.zeros(self._samples.shape[:2], np.bool_)
        self._left = np.ones(len(places.rings), dtype=np.bool_)
        self._penalty = CHANCE_PENALTY + float(np.log(2 * len(places.rings)))
        self._faces: list[SelectedFace] = []
        for face in faces:
            self._add(face)

    def run(self) -> tuple[SelectedFace, ...]:
        """Return the likeliest board, then the next, until what is left is as likely by chance."""
        found: list[SelectedFace] = []
        while True:
            ratio, coverage = self._evidence()
            best = largest(ratio)
            if ratio[best] <= 0:
                return tuple(found)
            ring = self._middle(best, ratio)
            board = self._as_face(ring, float(coverage[best]))
            self._left[best] = False
            if board is None:
                self._leave_out(ring)
            else:
                found.append(board)
                self._add(board)

    def _evidence(self) -> tuple[FloatArray, FloatArray]:
        # Of each place the log-likelihood ratio of its sides, 0 where they do not show a board, and
        # the share of them that is found.
        weight = self._sight.photos.weight
        evidence = self._sight.sides.evidence(self._everyone, self._ends, self._bare, self._joined)
        ratio = _in_favour(evidence.ratio, weight).reshape(-1, 2)
        views = (weight @ (evidence.ratio > SHOWS_SIDE)).reshape(-1, 2)
        free = self._joined.mean(axis=1).reshape(-1, 2) < JOINED_SHARE
        shown = free & (ratio > self._penalty) & (views >= SIDE_WEIGHT)
        holds = shown.any(axis=1) & ((ratio > 0) | ~free).all(axis=1)
        total = ratio.sum(axis=1)
        hit = (weight @ evidence.found.sum(axis=2)).reshape(-1, 2)
        there = (weight @ evidence.there.sum(axis=2)).reshape(-1, 2)
        coverage = hit.sum(axis=1) / np.maximum(there.sum(axis=1), 1e-300)
        holds &= self._left & (total > self._penalty) & (coverage > MIN_COVERAGE)
        return np.where(holds, total, 0.0), coverage

    def _middle(self, best: int, ratio: FloatArray) -> FloatArray:
        # The ring (4, 3) in the middle of the places about the best one that show a board: edges
        # are widened by a few pixels, and a rim has two, the board's upper and its lower.
        shows = (ratio > 0) & (self._places.pair == self._places.pair[best])
        gaps = np.nonzero(~shows)[0]
        reach = int(MIN_SIDE_PX)
        first = max(gaps[gaps < best].max(initial=-1) + 1, best - reach)
        last = min(gaps[gaps > best].min(initial=len(ratio)), best + reach + 1)
        run = np.arange(first, last)
        middle: FloatArray = np.tensordot(ratio[run], self._places.rings[run], 1) / ratio[run].sum()
        return middle

    def _as_face(self, ring: FloatArray, coverage: float) -> SelectedFace | None:
        # The board's face, if the views show one surface there that is neither the ground nor seen
        # through.
        sight, normal = self._sight, self._normal
        corners = ring if normal @ sight.ground.normal > 0 else ring[::-1].copy()
        inside = sight.judge.judge_clear_inside(corners, normal, self._clear)
        if inside is None:
            return None
        if sight.ground.holds(corners).all():
            if not self._outshines_ground(inside):
                return None
        elif sight.judge.shows_ground(corners, normal, inside, sight.taken):
            return None
        if sight.behind.seen_through(corners, normal, np.nonzero(inside.shown)[0]):
            return None
        # It is as level as things are built, and its height is known to an edge's reach.
        level = np.column_stack(
            [(corners - corners.mean(axis=0)) @ plane_basis(normal), np.ones(4)]
        )
        prior = np.diag([SQUARE_SLOPE, SQUARE_SLOPE, EDGE_PX * sight.pixel]) ** 2
        cov = level @ prior @ level.T
        return SelectedFace(corners, normal, inside.shown, coverage, inside.points, cov)

    def _outshines_ground(self, inside: FaceEvidence) -> bool:
        # Whether a board on the ground is brighter than any of the ground about: between two sides
        # the ground may be lit, or in a shadow whose edges are as straight.
        photos, ground = self._sight.photos, self._sight.ground
        views = np.nonzero(inside.shown)[0]
        clear = self._clear(inside.points)[views]
        level = np.median(photos.agree(views, inside.points, None, clear)[0].level)
        corners = np.concatenate([face.corners for face in self._faces])
        flat = corners - ground.above(corners)[:, None] * ground.normal
        middle = flat.mean(axis=0)
        around = (middle + AROUND[:, None, None] * (flat - middle)).reshape(-1, 3)
        found, seen = photos.agree(self._everyone, around, None, self._clear(around))
        known = (found.ratio > 0) & (photos.weight @ seen >= MIN_WEIGHT)
        if not known.any():
            return False
        return bool(level > found.level[known].max() * (1.0 + AGREES_SDS * LIGHT_SHARE))

    def _clear(self, points: FloatArray) -> NDArray[np.bool_]:
        # Which of the points (n, 3) each view sees past the found faces (V, n).
        clear = np.ones((len(self._everyone), len(points)), dtype=np.bool_)
        for face in self._faces:
            clear &= ~self._blocks(face, points)
        return clear

    def _blocks(self, face: SelectedFace, points: FloatArray) -> NDArray[np.bool_]:
        margin, centres = FREE_PX * self._sight.pixel, self._sight.photos.centres
        return blocked(face.corners, face.normal, points, centres, margin, face.holes)

    def _add(self, face: SelectedFace) -> None:
        # What a face hides, and the edges of its own sides, are no evidence for a board; where a
        # board's side lies on it, there may be no edge.
        self._faces.append(face)
        points = self._samples.reshape(-1, 3)
        self._bare &= ~self._blocks(face, points).reshape(self._bare.shape)
        ways = self._ends[:, 1] - self._ends[:, 0]
        ways = ways / np.linalg.norm(ways, axis=1, keepdims=True)
        for side in make_ring_sides(face.corners):
            along = np.nonzero(np.abs(ways @ _way(side)) > PARALLEL_COSINE)[0]
            known = np.broadcast_to(side, self._ends[along].shape)
            apart = self._sight.sides.apart(self._everyone, self._ends[along], known)
            self._bare[:, along] &= apart
        upwards = float(abs(face.normal @ self._normal))
        if upwards < UPRIGHT_SINE:
            off = np.abs((points - face.corners.mean(axis=0)) @ face.normal)
            on = off < FREE_PX * self._sight.pixel
            on[on] = find_points_within([face.corners], face.normal, points[on])
            self._joined |= on.reshape(self._joined.shape)
        elif upwards > PARALLEL_COSINE:
            self._leave_out(face.corners)

    def _leave_out(self, level: FloatArray) -> None:
        # Two boards nearer together than an outline may be thin are one.
        near = MIN_SIDE_PX * self._sight.pixel
        rings = self._places.rings
        for k in np.nonzero(self._left)[0].tolist():
            self._left[k] = not overlap(rings[k], self._normal, level, self._normal, near)


def _in_favour(ratio: FloatArray, weight: FloatArray) -> FloatArray:
    # The summed log-likelihood ratio (k,) of sides that each view (V, k) shows or not: some are too
    # faint in it.
    in_view = np.logaddexp(np.log(1 - FAINT) + ratio, np.log(FAINT))
    return np.asarray(weight @ in_view)


def _way(side: FloatArray) -> FloatArray:
    return np.asarray((side[1] - side[0]) / np.linalg.norm(side[1] - side[0]))


def with_boards(
    faces: Sequence[SelectedFace],
    photos: PhotometricViews,
    sides: SideJudge,
    taken: Sequence[NDArray[np.uint8]],
    ground: Ground | None,
    behind: LinesBehind,
    pixel: float,
) -> tuple[SelectedFace, ...]:
    """Return the `faces`, and the level boards between those that stand upright opposite each
    other.

    `taken` are the pixels that found faces explain, V pictures of 0 and 1; `pixel` is a pixel's
    length at the usual distance. Without a ground nothing says what is level: then as they are.
    """
    if ground is None:
        return tuple(faces)
    up = _level(faces, ground)
    places = board_places(faces, up, pixel, MIN_SIDE_PX * pixel)
    if not len(places.rings):
        return tuple(faces)
    sight = Sight(photos, sides, FaceJudge(photos, sides, ground), behind, taken, ground, pixel)
    found: list[SelectedFace] = []
    for normal in (up, -up):
        found += BoardSearch((*faces, *found), places, normal, sight).run()
    return (*faces, *found)


def _level(faces: Sequence[SelectedFace], ground: Ground) -> FloatArray:
    # A normal (3,) upwards: of the largest level face that was found, for a floor that is seen from
    # afar may be known worse; else the ground's.
    best, most = ground.normal, 0.0
    for face in faces:
        area = float(np.linalg.norm(compute_vector_area(face.corners)))
        if area > most and abs(face.normal @ ground.normal) > LEVEL_COSINE:
            best, most = np.sign(face.normal @ ground.normal) * face.normal, area
    return best
