"""Convex hulls and least rectangles of many sets of points in planes at once."""

import numpy as np

from facetlog.perception.flat_faces import hull_indices
from facetlog.perception.outlines import convex_loops, following
from facetlog.perception.row_table import Bools, Indices
from facetlog.perception.types import FloatArray

__all__ = ["Hulls", "least_rectangle", "least_rectangles"]

# Rectangles this much larger than the least one count as equal, and the longest of them is taken:
# all three round a triangle are of one size, and rounding must not choose. A 1 % difference in
# area is what an error of 0.5 % in each side gives.
RECTANGLE_TIE = 0.01

MOST_PRODUCTS = 2_000_000
"""Products of corners and sides worked out in one go: some 50 MB."""


class Hulls:
    """Convex hulls (r, h) of rows of points, counter-clockwise, as places in these rows.

    `sizes` (r,) are the numbers of corners; shorter rows repeat their last.
    """

    __slots__ = ("places", "sizes")

    def __init__(self, flat: FloatArray, there: Bools, slack: float = 0.0) -> None:
        """Hulls of the points (r, k, 2) that are `there` (r, k); `slack` as in hull_indices."""
        counts = there.sum(axis=1)
        in_a_row = (there == (np.arange(there.shape[1]) < counts[:, None])).all(axis=1)
        loop = in_a_row & convex_loops(flat, counts)
        if slack > 0.0:
            loop &= _sharp(flat, counts, slack)
        # An outline that is its own hull begins at its lowest x, as hulls do.
        x = np.where(there, flat[..., 0], np.inf)
        least = np.where(x == x.min(axis=1, initial=np.inf, keepdims=True), flat[..., 1], np.inf)
        first = least.argmin(axis=1) if there.shape[1] else counts
        found: dict[int, Indices] = {}
        for row in np.flatnonzero(~loop).tolist():
            own = np.flatnonzero(there[row])
            found[row] = own[hull_indices(flat[row, own], slack)]
        self.sizes = counts.copy()
        for row, own in found.items():
            self.sizes[row] = len(own)
        steps = np.minimum(np.arange(int(self.sizes.max(initial=0))), self.sizes[:, None] - 1)
        self.places = (first[:, None] + steps) % np.maximum(counts, 1)[:, None]
        for row, own in found.items():
            self.places[row] = own[steps[row]]

    def of(self, values: FloatArray) -> FloatArray:
        """The values (r, h, ...) at the hulls' corners, of all points' (r, k, ...)."""
        return np.asarray(values[np.arange(len(self.sizes))[:, None], self.places])


def _sharp(loops: FloatArray, sizes: Indices, slack: float) -> Bools:
    """Which loops (r, k, 2) have all corners farther than `slack` from their neighbours' line."""
    rows = np.arange(len(loops))[:, None]
    after = following(sizes, loops.shape[1])
    second = after[rows, after]
    here, chord = loops[rows, after] - loops, loops[rows, second] - loops
    twist = chord[..., 1] * here[..., 0] - chord[..., 0] * here[..., 1]
    length = np.sqrt((chord * chord).sum(axis=2))
    beyond = np.arange(loops.shape[1]) >= sizes[:, None]
    sharp: Bools = ((np.abs(twist) > slack * np.maximum(length, slack)) | beyond).all(axis=1)
    return sharp


def least_rectangle(flat: FloatArray) -> tuple[FloatArray, float, float]:
    """Direction (2,) of the longer side, and both sides, of the least rectangle round (n, 2)."""
    directions, lengths, widths = least_rectangles(flat[None], np.ones((1, len(flat)), np.bool_))
    return directions[0], float(lengths[0]), float(widths[0])


def least_rectangles(flat: FloatArray, there: Bools) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Directions (r, 2) of the longer sides, and both sides (r,), of the least rectangles round.

    Of the rectangles with a side on the hull of the points (r, k, 2) that are `there` (r, k), and
    within 1 % of the least area, it is the longest.
    """
    hulls = Hulls(flat, there)
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
    known = lengths > 0.0
    u = sides / np.where(known, lengths, 1.0)[..., None]
    u[~known.any(axis=1), 0] = [1.0, 0.0]
    known[:, 0] |= ~known.any(axis=1)
    v = u[..., ::-1] * [-1.0, 1.0]
    along = np.ptp(corners @ u.transpose(0, 2, 1), axis=1)
    across = np.ptp(corners @ v.transpose(0, 2, 1), axis=1)
    size = np.where(known, along * across, np.inf)
    tied = size <= size.min(axis=1, keepdims=True) * (1.0 + RECTANGLE_TIE)
    best = np.where(tied, np.maximum(along, across), -1.0).argmax(axis=1)
    along, across = along[every, best], across[every, best]
    turn = along < across
    direction = np.where(turn[:, None], v[every, best], u[every, best])
    return direction, np.where(turn, across, along), np.where(turn, along, across)
