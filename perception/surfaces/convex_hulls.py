"""Convex hulls and least rectangles of many sets of points in planes at once."""

import math
from collections.abc import Sequence

import numpy as np
import shapely

from facetlog.perception.batch_linalg import dots
from facetlog.perception.ragged import Bools, Indices
from facetlog.perception.stable_order import TIE
from facetlog.perception.surfaces.outline_overlap import following
from facetlog.perception.types import FloatArray

# Rectangles this much larger than the least one count as equal, and the longest of them is taken:
# all three round a triangle are of one size, and rounding must not choose. A 1 % difference in
# area is what an error of 0.5 % in each side gives.
RECTANGLE_TIE = 0.01

MOST_PRODUCTS = 2_000_000
"""Products of corners and sides worked out in one go: some 50 MB."""


# Above so many points Qhull beats the chain below (measured, 2 µs a point against 80 µs a call).
MANY_POINTS = 40

Point = tuple[float, float, int]


class Hulls:
    """Convex hulls (r, h) of rows of points, counter-clockwise, as places in these rows.

    They begin at their lowest x, and lowest y there. `sizes` (r,) are the numbers of corners;
    shorter rows repeat their last.
    """

    __slots__ = ("places", "sizes")

    def __init__(
        self,
        flat: FloatArray,
        there: Bools,
        loops: Bools | None = None,
        slack: float | None = None,
    ) -> None:
        """Find the hulls of the points (r, k, 2) that are `there` (r, k), one at least in each row.

        What is there of `loops` (r,), if they are given, comes first and is a convex loop already.
        Corners no further than `slack` from the line between their neighbours are left out, so
        that rounding decides nothing where points repeat or stand in a row.
        """
        self.sizes = there.sum(axis=1)
        found: dict[int, list[int]] = {}
        if loops is None or not loops.all():
            others = np.arange(len(flat)) if loops is None else np.flatnonzero(~loops)
            hulls = _hull_each if slack is None else _find_hulls
            found = dict(zip(others.tolist(), hulls(flat[others], there[others]), strict=True))
            for row, own in found.items():
                self.sizes[row] = len(own)
        steps = np.arange(int(self.sizes.max(initial=0)))
        steps = np.minimum(steps, np.maximum(self.sizes - 1, 0)[:, None])
        # A loop that is its own hull begins at its lowest x, as hulls do.
        x = np.where(there, flat[..., 0], np.inf)
        least = np.where(x == x.min(axis=1, initial=np.inf, keepdims=True), flat[..., 1], np.inf)
        first = least.argmin(axis=1) if there.shape[1] else self.sizes
        self.places = (first[:, None] + steps) % np.maximum(there.sum(axis=1), 1)[:, None]
        for row, own in found.items():
            self.places[row] = own[-1]
            self.places[row, : len(own)] = own
        if slack is not None:
            self._straighten(self.of(flat), slack)

    def _straighten(self, corners: FloatArray, slack: float) -> None:
        """Leave out what is nearer than `slack` to the line between its neighbours."""
        for row in np.flatnonzero(~_sharp(corners, self.sizes, slack)).tolist():
            kept = _find_sharp_corners(corners[row, : self.sizes[row]].tolist(), slack)
            own = self.places[row, kept]
            self.sizes[row] = len(own)
            self.places[row] = own[-1]
            self.places[row, : len(own)] = own

    def of(self, values: FloatArray) -> FloatArray:
        """Return the values (r, h, ...) at the hulls' corners, of all points' (r, k, ...)."""
        return np.asarray(values[np.arange(len(self.sizes))[:, None], self.places])


def _find_hulls(flat: FloatArray, there: Bools) -> list[list[int]]:
    """Return places of each row's hull, counter-clockwise from the lowest x on, by GEOS, all at
    once.

    GEOS decides exactly what is a corner. So corners that are one but for rounding remain.
    """
    row, place = np.nonzero(there)
    # What it gives back are points that it was given, with their third coordinate.
    points = np.column_stack([flat[row, place], place])
    # No line has but one point.
    alone = np.flatnonzero(there.sum(axis=1) == 1)
    points = np.concatenate((points, points[np.searchsorted(row, alone)]))
    row = np.concatenate((row, alone))
    order = np.argsort(row, kind="stable")
    lines = shapely.linestrings(points[order], indices=row[order])
    corners, of = shapely.get_coordinates(
        shapely.convex_hull(lines), include_z=True, return_index=True
    )
    places, starts = corners[:, 2].astype(np.intp).tolist(), np.flatnonzero(np.diff(of, prepend=-1))
    lowest = np.lexsort((corners[:, 1], corners[:, 0], of))[starts]
    found = []
    for low, high, first in zip(
        starts.tolist(), [*starts[1:].tolist(), len(of)], lowest.tolist(), strict=True
    ):
        # Rings run clockwise, and end where they begin.
        loop = places[low : high - 1] if high - low > 2 else places[low:high]
        turn = (first - low) % len(loop) + 1
        found.append((loop[turn:] + loop[:turn])[::-1])
    return found


def _hull_each(flat: FloatArray, there: Bools) -> list[list[int]]:
    """Return the places of the hulls, row by row."""
    found = []
    for own, points in zip(map(np.flatnonzero, there), flat, strict=True):
        found.append(own[_hull(points[own])].tolist() if len(own) else [0])
    return found


