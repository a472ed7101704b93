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

from facetlog.perception.flat_faces import FlatFace, plane_axes
from facetlog.perception.row_table import Indices, row_starts
from facetlog.perception.surfaces.convex_hulls import least_rectangle
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

POINTS_AT_ONCE = 200_000
"""Points of grids that are worked on in one go: some 20 MB."""

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


def surface_points(faces: Iterable[FlatFace], spacing: float) -> FloatArray:
    """Points (n, 3) all over the faces, outlines too, no farther apart than `spacing`."""
    shown = tuple(faces)
    polygons = np.array([face.polygon for face in shown], dtype=np.object_)
    there = np.flatnonzero(~shapely.is_empty(polygons)).tolist()
    if not there:
        return np.zeros((0, 3))
    shown, polygons = tuple(shown[i] for i in there), polygons[there]
    low, high = np.hsplit(shapely.bounds(polygons), 2)
    counts = ((high - low) / spacing).astype(np.intp) + 2
    found = []
    # So many faces at a time that the grids on them stay small.
    batch = np.cumsum(counts.prod(axis=1)) // POINTS_AT_ONCE
    for some in np.split(np.arange(len(shown)), np.flatnonzero(np.diff(batch)) + 1):
        own = polygons[some]
        x, y, face = _grids_within(own, low[some], high[some], counts[some])
        rim, of = shapely.get_coordinates(shapely.segmentize(own, spacing), return_index=True)
        # Face by face what is within it, and then its rim.
        within, along = (np.bincount(each, minlength=len(some)) for each in (face, of))
        starts = row_starts(within + along)
        flat = np.empty((len(x) + len(rim), 2))
        place = np.arange(len(x)) + np.repeat(starts - row_starts(within), within)
        flat[place, 0], flat[place, 1] = x, y
        flat[np.arange(len(rim)) + np.repeat(starts + within - row_starts(along), along)] = rim
        ends = starts + within + along
        for nth, start, end in zip(some.tolist(), starts.tolist(), ends.tolist(), strict=True):
            found.append(shown[nth].middle + flat[start:end] @ shown[nth].axes)
    return np.concatenate(found)


def _grids_within(
    polygons: NDArray[np.object_], low: FloatArray, high: FloatArray, counts: Indices
) -> tuple[FloatArray, FloatArray, Indices]:
    """x, y and number (n,) of the polygon, of points of grids within polygons (f,).

    The grids have so many columns and rows as `counts` (f, 2) say, from `low` to `high` (f, 2).
    A point is within if its row of the grid crosses the rim an odd number of times before it.
    """
    pitch = (high - low) / (counts - 1)
    total = counts.prod(axis=1)
    starts = row_starts(total)
    parts, part_of = shapely.get_parts(polygons, return_index=True)
    rings, ring_of = shapely.get_rings(parts, return_index=True)
    corners, ring = shapely.get_coordinates(rings, return_index=True)
    of = part_of[ring_of[ring]]
    first = np.flatnonzero(ring[1:] == ring[:-1])
    # A side crosses the rows from one end's row, rounded up, to below the other's.
    level = (corners[:, 1] - low[of, 1]) / pitch[of, 1]
    rows = np.ceil(level).astype(np.intp)
    lowest = np.minimum(rows[first], rows[first + 1])
    crossed = np.abs(rows[first + 1] - rows[first])
    side = np.repeat(first, crossed)
    face = of[side]
    row = np.arange(len(side)) + np.repeat(lowest - row_starts(crossed), crossed)
    share = (row - level[side]) / (level[side + 1] - level[side])
    x = corners[side, 0] + share * (corners[side + 1, 0] - corners[side, 0])
    column = np.ceil((x - low[face, 0]) / pitch[face, 0]).astype(np.intp)
    column = np.clip(column, 0, counts[face, 0])
    crossings = np.bincount(starts[face] + row * counts[face, 0] + column, minlength=total.sum())
    # Every row crosses an even number of times, so that one sum does for all.
    inside = np.flatnonzero(np.cumsum(crossings) % 2)
    face = np.searchsorted(starts, inside, side="right") - 1
    row, column = np.divmod(inside - starts[face], counts[face, 0])
    # What is on the rim of the grid is on that of the polygon at most.
    inner = (row > 0) & (column > 0) & (row < counts[face, 1] - 1) & (column < counts[face, 0] - 1)
    row, column, face = row[inner], column[inner], face[inner]
    x, y = column * pitch[face, 0] + low[face, 0], row * pitch[face, 1] + low[face, 1]
    return x, y, face


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
    from scipy import ndimage  # loaded only now: what pictures show does without

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
    from scipy import ndimage

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
