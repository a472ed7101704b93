"""Flat regions and the rest of a surface, of meshes and clouds alike."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import shapely

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.polygons import make_polygon
from facetlog.perception.scene import Plane
from facetlog.perception.types import FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class PlaneFrame:
    """Coordinates in a plane: x = (p - origin) · axes[0], y = (p - origin) · axes[1]."""

    origin: FloatArray
    axes: FloatArray

    def flatten(self, points: FloatArray) -> FloatArray:
        """Return coordinates (..., 2) of points (..., 3)."""
        flat: FloatArray = (points - self.origin) @ self.axes.T
        return flat

    def lift(self, flat: FloatArray) -> FloatArray:
        """Return the points (n, 3) at coordinates (n, 2)."""
        lifted: FloatArray = self.origin + flat @ self.axes
        return lifted

    def polygon(self, outline: FloatArray, holes: Iterable[FloatArray]) -> shapely.Polygon:
        """Return the polygon of loops (k, 3)."""
        return make_polygon(self.flatten(outline), [self.flatten(hole) for hole in holes])

    def lift_rings(
        self, polygon: shapely.Polygon, plane: Plane
    ) -> tuple[FloatArray, tuple[FloatArray, ...]]:
        """Return the outline (k, 3) and the holes of a polygon, moved onto a plane."""

        def onto(ring: shapely.LinearRing) -> FloatArray:
            where = self.lift(shapely.get_coordinates(ring)[:-1])
            moved: FloatArray = where - np.outer(plane.distance(where), plane.normal)
            return moved

        return onto(polygon.exterior), tuple(map(onto, polygon.interiors))


@dataclass(frozen=True, eq=False, slots=True)
class FlatRegion:
    """A connected flat piece of surface, of a mesh or a cloud.

    `outline` (k, 3) and `holes` are loops in the plane, without the first point repeated: the
    outline counter-clockwise seen from outside (against the normal), holes clockwise. `plane` has
    the covariance of its fit. `corner_sd` is the standard deviation of a corner, in the unit of
    length. `body` numbers the object that the region is of; -1: none, as a floor is. `noise` is the
    sd of a cloud's points off the region.
    """

    plane: Plane
    outline: FloatArray
    holes: tuple[FloatArray, ...] = ()
    corner_sd: float = 0.0
    body: int = 0
    noise: float = 0.0

    @property
    def frame(self) -> PlaneFrame:
        """Coordinates from its first corner, along its first side."""
        start = self.outline[0]
        return PlaneFrame(start, make_plane_axes(self.plane.normal, self.outline[1] - start))

    def flipped(self) -> "FlatRegion":
        """Return the region seen from behind."""
        return replace(
            self,
            plane=self.plane.flipped(),
            outline=self.outline[::-1],
            holes=tuple(hole[::-1] for hole in self.holes),
        )


@dataclass(frozen=True, eq=False, slots=True)
class Rest:
    """Surface that is in no flat region: points (n, 3), outward normals (n, 3) or zeros, areas.

    `bodies` (n,) numbers the object that each point is of; -1: none. A point of no area is near a
    face, and may close a gap beside it, but does not say how far the object reaches.
    """

    points: FloatArray
    normals: FloatArray
    areas: FloatArray
    bodies: FloatArray
