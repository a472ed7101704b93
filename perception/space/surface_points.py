"""Points all over faces and lines, so close that no cell of a grid that they pass is missed."""

from collections.abc import Iterable

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.flat_faces import FlatFace
from facetlog.perception.ragged import Indices, find_row_starts
from facetlog.perception.types import FloatArray

# Rounding takes points less far off, as a share of a face or of a spacing.
WITHIN = 1e-6

POINTS_AT_ONCE = 200_000
"""Points of grids that are worked on in one go: some 20 MB."""


def sample_lines(segments: FloatArray, spacing: float) -> FloatArray:
    """Return points (n, 3) along segments (l, 2, 3), both ends too, no farther apart than
    `spacing`.
    """
    span = segments[:, 1] - segments[:, 0]
    counts = np.ceil(np.sqrt((span * span).sum(axis=1)) / spacing).astype(np.intp) + 1
    line = np.repeat(np.arange(len(counts)), counts)
    nth = np.arange(len(line)) - find_row_starts(counts)[line]
    share = nth / np.maximum(counts - 1, 1)[line]
    points: FloatArray = segments[line, 0] + share[:, None] * span[line]
    return points


def inner_points(faces: Iterable[FlatFace], spacing: float) -> tuple[FloatArray, Indices]:
    """Return points (n, 3) all over faces, outlines too, and which of the faces (n,) each is on.

    They are no farther apart than `spacing`, face by face, and a millionth within their faces and
    behind them: where a face is the border of two cells they are in the inner one, however it is
    rounded.
    """
    shown = tuple(faces)
    polygons = np.array([face.polygon for face in shown], dtype=np.object_)
    there = np.flatnonzero(~shapely.is_empty(polygons)).tolist()
    if not there:
        return np.zeros((0, 3)), np.zeros(0, dtype=np.intp)
    shown, polygons = tuple(shown[i] for i in there), polygons[there]
    low, high = np.hsplit(shapely.bounds(polygons), 2)
    counts = ((high - low) / spacing).astype(np.intp) + 2
    found = []
    counted = []
    # So many faces at a time that the grids on them stay small.
    batch = np.cumsum(counts.prod(axis=1)) // POINTS_AT_ONCE
    for some in np.split(np.arange(len(shown)), np.flatnonzero(np.diff(batch)) + 1):
        own = polygons[some]
        x, y, inside = _find_grid_points_within(own, low[some], high[some], counts[some])
        rim, of = shapely.get_coordinates(shapely.segmentize(own, spacing), return_index=True)
        # Face by face what is within it, and then its rim.
        within, along = (np.bincount(each, minlength=len(some)) for each in (inside, of))
        starts = find_row_starts(within + along)
        flat = np.empty((len(x) + len(rim), 2))
        place = np.arange(len(x)) + np.repeat(starts - find_row_starts(within), within)
        flat[place, 0], flat[place, 1] = x, y
        flat[np.arange(len(rim)) + np.repeat(starts + within - find_row_starts(along), along)] = rim
        ends = starts + within + along
        for nth, start, end in zip(some.tolist(), starts.tolist(), ends.tolist(), strict=True):
            face = shown[nth]
            middle = face.middle - WITHIN * spacing * face.normal
            found.append(middle + flat[start:end] @ ((1.0 - WITHIN) * face.axes))
        counted.append(within + along)
    return np.concatenate(found), np.repeat(there, np.concatenate(counted))


def _find_grid_points_within(
    polygons: NDArray[np.object_], low: FloatArray, high: FloatArray, counts: Indices
) -> tuple[FloatArray, FloatArray, Indices]:
    """Return x, y and polygon number (n,) of the grid points within polygons (f,).

    The grids have so many columns and rows as `counts` (f, 2) say, from `low` to `high` (f, 2).
    A point is within if its row of the grid crosses the rim an odd number of times before it.
    """
    pitch = (high - low) / (counts - 1)
    total = counts.prod(axis=1)
    starts = find_row_starts(total)
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
    row = np.arange(len(side)) + np.repeat(lowest - find_row_starts(crossed), crossed)
    share = (row - level[side]) / (level[side + 1] - level[side])
    x = corners[side, 0] + share * (corners[side + 1, 0] - corners[side, 0])
    column = np.ceil((x - low[face, 0]) / pitch[face, 0]).astype(np.intp)
    column = np.clip(column, 0, counts[face, 0])
    crossings = np.bincount(starts[face] + row * counts[face, 0] + column, minlength=total.sum())
    # Every row crosses an even number of times, so that one sum does for all.
    inside = np.flatnonzero(np.cumsum(crossings) & 1)
    face = np.searchsorted(starts, inside, side="right") - 1
    row, column = np.divmod(inside - starts[face], counts[face, 0])
    # What is on the rim of the grid is on that of the polygon at most.
    inner = (row > 0) & (column > 0) & (row < counts[face, 1] - 1) & (column < counts[face, 0] - 1)
    row, column, face = row[inner], column[inner], face[inner]
    x, y = column * pitch[face, 0] + low[face, 0], row * pitch[face, 1] + low[face, 1]
    return x, y, face
