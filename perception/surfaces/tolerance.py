""" "Within 3 sd": how far apart two places may be and still count as one, for scenes of a block."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import ArrayLike, NDArray

from facetlog.perception.ragged import Indices, find_row_starts
from facetlog.perception.scene import Body, Scene
from facetlog.perception.types import FloatArray

__all__ = ["ANGLE_RESOLUTION", "SDS", "Tolerance", "Tolerances"]

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
    """Worst 1σ of every vertex (n,) of a scene, and the bounds of a tolerance, in its unit."""

    vertex_sds: FloatArray
    finest: float
    widest: float

    def within(self, sds: ArrayLike) -> FloatArray:
        """Return the tolerance: three of each sd, not below rounding and not above the widest.

        >>> Tolerance(np.zeros(0), 0.001, 0.02).within([0.0, 0.002, 5.0])
        array([0.001, 0.007, 0.02 ])
        """
        return np.minimum(SDS * np.asarray(sds) + self.finest, self.widest)


@dataclass(frozen=True, eq=False, slots=True)
class Tolerances:
    """Tolerances of the scenes (s,) of a block; vertex (n,) is of the scene `scene` (n,)."""

    vertex_sds: FloatArray
    scene: Indices
    finest: FloatArray
    widest: FloatArray

    @classmethod
    def of_scenes(
        cls, scenes: Sequence[Scene], points: FloatArray, covs: FloatArray
    ) -> "Tolerances":
        """Return those of the vertices of scenes (s,), all their points (n, 3) and covariances (n,
        3, 3), in proportion to the diagonal of each scene's largest object, or of all where none is
        known.
        """
        sds = np.sqrt(np.maximum(np.linalg.eigvalsh(covs)[:, -1], 0.0))
        counts = np.array([len(scene.vertices) for scene in scenes], dtype=np.intp)
        diagonals = np.zeros(len(scenes))
        for nth, (scene, first) in enumerate(
            zip(scenes, find_row_starts(counts).tolist(), strict=True)
        ):
            own = points[first : first + int(counts[nth])]
            for part in [own[_find_body_vertices(scene, body)] for body in scene.bodies] or [own]:
                if len(part):
                    diagonals[nth] = max(diagonals[nth], np.linalg.norm(np.ptp(part, axis=0)))
        scene_of = np.repeat(np.arange(len(counts)), counts)
        return cls(sds, scene_of, LENGTH_RESOLUTION * diagonals, WIDEST * diagonals)

    def of_scene(self, scene: int) -> Tolerance:
        """Return the tolerance of one of the scenes."""
        sds = self.vertex_sds[self.scene == scene]
        return Tolerance(sds, float(self.finest[scene]), float(self.widest[scene]))

    def within(self, sds: FloatArray, scenes: Indices) -> FloatArray:
        """Return the tolerance: three of each sd (...), not below rounding and not above the widest
        of `scenes` (...).
        """
        found: FloatArray = np.minimum(SDS * sds + self.finest[scenes], self.widest[scenes])
        return found

    def highest(self, vertices: NDArray[np.intp], reach: FloatArray) -> NDArray[np.bool_]:
        """Return which of the vertices (r, k) of each row have its highest reach (r, k), within 3
        sd.

        The mean of equals is the better estimate of an extreme: the highest alone is high by its
        noise, and which one it is depends on rounding. A reach of -inf is left out.
        """
        rows, top = np.arange(len(reach)), reach.argmax(axis=1)
        sds = self.vertex_sds[vertices]
        scenes = self.scene[vertices[:, :1]]
        limit = self.within(np.hypot(sds, sds[rows, top, None]), scenes)
        equal = reach >= reach[rows, top, None] - limit
        return np.asarray(equal & (reach > -np.inf))


def _find_body_vertices(scene: Scene, body: Body) -> list[int]:
    """Return the vertices that a body's faces and patches reach to."""
    rings = [scene.faces[i].outline for i in body.faces]
    return list(chain(*rings, *(scene.patches[i].hull for i in body.patches)))
