"""Level surfaces that face up in a cloud of all sides, found as peaks of the heights' histogram.

With up known a level surface has one unknown left, its height, which all of its points determine
together. That still works where neighbourhoods are wider than a board is thick, or where a cushion
is bent: there planes are not found, or a board's two sides are one plane, which may face down.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.signal import find_peaks

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.shapes.regions.visibility_grid import CUBES, FreeWays
from facetlog.perception.types import FloatArray

# Heights are counted in bins of this share of the noise, and the counts smoothed by the noise.
BIN_SHARE = 0.5
# A level's points are within so many sd of its height, ...
SLAB_SDS = 2.0
# ... and where it faces up there are next to none so many sd further up: a wall has as many there,
# a second layer at least a third.
CLEAR_SDS = 4.0
CLEAR_RATIO = 3.0
# Columns are so many spacings wide: nine points of a level surface fall into each on average, and
# one column in 160 has fewer than three.
COLUMN_SPACINGS = 3.0
LEAST_HELD = 3
# A level takes this share of the plan at least, as in levels.py: the rest is rims and leg ends.
LEAST_SHARE = 0.1
# No more than every second column of a level is filled, not held.
FILLED = 2.0
# Columns that are missing by chance are filled, one wide; strips less than two wide are the tops of
# walls, and are taken away.
CROSS = ndimage.generate_binary_structure(2, 1)
BLOCK = np.ones((2, 2), dtype=bool)
# Cubes of the grid that is looked out through, in spacings: where a surface's points fall half into
# one cube and half into the next, either is empty by chance once in e^6, 400.
CUBE_SPACINGS = 3.5
# A level is not an inner side of a closed box if this share of all directions is free above it, on
# the mean over its columns: half-way up to what is above it, or all if nothing is.
LEAST_SIGHT = 0.03
# Columns at the rim, so many wide, have no say: a cube there reaches past the rim.
RIM = 2
# Half of what faces up at a height is known already: it needs no second face.
KNOWN_SHARE = 0.5


def find_levels_by_height(
    points: FloatArray, up: FloatArray, known: NDArray[np.bool_], *, noise: float, spacing: float
) -> Iterator[NDArray[np.intp]]:
    """Yield rows of points (n, 3) on each level that faces up, those of most points first.

    `known` (n,) are points of faces that look up: what is mostly of these is left out. `up` is a
    unit vector, `noise` the sd of a point off its surface, `spacing` the typical distance between
    points on it. A level is connected, and no point is in two.
    """
    if not (noise > 0.0 and spacing > 0.0 and np.ptp(points @ up) > SLAB_SDS * noise):
        return
    columns = _Columns.of(points, up, COLUMN_SPACINGS * spacing)
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    ways = FreeWays.of(points, max(CUBE_SPACINGS * spacing, extent / CUBES))
    free = np.ones(len(points), dtype=bool)
    for middle in _heights(columns.height, BIN_SHARE * noise):
        top = middle + SLAB_SDS * noise
        clear = top + CLEAR_SDS * noise
        rows = columns.between(middle - SLAB_SDS * noise, top)
        rows = rows[free[rows]]
        if len(rows) < LEAST_HELD * LEAST_SHARE * columns.taken / FILLED:
            continue  # where noise is little, a wall has as many heights as points
        held, over = columns.counts(rows), columns.counts(columns.between(top, clear))
        level = (held >= LEAST_HELD) & (held >= CLEAR_RATIO * over)
        roof = columns.find_lowest_from(clear)
        for part in _parts(level.reshape(columns.shape), LEAST_SHARE * columns.taken):
            members = rows[part.ravel()[columns.column[rows]]]
            free[members] = False
            if known[members].mean() >= KNOWN_SHARE:
                continue
            inner = members[_inner(part).ravel()[columns.column[members]]]
            gaps = roof[columns.column[inner]] - middle
            if _sight(points[inner], up, gaps, ways) >= LEAST_SIGHT:
                yield np.sort(members)


def _inner(part: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return columns of a part away from its rim, over which one sees past it; all if no other is
    left.
    """
    inner = ndimage.binary_erosion(part, iterations=RIM)
    return inner if inner.any() else part


