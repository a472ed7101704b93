"""Many faces at once, as arrays: heights over them, feet inside them, weights of their vertices."""

from dataclasses import dataclass, fields

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.ragged import Indices
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.types import FloatArray

__all__ = ["Sheets"]


@dataclass(frozen=True, eq=False, slots=True)
class Sheets:
    """Faces that have an area (f,), with outlines of k vertices at most; all in the scene's unit.

    The plane's height at x, in the plane's axes from `centres` on, is the mean of its vertices'
    heights, weighted by `shares` + x · `levers`: the least-squares plane has the weights
    1 / k + (x - m)ᵀ S⁻¹ (xi - m), with S = Σ (xi - m)(xi - m)ᵀ. Shorter outlines end in weights 0.
    """

    normals: FloatArray
    middles: FloatArray
    axes: FloatArray
    polygons: NDArray[np.object_]
    low: FloatArray
    high: FloatArray
    outlines: Indices
    centres: FloatArray
    shares: FloatArray
    levers: FloatArray

    @classmethod
    def of(cls, table: FaceTable, faces: Indices) -> "Sheets":
        """Some faces (f,) of a scene, in this order."""
        outlines, there, flat = table.outlines[faces], table.there[faces], table.flat[faces]
        loops = table.points[outlines]
        shares = there / there.sum(axis=1)[:, None]
        centres = (shares[:, None] @ flat)[:, 0]
        spokes = np.where(there[..., None], flat - centres[:, None], 0.0)
        across = spokes.transpose(0, 2, 1)
        return cls(
            table.planes.normals[faces],
            table.middles[faces],
            table.axes[faces],
            table.polygons[faces],
            loops.min(axis=1),
            loops.max(axis=1),
            np.where(there, outlines, 0),
            centres,
            shares,
            np.linalg.pinv(across @ spokes, hermitian=True) @ across,
        )

    def part(self, rows: slice) -> "Sheets":
        """Some of the faces."""
        return Sheets(*(getattr(self, field.name)[rows] for field in fields(self)))

    def heights(self, rows: Indices, where: FloatArray) -> FloatArray:
        """Heights (c,) of points (c, 3) above the planes of these faces (c,)."""
        lift: FloatArray = ((where - self.middles[rows]) * self.normals[rows]).sum(axis=1)
        return lift

    def flat(self, rows: Indices, where: FloatArray) -> FloatArray:
        """Coordinates (c, 2) of points (c, 3) in the planes of these faces (c,)."""
        spokes = (where - self.middles[rows])[:, :, None]
        coordinates: FloatArray = (self.axes[rows] @ spokes)[:, :, 0]
        return coordinates

    def inside(self, rows: Indices, where: FloatArray, slack: float) -> NDArray[np.bool_]:
        """Whether points (c, 3) are within the outlines of these faces, outside their holes."""
        dots = shapely.points(self.flat(rows, where))
        return np.asarray(shapely.distance(dots, self.polygons[rows]) <= slack, dtype=np.bool_)

    def weights(self, rows: Indices, where: FloatArray) -> FloatArray:
        """Weights (c, k) of the outlines' vertices in the planes' heights at points (c, 3)."""
        x = (self.flat(rows, where) - self.centres[rows])[:, None]
        found: FloatArray = self.shares[rows] + (x @ self.levers[rows])[:, 0]
        return found
