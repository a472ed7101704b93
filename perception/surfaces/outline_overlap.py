"""Outlines of many faces in planes: areas that two share, points that they hold.

Loops of faces without holes that are convex, which most are, are worked on as arrays, all at once;
for the others there is shapely.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.polygons import find_intersection, make_valid
from facetlog.perception.ragged import Bools, Indices, find_row_starts, sum_padded_rows
from facetlog.perception.types import FloatArray

Shapes = NDArray[np.object_]

FEW_CORNERS = 4

MOST_NUMBERS = 1_000_000
"""Numbers worked on in one go: some 10 MB an array."""


def following(sizes: Indices, longest: int) -> Indices:
    """Return place (r, k) of the corner after each one of loops of some sizes (r,).

    What is beyond the last corner is followed by itself.

    >>> following(np.array([3]), 4).tolist()
    [[1, 2, 0, 3]]
    """
    steps = np.arange(longest)
    if len(sizes) and (sizes == longest).all():  # as quads are: one row does for all
        return np.broadcast_to((steps + 1) % longest, (len(sizes), longest))
    last = (sizes - 1)[:, None]
    return np.where(steps == last, 0, steps + (steps < last))


def find_convex_loops(loops: FloatArray, sizes: Indices) -> Bools:
    """Return which loops (r, k, 2) turn left at every corner, and once round in all."""
    rows, after = np.arange(len(loops))[:, None], following(sizes, loops.shape[1])
    here = loops[rows, after] - loops
    there = here[rows, after]
    twist = here[..., 0] * there[..., 1] - here[..., 1] * there[..., 0]
    beyond = np.arange(loops.shape[1]) >= sizes[:, None]
    turn = np.where(beyond, 0.0, np.arctan2(twist, (here * there).sum(axis=2))).sum(axis=1)
    return np.asarray(((twist > 0.0) | beyond).all(axis=1) & (turn < 3.0 * np.pi) & (sizes > 2))


def _compute_loop_areas(loops: FloatArray) -> FloatArray:
    """Return signed areas (r,) of loops (r, k, 2), counter-clockwise positive."""
    spokes = loops[:, 1:] - loops[:, :1]
    one, two = spokes[:, :-1], spokes[:, 1:]
    return 0.5 * sum_padded_rows(one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0])


def _reduce_corners(which: np.ufunc, loops: FloatArray) -> FloatArray:
    """Return lowest or highest coordinates (r, 2) of loops (r, k, 2), corner by corner: numpy
    reduces an axis in the middle slowly.
    """
    found = loops[:, 0] if loops.shape[1] else np.zeros((len(loops), 2))
    for k in range(1, loops.shape[1]):
        found = which(found, loops[:, k])
    return found


def make_valid_polygons(
    corners: FloatArray, rings: Indices, faces: Indices, sound: Bools
) -> Shapes:
    """Return polygons (r,) of corners (c, 2) in rings of some lengths, of these faces (rings,), in
    order.

    The first ring of a face is its outline. What is not `sound` (r,), known to be valid, is made
    so: of a loop that crosses itself remains what it surrounds.
    """
    ring_of = np.repeat(np.arange(len(rings)), rings)
    polygons = shapely.polygons(shapely.linearrings(corners, indices=ring_of), indices=faces)
    polygons[~sound] = make_valid(polygons[~sound])
    return np.asarray(polygons, dtype=np.object_)


def measure_loop_distances(
    loops: FloatArray, sizes: Indices, where: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return distances (r, q) of points (r, q, 2) from convex loops (r, k, 2): outside, and to the
    rim.

    The former is 0 within the loop.
    """
    loops = loops[:, : sizes.max(initial=1)]
    after = loops[np.arange(len(loops))[:, None], following(sizes, loops.shape[1])]
    # Coordinate by coordinate: numpy adds up two numbers a row slowly.
    x, y = loops[:, None, :, 0], loops[:, None, :, 1]
    span_x, span_y = after[:, None, :, 0] - x, after[:, None, :, 1] - y
    beside_x, beside_y = where[:, :, None, 0] - x, where[:, :, None, 1] - y
    within = (span_x * beside_y - span_y * beside_x >= 0.0).all(axis=2)
    square = np.maximum(span_x * span_x + span_y * span_y, 1e-300)
    t = np.clip((beside_x * span_x + beside_y * span_y) / square, 0.0, 1.0)
    apart_x, apart_y = beside_x - t * span_x, beside_y - t * span_y
    square = apart_x * apart_x + apart_y * apart_y
    # What repeats the last corner must not say where it is once more, rounded otherwise.
    square = np.where((np.arange(loops.shape[1]) < sizes[:, None])[:, None], square, np.inf)
    rim: FloatArray = np.sqrt(square.min(axis=2))
    return np.where(within, 0.0, rim), rim


