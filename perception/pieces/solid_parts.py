"""The cells that a thing fills into solid parts, by openings.

An opening keeps what a probe fills that lies wholly inside. A cube finds blocks, which are cut
where that makes them more convex, as a seat off a back as thick; flat squares find boards, square
to the grid, and where boards cross the larger goes through; sticks find bars. A probe half as long
finds the smaller ones among what is left. What none finds, as a leaning back, is a part as it hangs
together. Parts that are nearly convex together are one, as those of a wedge, and so is what nowhere
reaches farther from a larger part than crumbs do: rims, rounded edges.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.ragged import Indices
from facetlog.perception.types import FloatArray

_Cells = NDArray[np.bool_]

# Share of the convex hull that parts fill together. A slope in steps of cells takes some per cent
# from it; a flight of three steps, which is not one part, fills .88.
CONVEX = 0.9
# A cut has to fill so much more of the hulls.
GAIN = 1.0 - CONVEX
# Cuts are tried where the section changes most: so many along each axis.
CUTS = 2
_CORNERS = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(-1, 3)


def is_convex(cells: NDArray[np.bool_]) -> bool:
    """Return whether cells (nx, ny, nz), some at least, are nearly their own convex hull."""
    volume, _ = _hull(_find_outer_corners(np.argwhere(cells)))
    return int(cells.sum()) >= CONVEX * volume


def cut_to_convex(cells: _Cells) -> list[_Cells]:
    """Return cells (nx, ny, nz), some at least, cut square to the grid as long as that makes them
    more convex: a seat off the back that is as thick as it, a step off the next.
    """
    volume, _ = _hull(_find_outer_corners(np.argwhere(cells)))
    if cells.sum() >= CONVEX * volume:
        return [cells]
    best, filled = None, float(cells.sum()) / volume + GAIN
    # level cuts first: a seat goes through below its back
    for axis in (2, 1, 0):
        areas = np.moveaxis(cells, axis, 0).sum(axis=(1, 2))
        for last in np.argsort(-np.abs(np.diff(areas)), kind="stable")[:CUTS]:
            sides = _split_cells(cells, axis, int(last) + 1)
            hulls = sum(_hull(_find_outer_corners(np.argwhere(side)))[0] for side in sides)
            if len(sides) > 1 and cells.sum() / hulls > filled:
                best, filled = sides, float(cells.sum()) / hulls
    return [cells] if best is None else [part for side in best for part in cut_to_convex(side)]


def _split_cells(cells: _Cells, axis: int, place: int) -> list[_Cells]:
    """Return the connected parts of cells before a place along an axis, and of cells from it on."""
    from scipy import ndimage

    first = (np.arange(cells.shape[axis]) < place).reshape(
        [-1 if i == axis else 1 for i in range(3)]
    )
    found = []
    for side in (cells & first, cells & ~first):
        labels, count = ndimage.label(side)
        found += [labels == number for number in range(1, count + 1)]
    return found


def join_convex_parts(parts: Indices) -> Indices:
    """Return the parts (nx, ny, nz) with those that are nearly convex together under one number.

    The two that together fill their hull the most are joined first.
    """
    found = parts.copy()
    count = int(parts.max())
    sizes = np.bincount(parts.ravel(), minlength=count + 1).tolist()
    hulls = {i: _hull(_find_outer_corners(np.argwhere(parts == i)))[1] for i in range(1, count + 1)}
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
    """Return pairs of parts, the lower number first, of which cells share a side."""
    found: set[tuple[int, int]] = set()
    for axis in range(3):
        moved = np.moveaxis(parts, axis, 0)
        one, other = moved[:-1], moved[1:]
        meet = (one != other) & (one > 0) & (other > 0)
        pairs = np.sort(np.stack([one[meet], other[meet]], axis=-1), axis=-1)
        found.update((a, b) for a, b in np.unique(pairs, axis=0).tolist())
    return found


def _find_outer_corners(cells: Indices) -> FloatArray:
    """Return corners (k, 3) of cells (n, 3) in their order, all of their convex hull among them."""
    # Between the lowest and the highest of a column nothing is a corner.
    ends = np.any(cells[1:, :2] != cells[:-1, :2], axis=1)
    outer = cells[np.concatenate([[True], ends]) | np.concatenate([ends, [True]])]
    corners: FloatArray = (outer[:, None] + _CORNERS).reshape(-1, 3).astype(np.float64)
    return corners


def _hull(points: FloatArray) -> tuple[float, FloatArray]:
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    return float(hull.volume), points[hull.vertices]


# How long a probe is, of the thing's longest side: a fifth, then a tenth.
PROBES = (0.2, 0.1)
# What lies this near to a larger part, of the thing's longest side, and nowhere farther away from
# it, is no part of its own.
CRUMB = 0.05
_AROUND = np.ones((3, 3, 3), dtype=bool)


def solid_parts(solid: _Cells) -> Indices:
    """Return the part (nx, ny, nz), from 1, to which each of these solid cells belongs; 0
    elsewhere.

    Parts stand in the order of their sizes, the largest first.
    """
    if not solid.any() or is_convex(solid):
        return solid.astype(np.intp)
    longest = max(solid.shape)
    left = solid.copy()
    parts = np.zeros(solid.shape, dtype=np.intp)
    count = 0
    for cores in _iter_probed(left, longest):
        # Where two cross the larger goes through.
        for core in sorted(cores, key=lambda cells: -int(cells.sum())):
            own = core & left
            if own.any():
                count += 1
                parts[own] = count
                left &= ~own
    parts = _in_order(parts)
    parts = _in_order(_merge_crumbs(parts, max(1, round(CRUMB * longest))))
    return _in_order(join_convex_parts(parts))


def _iter_probed(left: _Cells, longest: int) -> Iterator[list[_Cells]]:
    """Yield the parts that each sort of probe finds in the cells left by then; at last the rest."""
    lengths = [max(3, round(share * longest)) for share in PROBES]
    for long in lengths:
        blocks = _connected(_opened(left, (long, long, long)))
        yield [part for block in blocks for part in cut_to_convex(block)]
        squares = [[1 if axis == flat else long for axis in range(3)] for flat in range(3)]
        yield [part for probe in squares for part in _connected(_opened(left, probe))]
    for long in lengths:
        sticks = [[long if axis == along else 1 for axis in range(3)] for along in range(3)]
        yield [part for probe in sticks for part in _connected(_opened(left, probe))]
    yield _connected(left)


def _connected(cells: _Cells) -> list[_Cells]:
    from scipy import ndimage

    labels, count = ndimage.label(cells, _AROUND)
    return [labels == number for number in range(1, count + 1)]


def _opened(cells: _Cells, probe: Sequence[int]) -> _Cells:
    """Return the cells that a box of so many cells fills which lies wholly inside."""
    if any(length > side for length, side in zip(probe, cells.shape, strict=True)):
        return np.zeros_like(cells)
    starts = cells
    for axis, length in enumerate(probe):
        starts = _find_full_stretches(starts, axis, length)
    for axis, length in enumerate(probe):
        starts = _mark_stretches(starts, axis, length)
    return starts


def _count_in_stretches(cells: _Cells, axis: int, length: int) -> NDArray[np.int16]:
    """Return how many of so many cells from each on along the axis are there: shorter by length -
    1.
    """
    sums = np.cumsum(cells, axis=axis, dtype=np.int16)  # there are some tens of cells
    sums = np.moveaxis(np.pad(sums, [(int(i == axis), 0) for i in range(3)]), axis, 0)
    found: NDArray[np.int16] = np.moveaxis(sums[length:] - sums[:-length], 0, axis)
    return found


def _find_full_stretches(cells: _Cells, axis: int, length: int) -> _Cells:
    """Return where so many cells from here on along the axis are all there."""
    return np.asarray(_count_in_stretches(cells, axis, length) == length)


def _mark_stretches(starts: _Cells, axis: int, length: int) -> _Cells:
    """Return the cells of stretches of this length along the axis that begin here."""
    margin = [(length - 1) * int(i == axis) for i in range(3)]
    padded = np.pad(starts, [(each, each) for each in margin])
    return np.asarray(_count_in_stretches(padded, axis, length) > 0)


def _merge_crumbs(parts: Indices, near: int) -> Indices:
    """Return the parts with all that lies wholly within `near` cells of a larger one as
    part of it.
    """
    from scipy import ndimage

    found = parts.copy()
    boxes = ndimage.find_objects(parts)
    for number in range(len(boxes), 1, -1):
        around = tuple(
            slice(max(0, own.start - near), own.stop + near) for own in boxes[number - 1]
        )
        window = found[around]
        own = window == number
        for larger in np.unique(window[ndimage.binary_dilation(own, _AROUND)]).tolist():
            if 0 < larger < number:
                away = ndimage.distance_transform_cdt(window != larger, metric="chessboard")
                if int(away[own].max()) <= near:
                    window[own] = larger
                    break
    return found


def _in_order(parts: Indices) -> Indices:
    """Return the parts numbered anew, without gaps, the largest first."""
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    order = np.argsort(-sizes, kind="stable")
    numbers = np.zeros(len(sizes), dtype=np.intp)
    there = order[sizes[order] > 0]
    numbers[there] = np.arange(1, len(there) + 1)
    found: Indices = numbers[parts]
    return found
