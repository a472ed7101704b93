"""Points on triangles, so dense that no place of the surface is far from one; deterministic."""

from dataclasses import dataclass

import numpy as np

from facetlog.perception.flat_faces import cross
from facetlog.perception.ragged import Indices, find_distinct, number_rows, sum_by_group
from facetlog.perception.types import FloatArray

# Rows are this much nearer than points in a row are: √(0.85² + 0.5²) < 1.
ROW_SHARE = 0.85


@dataclass(frozen=True, eq=False, slots=True)
class Samples:
    """Points (n, 3), the area (n,) that each stands for, and its triangle (n,)."""

    points: FloatArray
    areas: FloatArray
    triangles: Indices


def sample_triangles(corners: FloatArray, spacing: float) -> Samples:
    """Return points on triangles (m, 3, 3), one within `spacing` of every place of each triangle.

    Rows run along the longest side a b, so a needle gets a row and not a square of points:
    p = (1 - v) (a + u (b - a)) + v c. A row is the lower side of its strip, because that is as
    long as the strip: every place has a point straight below it. From v to v + 1 / rows a strip
    has the area A (2 - 2 v - 1 / rows) / rows.
    """
    if not len(corners):
        return Samples(np.zeros((0, 3)), np.zeros(0), np.zeros(0, dtype=np.int64))
    longest, double, columns, rows = _laid_out(corners, spacing)
    every = np.arange(len(corners))
    a, b, c = (corners[every, (longest + k) % 3] for k in range(3))
    counts = columns * rows
    owner = np.repeat(every, counts)
    nth = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    across, down = np.repeat(columns, counts), np.repeat(rows, counts)
    row = np.floor(nth / across)
    u, v = (nth - row * across + 0.5) / across, row / down
    points = np.empty((3, len(owner)))
    for along, start, side, apex in zip(points, a.T, (b - a).T, c.T, strict=True):
        along[:] = np.repeat(start, counts) + u * np.repeat(side, counts)
        along *= 1.0 - v
        along += v * np.repeat(apex, counts)
    areas = np.repeat(double / counts, counts) * (1.0 - v - 0.5 / down)
    return Samples(points.T, areas, owner)


def sample_count(corners: FloatArray, spacing: float) -> int:
    """Return how many samples `sample_triangles` would give."""
    _, _, columns, rows = _laid_out(corners, spacing)
    return int((columns * rows).sum())


def _laid_out(corners: FloatArray, spacing: float) -> tuple[Indices, FloatArray, Indices, Indices]:
    """Return which side of each triangle is the longest, twice its area, and its number of samples
    along that side and across.
    """
    sides = [corners[:, (k + 1) % 3] - corners[:, k] for k in range(3)]
    squares = np.array([np.einsum("ij,ij->i", side, side) for side in sides])
    longest = squares.argmax(axis=0)
    span = np.sqrt(squares[longest, np.arange(len(corners))])
    normal = cross(sides[0], sides[1])
    double = np.sqrt(np.einsum("ij,ij->i", normal, normal))
    height = double / np.maximum(span, 1e-300)
    columns = np.maximum(np.ceil(span / spacing), 1.0).astype(np.int64)
    rows = np.maximum(np.ceil(height / (ROW_SHARE * spacing)), 1.0).astype(np.int64)
    return longest, double, columns, rows


def thinned(
    points: FloatArray, areas: FloatArray, groups: Indices, cell: float
) -> tuple[Indices, Indices, FloatArray]:
    """Return one point's index for each cell and group with points, each point's place,
    area sums.
    """
    if not len(points):
        none = np.zeros(0, dtype=np.int64)
        return none, none, np.zeros(0)
    cells = [((along - along.min()) / cell).astype(np.int64) for along in points.T]
    kept, place = find_distinct(number_rows(np.array([*cells, groups]).T))
    return kept, place, sum_by_group(place, areas, len(kept))
