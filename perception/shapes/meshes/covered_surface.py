"""What of a flat region is surface: not where another solid of the same object begins.

Boards that are laid together are closed sheets that touch or reach into each other. Where one
stands on another's face nobody sees that face, and the object has no surface there: a tread is as
deep as what the step above leaves of it. So each region loses the sections that other closed sheets
have just in front of its plane.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import shapely

from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.polygons import (
    find_difference,
    find_enclosed_area,
    find_union,
    make_polygon,
    make_valid,
)
from facetlog.perception.ragged import Indices, by_group
from facetlog.perception.shapes.meshes.clean_mesh import Surface, sizes_of
from facetlog.perception.shapes.regions.flat_region import FlatRegion
from facetlog.perception.types import FloatArray

__all__ = ["Solids"]

# Boards nearer than this share of the object's size touch; sections lie so far before a plane.
TOUCH_SHARE = 1e-4


@dataclass(frozen=True, eq=False, slots=True)
class Solids:
    """The closed sheets (s,) of a surface: number, object, box from `low` to `high` (s, 3), and
    which triangles are of each. `sizes` (b,) are those of all objects.
    """

    surface: Surface
    numbers: Indices
    bodies: Indices
    low: FloatArray
    high: FloatArray
    triangles: tuple[Indices, ...]
    sizes: FloatArray

    @classmethod
    def of(cls, surface: Surface, bodies: Indices) -> "Solids":
        """Of a surface whose triangles (m,) are of these objects."""
        rows = np.flatnonzero(surface.closed)
        sizes = np.zeros(int(bodies.max()) + 1)
        sizes[bodies] = sizes_of(surface.corners, bodies)
        groups = tuple(rows[own] for own in by_group(surface.sheets[rows]))
        corners = [surface.corners[own].reshape(-1, 3) for own in groups]
        first = np.array([own[0] for own in groups], dtype=np.intp)
        return cls(
            surface,
            surface.sheets[first],
            bodies[first],
            np.array([each.min(axis=0) for each in corners]).reshape(-1, 3),
            np.array([each.max(axis=0) for each in corners]).reshape(-1, 3),
            groups,
            sizes,
        )

    def uncovered(self, region: FlatRegion, own: Indices) -> Iterator[FlatRegion]:
        """What the solids of its object, but for those of the sheets `own`, leave of a region.

        The region is in the surface's frame. It may fall apart, or vanish.
        """
        normal, touch = region.plane.normal, TOUCH_SHARE * float(self.sizes[region.body])
        before = region.outline + touch * normal
        near = (self.bodies == region.body) & ~np.isin(self.numbers, own)
        near &= (self.low < before.max(axis=0)).all(axis=1)
        near &= (self.high > before.min(axis=0)).all(axis=1)
        if not near.any():
            yield region
            return
        axes = plane_axes(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
        face = make_polygon(region.outline @ axes.T, [hole @ axes.T for hole in region.holes])
        distance = float(before[0] @ normal)
        sections = [
            self._section(nth, normal, distance, axes) for nth in np.flatnonzero(near).tolist()
        ]
        left = find_difference(face, find_union(sections))
        if left.area > face.area * (1.0 - TOUCH_SHARE):
            yield region
            return
        # neither slivers nor the gaps between boards that touch are anything by themselves
        left = left.buffer(-touch, join_style="mitre").buffer(touch, join_style="mitre")
        sd = float(np.hypot(region.corner_sd, touch))
        for part in shapely.get_parts(left):
            simple = part.simplify(touch)
            if isinstance(simple, shapely.Polygon) and simple.area > 0.0:
                rings = shapely.orient_polygons(simple)
                yield replace(
                    region,
                    outline=_lifted(rings.exterior, region, axes),
                    holes=tuple(_lifted(ring, region, axes) for ring in rings.interiors),
                    corner_sd=sd,
                )

    def _section(
        self, nth: int, normal: FloatArray, distance: float, axes: FloatArray
    ) -> shapely.Geometry:
        """The section of a solid by the plane n · x = distance, in the plane's coordinates."""
        corners = self.surface.triangles[self.triangles[nth]]
        names, place = np.unique(corners, return_inverse=True)
        place = place.reshape(corners.shape)
        points = self.surface.points[names]
        heights = points @ normal - distance
        above = (heights > 0.0)[place]
        # two sides of each triangle that the plane passes through
        cut = above != np.roll(above, -1, axis=1)
        one, two = np.sort(np.stack([place[cut], np.roll(place, -1, axis=1)[cut]]), axis=0)
        # p + t (q - p), the same for both triangles at the side
        share = heights[one] / (heights[one] - heights[two])
        flat = (points[one] + share[:, None] * (points[two] - points[one])) @ axes.T
        area = find_enclosed_area(flat.reshape(-1, 2, 2))
        return shapely.Polygon() if area is None else make_valid(area)


def _lifted(ring: shapely.LinearRing, region: FlatRegion, axes: FloatArray) -> FloatArray:
    """The corners (k, 3) of a ring in the region's plane."""
    plane = region.plane
    where = shapely.get_coordinates(ring)[:-1] @ axes
    onto: FloatArray = where - np.outer(plane.distance(where), plane.normal)
    return onto