def _hull(flat: FloatArray) -> list[int]:
    """Return places of the hull's corners, of points (n, 2), n > 0."""
    if len(flat) > MANY_POINTS:
        from scipy.spatial import ConvexHull, QhullError  # a quarter of a second to load

        try:
            corners: list[int] = ConvexHull(flat).vertices.tolist()  # type: ignore[assignment]
            return corners
        except QhullError:  # all on one line
            pass
    order = np.lexsort((flat[:, 1], flat[:, 0])).tolist()
    xy = flat.tolist()
    # Andrew's monotone chain (1979).
    points = [(*xy[i], i) for i in order]
    return _chain(points)[:-1] + _chain(points[::-1])[:-1] or [0]


def _chain(points: Sequence[Point]) -> list[int]:
    kept: list[Point] = []
    for point in points:
        x, y, _ = point
        while len(kept) > 1:
            (ax, ay, _), (bx, by, _) = kept[-2:]
            if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                break
            kept.pop()
        kept.append(point)
    return [place for _, _, place in kept]


def _sharp(loops: FloatArray, sizes: Indices, slack: float) -> Bools:
    """Return which loops (r, k, 2) have no corner within `slack` of the line of its
    neighbours.
    """
    rows = np.arange(len(loops))[:, None]
    after = following(sizes, loops.shape[1])
    second = after[rows, after]
    here, chord = loops[rows, after] - loops, loops[rows, second] - loops
    twist = chord[..., 1] * here[..., 0] - chord[..., 0] * here[..., 1]
    length = np.sqrt((chord * chord).sum(axis=2))
    beyond = np.arange(loops.shape[1]) >= sizes[:, None]
    sharp: Bools = ((np.abs(twist) > slack * np.maximum(length, slack)) | beyond).all(axis=1)
    return sharp


def _find_sharp_corners(loop: list[list[float]], slack: float) -> list[int]:
    """Return places of a convex loop's corners that are farther than `slack` from their neighbours'
    line.

    All, if less than three are left.
    """
    kept: list[int] = []
    for i, (x, y) in enumerate(loop):
        a = loop[kept[-1] if kept else -1]
        c = loop[i + 1] if i + 1 < len(loop) else loop[kept[0] if kept else 0]
        chord = math.dist(a, c)
        twist = (x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])
        if twist > slack * max(chord, slack):
            kept.append(i)
    return kept if len(kept) > 2 else list(range(len(loop)))


def find_least_rectangle(flat: FloatArray) -> tuple[FloatArray, float, float]:
    """Return the direction (2,) of the longer side, and both sides, of the least rectangle round
    (n, 2).
    """
    directions, lengths, widths = find_least_rectangles(
        flat[None], np.ones((1, len(flat)), np.bool_)
    )
    return directions[0], float(lengths[0]), float(widths[0])


def find_least_rectangles(
    flat: FloatArray, there: Bools, loops: Bools | None = None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return directions (r, 2) of the longer sides, and both sides (r,), of the least rectangles
    round.

    Of the rectangles with a side on the hull of the points (r, k, 2) that are `there` (r, k), and
    within 1 % of the least area, it is the longest. `loops` (r,) as for Hulls.
    """
    hulls = Hulls(flat, there, loops)
    corners, sizes = hulls.of(flat), hulls.sizes
    directions, lengths, widths = np.zeros((len(flat), 2)), np.zeros(len(flat)), np.zeros(len(flat))
    # Rows of like size together: a round table top must not make every quad as long.
    kind = np.ceil(np.log2(np.maximum(sizes, 1))).astype(np.intp)
    for size in np.unique(kind).tolist():
        rows = np.flatnonzero(kind == size)
        widest = int(sizes[rows].max())
        step = max(1, MOST_PRODUCTS // widest**2)
        for start in range(0, len(rows), step):
            some = rows[start : start + step]
            directions[some], lengths[some], widths[some] = _least(
                corners[some, :widest], sizes[some]
            )
    return directions, lengths, widths


def _least(corners: FloatArray, sizes: Indices) -> tuple[FloatArray, FloatArray, FloatArray]:
    every = np.arange(len(corners))
    sides = corners[every[:, None], following(sizes, corners.shape[1])] - corners
    lengths = np.sqrt((sides * sides).sum(axis=2))
    # Corners that are one but for rounding have a side of any direction between them.
    known = lengths > TIE * lengths.max(axis=1, keepdims=True)
    u = sides / np.where(known, lengths, 1.0)[..., None]
    u[~known.any(axis=1), 0] = [1.0, 0.0]
    known[:, 0] |= ~known.any(axis=1)
    v = u[..., ::-1] * [-1.0, 1.0]
    along, across = _reaches(corners, u), _reaches(corners, v)
    size = np.where(known, along * across, np.inf)
    tied = size <= size.min(axis=1, keepdims=True) * (1.0 + RECTANGLE_TIE)
    best = np.where(tied, np.maximum(along, across), -1.0).argmax(axis=1)
    along, across = along[every, best], across[every, best]
    turn = along < across
    direction = np.where(turn[:, None], v[every, best], u[every, best])
    return direction, np.where(turn, across, along), np.where(turn, along, across)


def _reaches(corners: FloatArray, ways: FloatArray) -> FloatArray:
    """Return extents (r, w) of corners (r, k, 2) along unit vectors (r, w, 2)."""
    reach = dots(corners[:, :, None], ways[:, None])
    return np.asarray(reach.max(axis=1) - reach.min(axis=1), dtype=np.float64)
