"""Greedy selection of faces among candidate outlines; each pixel is explained by one face only.

Candidates are judged by all views. The best is a face; the pixels that show it are no evidence for
anything in front of or behind it, so candidates that used them are judged again without them, and
their planes are searched again. The remaining pixels decide on the next.

Two faces that meet show an edge between them only where their shades differ, which those of a thing
of one colour in the shade often do not. A missing edge says nothing at a side of a face found
before; anywhere else a face ends in the air, and its edge stands before what lies behind.
"""

import heapq
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import count

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.candidate_faces import (
    LEAST_PENALTY,
    Candidate,
    SelectedFace,
    penalty,
    simplest,
    square,
    tidy,
)
from facetlog.perception.detection.line_front_end.evidence.beside_segments import (
    find_surface_beside,
)
from facetlog.perception.detection.line_front_end.evidence.face_conflicts import (
    MAX_BLOCKED,
    alike,
    back_to_back,
    blocked,
    find_points_within,
    overlap,
    touch,
)
from facetlog.perception.detection.line_front_end.evidence.face_evidence import FaceJudge
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.see_through import LinesBehind
from facetlog.perception.detection.line_front_end.evidence.side_evidence import SideJudge
from facetlog.perception.detection.line_front_end.holes_and_spurs import HoleFinder, remove_spurs
from facetlog.perception.detection.line_front_end.outlines.outline_search import find_outlines
from facetlog.perception.detection.line_front_end.outlines.parallelograms import parallelograms
from facetlog.perception.detection.line_front_end.outlines.plane_regions import (
    ON_PLANE_PX,
    RegionFinder,
)
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.detection.line_front_end.planes.plane_choice import (
    OPEN_SLOPE,
    ChosenPlane,
    choose_planes,
    find_same_planes,
    plane_cov,
)
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_basis,
)
from facetlog.perception.detection.line_front_end.planes.square_planes import SQUARE_SLOPE
from facetlog.perception.detection.line_front_end.planes.texture_planes import (
    TexturePlane,
    add_texture_patches,
)
from facetlog.perception.detection.line_front_end.points_3d.texture_points import TexturePoints
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.detection.line_front_end.segments_3d.line_extent import (
    LineProfiles,
    find_covered_extents,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.flat_faces import compute_vector_area, make_ring_sides
from facetlog.perception.types import FloatArray, View

# Least coverage of the sides of a face when it is as plain as may be.
MIN_FINAL = 0.75
# Smaller faces (root of the area, px) are below what edges can bound.
MIN_SIZE_PX = 6.0
# A candidate that loses this share of its score to the faces before it has its plane searched
# again.
KEPT_SCORE = 0.6
# Coplanar faces lie this near to one plane, px.
SAME_PLANE_PX = 8.0
# Faces touch within so many px, and their corners become one.
TOUCH_PX = 8.0
# Lines that pass this near to a face's outline or end this near to its plane, px, are not blocked.
FREE_PX = 4.0
# What meets at a smaller angle is one surface, and the two sides of a board have no side in common.
LEAST_TURN_COSINE = float(np.cos(np.radians(30.0)))


def joined_sides(normal: FloatArray, faces: Iterable[SelectedFace]) -> FloatArray:
    """Return the sides (n, 2, 3) of the faces that a plane of that normal (3,) may meet."""
    sides = [
        make_ring_sides(face.corners)
        for face in faces
        if abs(normal @ face.normal) < LEAST_TURN_COSINE
    ]
    return np.concatenate(sides) if sides else np.zeros((0, 2, 3))


def find_points_on_segments(
    points: FloatArray, segments: FloatArray, near: float
) -> NDArray[np.bool_]:
    """Return which points (..., 3) are nearer than that to one of the segments (n, 2, 3).

    >>> level = np.array([[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]])
    >>> find_points_on_segments(np.array([[1.0, 0.1, 0.0], [3.0, 0.0, 0.0]]), level, 0.5)
    array([ True, False])
    """
    if not len(segments):
        return np.zeros(points.shape[:-1], dtype=np.bool_)
    along = segments[:, 1] - segments[:, 0]
    off = points[..., None, :] - segments[:, 0]
    square = np.maximum((along**2).sum(axis=-1), np.finfo(np.float64).tiny)
    share = np.clip((off * along).sum(axis=-1) / square, 0.0, 1.0)
    away = np.linalg.norm(off - share[..., None] * along, axis=-1)
    close: NDArray[np.bool_] = (away < near).any(axis=-1)
    return close


def select_faces(
    planes: Sequence[PlaneHypothesis],
    cloud: LineCloud,
    score: FloatArray,
    views: Sequence[View],
    profiles: LineProfiles,
    ground: Ground | None,
    photos: PhotometricViews,
    sides: SideJudge,
    behind: LinesBehind,
    texture: TexturePoints | None = None,
    patches: Sequence[TexturePlane] = (),
) -> tuple[tuple[SelectedFace, ...], tuple[NDArray[np.uint8], ...]]:
    """Select faces on the planes, the best first; and in each view the pixels (H, W) they explain,
    1.

    None of them is the ground. Of the cloud's lines `score` (n,) is their log-likelihood ratio, and
    `profiles` say how far they are covered; what views see lines of `behind` through is no face.
    The `patches` of texture points propose planes, too.
    """
    selection = _Selection(planes, cloud, score, views, profiles, ground, photos, sides, behind)
    if texture is not None:
        selection.add_texture_planes(patches, texture)
    return selection.run()


class _Selection:
    def __init__(
        self,
        planes: Sequence[PlaneHypothesis],
        cloud: LineCloud,
        score: FloatArray,
        views: Sequence[View],
        profiles: LineProfiles,
        ground: Ground | None,
        photos: PhotometricViews,
        sides: SideJudge,
        behind: LinesBehind,
    ) -> None:
        self._cloud = cloud
        self._profiles = profiles
        self._extents = find_covered_extents(cloud.segments, profiles)
        self._views = views
        self._pixel = cloud.pixel
        self._sides = sides
        self._ground = ground
        self._photos = photos
        self._judge = FaceJudge(self._photos, self._sides, ground)
        self._behind = behind
        self._holes = HoleFinder(photos, sides, cloud, profiles, behind)
        chosen = choose_planes(planes, cloud, score, ground, self._beside, LEAST_PENALTY)
        self._planes = list(chosen)
        self._finder = RegionFinder(
            views, photos.levels, photos.weight, cloud.segments, ground, cloud.pixel
        )
        self._taken = [np.zeros(view.image.shape, dtype=np.uint8) for view in views]
        self._faces: list[SelectedFace] = []
        self._seen_through: list[Candidate] = []
        self._number = count()
        # A queue of outlines by their score, and of planes by the bound of an outline's score
        # there.
        self._queue: list[tuple[float, int, Candidate | int]] = []

    def _beside(self, plane: PlaneHypothesis) -> NDArray[np.bool_]:
        lines = self._cloud.segments[plane.lines]
        return find_surface_beside(self._photos, plane.normal, lines, self._pixel)

    def add_texture_planes(self, patches: Sequence[TexturePlane], texture: TexturePoints) -> None:
        """Search the planes of texture points, too."""
        self._planes = list(add_texture_patches(self._planes, patches, texture, self._cloud))

    def run(self) -> tuple[tuple[SelectedFace, ...], tuple[NDArray[np.uint8], ...]]:
        for plane, chosen in enumerate(self._planes):
            self._push(chosen.bound - LEAST_PENALTY, plane)
        searched: dict[tuple[int, float], int] = {}
        while self._queue:
            score, _, best = heapq.heappop(self._queue)
            if isinstance(best, int):
                self._look_over(best)
                for side in (1.0, -1.0):
                    searched[best, side] = len(self._faces)
                continue
            if any(self._contradicts(best, f) for f in self._faces[best.after :]):
                continue
            if any(_alike(best, other) for other in self._seen_through):
                continue
            if best.after == len(self._faces):
                # The plainest form may leave out a side that a face needs.
                best = self._without_spurs(best)
                forms = (self._plain(best), best)
                plain = next((form for form in forms if self._is_face(form)), None)
                if plain is not None and not self._accepted(plain):
                    self._seen_through.append(plain)
                    rest = self._trimmed(plain)
                    if rest is not None and self._is_face(rest):
                        self._accepted(rest)
                continue
            again = self._judged(best.corners, best.normal, best.plane, moved=best.moved)
            if again is not None and again.score >= -KEPT_SCORE * score:
                self._push(again.score, again)
                continue
            plane = best.plane
            side = float(np.sign(best.normal @ self._planes[plane].plane.normal))
            # A plane that is still in the queue is searched when its turn comes.
            if searched.get((plane, side), len(self._faces)) < len(self._faces):
                searched[plane, side] = len(self._faces)
                self._search(plane, side)
        return tuple(self._faces), tuple(self._taken)

    def _look_over(self, plane: int) -> None:
        hypothesis = self._planes[plane].plane
        # Texture divides a face into regions; its own lines go all the way round.
        for outline in find_outlines(hypothesis, self._cloud, self._profiles):
            for normal in (outline.normal, -outline.normal):
                corners = _counter_clockwise(outline.corners, normal)
                self._propose(corners, normal, plane, moved=False)
        self._complete(plane)
        for side in self._planes[plane].sides:
            self._search(plane, side)

    def _complete(self, plane: int, new: FloatArray | None = None) -> None:
        # Two or three sides that meet propose the others, where the pictures show them best; if a
        # side (2, 3) is `new`, those that it is a side of.
        hypothesis = self._planes[plane].plane
        near = ON_PLANE_PX * self._pixel
        known = [self._extents[hypothesis.lines]]
        for face in self._faces:
            sides = make_ring_sides(face.corners)
            off = np.abs(sides @ hypothesis.normal - hypothesis.distance)
            known.append(sides[(off < near).all(axis=1)])
        for ring in parallelograms(np.concatenate(known), hypothesis, self._pixel):
            middles = (ring + np.roll(ring, -1, axis=0)) / 2
            if new is None or find_points_on_segments(middles, new[None], near).any():
                self._propose_rough(ring, hypothesis.normal, plane)

    def _propose_moved(self, corners: FloatArray, normal: FloatArray, plane: int) -> None:
        views = self._photos.facing(corners.mean(axis=0), normal)
        moved = self._sides.snap_to_edges(views, corners, normal, self._pixel)
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
        corners = tidy(corners, normal, self._pixel)
        found = self._judged(corners, normal, plane, moved=moved)
        if found is not None and not any(self._contradicts(found, f) for f in self._faces):
            self._push(found.score, found)

    def _push(self, score: float, what: "Candidate | int") -> None:
        # Faces of a ring with equal scores up to rounding come in the given order.
        heapq.heappush(self._queue, (-round(score, 6), next(self._number), what))

    def _judged(
        self, corners: FloatArray, normal: FloatArray, plane: int, *, moved: bool
    ) -> Candidate | None:
        size = np.sqrt(shapely.Polygon(corners @ plane_basis(normal)).area)
        if size < MIN_SIZE_PX * self._pixel:
            return None
        e = self._judge.judge(
            corners, normal, self._taken, penalty(corners, moved=moved), self._joins
        )
        if e is None:
            return None
        candidate = Candidate(corners, normal, e, plane, moved, len(self._faces))
        return candidate if candidate.score > 0 else None

    def _joins(self, points: FloatArray, normal: FloatArray) -> NDArray[np.bool_]:
        sides = joined_sides(normal, self._faces)
        return find_points_on_segments(points, sides, ON_PLANE_PX * self._pixel)

    def _list_known_normals(self, candidate: Candidate) -> list[FloatArray]:
        # Of the ground and the faces that it touches.
        near = TOUCH_PX * self._pixel
        known = [] if self._ground is None else [self._ground.normal]
        return known + [f.normal for f in self._faces if touch(candidate.corners, f.corners, near)]

    def _without_spurs(self, candidate: Candidate) -> Candidate:
        # Without what is ground, if that is a face.
        corners, normal, shown = candidate.corners, candidate.normal, candidate.evidence.shown
        seen = self._taken, self._photos, self._ground, self._pixel
        ring = remove_spurs(corners, normal, shown, *seen)
        if ring is corners:
            return candidate
        return self._instead(tidy(ring, normal, self._pixel), candidate) or candidate

    def _plain(self, best: Candidate) -> Candidate:
        # In the plainest form, square to what is known.
        queued = (c for _, _, c in sorted(self._queue, key=lambda entry: entry[:2]))
        others = [c for c in queued if isinstance(c, Candidate)]
        plain = simplest(best, others, self._cloud.pixel, self._instead)
        return square(
            plain,
            self._list_known_normals(plain),
            self._planes[plain.plane].plane,
            self._cloud,
            self._photos,
            self._sides,
            self._instead,
        )

    def _instead(self, corners: FloatArray, candidate: Candidate) -> Candidate | None:
        return self._judged(corners, candidate.normal, candidate.plane, moved=candidate.moved)

    def _is_face(self, candidate: Candidate) -> bool:
        # Most of its sides are found, and the ground does not explain its pixels better.
        e = candidate.evidence
        return e.coverage >= MIN_FINAL and not self._judge.shows_ground(
            candidate.corners, candidate.normal, e, self._taken
        )

    def _trimmed(self, candidate: Candidate) -> Candidate | None:
        # What is left of a face that is seen through, without its openings.
        ring = self._holes.trimmed(
            candidate.corners, self._flat(candidate), candidate.evidence.shown, self._taken
        )
        if ring is None:
            return None
        rest = self._instead(tidy(ring, candidate.normal, self._pixel), candidate)
        return None if rest is None else replace(rest, square=candidate.square)

    def _flat(self, candidate: Candidate) -> PlaneHypothesis:
        # Its plane, which may have been rotated since its lines proposed it.
        normal, lines = candidate.normal, self._planes[candidate.plane].plane.lines
        return PlaneHypothesis(normal, float(normal @ candidate.corners[0]), lines)

    def _accepted(self, candidate: Candidate) -> bool:
        # Not if one sees lines through it beside its holes.
        e = candidate.evidence
        corners, normal = candidate.corners, candidate.normal
        flat = self._flat(candidate)
        holes = self._holes.holes(corners, flat, e.shown, self._taken)
        if self._behind.seen_through(corners, normal, np.nonzero(e.shown)[0], holes):
            return False
        known = self._planes[candidate.plane].plane
        slope = SQUARE_SLOPE if candidate.square else OPEN_SLOPE
        rings = np.concatenate([corners, *holes])
        cov = plane_cov(known, self._cloud, rings, slope)
        seen = e.points[~find_points_within(holes, normal, e.points)]
        face = SelectedFace(corners, normal, e.shown, e.coverage, seen, cov, holes)
        self._faces.append(face)
        take_pixels(self._taken, self._views, e.shown, (corners, *holes))
        self._propose_neighbours(face, candidate.score)
        return True

    def _propose_neighbours(self, face: SelectedFace, score: float) -> None:
        # Most things have right angles: a plane through each side across the face, also of holes.
        for side in face.long_sides:
            reach = float(np.linalg.norm(side[1] - side[0]))
            normal = np.cross(face.normal, (side[1] - side[0]) / reach)
            distance = float(normal @ side.mean(axis=0))
            away = np.abs(self._cloud.segments @ normal - distance).max(axis=1)
            plane = PlaneHypothesis(
                normal, distance, np.nonzero(away < ON_PLANE_PX * self._pixel)[0]
            )
            same = find_same_planes(plane, side, [p.plane for p in self._planes], self._pixel)
            number = int(same.argmax()) if same.any() else len(self._planes)
            if number == len(self._planes):
                across = np.array([-0.5, 0.5])[:, None, None] * reach * face.normal
                self._planes.append(ChosenPlane(plane, score, (1.0, -1.0), side + across))
                self._push(score, number)
            else:
                self._complete(number, side)
            self._propose_down(side, number)

    def _propose_down(self, side: FloatArray, number: int) -> None:
        # What is bounded above often stands on the ground.
        normal = self._planes[number].plane.normal
        if self._ground is not None:
            ring = self._ground.extend_to_ground(side, normal)
            if len(ring):
                self._propose_rough(ring, normal, number)

    def _propose_rough(self, ring: FloatArray, normal: FloatArray, plane: int) -> None:
        for outwards in (normal, -normal):
            corners = _counter_clockwise(ring, outwards)
            if self._judge.is_surface_inside(corners, outwards, self._taken):
                self._propose_moved(corners, outwards, plane)

    def _contradicts(self, candidate: Candidate, face: SelectedFace) -> bool:
        # They overlap in one plane, where holes are no surface either, and are not a board's two
        # sides; or the candidate hides the face from views that show it.
        corners, normal = candidate.corners, candidate.normal
        near, known = SAME_PLANE_PX * self._pixel, ON_PLANE_PX * self._pixel
        two = corners, normal, face.corners, face.normal
        if overlap(*two, near) and not back_to_back(*two, known):
            return True
        centres, free = self._photos.centres[face.shown], FREE_PX * self._pixel
        hides = blocked(corners, normal, face.seen, centres, free)
        return bool(hides.sum() > MAX_BLOCKED * hides.size)


def _alike(one: Candidate, other: Candidate) -> bool:
    if one.plane != other.plane or one.normal @ other.normal <= 0:
        return False
    return alike(one.corners, other.corners, one.normal)


def _counter_clockwise(corners: FloatArray, normal: FloatArray) -> FloatArray:
    return corners if compute_vector_area(corners) @ normal > 0 else corners[::-1].copy()


# Pixels at a face's rim belong to its neighbours too: half this width, px. A gap between two faces
# belongs to both.
RIM, BETWEEN = np.ones((5, 5), dtype=np.uint8), np.ones((7, 7), dtype=np.uint8)


def take_pixels(
    taken: list[NDArray[np.uint8]],
    views: Sequence[View],
    shown: NDArray[np.bool_],
    rings: Sequence[FloatArray],
) -> None:
    """Add to `taken`, of each view its pixels (H, W), 1 where they are explained, those within the
    outline of a face and outside of its holes (`rings`, the outline first), in the views (V,) that
    are `shown` to show it.
    """
    for k in np.nonzero(shown)[0].tolist():
        drawn = [project_points(views[k].projection, ring) for ring in rings]
        if all((depth > 0).all() for _, depth in drawn):
            filled = np.zeros_like(taken[k])
            cv2.fillPoly(filled, [np.rint(uv).astype(np.int32) for uv, _ in drawn], 1)
            more = cv2.bitwise_or(taken[k], cv2.erode(filled, RIM))
            taken[k] = np.asarray(cv2.morphologyEx(more, cv2.MORPH_CLOSE, BETWEEN), dtype=np.uint8)
