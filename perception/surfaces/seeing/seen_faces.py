"""Faces as lattices of points in their planes: which views see each is asked point by point."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.polygons import make_polygon
from facetlog.perception.scene import Face, Scene, SeenLattice
from facetlog.perception.stable_order import largest
from facetlog.perception.types import FloatArray

__all__ = ["Surface", "surfaces_of"]

# Points of all lattices together: on a thing of six equal sides they are 1/37 of a side apart, as
# far as the cells of its space about are, so that views that see a face pass most cells before it.
MOST_POINTS = 8_000
# The lattice of a face that is small beside the others has about so many points.
LEAST_POINTS = 60
# So many views of a face are kept, evenly from all that show it: more pass the same cells.
MOST_VIEWS = 32


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
        """The face with these rings, the outline first, and points so far apart at most."""
        basis, polygon = _laid_flat(face, rings)
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
        """What views with their centres at origins (V, 3) see of the points, `shown` (V, n)."""
        views = np.flatnonzero(shown.any(axis=1))
        if not len(views):
            return None
        count = min(len(views), MOST_VIEWS)
        views = views[np.linspace(0, len(views) - 1, count).round().astype(np.intp)]
        bits = np.zeros((len(views), *self.inside.shape), dtype=np.bool_)
        bits[:, self.inside] = shown[views]
        named = tuple(views.tolist())
        return SeenLattice(self.corner, self.steps, origins[views], bits, named, ground=False)


def surfaces_of(scene: Scene) -> list[Surface]:
    """The faces of the scene, their points about equally dense but on small ones."""
    rings = [
        tuple(scene.points[list(ring)] for ring in (face.outline, *face.holes))
        for face in scene.faces
    ]
    boxes = 0.0
    for face, own in zip(scene.faces, rings, strict=True):
        _, polygon = _laid_flat(face, own)
        if polygon.area > 0:
            x, y, right, top = polygon.bounds
            boxes += (right - x) * (top - y)
    pitch = float(np.sqrt(boxes / MOST_POINTS))
    return [Surface.of(face, own, pitch) for face, own in zip(scene.faces, rings, strict=True)]


def _laid_flat(face: Face, rings: Sequence[FloatArray]) -> tuple[FloatArray, shapely.Geometry]:
    # Axes (3, 2) in the face's plane, and the face along them. The first is that of its longest
    # side: independent of the world frame.
    along = np.roll(rings[0], -1, axis=0) - rings[0]
    longest = along[largest(np.linalg.norm(along, axis=1))]
    basis = plane_axes(face.plane.normal, longest).T
    flat = [ring @ basis for ring in rings]
    return basis, make_polygon(flat[0], flat[1:])
