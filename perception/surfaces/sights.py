"""What each view saw: of every face how much, hidden by which, and how far it looked.

A line of sight ends where a picture agrees with the others on the surface that it meets first: a
face of the scene, or the ground; and on the edges that a view shows, of whatever they are. What was
seen from somewhere has nothing before it; a later step decides from that which space is free.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.detection.gradients import gradient
from facetlog.perception.detection.line_front_end.evidence.face_evidence import inner_points
from facetlog.perception.detection.line_front_end.evidence.photo_consistency import GreyLevels
from facetlog.perception.detection.line_front_end.evidence.photometric_views import (
    MIN_FACING_SINE,
    PhotometricViews,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.detection.tracked_faces import Landmarks
from facetlog.perception.flat_faces import part_above, plane_axes
from facetlog.perception.scene import Face, FaceSight, Scene, SightLines
from facetlog.perception.types import FloatArray, View

__all__ = ["with_sights"]

# Lines of sight across a picture, as many a length downwards: some ten for each side of a thing
# that fills a quarter of it.
ACROSS = 40
# Views that are asked whether they agree with one: the time grows with their number.
WITNESSES = 24
# A surface this much nearer than another, in lengths of a pixel there, is before it: a corner is
# known to about one.
BEFORE_PX = 3.0
# Nearer to the ground's horizon than this, px, nothing ends on it: one px is a tenth of the way
# there, and all of it where the ground was found a little tilted.
HORIZON_PX = 10.0
# A face that reaches past the camera is looked at from this share of its reach on.
NEAREST = 1e-3


@dataclass(frozen=True, eq=False, slots=True)
class _Surface:
    # A face of the scene: corners of its rings (k, 3), and points (n, 3) spread over it.
    face: Face
    rings: tuple[FloatArray, ...]
    points: FloatArray


def with_sights(
    scene: Scene,
    views: Sequence[View],
    weight: Sequence[float],
    ground: tuple[FloatArray, float] | None,
    landmarks: Landmarks | None = None,
) -> Scene:
    """The scene with what each of its views saw of the faces, and with its lines of sight.

    `views` are those of the scene, at the poses at which it was found, each with its `weight`
    beside views almost like it. `ground` and `landmarks` as in `TrackedFaces`.
    """
    surfaces = [_surface(face, scene.points) for face in scene.faces]
    levels = GreyLevels(views, [gradient(view.image) for view in views])
    photos = PhotometricViews(views, levels, np.array(weight))
    looks = [_Look.at(surface, len(views)) for surface in surfaces]
    observed: list[list[FloatArray]] = [[] for _ in views]
    for vertex in scene.vertices:
        for seen in vertex.observations:
            observed[seen.view].append(vertex.point)
    lines = []
    for k, view in enumerate(views):
        # An eye holds a picture of each face: one at a time.
        eye = _Eye(view, surfaces)
        for number, look in enumerate(looks):
            look.through(k, eye, number)
        met = _first_met(eye, ground)
        corners = np.reshape(observed[k], (-1, 3))
        shown = _shown(photos, met, _asked_with(k, len(views)))[0]
        ends = np.concatenate([met[shown], corners[eye.in_sight(corners)]])
        if landmarks is not None:
            ends = np.concatenate(
                [ends, eye.where_none_ends(ends, landmarks.points[landmarks.seen[:, k]])]
            )
        if len(ends):
            lines.append(SightLines(eye.centre, ends, k))
    faces = tuple(look.face(photos) for look in looks)
    return replace(scene, faces=faces, sights=tuple(lines))


def _surface(face: Face, vertices: FloatArray) -> _Surface:
    rings = tuple(vertices[list(ring)] for ring in (face.outline, *face.holes))
    points = inner_points(rings[0], face.plane.normal)
    axes = plane_axes(face.plane.normal, rings[0][1] - rings[0][0]).T
    for hole in rings[1:]:
        inside = shapely.contains_xy(shapely.Polygon(hole @ axes), points @ axes)
        points = points[~inside]
    return _Surface(face, rings, points)


def _shown(
    photos: PhotometricViews,
    points: FloatArray,
    views: NDArray[np.intp],
    clear: NDArray[np.bool_] | None = None,
) -> NDArray[np.bool_]:
    # Which of the views (v,) show the surface at points (n, 3): (v, n). `clear` (v, n) are those
    # that have nothing else before it, as far as is known.
    found, _ = photos.agree(views, points, clear=clear)
    return found.agrees & (found.ratio > 0)


class _Eye:
    """A view before the faces of a scene."""

    def __init__(self, view: View, surfaces: Sequence[_Surface]) -> None:
        self.view = view
        self.centre = view.pose.centre
        self.size = np.array(view.image.shape[::-1])
        self._surfaces = surfaces
        self._masks = [self._drawn(surface) for surface in surfaces]
        camera = view.camera
        self._step = step = camera.width / ACROSS
        rows = np.arange(step / 2, camera.height, step) - 0.5
        columns = np.arange(step / 2, camera.width, step) - 0.5
        self.lattice = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)

    def rays(self, uv: FloatArray) -> FloatArray:
        """Rays (n, 3) through pixels (n, 2), as long as to reach one unit forward."""
        camera = self.view.camera
        x, y = ((uv - [camera.cx, camera.cy]) / [camera.fx, camera.fy]).T
        rays: FloatArray = np.stack([x, y, np.ones(len(uv))], axis=1) @ self.view.pose.rotation.T
        return rays

    def depths(self, uv: FloatArray) -> FloatArray:
        """How far forward each face (F, n) lies on the rays of pixels (n, 2) in the picture."""
        depth = np.full((len(self._masks), len(uv)), np.inf)
        column, row = np.rint(uv).astype(np.intp).T
        rays = self.rays(uv)
        for n, (surface, mask) in enumerate(zip(self._surfaces, self._masks, strict=True)):
            on = np.nonzero(mask[row, column])[0]
            plane = surface.face.plane
            towards = rays[on] @ plane.normal
            with np.errstate(divide="ignore", invalid="ignore"):
                away = -plane.distance(self.centre) / towards
            depth[n, on] = np.where(away > 0, away, np.inf)
        return depth

    def in_sight(self, points: FloatArray) -> NDArray[np.bool_]:
        """Which points (n, 3) lie in the picture and no face lies before."""
        uv, depth = project_points(self.view.projection, points)
        seen = np.logical_and(depth > 0, _in_picture(uv, self.size))
        nearest = self.depths(uv[seen]).min(axis=0, initial=np.inf)
        seen[seen] = nearest > depth[seen] - BEFORE_PX * self.pixel(depth[seen])
        return seen

    def where_none_ends(self, ends: FloatArray, points: FloatArray) -> FloatArray:
        """Of points (n, 3) in sight one in each cell of the lattice without an end (m, 3)."""
        points = points[self.in_sight(points)]
        _, first = np.unique(self._cells(points), axis=0, return_index=True)
        points = points[np.sort(first)]
        known = set(map(tuple, self._cells(ends).tolist()))
        free = [tuple(cell) not in known for cell in self._cells(points).tolist()]
        chosen: FloatArray = points[np.array(free, dtype=np.bool_)]
        return chosen

    def _cells(self, points: FloatArray) -> NDArray[np.intp]:
        # Columns and rows (n, 2) of the lattice in which points before the view lie.
        uv, _ = project_points(self.view.projection, points)
        return np.floor((uv + 0.5) / self._step).astype(np.intp)

    def pixel(self, depth: FloatArray) -> FloatArray:
        """The length of a pixel so far forward."""
        return depth / self.view.camera.fx

    def _drawn(self, surface: _Surface) -> NDArray[np.uint8]:
        mask = np.zeros(self.view.image.shape, dtype=np.uint8)
        forward = self.view.pose.rotation[:, 2]
        loops = []
        for ring in surface.rings:
            ahead = (ring - self.centre) @ forward
            before = part_above(ring, ahead - NEAREST * np.abs(ahead).max())
            if len(before) >= 3:
                uv, _ = project_points(self.view.projection, before)
                loops.append(np.rint(uv).astype(np.int32))
        if loops:
            cv2.fillPoly(mask, loops, 1)
        return mask


def _in_picture(uv: FloatArray, size: NDArray[np.intp]) -> NDArray[np.bool_]:
    # To a pixel inside the border, where rounding stays in the picture of that width and height.
    return np.asarray(((uv > 1) & (uv < size - 2)).all(axis=-1), dtype=np.bool_)


@dataclass(frozen=True, eq=False, slots=True)
class _Look:
    """How the views look at a face: which are `before` it (V,), and of each point (V, n) whether it
    is `inside` the picture, and which face is its `hider`, -1 for none.
    """

    surface: _Surface
    before: NDArray[np.bool_]
    inside: NDArray[np.bool_]
    hider: NDArray[np.intp]

    @classmethod
    def at(cls, surface: _Surface, views: int) -> "_Look":
        """Before any view looked."""
        rows = views, len(surface.points)
        before, inside = np.zeros(views, dtype=np.bool_), np.zeros(rows, dtype=np.bool_)
        return cls(surface, before, inside, np.full(rows, -1))

    def through(self, view: int, eye: _Eye, number: int) -> None:
        """Looks by one view at the face, which has this number among all."""
        points = self.surface.points
        if not len(points):
            return
        away = eye.centre - points.mean(axis=0)
        height = float(away @ self.surface.face.plane.normal)
        self.before[view] = height > MIN_FACING_SINE * float(np.linalg.norm(away))
        uv, depth = project_points(eye.view.projection, points)
        self.inside[view] = np.logical_and(depth > 0, _in_picture(uv, eye.size))
        if not self.before[view]:
            return
        on = np.nonzero(self.inside[view])[0]
        others = eye.depths(uv[on])
        others[number] = np.inf
        limit = depth[on] - BEFORE_PX * eye.pixel(depth[on])
        self.hider[view, on] = np.where(others.min(axis=0) < limit, others.argmin(axis=0), -1)

    def face(self, photos: PhotometricViews) -> Face:
        """The face with what each view before it shows of it."""
        face, points = self.surface.face, self.surface.points
        if not len(points):
            return face
        clear = self.before[:, None] & self.inside & (self.hider < 0)
        shown = _shown(photos, points, np.arange(len(clear)), clear)
        sights = tuple(
            FaceSight(
                k,
                float(shown[k].mean()),
                tuple(
                    (by, float((self.hider[k] == by).mean()))
                    for by in np.unique(self.hider[k]).tolist()
                    if by >= 0
                ),
                float(1.0 - self.inside[k].mean()),
            )
            for k in np.nonzero(self.before)[0].tolist()
        )
        return replace(face, coverage=float(shown.any(axis=0).mean()), sights=sights)


def _asked_with(view: int, count: int) -> NDArray[np.intp]:
    # A view, and evenly among the others so many that more would hardly change anything.
    others = np.delete(np.arange(count), view)
    chosen = np.linspace(0, len(others) - 1, min(WITNESSES, len(others))).round().astype(np.intp)
    return np.concatenate([[view], others[chosen]])


def _first_met(eye: _Eye, ground: tuple[FloatArray, float] | None) -> FloatArray:
    # Where the rays of a view's lattice first meet a face or the ground (n, 3).
    rays = eye.rays(eye.lattice)
    depth = eye.depths(eye.lattice).min(axis=0, initial=np.inf)
    if ground is not None:
        normal, height = ground
        drop = rays @ normal
        with np.errstate(divide="ignore"):
            floor = (height - eye.centre @ normal) / drop
        steep = np.abs(drop) * eye.view.camera.fx > HORIZON_PX * np.linalg.norm(rays, axis=1)
        depth = np.minimum(depth, np.where((floor > 0) & steep, floor, np.inf))
    met = np.isfinite(depth)
    ends: FloatArray = eye.centre + depth[met, None] * rays[met]
    return ends
