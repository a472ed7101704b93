""" "Within 3 sd": how far apart two places may be and still count as one, for one scene."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from facetlog.perception.scene import Scene
from facetlog.perception.types import FloatArray

__all__ = ["ANGLE_RESOLUTION", "SDS", "Tolerance"]

# 99.7 % of a normal distribution.
SDS = 3.0
# Lengths below this share of the scene's diagonal are rounding of single-precision files.
LENGTH_RESOLUTION = 1e-6
# Angles below this (radians) are the same rounding over sides of 1 % of the diagonal.
ANGLE_RESOLUTION = 1e-4
# 3 sd above this share of the scene's diagonal would join everything that is near: no contact is
# stated beyond it, however vague the vertices.
WIDEST = 0.02


@dataclass(frozen=True, eq=False, slots=True)
class Tolerance:
    """Worst 1σ of every vertex (n,), and the bounds of a tolerance, all in the scene's unit."""

    vertex_sds: FloatArray
    finest: float
    widest: float

    @classmethod
    def of(cls, scene: Scene) -> "Tolerance":
        """The scene's tolerance."""
        covs = np.array([v.cov for v in scene.vertices]).reshape(-1, 3, 3)
        return cls.of_vertices(scene.points, covs)

    @classmethod
    def of_vertices(cls, points: FloatArray, covs: FloatArray) -> "Tolerance":
        """That of vertices (n, 3) with covariances (n, 3, 3), in proportion to their diagonal."""
        if not len(points):
            return cls(np.zeros(0), 0.0, 0.0)
        sds = np.sqrt(np.maximum(np.linalg.eigvalsh(covs)[:, -1], 0.0))
        diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
        return cls(sds, LENGTH_RESOLUTION * diagonal, WIDEST * diagonal)

    def within(self, sds: ArrayLike) -> FloatArray:
        """Three of each sd, not below rounding and not above the widest.

        >>> Tolerance(np.zeros(0), 0.001, 0.02).within([0.0, 0.002, 5.0])
        array([0.001, 0.007, 0.02 ])
        """
        return np.minimum(SDS * np.asarray(sds) + self.finest, self.widest)

    def highest(self, vertices: NDArray[np.intp], reach: FloatArray) -> NDArray[np.bool_]:
        """Which of the vertices (r, k) of each row have its highest reach (r, k), within 3 sd.

        The mean of equals is the better estimate of an extreme: the highest alone is high by its
        noise, and which one it is depends on rounding. A reach of -inf is left out.
        """
        rows, top = np.arange(len(reach)), reach.argmax(axis=1)
        sds = self.vertex_sds[vertices]
        limit = self.within(np.hypot(sds, sds[rows, top, None]))
        equal = reach >= reach[rows, top, None] - limit
        return np.asarray(equal & (reach > -np.inf))
