"""Many faces at once, as arrays: heights over them, feet inside them, weights of their vertices."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.flat_faces import FlatFace
from facetlog.perception.types import FloatArray

__all__ = ["Sheets"]

Indices = NDArray[np.intp]


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
    def of(cls, faces: Sequence[FlatFace], points: FloatArray) -> "Sheets":
        """The faces, in order; `points` (n, 3) are the scene's vertices."""
        longest = max((len(f.outline) for f in faces), default=0)
        loops = [points[list(f.outline)] for f in faces]
        outlines = np.zeros((len(faces), longest), dtype=np.intp)
        centres, shares = np.zeros((len(faces), 2)), np.zeros((len(faces), longest))
        levers = np.zeros((len(faces), 2, longest))
        for nth, (face, loop) in enumerate(zip(faces, loops, strict=True)):
            count = len(loop)
            flat = face.flatten(loop)
            centres[nth] = flat.mean(axis=0)
            spokes = flat - centres[nth]
            outlines[nth, :count], shares[nth, :count] = face.outline, 1.0 / count
            levers[nth, :, :count] = np.linalg.pinv(spokes.T @ spokes, hermitian=True) @ spokes.T
        return cls(
            np.array([f.normal for f in faces]).reshape(-1, 3),
            np.array([f.middle for f in faces]).reshape(-1, 3),
            np.array([f.axes for f in faces]).reshape(-1, 2, 3),
            np.array([f.polygon for f in faces], dtype=np.object_),
            np.array([loop.min(axis=0) for loop in loops]).reshape(-1, 3),
            np.array([loop.max(axis=0) for loop in loops]).reshape(-1, 3),
            outlines,
            centres,
            shares,
            levers,
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
