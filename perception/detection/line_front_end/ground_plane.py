"""The ground: one plane below everything, which is nobody's face."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.line_cloud import LineCloud
from facetlog.perception.detection.line_front_end.plane_hypotheses import PlaneHypothesis
from facetlog.perception.flat_faces import part_above
from facetlog.perception.ties import descending
from facetlog.perception.types import FloatArray, View

__all__ = ["Ground", "find_ground"]

# A point this near to the ground, px, lies on it.
ON_GROUND_PX = 6.0
# So little of the segments' likelihood may reach below the ground: that of lines by chance.
MAX_BELOW = 0.05
# A ground is level to this cosine, where up is known.
LEVEL_COSINE = np.cos(np.radians(14.0))


@dataclass(frozen=True, eq=False, slots=True)
class Ground:
    """normal · x = height; the normal points to the cameras.

    `margin` is how near is on it, at the usual `distance` from the cameras at `centres` (V, 3).
    """

    normal: FloatArray
    height: float
    margin: float
    centres: FloatArray
    distance: float

    def above(self, points: FloatArray) -> FloatArray:
        """Heights (...) of points (..., 3) over the ground."""
        heights: FloatArray = points @ self.normal - self.height
        return heights

    def holds(self, points: FloatArray) -> NDArray[np.bool_]:
        """Which points (n, 3) lie on the ground, as well as their depth is known."""
        away = np.median(np.linalg.norm(points[:, None] - self.centres, axis=-1), axis=1)
        # The error of a depth grows with its square.
        margin = self.margin * np.maximum(away / self.distance, 1.0) ** 2
        held: NDArray[np.bool_] = np.abs(self.above(points)) < margin
        return held

    def behind(
        self, centre: FloatArray, points: FloatArray
    ) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Where rays from a centre (3,) through points (n, 3) meet the ground, and whether."""
        rays = points - centre
        drop = rays @ self.normal
        meets = drop < -1e-9 * np.linalg.norm(rays, axis=1)
        share = -self.above(centre) / np.where(meets, drop, -1.0)
        return centre + share[:, None] * rays, meets

    def down_from(self, side: FloatArray, normal: FloatArray) -> FloatArray:
        """The part (4, 3) of a plane with this normal between one of its segments (2, 3) and here.

        (0, 3) where the plane is about level, or an end of the segment lies on the ground.
        """
        down = (self.normal @ normal) * normal - self.normal
        steep = float(np.linalg.norm(down))
        if steep < np.sqrt(1 - LEVEL_COSINE**2) or self.holds(side).any():
            return np.zeros((0, 3))
        reach = self.above(side)[:, None] / steep * (down / steep)
        return np.array([side[0], side[1], side[1] + reach[1], side[0] + reach[0]])

    def clipped(self, corners: FloatArray) -> FloatArray:
        """A polygon (k, 3) without what lies below the ground; (0, 3) if all of it does."""
        heights = self.above(corners)
        return corners if (heights >= -self.margin).all() else part_above(corners, heights)


def find_ground(
    planes: Sequence[PlaneHypothesis],
    cloud: LineCloud,
    worth: FloatArray,
    views: Sequence[View],
    distance: float,
    up: FloatArray | None,
) -> Ground | None:
    """The plane of the likeliest lines that has all cameras and nearly all lines on one side.

    `worth` (n,) is the log-likelihood ratio of the cloud's lines: a line that is there by chance
    has little. Of level planes where up is known; if none of them has lines, the level below which
    hardly any line reaches. None where up is not known and no plane is below everything. `distance`
    is what the views look at from, in the median.
    """
    centres = np.array([v.pose.centre for v in views])
    margin = ON_GROUND_PX * cloud.pixel
    likely = np.array([worth[plane.lines].sum() for plane in planes])
    for plane in (planes[k] for k in descending(likely)):
        side = np.sign(centres @ plane.normal - plane.distance)
        if abs(side.sum()) < len(views):
            continue
        normal, height = side[0] * plane.normal, float(side[0] * plane.distance)
        ground = Ground(normal, height, margin, centres, distance)
        if up is not None and ground.normal @ up < LEVEL_COSINE:
            continue
        below = (ground.above(cloud.segments) < -margin).any(axis=1)
        if worth[below].sum() <= MAX_BELOW * worth.sum():
            return ground
    if up is None or not len(cloud.segments):
        return None
    lowest = (cloud.segments @ up).min(axis=1)
    order = np.argsort(lowest, kind="stable")
    below = np.cumsum(worth[order])
    height = float(lowest[order][np.searchsorted(below, MAX_BELOW * below[-1])])
    return Ground(np.array(up), height, margin, centres, distance)
