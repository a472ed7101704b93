"""A view before the faces of a scene: how far away each is, and which points none of them hides."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.flat_faces import part_above
from facetlog.perception.surfaces.seeing.seen_faces import Surface
from facetlog.perception.types import FloatArray, View

__all__ = ["BEFORE_PX", "NEAREST", "Eye", "in_picture", "where_none_ends"]

# Cells across a picture, as many a length downwards: to what is neither face nor ground goes one
# line of sight in each at most, some ten for each side of a thing that fills a quarter of it.
ACROSS = 40
# A surface this much nearer than another, in lengths of a pixel there, is before it: a corner is
# known to about one.
BEFORE_PX = 3.0
# A face that reaches past the camera is looked at from this share of its reach on.
NEAREST = 1e-3


class Eye:
    """A view before the faces of a scene."""

    def __init__(self, view: View, surfaces: Sequence[Surface]) -> None:
        self.view = view
        self.centre = view.pose.centre
        self.size = np.array(view.image.shape[::-1])
        self._surfaces = surfaces
        self._masks = [self._drawn(surface) for surface in surfaces]

    def rays(self, uv: FloatArray) -> FloatArray:
        """Rays (n, 3) through pixels (n, 2), as long as to reach one unit forward."""
        camera = self.view.camera
        x, y = ((uv - [camera.cx, camera.cy]) / [camera.fx, camera.fy]).T
        rays: FloatArray = np.stack([x, y, np.ones(len(uv))], axis=1) @ self.view.pose.rotation.T
        return rays

    def depths(self, uv: FloatArray) -> FloatArray:
        """How far forward each face (F, n) lies on the rays of pixels (n, 2) in the picture."""
        depth = np.full((len(self._masks), len(uv)), np.inf)
        column, row = np.rint(uv).astype(np.intp).T
        rays = self.rays(uv)
        for n, (surface, mask) in enumerate(zip(self._surfaces, self._masks, strict=True)):
            on = np.nonzero(mask[row, column])[0]
            plane = surface.face.plane
            towards = rays[on] @ plane.normal
            with np.errstate(divide="ignore", invalid="ignore"):
                away = -plane.distance(self.centre) / towards
            depth[n, on] = np.where(away > 0, away, np.inf)
        return depth

    def in_sight(self, points: FloatArray) -> NDArray[np.bool_]:
        """Which points (n, 3) lie in the picture and no face lies before."""
        uv, depth = project_points(self.view.projection, points)
        seen = np.logical_and(depth > 0, in_picture(uv, self.size))
        nearest = self.depths(uv[seen]).min(axis=0, initial=np.inf)
        seen[seen] = nearest > depth[seen] - BEFORE_PX * self.pixel(depth[seen])
        return seen

    def pixel(self, depth: FloatArray) -> FloatArray:
        """The length of a pixel so far forward."""
        return depth / self.view.camera.fx

    def _drawn(self, surface: Surface) -> NDArray[np.uint8]:
        mask = np.zeros(self.view.image.shape, dtype=np.uint8)
        forward = self.view.pose.rotation[:, 2]
        loops = []
        for ring in surface.rings:
            ahead = (ring - self.centre) @ forward
            before = part_above(ring, ahead - NEAREST * np.abs(ahead).max())
            if len(before) >= 3:
                uv, _ = project_points(self.view.projection, before)
                loops.append(np.rint(uv).astype(np.int32))
        if loops:
            cv2.fillPoly(mask, loops, 1)
        return mask


def where_none_ends(view: View, ends: FloatArray, points: FloatArray) -> FloatArray:
    """Of points (n, 3) that a view sees one in each cell of its picture without an end (m, 3)."""
    cells, first = np.unique(_cells(view, points), return_index=True)
    chosen: FloatArray = points[np.sort(first[~np.isin(cells, _cells(view, ends))])]
    return chosen


def _cells(view: View, points: FloatArray) -> NDArray[np.intp]:
    # Which cells (n,) of the picture points before the view lie in.
    uv, _ = project_points(view.projection, points)
    column, row = np.floor((uv + 0.5) * ACROSS / view.camera.width).astype(np.intp).T
    return np.asarray(row * ACROSS + column)


def in_picture(uv: FloatArray, size: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Which pixels (..., 2) are inside the border of a picture of that width and height (2,).

    By a pixel, where rounding stays in the picture.
    """
    return np.asarray(((uv > 1) & (uv < size - 2)).all(axis=-1), dtype=np.bool_)
