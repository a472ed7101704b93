"""Clipping of world polygons and segments to a picture, before projection."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from facetlog.perception.flat_faces import clip_polygon_above
from facetlog.perception.types import Camera, FloatArray, Pose

# Polygons are cut this share of the picture's size outside of it, so that the cut's own edges are
# never seen, yet pixel coordinates stay small enough for the drawing routines' integers.
MARGIN = 0.25
# Depths below this share of the largest depth at hand count as behind the camera.
NEAR_SHARE = 1e-3


@dataclass(frozen=True, eq=False)
class Frustum:
    """The cone of space that one camera sees, a little wider than the picture."""

    camera: Camera
    pose: Pose

    def in_camera(self, points: ArrayLike) -> FloatArray:
        """Return world points (n, 3) in the camera's frame, (n, 3)."""
        offset = np.asarray(points, dtype=np.float64).reshape(-1, 3) - self.pose.centre
        return np.asarray(offset @ self.pose.rotation, dtype=np.float64)

    def pixels(self, in_camera: FloatArray) -> FloatArray:
        """Return pixels (n, 2) of camera-frame points (n, 3), which must lie in front of the
        camera.
        """
        c = self.camera
        u = c.fx * in_camera[:, 0] / in_camera[:, 2] + c.cx
        v = c.fy * in_camera[:, 1] / in_camera[:, 2] + c.cy
        return np.column_stack([u, v])

    def polygon(self, ring: ArrayLike) -> FloatArray:
        """Return pixels (m, 2) of the part of a closed world polygon (n, 3) that is in view; m may
        be 0.

        Sutherland and Hodgman (1974): cut by one plane after the other. Of a concave ring pieces
        may hang together along the cut, outside the picture.
        """
        points = self.in_camera(ring)
        for plane in self._planes(points):
            points = clip_polygon_above(points, points @ plane[:3] + plane[3])
        return self.pixels(points) if len(points) >= 3 else np.empty((0, 2))

    def segment(self, start: ArrayLike, end: ArrayLike) -> FloatArray | None:
        """Return the part of a world segment that is in view, camera frame, (2, 3), or None."""
        points = self.in_camera(np.stack([np.asarray(start), np.asarray(end)]))
        low, high = 0.0, 1.0
        for plane in self._planes(points):
            first, last = points @ plane[:3] + plane[3]
            if first < 0 and last < 0:
                return None
            if first < 0:
                low = max(low, first / (first - last))
            elif last < 0:
                high = min(high, first / (first - last))
        if low >= high:
            return None
        return np.asarray(points[0] + np.outer([low, high], points[1] - points[0]))

    def _planes(self, points: FloatArray) -> FloatArray:
        """Return the five planes (5, 4), inside where plane · (x, y, z, 1) ≥ 0, for camera
        points.
        """
        near = NEAR_SHARE * max(float(points[:, 2].max(initial=0.0)), np.finfo(np.float64).tiny)
        return np.vstack([[0.0, 0.0, 1.0, -near], self._sides])

    @cached_property
    def _sides(self) -> FloatArray:
        c = self.camera
        left, right = -MARGIN * c.width, (1 + MARGIN) * c.width
        top, bottom = -MARGIN * c.height, (1 + MARGIN) * c.height
        # u ≥ left means fx x + (cx - left) z ≥ 0, and so on round the picture.
        return np.array(
            [
                [c.fx, 0.0, c.cx - left, 0.0],
                [-c.fx, 0.0, right - c.cx, 0.0],
                [0.0, c.fy, c.cy - top, 0.0],
                [0.0, -c.fy, bottom - c.cy, 0.0],
            ]
        )
