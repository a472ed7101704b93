"""Flat regions and the rest of a surface, of meshes and clouds alike."""

from dataclasses import dataclass, replace

from facetlog.perception.scene import Plane
from facetlog.perception.types import FloatArray


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
