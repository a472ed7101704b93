"""Through which cells lines of sight passed: nothing stands there.

A line ends where surface was seen, and passes no cell that holds measured surface: what is hidden
behind it is not free by that line.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.ragged import row_starts
from facetlog.perception.scene import SightLines
from facetlog.perception.space.grid import Cells, Lattice
from facetlog.perception.types import FloatArray

__all__ = ["places_through"]

# Places along a line are this far apart, in cells: it misses only cells that it cuts a corner of.
STEP = 0.5
# A line says nothing of the last cell before what it ends on.
BEFORE_END = 1.0
# Places that are worked on in one go: some 30 MB.
AT_ONCE = 400_000


def places_through(
    lattice: Lattice, sights: Iterable[SightLines], full: Cells
) -> NDArray[np.int32]:
    """From how many different places a line passed each cell (nx, ny, nz) before its end.

    `full` (nx, ny, nz) are the cells that hold measured surface; lines end there at the latest.
    """
    origins: dict[tuple[float, ...], list[FloatArray]] = {}
    for lines in sights:
        origins.setdefault(tuple(lines.origin.tolist()), []).append(lines.ends)
    counts = np.zeros(lattice.size, dtype=np.int32)
    flat = full.ravel()
    for origin, ends in origins.items():
        counts += _passed(lattice, np.array(origin), np.concatenate(ends), flat)
    return counts.reshape(lattice.shape)


def _passed(
    lattice: Lattice, origin: FloatArray, ends: FloatArray, full: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Cells (n,) that lines from one place to some ends (k, 3) passed."""
    passed = np.zeros(lattice.size, dtype=np.bool_)
    start = lattice.local(origin[None])[0]
    rays = lattice.local(ends) - start
    length = np.sqrt((rays * rays).sum(axis=1))
    ahead = length > BEFORE_END
    rays, length = rays[ahead], length[ahead]
    rays /= length[:, None]
    first, last = _within(lattice, start, rays)
    last = np.minimum(last, length - BEFORE_END)
    counts = np.maximum(np.ceil((last - first) / STEP), 0.0).astype(np.intp)
    through = np.flatnonzero(counts)
    batches = np.cumsum(counts[through]) // AT_ONCE
    for some in np.split(through, np.flatnonzero(np.diff(batches)) + 1):
        passed[_cells_of_lines(lattice, start, rays[some], first[some], counts[some], full)] = True
    return passed


def _within(lattice: Lattice, start: FloatArray, rays: FloatArray) -> tuple[FloatArray, FloatArray]:
    """From where to where, in cells along unit rays (k, 3), each is within the lattice.

    The first is not behind the start, and beyond the last where the ray misses the lattice.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = -start / rays, (np.array(lattice.shape) - start) / rays
    # along an axis that a ray does not run along, it is always within or never
    beside = (start < 0) | (start > lattice.shape)
    still = rays == 0.0
    low = np.where(still, np.where(beside, np.inf, -np.inf), low)
    high = np.where(still, np.where(beside, -np.inf, np.inf), high)
    first = np.maximum(np.minimum(low, high).max(axis=1), 0.0)
    last = np.maximum(low, high).min(axis=1)
    return first, np.where(still & beside, -np.inf, last[:, None]).min(axis=1)


def _cells_of_lines(
    lattice: Lattice,
    start: FloatArray,
    rays: FloatArray,
    first: FloatArray,
    counts: NDArray[np.intp],
    full: NDArray[np.bool_],
) -> NDArray[np.intp]:
    """The cells (m,) in which so many places along each ray lie, up to the first that is full."""
    starts = row_starts(counts)
    ray = np.repeat(np.arange(len(counts)), counts)
    nth = np.arange(len(ray)) - starts[ray]
    away = first[ray] + STEP * (nth + 0.5)
    nx, ny, nz = lattice.shape
    cell = np.zeros(len(ray), dtype=np.intp)
    for axis, size in enumerate((nx, ny, nz)):
        along = (start[axis] + away * rays[ray, axis]).astype(np.intp)
        cell = cell * size + np.clip(along, 0, size - 1)
    stopped = np.where(full[cell], nth, counts[ray])
    return cell[nth < np.minimum.reduceat(stopped, starts)[ray]]
