"""The planes of all faces of a scene as arrays: heights over them, and how sure they are."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from facetlog.perception.batch_linalg import compute_quadratic_forms, dots
from facetlog.perception.ragged import Indices, stacked
from facetlog.perception.scene import Scene
from facetlog.perception.types import FloatArray


@dataclass(frozen=True, eq=False)
class PlaneTable:
    """Unit outward normals (f, 3), offsets (f,), covariances (f, 4, 4) of the faces' planes."""

    normals: FloatArray
    offsets: FloatArray
    covs: FloatArray

    @classmethod
    def of(cls, scene: Scene) -> "PlaneTable":
        """Return the planes of the scene's faces, in order."""
        planes = [face.plane for face in scene.faces]
        return cls(
            stacked([p.normal for p in planes], 3),
            np.array([p.offset for p in planes], dtype=np.float64),
            stacked([p.cov for p in planes], 4, 4),
        )

    @property
    def normal_covs(self) -> FloatArray:
        """Covariances (f, 3, 3) of the normals."""
        return self.covs[:, :3, :3]

    def distances(self, points: FloatArray, covs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return signed distances (n, f) of points (n, 3) of covariances (n, 3, 3), and their
        1σ.
        """
        levers = np.column_stack([points, np.ones(len(points))])
        # var d = (p, 1) C (p, 1)ᵀ + nᵀ V n, both as products of flattened squares
        variance = _squares(levers) @ self.covs.reshape(-1, 16).T
        variance += covs.reshape(-1, 9) @ _squares(self.normals).T
        return points @ self.normals.T + self.offsets, np.sqrt(np.maximum(variance, 0.0))

    def heights(
        self, faces: Indices, places: Indices, points: FloatArray, covs: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return signed distances (r,) from the planes of faces (r,), and their 1σ.

        They are of `places` (r,) of points (n, 3) of covariances (n, 3, 3).
        """
        normals, levers = self.normals[faces], np.ones((len(places), 4))
        levers[:, :3] = points[places]
        variance = compute_quadratic_forms(levers, self.covs, faces)
        variance += compute_quadratic_forms(normals, covs, places)
        away = dots(levers[:, :3], normals) + self.offsets[faces]
        return away, np.sqrt(np.maximum(variance, 0.0))

    @cached_property
    def tilt_sds(self) -> FloatArray:
        """Worst 1σ tilts (f,) of the normals, in radians: largest roots of their covariances."""
        if not len(self.normals):
            return np.zeros(0)
        largest = np.linalg.eigvalsh(self.normal_covs)[:, -1]
        return np.asarray(np.sqrt(np.maximum(largest, 0.0)), dtype=np.float64)


def _squares(vectors: FloatArray) -> FloatArray:
    """Return v vᵀ (n, k²) of vectors (n, k), flattened."""
    products: FloatArray = vectors[:, :, None] * vectors[:, None]
    return products.reshape(len(vectors), vectors.shape[1] ** 2)
