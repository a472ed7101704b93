"""How views look at the faces of a scene: which points of each are seen, hidden, and by what.

A face is a lattice of points in its plane. Which views see each is asked point by point.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.photometric_views import (
    MIN_FACING_SINE,
    PhotometricViews,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.flat_faces import clip_polygon_above, make_plane_axes
from facetlog.perception.polygons import make_polygon
from facetlog.perception.scene import Face, FaceSight, Scene, SeenLattice
from facetlog.perception.stable_order import largest
from facetlog.perception.types import FloatArray, View

# Points of all lattices together: on a thing of six equal sides they are 1/37 of a side apart, as
# far as the cells of its space about are, so that views that see a face pass most cells before it.
MOST_POINTS = 8_000
# The lattice of a face that is small beside the others has about so many points.
LEAST_POINTS = 60
# So many views of a face are kept, evenly from all that show it: more pass the same cells.
MOST_VIEWS = 32
# Cells across a picture, as many a length downwards: to what is neither face nor ground goes one
# line of sight in each at most, some ten for each side of a thing that fills a quarter of it.
ACROSS = 40
# A surface this much nearer than another, in lengths of a pixel there, is before it: a corner is
# known to about one.
BEFORE_PX = 3.0
# A face that reaches past the camera is looked at from this share of its reach on.
NEAREST = 1e-3
# A face hides so much of another, or it is a pixel at the rim of a neighbour.
LEAST_HIDDEN = 1.0 / 60.0


@dataclass(frozen=True, eq=False, slots=True)
class Surface:
    """A face of the scene: corners of its rings (k, 3), and a lattice in its plane, of which
    `inside` (rows, columns) are the points on the face.

    Point (i, j) is at `corner` (3,) + i `steps`[0] + j `steps`[1], steps (2, 3).
    """

    face: Face
    rings: tuple[FloatArray, ...]
    corner: FloatArray
    steps: FloatArray
    inside: NDArray[np.bool_]

    @classmethod
    def of(cls, face: Face, rings: tuple[FloatArray, ...], pitch: float) -> "Surface":
        """Return the face with these rings, the outline first, and points so far apart at most."""
        basis, polygon = _lay_face_flat(face, rings)
        if not polygon.area > 0:
            return cls(face, rings, rings[0][0], np.zeros((2, 3)), np.zeros((0, 0), np.bool_))
        low, high = np.array(polygon.bounds).reshape(2, 2)
        sides = high - low
        pitch = min(pitch, float(np.sqrt(sides.prod() / LEAST_POINTS)))
        columns, rows = np.maximum(np.ceil(sides / pitch), 1).astype(int).tolist()
        step = sides / [columns, rows]
        normal = face.plane.normal
        corner = basis @ (low + step / 2) + normal * float(normal @ rings[0].mean(axis=0))
        x = low[0] + (np.arange(columns) + 0.5) * step[0]
        y = low[1] + (np.arange(rows) + 0.5) * step[1]
        inside = shapely.contains_xy(polygon, *np.meshgrid(x, y))
        return cls(face, rings, corner, step[::-1, None] * basis.T[::-1], inside)

    @property
    def points(self) -> FloatArray:
        """The points on the face (n, 3)."""
        found: FloatArray = self.corner + np.argwhere(self.inside) @ self.steps
        return found

    def seen(self, origins: FloatArray, shown: NDArray[np.bool_]) -> SeenLattice | None:
        """Return what views with their centres at origins (V, 3) see of the points, `shown` (V,
        n).
        """
        views = np.flatnonzero(shown.any(axis=1))
        if not len(views):
            return None
        count = min(len(views), MOST_VIEWS)
        views = views[np.linspace(0, len(views) - 1, count).round().astype(np.intp)]
        bits = np.zeros((len(views), *self.inside.shape), dtype=np.bool_)
        bits[:, self.inside] = shown[views]
        named = tuple(views.tolist())
        return SeenLattice(self.corner, self.steps, origins[views], bits, named, ground=False)


def make_surfaces(scene: Scene) -> list[Surface]:
    """Return the faces of the scene, their points about equally dense but on small ones."""
    rings = [
        tuple(scene.points[list(ring)] for ring in (face.outline, *face.holes))
        for face in scene.faces
    ]
    boxes = 0.0
    for face, own in zip(scene.faces, rings, strict=True):
        _, polygon = _lay_face_flat(face, own)
        if polygon.area > 0:
            x, y, right, top = polygon.bounds
            boxes += (right - x) * (top - y)
    pitch = float(np.sqrt(boxes / MOST_POINTS))
    return [Surface.of(face, own, pitch) for face, own in zip(scene.faces, rings, strict=True)]


def _lay_face_flat(face: Face, rings: Sequence[FloatArray]) -> tuple[FloatArray, shapely.Geometry]:
    # Axes (3, 2) in the face's plane, and the face along them. The first is that of its longest
    # side: independent of the world frame.
    along = np.roll(rings[0], -1, axis=0) - rings[0]
    longest = along[largest(np.linalg.norm(along, axis=1))]
    basis = make_plane_axes(face.plane.normal, longest).T
    flat = [ring @ basis for ring in rings]
    return basis, make_polygon(flat[0], flat[1:])


class Eye:
    """A view before the faces of a scene."""

    def __init__(self, view: View, surfaces: Sequence[Surface]) -> None:
        self.view = view
        self.centre = view.pose.centre
        self.size = np.array(view.image.shape[::-1])
        self._surfaces = surfaces
        self._masks = [self._drawn(surface) for surface in surfaces]

    def rays(self, uv: FloatArray) -> FloatArray:
        """Return rays (n, 3) through pixels (n, 2), as long as to reach one unit forward."""
        camera = self.view.camera
        x, y = ((uv - [camera.cx, camera.cy]) / [camera.fx, camera.fy]).T
        rays: FloatArray = np.stack([x, y, np.ones(len(uv))], axis=1) @ self.view.pose.rotation.T
        return rays

    def depths(self, uv: FloatArray) -> FloatArray:
        """Return how far forward each face (F, n) lies on the rays of pixels (n, 2) in the
        picture.
        """
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
        """Return which points (n, 3) lie in the picture and no face lies before."""
        uv, depth = project_points(self.view.projection, points)
        seen = np.logical_and(depth > 0, in_picture(uv, self.size))
        nearest = self.depths(uv[seen]).min(axis=0, initial=np.inf)
        seen[seen] = nearest > depth[seen] - BEFORE_PX * self.pixel(depth[seen])
        return seen

    def pixel(self, depth: FloatArray) -> FloatArray:
        """Return the length of a pixel so far forward."""
        return depth / self.view.camera.fx

    def _drawn(self, surface: Surface) -> NDArray[np.uint8]:
        mask = np.zeros(self.view.image.shape, dtype=np.uint8)
        forward = self.view.pose.rotation[:, 2]
        loops = []
        for ring in surface.rings:
            ahead = (ring - self.centre) @ forward
            before = clip_polygon_above(ring, ahead - NEAREST * np.abs(ahead).max())
            if len(before) >= 3:
                uv, _ = project_points(self.view.projection, before)
                loops.append(np.rint(uv).astype(np.int32))
        if loops:
            cv2.fillPoly(mask, loops, 1)
        return mask


def choose_points_without_ends(view: View, ends: FloatArray, points: FloatArray) -> FloatArray:
    """Choose, of points (n, 3) that a view sees, one in each cell of its picture without an end (m,
    3).
    """
    cells, first = np.unique(_cells(view, points), return_index=True)
    chosen: FloatArray = points[np.sort(first[~np.isin(cells, _cells(view, ends))])]
    return chosen


def _cells(view: View, points: FloatArray) -> NDArray[np.intp]:
    # Which cells (n,) of the picture points before the view lie in.
    uv, _ = project_points(view.projection, points)
    column, row = np.floor((uv + 0.5) * ACROSS / view.camera.width).astype(np.intp).T
    return np.asarray(row * ACROSS + column)


def in_picture(uv: FloatArray, size: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Return which pixels (..., 2) are inside the border of a picture of that width and height
    (2,).

    By a pixel, where rounding stays in the picture.
    """
    return np.asarray(((uv > 1) & (uv < size - 2)).all(axis=-1), dtype=np.bool_)


