"""Clouds of all sides: whether a cloud is one, and the level surfaces that face up in it.

A scan from one side has no occluded points: there is a direction from which all of it is visible. A
cloud of all sides has hidden surface from every direction, for solids about half of it.

Level surfaces are peaks of the heights' histogram. With up known such a surface has one unknown
left, its height, which all of its points determine together. That still works where neighbourhoods
are wider than a board is thick, or where a cushion is bent: there planes are not found, or a
board's two sides are one plane, which may face down.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.signal import find_peaks
from scipy.spatial import cKDTree

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.shapes.clouds.lines_of_sight import MOST_PLACES
from facetlog.perception.shapes.regions.visibility_grid import CUBES, FreeWays
from facetlog.perception.space.flooding import OPEN_SHARE, is_empty_shell
from facetlog.perception.types import FloatArray

# A room, too, goes all round the sensor. It is told from a thing by what stands in it. Of a shell
# in which nothing stands nothing tells which it is: an empty room and a carton differ in size
# alone. It counts as a thing.

# Directions that are looked along, 20 degrees apart: a thing is closed in those in which it has
# points.
WAYS_ROUND = 96
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


def find_things_round_sensor(
    points: FloatArray,
    bodies: NDArray[np.intp],
    seen_from: FloatArray | None,
    up: FloatArray | None,
) -> tuple[int, ...]:
    """Return the numbers of the things that go round a place from which points (n, 3) were seen.

    `bodies` (n,) is the object of each, -1 for none; `seen_from` (n, 3) as of a Cloud. The ground
    closes a thing below where `up` (3,) is known.
    """
    if seen_from is None:
        return ()
    known = np.isfinite(seen_from).all(axis=1)
    places = np.unique(seen_from[known], axis=0)
    if len(places) > MOST_PLACES:
        return ()
    found = []
    for body in range(int(bodies.max(initial=-1)) + 1):
        own = points[bodies == body]
        low, high = own.min(axis=0), own.max(axis=0)
        within = places[((places > low) & (places < high)).all(axis=1)]
        if any(_is_round(own, points, place, up) for place in within):
            found.append(body)
    return tuple(found)


def _is_round(
    own: FloatArray, points: FloatArray, place: FloatArray, up: FloatArray | None
) -> bool:
    """Return whether a thing, of its `own` points (k, 3) of all, and no room, goes round a
    place.
    """
    rays = own - place
    ways = rays / np.maximum(np.linalg.norm(rays, axis=1), 1e-300)[:, None]
    directions = make_even_directions(WAYS_ROUND)
    asked = np.ones(len(directions), dtype=bool) if up is None else directions @ up > 0.0
    closed = np.zeros(len(directions), dtype=bool)
    closed[cKDTree(directions).query(ways)[1]] = True
    if not asked.any() or float((~closed[asked]).mean()) > OPEN_SHARE:
        return False
    return is_empty_shell(own, points, place)


# Directions to look along, each from both ends: none is further than 15 degrees from one of them.
DIRECTIONS = 48
GOLDEN_TURN = float(np.pi * (3.0 - np.sqrt(5.0)))
# Rays run through cells so many spacings wide: of points at random one cell in 500 is empty.
CELL_SPACINGS = 2.5
# A gap of so many sd and so many cells in depth separates two layers; less is noise, or the slope
# of one surface.
GAP_SDS = 4.0
GAP_CELLS = 1.0
# In a view from one side less than this is hidden: flying points, and points seen past an edge from
# beside the nearest tested direction. Of 62 views of boxes none hides more than 0.5 %; of
# noisy samples all over furniture the least, tables of one thin sheet on four legs, hide 1.3 %.
HIDDEN_SHARE = 0.01


def covers_all_sides(points: FloatArray, *, noise: float, spacing: float) -> bool:
    """Return whether more of points (n, 3) is hidden from every direction than in a view from one
    side.
    """
    return compute_least_hidden(points, noise=noise, spacing=spacing) > HIDDEN_SHARE


def compute_least_hidden(points: FloatArray, *, noise: float, spacing: float) -> float:
    """Return the share of points (n, 3) hidden behind others, from the direction where it is
    smallest.

    `noise` is the sd of a point off its surface, `spacing` the typical distance between points.
    """
    width = max(CELL_SPACINGS * spacing, 1e-300)
    gap = max(GAP_SDS * noise, GAP_CELLS * width)
    shares = [
        share
        for way in make_even_directions(DIRECTIONS, lowest=0.0)
        for share in _hidden(points, way, width, gap)
    ]
    return min(shares)


def make_even_directions(count: int, lowest: float = -1.0) -> FloatArray:
    """Return `count` unit vectors (count, 3) evenly over the sphere above a height, along a
    spiral.
    """
    nth = np.arange(count)
    height = lowest + (1.0 - lowest) * (nth + 0.5) / count
    radius = np.sqrt(1.0 - height**2)
    turn = GOLDEN_TURN * nth
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])


def _hidden(points: FloatArray, way: FloatArray, width: float, gap: float) -> tuple[float, float]:
    """Return shares of points hidden when seen along the direction `way`, and against it."""
    flat = points @ make_plane_axes(way, np.roll(way, 1)).T
    cells = np.floor((flat - flat.min(axis=0)) / width).astype(np.int64)
    cell = cells[:, 0] * (int(cells[:, 1].max()) + 1) + cells[:, 1]
    depth = points @ way
    order = np.lexsort((depth, cell))
    cell, depth = cell[order], depth[order]
    first = np.append(True, cell[1:] != cell[:-1])
    # the runs of points without a gap in depth: the first and the last of a cell lie open
    breaks = first | np.append(True, np.diff(depth) > gap)
    run = np.cumsum(breaks) - 1
    sizes = np.bincount(run)
    front: NDArray[np.bool_] = first[breaks]
    back = np.append(front[1:], True)
    return float(sizes[~front].sum()) / len(points), float(sizes[~back].sum()) / len(points)
