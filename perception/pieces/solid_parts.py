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

from facetlog.perception.pieces.convex_parts import convex_cut, convex_joined, is_convex
from facetlog.perception.ragged import Indices

__all__ = ["solid_parts"]

_Cells = NDArray[np.bool_]

# How long a probe is, of the thing's longest side: a fifth, then a tenth.
PROBES = (0.2, 0.1)
# What lies this near to a larger part, of the thing's longest side, and nowhere farther away from
# it, is no part of its own.
CRUMB = 0.05
_AROUND = np.ones((3, 3, 3), dtype=bool)


def solid_parts(solid: _Cells) -> Indices:
    """The part (nx, ny, nz), from 1, to which each of these solid cells belongs; 0 elsewhere.

    Parts stand in the order of their sizes, the largest first.
    """
    if not solid.any() or is_convex(solid):
        return solid.astype(np.intp)
    longest = max(solid.shape)
    left = solid.copy()
    parts = np.zeros(solid.shape, dtype=np.intp)
    count = 0
    for cores in _probed(left, longest):
        # Where two cross the larger goes through.
        for core in sorted(cores, key=lambda cells: -int(cells.sum())):
            own = core & left
            if own.any():
                count += 1
                parts[own] = count
                left &= ~own
    parts = _in_order(parts)
    parts = _in_order(_without_crumbs(parts, max(1, round(CRUMB * longest))))
    return _in_order(convex_joined(parts))


def _probed(left: _Cells, longest: int) -> Iterator[list[_Cells]]:
    """What each sort of probe finds in the cells that are left by then; at last the rest."""
    lengths = [max(3, round(share * longest)) for share in PROBES]
    for long in lengths:
        blocks = _connected(_opened(left, (long, long, long)))
        yield [part for block in blocks for part in convex_cut(block)]
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
    """The cells that a box of so many cells fills which lies wholly inside."""
    if any(length > side for length, side in zip(probe, cells.shape, strict=True)):
        return np.zeros_like(cells)
    starts = cells
    for axis, length in enumerate(probe):
        starts = _all_of(starts, axis, length)
    for axis, length in enumerate(probe):
        starts = _any_of(starts, axis, length)
    return starts


def _in_stretches(cells: _Cells, axis: int, length: int) -> NDArray[np.int16]:
    """How many of so many cells from each on along the axis are there: shorter by length - 1."""
    sums = np.cumsum(cells, axis=axis, dtype=np.int16)  # there are some tens of cells
    sums = np.moveaxis(np.pad(sums, [(int(i == axis), 0) for i in range(3)]), axis, 0)
    found: NDArray[np.int16] = np.moveaxis(sums[length:] - sums[:-length], 0, axis)
    return found


def _all_of(cells: _Cells, axis: int, length: int) -> _Cells:
    """Where so many cells from here on along the axis are all there."""
    return np.asarray(_in_stretches(cells, axis, length) == length)


def _any_of(starts: _Cells, axis: int, length: int) -> _Cells:
    """The cells of stretches of this length along the axis that begin here."""
    margin = [(length - 1) * int(i == axis) for i in range(3)]
    padded = np.pad(starts, [(each, each) for each in margin])
    return np.asarray(_in_stretches(padded, axis, length) > 0)


def _without_crumbs(parts: Indices, near: int) -> Indices:
    """The same with what lies wholly within `near` cells of a larger part in that part's number."""
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
    """The parts numbered anew, without gaps, the largest first."""
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    order = np.argsort(-sizes, kind="stable")
    numbers = np.zeros(len(sizes), dtype=np.intp)
    there = order[sizes[order] > 0]
    numbers[there] = np.arange(1, len(there) + 1)
    found: Indices = numbers[parts]
    return found