@dataclass(frozen=True, eq=False, slots=True)
class Look:
    """How the views look at a face: which are `before` it (V,), and of each point (V, n) whether it
    is `inside` the picture, and which face is its `hider`, -1 for none.
    """

    surface: Surface
    points: FloatArray
    before: NDArray[np.bool_]
    inside: NDArray[np.bool_]
    hider: NDArray[np.intp]

    @classmethod
    def at(cls, surface: Surface, views: int) -> "Look":
        """Return the look at a face before any view looked."""
        points = surface.points
        rows = views, len(points)
        before, inside = np.zeros(views, dtype=np.bool_), np.zeros(rows, dtype=np.bool_)
        return cls(surface, points, before, inside, np.full(rows, -1))

    def through(self, view: int, eye: Eye, number: int) -> None:
        """Look by one view at the face, which has this number among all."""
        points = self.points
        if not len(points):
            return
        away = eye.centre - points.mean(axis=0)
        height = float(away @ self.surface.face.plane.normal)
        self.before[view] = height > MIN_FACING_SINE * float(np.linalg.norm(away))
        uv, depth = project_points(eye.view.projection, points)
        self.inside[view] = np.logical_and(depth > 0, in_picture(uv, eye.size))
        if not self.before[view]:
            return
        on = np.nonzero(self.inside[view])[0]
        others = eye.depths(uv[on])
        others[number] = np.inf
        limit = depth[on] - BEFORE_PX * eye.pixel(depth[on])
        self.hider[view, on] = np.where(others.min(axis=0) < limit, others.argmin(axis=0), -1)

    def _hidden(self, view: int) -> tuple[tuple[int, float], ...]:
        # By which faces it is hidden from a view, each with its share.
        hider = self.hider[view]
        shares = ((by, float((hider == by).mean())) for by in np.unique(hider[hider >= 0]).tolist())
        return tuple((by, share) for by, share in shares if share >= LEAST_HIDDEN)

    def shown(self, photos: PhotometricViews) -> NDArray[np.bool_]:
        """Return which views show which points of the face (V, n), as others do."""
        clear = self.before[:, None] & self.inside & (self.hider < 0)
        found, _ = photos.agree(np.arange(len(clear)), self.points, clear=clear)
        return found.agrees & (found.ratio > 0)

    def face(self, shown: NDArray[np.bool_]) -> Face:
        """Return the face with what each view before it shows of it, of which points (V, n) are
        shown.
        """
        face = self.surface.face
        if not len(self.points):
            return face
        sights = tuple(
            FaceSight(
                k,
                float(shown[k].mean()),
                self._hidden(k),
                float(1.0 - self.inside[k].mean()),
            )
            for k in np.nonzero(self.before)[0].tolist()
        )
        return replace(face, coverage=float(shown.any(axis=0).mean()), sights=sights)
