"""The ground: one plane below everything, which is nobody's face."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from facetlog.perception.detection.line_front_end.line_cloud import LineCloud
from facetlog.perception.detection.line_front_end.plane_hypotheses import PlaneHypothesis
from facetlog.perception.types import FloatArray, View

__all__ = ["Ground", "find_ground"]

# A point this near to the ground, px, lies on it.
ON_GROUND_PX = 6.0
# Of the segments, so few may reach below the ground: chance lines do.
MAX_BELOW = 0.05
# A ground is level to this cosine, where up is known.
LEVEL_COSINE = np.cos(np.radians(14.0))
# A segment is level when it rises by less than this share of its length.
LEVEL_RISE = 0.1
# Where no plane of lines is the ground, it is as low as this share of the level segments.
LOWEST_SHARE = 0.02


@dataclass(frozen=True, eq=False, slots=True)
class Ground:
    """normal · x = height; the normal points to the cameras. `margin` is how near is on it."""

    normal: FloatArray
    height: float
    margin: float

    def above(self, points: FloatArray) -> FloatArray:
        """Heights (...) of points (..., 3) over the ground."""
        heights: FloatArray = points @ self.normal - self.height
        return heights

    def holds(self, points: FloatArray) -> bool:
        """Whether all points (n, 3) lie on the ground."""
        return bool((np.abs(self.above(points)) < self.margin).all())


def find_ground(
    planes: Sequence[PlaneHypothesis],
    cloud: LineCloud,
    views: Sequence[View],
    up: FloatArray | None,
) -> Ground | None:
    """The plane with most lines that has all cameras and nearly all segments on one side.

    Of level planes where up is known; if none of them has lines, the level of the lowest segments.
    None where up is not known and no plane is below everything.
    """
    centres = np.array([v.pose.centre for v in views])
    margin = ON_GROUND_PX * cloud.pixel
    for plane in sorted(planes, key=lambda p: -len(p.lines)):
        side = np.sign(centres @ plane.normal - plane.distance)
        if abs(side.sum()) < len(views):
            continue
        ground = Ground(side[0] * plane.normal, float(side[0] * plane.distance), margin)
        if up is not None and ground.normal @ up < LEVEL_COSINE:
            continue
        if (ground.above(cloud.segments) < -margin).any(axis=1).mean() <= MAX_BELOW:
            return ground
    if up is None or not len(cloud.segments):
        return None
    heights = cloud.segments @ up
    rise = np.abs(heights[:, 1] - heights[:, 0])
    length = np.linalg.norm(cloud.segments[:, 1] - cloud.segments[:, 0], axis=1)
    level = rise < LEVEL_RISE * length
    lowest = np.sort(heights[level].mean(axis=1) if level.any() else heights.ravel())
    return Ground(np.array(up), float(lowest[int(LOWEST_SHARE * len(lowest))]), margin)