def _sight(points: FloatArray, up: FloatArray, gaps: FloatArray, ways: FreeWays) -> float:
    """Return share of directions that are free half-way up from points (n, 3), all where gaps are
    inf.

    Into a gap narrower than two cubes the grid does not see.
    """
    sights = np.where(np.isinf(gaps), 1.0, 0.0)
    covered = np.flatnonzero(np.isfinite(gaps) & (gaps >= 2.0 * ways.cube))
    halves = gaps[covered, None] / 2.0
    sights[covered] = ways.open_share(points[covered] + halves * up)
    return float(sights.mean())


@dataclass(frozen=True, eq=False, slots=True)
class _Columns:
    """Points (n,) by height and by `column`, the number of a square of a plan of this `shape`.

    `order` are the rows by height, `taken` says how many columns hold a point.
    """

    height: FloatArray
    column: NDArray[np.intp]
    shape: tuple[int, int]
    order: NDArray[np.intp]
    taken: int

    @classmethod
    def of(cls, points: FloatArray, up: FloatArray, width: float) -> "_Columns":
        """Return columns so wide through points (n, 3)."""
        height = points @ up
        plan = points @ make_plane_axes(up, np.roll(up, 1)).T
        places = np.floor((plan - plan.min(axis=0)) / width).astype(np.intp)
        shape = (int(places[:, 0].max()) + 1, int(places[:, 1].max()) + 1)
        column = places @ np.array([shape[1], 1])
        taken = int(np.count_nonzero(np.bincount(column)))
        return cls(height, column, shape, np.argsort(height, kind="stable"), taken)

    def between(self, low: float, high: float) -> NDArray[np.intp]:
        """Return rows, ascending by height, of the points from `low` up to below `high`."""
        first, last = np.searchsorted(self.height, [low, high], sorter=self.order)
        rows: NDArray[np.intp] = self.order[first:last]
        return rows

    def counts(self, rows: NDArray[np.intp]) -> NDArray[np.intp]:
        """Return how many of some points are in each column."""
        return np.bincount(self.column[rows], minlength=self.shape[0] * self.shape[1])

    def find_lowest_from(self, low: float) -> FloatArray:
        """Return the height at which there is surface from `low` on, in a column or one next to it.

        It is inf where there is none: in one column alone points may be missing by chance.
        """
        rows = self.between(low, np.inf)
        counts = self.counts(rows)
        by_column = rows[np.argsort(self.column[rows], kind="stable")]
        held = counts >= LEAST_HELD
        found = np.full(len(counts), np.inf)
        starts = np.cumsum(counts) - counts
        found[held] = self.height[by_column[starts[held] + LEAST_HELD - 1]]
        return np.asarray(ndimage.minimum_filter(found.reshape(self.shape), 3)).ravel()


def _heights(height: FloatArray, step: float) -> list[float]:
    """Return heights at which more points are than right above and below, those of most points
    first.
    """
    low = float(height.min())
    bins = np.floor((height - low) / step).astype(np.intp)
    # empty bins at both ends, so that the highest and the lowest can be peaks
    counts = np.pad(np.bincount(bins).astype(np.float64), 3)
    smooth = ndimage.gaussian_filter1d(counts, 1.0 / BIN_SHARE, mode="constant")
    peaks = find_peaks(smooth)[0]
    return [low + (p - 2.5) * step for p in peaks[np.argsort(-smooth[peaks], kind="stable")]]


def _parts(level: NDArray[np.bool_], least: float) -> Iterator[NDArray[np.bool_]]:
    """Yield the connected parts of a plan with so many columns at least."""
    filled = ndimage.binary_closing(np.pad(level, 1), CROSS)[1:-1, 1:-1] | level
    broad = ndimage.binary_opening(filled, BLOCK)
    labels, count = ndimage.label(broad, np.ones((3, 3)))
    sizes = np.bincount(labels.ravel(), minlength=count + 1)
    for nth in np.argsort(-sizes[1:], kind="stable") + 1:
        if sizes[nth] >= max(least, 1.0):
            yield labels == nth
