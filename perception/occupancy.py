"""Where a thing is and where space is free: its surface in a grid, flooded from outside.

The grid stands on the thing's lowest level, square to the least rectangle round its plan. A cell is
solid if the surface passes through it or if it cannot be reached from outside: a closed cabinet is
solid, an open shelf is not. So it does not matter which way a surface is turned, whether it is
doubled, or whether parts cross; gaps narrower than a cell are closed. Where outlines are known less
well than to a cell, as those of clouds are, neighbouring faces miss each other by as much: then the
flood does not pass through gaps that narrow either.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage

from facetlog.perception.flat_faces import FlatFace, plane_axes
from facetlog.perception.hulls import least_rectangle
from facetlog.perception.types import FloatArray

__all__ = ["Grid", "occupancy", "surface_points"]

# Cells along the longest side. A chair's leg is 4 % of its height: a cell is 3 %. Finer grids
# changed no more than 1 % of shares on furniture, and take time with the third power.
CELLS = 32
# Two faces' outlines miss each other by less than this many sd of a corner, to either side.
MISSED_SDS = 2.0
# Less than this share of a cell, to either side, closes itself: both reach into it.
LEAST_MISSED = 0.25
# Samples of a face are this share of a cell apart, so that none of its cells is missed: an inner
# cell of a plane holds a sample at any spacing below 1; corners of cells are cut at more than .5.
SPACING = 0.5

_Cells = NDArray[np.bool_]


@dataclass(frozen=True, eq=False, slots=False)
class Grid:
    """`solid` (nx, ny, nz) of cubic cells with side `cell`.

    `axes` (3, 3) are the grid's directions as rows, the last one up, right-handed; `corner` (3,)
    is its lowest corner in these axes.
    """

    solid: _Cells
    cell: float
    axes: FloatArray
    corner: FloatArray

    @cached_property
    def footprint(self) -> _Cells:
        """Columns (nx, ny) that hold something."""
        return np.asarray(self.solid.any(axis=2))

    @cached_property
    def upper(self) -> _Cells:
        """Cells (nx, ny, nz) that are solid with free space right above them."""
        free_above: _Cells = np.ones_like(self.solid)
        free_above[:, :, :-1] = ~self.solid[:, :, 1:]
        found: _Cells = self.solid & free_above
        return found

    def layer(self, height: float) -> int:
        """The layer of cells that holds a height (along up, in the scene's frame)."""
        layer = int(np.floor((height - self.corner[2]) / self.cell - 1e-9))
        return min(max(layer, 0), int(self.solid.shape[2]) - 1)


def _rings(faces: Iterable[FlatFace]) -> list[FloatArray]:
    return [np.asarray(shapely.get_coordinates(face.polygon)) for face in faces]


def surface_points(faces: Iterable[FlatFace], spacing: float) -> FloatArray:
    """Points (n, 3) all over the faces, outlines too, no farther apart than `spacing`."""
    found: list[FloatArray] = []
    for face in faces:
        if face.polygon.is_empty:
            continue
        low_x, low_y, high_x, high_y = face.polygon.bounds
        columns = np.linspace(low_x, high_x, int((high_x - low_x) / spacing) + 2)
        rows = np.linspace(low_y, high_y, int((high_y - low_y) / spacing) + 2)
        x, y = (a.ravel() for a in np.meshgrid(columns, rows))
        inside = shapely.contains_xy(face.polygon, x, y)
        rim = shapely.get_coordinates(shapely.segmentize(face.polygon, spacing))
        flat = np.concatenate([np.column_stack([x[inside], y[inside]]), rim])
        found.append(face.middle + flat @ face.axes)
    return np.concatenate(found) if found else np.zeros((0, 3))


def _axes(points: FloatArray, up: FloatArray) -> FloatArray:
    first, second = plane_axes(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    direction, _, _ = least_rectangle(points @ np.array([first, second]).T)
    along = direction[0] * first + direction[1] * second
    return np.array([along, np.cross(up, along), up])


def _missed(corner_sd: float) -> int:
    """By how many cells an outline may miss its neighbour's, if a corner's sd is so many cells.

    >>> _missed(0.1), _missed(0.2), _missed(0.6)
    (0, 1, 2)
    """
    missed = MISSED_SDS * corner_sd
    return int(np.ceil(missed)) if missed > LEAST_MISSED else 0


def _flooded(surface: _Cells, on_ground: bool, missed: int) -> _Cells:
    """Cells that are surface or cannot be reached from outside; on the ground not from below.

    Gaps of up to twice as many cells as `missed` do not let the flood through, only in.
    """
    below = 0 if on_ground else 1
    margin = max(1, missed)
    rim = ((margin, margin), (margin, margin), (below * margin, margin))
    free = np.pad(~surface, rim, constant_values=True)
    open_ = free & ~_closed(free, on_ground, missed) if missed else free
    regions, _ = ndimage.label(open_)
    reached = regions == regions[0, 0, -1]
    if missed:
        reached = ndimage.binary_dilation(
            reached, iterations=missed, mask=reached | (free & ~open_)
        )
    nx, ny, nz = surface.shape
    low = below * margin
    solid: _Cells = ~reached[margin : margin + nx, margin : margin + ny, low : low + nz]
    return solid


def _closed(free: _Cells, on_ground: bool, missed: int) -> _Cells:
    """The surface in a grid of which these cells are `free`, and the gaps in it."""
    # what stands on the ground goes on beneath it
    full = np.pad(~free, ((0, 0), (0, 0), (missed, 0)), constant_values=False)
    if on_ground:
        full[:, :, :missed] = full[:, :, missed : missed + 1]
    closed: _Cells = ndimage.binary_closing(full, iterations=missed)[:, :, missed:]
    return closed | ~free


def occupancy(
    faces: Iterable[FlatFace],
    outer: FloatArray,
    others: FloatArray,
    up: FloatArray,
    *,
    corner_sd: float = 0.0,
    on_ground: bool = True,
) -> Grid | None:
    """The grid of a thing, or None if it has no extent.

    `outer` (k, 3) are points that reach as far as the thing does, `others` (m, 3) points of its
    surface that is not flat, `up` (3,) a unit vector, `corner_sd` the sd of a face's corner. What
    does not stand `on_ground` is reached from below, too.
    """
    axes = _axes(outer, up)
    local = outer @ axes.T
    low, size = local.min(axis=0), np.ptp(local, axis=0)
    cell = float(size.max()) / CELLS
    if not cell > 0.0:
        return None
    shape = np.maximum(np.ceil(size / cell - 1e-9), 1).astype(np.intp)
    surface = np.concatenate([surface_points(faces, SPACING * cell), others, outer]) @ axes.T
    cells = np.clip(np.floor((surface - low) / cell).astype(np.intp), 0, shape - 1)
    touched = np.zeros(tuple(shape), dtype=bool)
    touched[tuple(cells.T)] = True
    return Grid(_flooded(touched, on_ground, _missed(corner_sd / cell)), cell, axes, low)
