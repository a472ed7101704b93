"""Parts that are nearly convex together are one; one that is far from it is several."""

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.ragged import Indices
from facetlog.perception.types import FloatArray

__all__ = ["convex_cut", "convex_joined", "is_convex"]

# Share of the convex hull that parts fill together. A slope in steps of cells takes some per cent
# from it; a flight of three steps, which is not one part, fills .88.
CONVEX = 0.9
# A cut has to fill so much more of the hulls.
GAIN = 1.0 - CONVEX
# Cuts are tried where the section changes most: so many along each axis.
CUTS = 2
_Cells = NDArray[np.bool_]
_CORNERS = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(-1, 3)


def is_convex(cells: NDArray[np.bool_]) -> bool:
    """Whether cells (nx, ny, nz), some at least, are nearly their own convex hull."""
    volume, _ = _hull(_outer_corners(np.argwhere(cells)))
    return int(cells.sum()) >= CONVEX * volume


def convex_cut(cells: _Cells) -> list[_Cells]:
    """Cells (nx, ny, nz), some at least, cut square to the grid as long as that makes them more
    convex: a seat off the back that is as thick as it, a step off the next."""
    volume, _ = _hull(_outer_corners(np.argwhere(cells)))
    if cells.sum() >= CONVEX * volume:
        return [cells]
    best, filled = None, float(cells.sum()) / volume + GAIN
    # level cuts first: a seat goes through below its back
    for axis in (2, 1, 0):
        areas = np.moveaxis(cells, axis, 0).sum(axis=(1, 2))
        for last in np.argsort(-np.abs(np.diff(areas)), kind="stable")[:CUTS]:
            sides = _halves(cells, axis, int(last) + 1)
            hulls = sum(_hull(_outer_corners(np.argwhere(side)))[0] for side in sides)
            if len(sides) > 1 and cells.sum() / hulls > filled:
                best, filled = sides, float(cells.sum()) / hulls
    return [cells] if best is None else [part for side in best for part in convex_cut(side)]


def _halves(cells: _Cells, axis: int, place: int) -> list[_Cells]:
    """What hangs together of the cells before a place along an axis, and of those from it on."""
    from scipy import ndimage

    first = (np.arange(cells.shape[axis]) < place).reshape(
        [-1 if i == axis else 1 for i in range(3)]
    )
    found = []
    for side in (cells & first, cells & ~first):
        labels, count = ndimage.label(side)
        found += [labels == number for number in range(1, count + 1)]
    return found


def convex_joined(parts: Indices) -> Indices:
    """The same parts (nx, ny, nz), with those that are nearly convex together under one number.

    The two that together fill their hull the most are joined first.
    """
    found = parts.copy()
    count = int(parts.max())
    sizes = np.bincount(parts.ravel(), minlength=count + 1).tolist()
    hulls = {i: _hull(_outer_corners(np.argwhere(parts == i)))[1] for i in range(1, count + 1)}
    fills: dict[tuple[int, int], float] = {}

    def together(one: int, other: int) -> float:
        if (one, other) not in fills:
            volume, _ = _hull(np.concatenate([hulls[one], hulls[other]]))
            fills[one, other] = (sizes[one] + sizes[other]) / volume
        return fills[one, other]

    touching = _touching(found)
    while touching:
        best = max(touching, key=lambda pair: (together(*pair), pair))
        if together(*best) < CONVEX:
            break
        one, other = best
        found[found == other] = one
        hulls[one] = _hull(np.concatenate([hulls[one], hulls.pop(other)]))[1]
        sizes[one] += sizes[other]
        for pair in [pair for pair in fills if one in pair or other in pair]:
            del fills[pair]
        renamed = (tuple(sorted(one if i == other else i for i in pair)) for pair in touching)
        touching = {(a, b) for a, b in renamed if a != b}
    return found


def _touching(parts: Indices) -> set[tuple[int, int]]:
    """Pairs of parts, the lower number first, of which cells share a side."""
    found: set[tuple[int, int]] = set()
    for axis in range(3):
        moved = np.moveaxis(parts, axis, 0)
        one, other = moved[:-1], moved[1:]
        meet = (one != other) & (one > 0) & (other > 0)
        pairs = np.sort(np.stack([one[meet], other[meet]], axis=-1), axis=-1)
        found.update((a, b) for a, b in np.unique(pairs, axis=0).tolist())
    return found


def _outer_corners(cells: Indices) -> FloatArray:
    """Corners (k, 3) of cells (n, 3) in their order, all of their convex hull among them."""
    # Between the lowest and the highest of a column nothing is a corner.
    ends = np.any(cells[1:, :2] != cells[:-1, :2], axis=1)
    outer = cells[np.concatenate([[True], ends]) | np.concatenate([ends, [True]])]
    corners: FloatArray = (outer[:, None] + _CORNERS).reshape(-1, 3).astype(np.float64)
    return corners


def _hull(points: FloatArray) -> tuple[float, FloatArray]:
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    return float(hull.volume), points[hull.vertices]