@dataclass(frozen=True, eq=False, slots=True)
class Outlines:
    """Outlines (r,) of faces, each in a frame of its own.

    `loops` (r, k, 2) of `sizes` (r,) corners run counter-clockwise; shorter ones repeat their last
    corner. `areas` (r,) are without holes. `shapes` (r,) are polygons of what is not `convex` (r,).
    """

    loops: FloatArray
    sizes: Indices
    areas: FloatArray
    convex: Bools
    shapes: Shapes

    @classmethod
    def of(
        cls,
        loops: FloatArray,
        sizes: Indices,
        convex: Bools,
        rings_of: Callable[[Indices], tuple[FloatArray, Indices, Indices]],
    ) -> "Outlines":
        """Make outlines of loops (r, k, 2), either way round, of faces that are `convex` (r,) in
        their planes.

        `rings_of` rows gives the outlines and holes of what is not convex: corners (c, 2) of rings,
        how many each ring has, and whose it is, as a place among these rows.
        """
        areas = _compute_loop_areas(loops)
        steps = np.minimum(np.arange(loops.shape[1]), sizes[:, None] - 1)
        steps = np.where(areas[:, None] < 0.0, (sizes[:, None] - steps) % sizes[:, None], steps)
        loops, areas = loops[np.arange(len(loops))[:, None], steps], np.abs(areas)
        convex = convex & find_convex_loops(loops, sizes)
        shapes = np.full(len(loops), None, dtype=np.object_)
        others = np.flatnonzero(~convex)
        if len(others):
            corners, lengths, owner = rings_of(others)
            doubtful = np.zeros(len(others), np.bool_)
            shapes[others] = make_valid_polygons(corners, lengths, owner, doubtful)
            areas[others] = shapely.area(shapes[others])
        return cls(loops, sizes, areas, convex, shapes)

    @property
    def low(self) -> FloatArray:
        """Lowest coordinates (r, 2)."""
        return _reduce_corners(np.minimum, self.loops)

    @property
    def high(self) -> FloatArray:
        """Highest coordinates (r, 2)."""
        return _reduce_corners(np.maximum, self.loops)

    def take(self, rows: Indices | Bools) -> "Outlines":
        """Return the chosen rows."""
        return Outlines(
            self.loops[rows],
            self.sizes[rows],
            self.areas[rows],
            self.convex[rows],
            self.shapes[rows],
        )

    def polygons(self) -> Shapes:
        """Return all of them as polygons (r,)."""
        shapes = self.shapes.copy()
        shapes[self.convex] = shapely.polygons(self.loops[self.convex])
        return shapes

    def corners(self) -> tuple[FloatArray, Bools]:
        """Return corners (r, k, 2) of what the outlines surround, and which are there (r, k)."""
        there = np.arange(self.loops.shape[1]) < self.sizes[:, None]
        others = np.flatnonzero(~self.convex)
        if not len(others):
            return self.loops, there
        found, row = shapely.get_coordinates(self.shapes[others], return_index=True)
        counts = np.bincount(row, minlength=len(others))
        widest = max(int(counts.max()), self.loops.shape[1])
        loops, known = np.zeros((len(there), widest, 2)), np.zeros((len(there), widest), np.bool_)
        loops[:, : there.shape[1]], known[:, : there.shape[1]] = self.loops, there
        known[others] = np.arange(widest) < counts[:, None]
        loops[others[row], np.arange(len(row)) - np.repeat(find_row_starts(counts), counts)] = found
        return loops, known

    def get_padded_corners(self, longest: int) -> FloatArray:
        """Return corners (r, longest, 2): what is beyond the last corner repeats it."""
        steps = np.minimum(np.arange(longest), self.loops.shape[1] - 1)
        return self.loops[:, steps]

    def compute_shared_areas(self, others: "Outlines") -> FloatArray:
        """Return areas (r,) that these share with the others (r,), one with one."""
        shared = np.zeros(len(self.areas))
        meet = ((self.low < others.high) & (others.low < self.high)).all(axis=1)
        simple = self.convex & others.convex
        fewer = np.minimum(self.sizes, others.sizes)
        # Clipping takes a step for each corner of the one that has fewer: most have four.
        for rows in (
            np.flatnonzero(meet & simple & (fewer <= FEW_CORNERS)),
            np.flatnonzero(meet & simple & (fewer > FEW_CORNERS)),
        ):
            step = max(1, MOST_NUMBERS // max(4 * self.loops.shape[1] * others.loops.shape[1], 1))
            for start in range(0, len(rows), step):
                some = rows[start : start + step]
                shared[some] = _compute_convex_overlaps(self.take(some), others.take(some))
        rows = np.flatnonzero(meet & ~simple)
        if len(rows):
            one, two = self.take(rows).polygons(), others.take(rows).polygons()
            shared[rows] = shapely.area(find_intersection(one, two))
        return shared

    def hold(self, where: FloatArray) -> Bools:
        """Return which points (r, q, 2) the outlines hold, one row each, their rims included (r,
        q).
        """
        within = np.zeros(where.shape[:2], dtype=np.bool_)
        rows = np.flatnonzero(self.convex)
        # Those with more corners first: each step has to do with the first rows alone.
        rows = rows[np.argsort(-self.sizes[rows], kind="stable")]
        inside = np.ones((len(rows), where.shape[1]), dtype=np.bool_)
        loops = self.loops[rows, : self.sizes[rows].max(initial=0)]
        x, y = where[rows, :, 0], where[rows, :, 1]
        after = loops[np.arange(len(rows))[:, None], following(self.sizes[rows], loops.shape[1])]
        span = after - loops
        for k in range(loops.shape[1]):
            n = int((self.sizes[rows] > k).sum())
            a, side = loops[:n, k, :, None], span[:n, k, :, None]
            inside[:n] &= side[:, 0] * (y[:n] - a[:, 1]) >= side[:, 1] * (x[:n] - a[:, 0])
        within[rows] = inside
        others = np.flatnonzero(~self.convex)
        if len(others):
            shapely.prepare(self.shapes[others])
            at = where[others]
            within[others] = shapely.intersects_xy(
                self.shapes[others, None], at[..., 0], at[..., 1]
            )
        return within


def _compute_convex_overlaps(one: Outlines, two: Outlines) -> FloatArray:
    """Return areas (p,) that convex outlines (p,) share, side by side.

    The one that has fewer corners clips the other. Sutherland and Hodgman (1974).
    """
    clips = (one.sizes < two.sizes)[:, None]
    longest = max(int(one.sizes.max()), int(two.sizes.max()))
    first, second = one.get_padded_corners(longest), two.get_padded_corners(longest)
    sizes = np.where(clips[:, 0], two.sizes, one.sizes)
    loops = np.where(clips[..., None], second, first)[:, : sizes.max()]
    other_sizes = np.where(clips[:, 0], one.sizes, two.sizes)
    others = np.where(clips[..., None], first, second)[:, : other_sizes.max()]
    after = others[np.arange(len(others))[:, None], following(other_sizes, others.shape[1])]
    for k in range(others.shape[1]):
        loops, sizes = _clip_loops(loops, sizes, others[:, k], after[:, k])
    return np.maximum(_compute_loop_areas(loops), 0.0)


def _clip_loops(
    loops: FloatArray, sizes: Indices, start: FloatArray, end: FloatArray
) -> tuple[FloatArray, Indices]:
    """Return the parts of convex loops (p, k, 2) left of lines from `start` (p, 2) to `end` (p,
    2).
    """
    rows, longest = np.arange(len(loops))[:, None], loops.shape[1]
    after, there = following(sizes, longest), np.arange(longest) < sizes[:, None]
    side, spokes = (end - start)[:, None], loops - start[:, None]
    depth = side[..., 0] * spokes[..., 1] - side[..., 1] * spokes[..., 0]
    inside = depth >= 0.0
    crosses = there & (inside != inside[rows, after])
    span = np.where(crosses, depth - depth[rows, after], 1.0)
    cut = loops + (depth / span)[..., None] * (loops[rows, after] - loops)
    # Each corner that is inside, and then where the side from there on crosses the line.
    found = np.stack([loops, cut], axis=2).reshape(len(loops), -1, 2)
    kept = np.stack([inside & there, crosses], axis=2).reshape(len(loops), -1)
    sizes = kept.sum(axis=1)
    order = np.argsort(~kept, axis=1, kind="stable")
    steps = np.arange(max(int(sizes.max(initial=0)), 1))
    place = order[rows, np.minimum(steps, np.maximum(sizes - 1, 0)[:, None])]
    return found[rows, place], sizes
