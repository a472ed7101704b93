"""A plane divided into cells, their pixels in the views, and connected regions of cells."""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import PlaneHypothesis
from facetlog.perception.types import FloatArray

# Sides of a cell, px, when a plane is looked over and when its regions are outlined; of a large
# plane not more cells than this along a side.
COARSE_PX, FINE_PX = 8.0, 2.0
MAX_CELLS = 170
# Fewer cells than this, at the coarse and the fine step, are no region.
MIN_COARSE, MIN_FINE = 3, 64
CROSS = np.ones((3, 3), dtype=np.uint8)


@dataclass(frozen=True, eq=False, slots=True)
class PlaneGrid:
    """Cells of a plane, `shape` (rows, columns).

    Cell (row, column) has its middle at low + (column + ½, row + ½) · step, measured along `basis`
    (3, 2) from `origin` (3,).
    """

    origin: FloatArray
    basis: FloatArray
    low: FloatArray
    step: float
    shape: tuple[int, int]

    @classmethod
    def over(
        cls,
        plane: PlaneHypothesis,
        basis: FloatArray,
        low: FloatArray,
        high: FloatArray,
        step: float,
    ) -> "PlaneGrid":
        """Return cells of a side of `step` from `low` (2,) to `high` or a little beyond."""
        columns, rows = np.maximum(np.ceil((high - low) / step), 1).astype(int)
        return cls(plane.normal * plane.distance, basis, low, step, (int(rows), int(columns)))

    def pixels(
        self, projections: FloatArray, sizes: NDArray[np.intp]
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Return pixels (2, v, rows, columns) of the cells in views, and which are in the picture.

        `projections` (v, 3, 4) and `sizes` (v, 2), width and height, are those of the views.
        """
        x = (self.low[0] + (np.arange(self.shape[1]) + 0.5) * self.step).astype(np.float32)
        y = (self.low[1] + (np.arange(self.shape[0])[:, None] + 0.5) * self.step).astype(np.float32)
        h = projections[:, :, :3] @ np.column_stack([self.basis, self.origin])
        h[:, :, 2] += projections[:, :, 3]
        a, b, c = h.astype(np.float32).transpose(2, 1, 0)[..., None, None]
        at = a * x + (b * y + c)  # (3, v, rows, columns)
        uv, depth = at[:2], at[2]
        before = depth > 0
        np.copyto(depth, np.inf, where=~before)
        uv /= depth
        u, v = uv
        width, height = sizes.T[:, :, None, None]
        inside = before & (u > 1) & (u < width - 2) & (v > 1) & (v < height - 2)
        return uv, inside

    def cells(self, points: FloatArray) -> FloatArray:
        """Return points (..., 3) of the plane in cells (x, y), the first cell's middle at 0."""
        cells: FloatArray = ((points - self.origin) @ self.basis - self.low) / self.step - 0.5
        return cells

    def points(self, cells: FloatArray) -> FloatArray:
        """Return the inverse, for `border`'s coordinates: cell middles at ½."""
        points: FloatArray = self.origin + (self.low + cells * self.step) @ self.basis.T
        return points


def find_connected_regions(cells: NDArray[np.uint8], least: int) -> Iterator[NDArray[np.uint8]]:
    """Return connected regions of so many cells and more, each a mask of 0 and 1, the largest
    first.

    Of fine cells, where MIN_COARSE are too few, thin bridges are left out.
    """
    opened = (
        cv2.morphologyEx(cells.astype(np.uint8), cv2.MORPH_OPEN, CROSS)
        if least > MIN_COARSE
        else cells
    )
    _, labels, stats, _ = cv2.connectedComponentsWithStats(
        np.asarray(opened, dtype=np.uint8), connectivity=4
    )
    areas = stats[1:, cv2.CC_STAT_AREA]
    for k in np.argsort(-areas, kind="stable"):
        if areas[k] >= least:
            yield (labels == k + 1).astype(np.uint8)
