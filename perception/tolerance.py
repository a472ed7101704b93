""" "Within 3 sd": how far apart two places may be and still count as one, for one scene."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from facetlog.perception.types import FloatArray, Scene

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
        """The scene's tolerance, its bounds in proportion to the diagonal of its vertices."""
        if not scene.vertices:
            return cls(np.zeros(0), 0.0, 0.0)
        covs = np.array([v.cov for v in scene.vertices])
        sds = np.sqrt(np.maximum(np.linalg.eigvalsh(covs)[:, -1], 0.0))
        diagonal = float(np.linalg.norm(np.ptp(scene.points, axis=0)))
        return cls(sds, LENGTH_RESOLUTION * diagonal, WIDEST * diagonal)

    def within(self, sds: ArrayLike) -> FloatArray:
        """Three of each sd, not below rounding and not above the widest.

        >>> Tolerance(np.zeros(0), 0.001, 0.02).within([0.0, 0.002, 5.0])
        array([0.001, 0.007, 0.02 ])
        """
        return np.minimum(SDS * np.asarray(sds) + self.finest, self.widest)

    def highest(self, vertices: NDArray[np.intp], reach: FloatArray) -> NDArray[np.intp]:
        """Positions among `vertices` of the one with the highest reach, and of its equals.

        Equal are those within 3 sd. The mean of equals is the better estimate of an extreme: the
        highest alone is high by its noise, and which one it is depends on rounding.
        """
        top = int(np.argmax(reach))
        sds = self.vertex_sds[vertices]
        equal: NDArray[np.intp] = np.flatnonzero(
            reach >= reach[top] - self.within(np.hypot(sds, sds[top]))
        )
        return equal
