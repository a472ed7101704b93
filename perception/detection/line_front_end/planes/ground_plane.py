"""The ground: one plane below everything, which is no object's face."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import PlaneHypothesis
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.flat_faces import clip_polygon_above
from facetlog.perception.types import FloatArray, View

# A point this near to the ground, px, lies on it.
ON_GROUND_PX = 6.0
# Share of the segments' likelihood that is due to chance lines. So much of it may lie below the
# ground, that of a segment spread over its length; or, without a plane, belong to segments below.
MAX_BELOW = 0.05
# And the ground has so many times as much on it as lies below: a seat's rim above legs has not.
ON_TO_BELOW = 2.0
# A ground is level to this cosine, where up is known.
LEVEL_COSINE = np.cos(np.radians(14.0))
# Heights settle on their mean in few steps.
STEPS = 10


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
        """Return heights (...) of points (..., 3) over the ground."""
        heights: FloatArray = points @ self.normal - self.height
        return heights

    def holds(self, points: FloatArray) -> NDArray[np.bool_]:
        """Return which points (n, 3) lie on the ground, within the accuracy of their depth."""
        away = np.median(np.linalg.norm(points[:, None] - self.centres, axis=-1), axis=1)
        # The error of a depth grows with its square.
        margin = self.margin * np.maximum(away / self.distance, 1.0) ** 2
        held: NDArray[np.bool_] = np.abs(self.above(points)) < margin
        return held

    def behind(
        self, centre: FloatArray, points: FloatArray
    ) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Return where rays from a centre (3,) through points (n, 3) meet the ground, or not."""
        rays = points - centre
        drop = rays @ self.normal
        meets = drop < -1e-9 * np.linalg.norm(rays, axis=1)
        share = -self.above(centre) / np.where(meets, drop, -1.0)
        return centre + share[:, None] * rays, meets

    def extend_to_ground(self, side: FloatArray, normal: FloatArray) -> FloatArray:
        """Return the part (4, 3) of a plane with this normal between one of its segments (2, 3) and
        here.

        (0, 3) where the plane is about level, or an end of the segment lies on the ground.
        """
        down = (self.normal @ normal) * normal - self.normal
        steep = float(np.linalg.norm(down))
        if steep < np.sqrt(1 - LEVEL_COSINE**2) or self.holds(side).any():
            return np.zeros((0, 3))
        reach = self.above(side)[:, None] / steep * (down / steep)
        return np.array([side[0], side[1], side[1] + reach[1], side[0] + reach[0]])

    def clipped(self, corners: FloatArray) -> FloatArray:
        """Return a polygon (k, 3) without what lies below the ground; (0, 3) if all of it does."""
        heights = self.above(corners)
        return corners if (heights >= -self.margin).all() else clip_polygon_above(corners, heights)


def find_ground(
    planes: Sequence[PlaneHypothesis],
    cloud: LineCloud,
    score: FloatArray,
    views: Sequence[View],
    distance: float,
    up: FloatArray | None,
) -> Ground | None:
    """Return the plane of the likeliest lines that has all cameras and nearly all lines on one
    side.

    `score` (n,) is the log-likelihood ratio of the cloud's lines: a line that is there by chance
    has little. Where up is known it is a level plane, of lines that are level themselves; if none
    is below everything, the level below which hardly any line reaches. None where up is not known
    and no plane is below everything. `distance` is what the views look at from, in the median.
    """
    centres = np.array([v.pose.centre for v in views])
    margin = ON_GROUND_PX * cloud.pixel
    candidates = [(plane.normal, plane.distance) for plane in planes]
    if up is not None:
        candidates += [(up, h) for h in _levels(cloud.segments, score, up, margin)]
    best: Ground | None = None
    most = 0.0
    for normal, height in candidates:
        side = np.sign(centres @ normal - height)
        if abs(side.sum()) < len(views):
            continue
        ground = Ground(side[0] * normal, float(side[0] * height), margin, centres, distance)
        if up is not None and ground.normal @ up < LEVEL_COSINE:
            continue
        above = ground.above(cloud.segments)
        likely = float(score[(np.abs(above) < margin).all(axis=1)].sum())
        below = float(score @ _share_below(above + margin))
        chance = min(MAX_BELOW * score.sum(), likely / ON_TO_BELOW)
        if likely > most and below <= chance:
            best, most = ground, likely
    if best is not None:
        return best
    if up is None or not len(cloud.segments):
        return None
    lowest = (cloud.segments @ up).min(axis=1)
    order = np.argsort(lowest, kind="stable")
    reach = np.cumsum(score[order])
    height = float(lowest[order][np.searchsorted(reach, MAX_BELOW * reach[-1])])
    return Ground(np.array(up), height, margin, centres, distance)


def _levels(segments: FloatArray, score: FloatArray, up: FloatArray, margin: float) -> list[float]:
    # Heights that level segments (n, 2, 3) cluster about: two sides of a foot give the ground, and
    # even one. Each segment's height moves to the mean of those near it (mean shift).
    heights = segments @ up
    level = (np.ptp(heights, axis=1) < margin) & (score > 0)
    middle, weight = heights[level].mean(axis=1), score[level]
    height = middle
    for _ in range(STEPS):
        near = np.abs(middle - height[:, None]) <= (1 + 1e-9) * margin
        height = near @ (weight * middle) / (near @ weight)
    found: list[float] = np.unique(height).tolist()
    return found


def _share_below(heights: FloatArray) -> FloatArray:
    # Share of each segment (n,) below 0 by the heights of its ends (n, 2). That an upright one is
    # followed a little below its foot lowers no ground.
    low, high = heights.min(axis=1), heights.max(axis=1)
    share: FloatArray = np.clip(-low / np.maximum(high - low, 1e-300), 0.0, 1.0)
    return np.where(high <= 0, 1.0, share)
