"""The openings of a thing: holes that one sees through, with the thing all round them.

They are looked for along the directions of the thing's space. Where it stands on the ground, the
ground closes them below, as between the posts of a gate.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.ragged import Indices
from facetlog.perception.space.grid import Grid, Lattice
from facetlog.perception.space.space import Space, State
from facetlog.perception.types import FloatArray

# A hole that is nowhere so many cells wide is no more than how surfaces round to cells.
FEWEST_CELLS = 2
# So much of a hole is known to be free right through, or it may be closed where nobody looked.
SEEN_THROUGH = 0.5

HALF = 0.5
"""Share of the cells that hold an opening's rim that is free, on average."""

_Plan = NDArray[np.bool_]


@dataclass(frozen=True, eq=False, slots=True)
class Opening:
    """A hole through a thing along the axis `along` of a lattice.

    `cells` (n, 2) are those that it takes in the plane of the two other axes, in their order, and
    `rim` (m, 3) the solid cells of the lattice that lie beside it. `low` and `high` (3,) are the
    ends of its box along the lattice's axes, in cells from its corner: in its plane they lie half a
    cell within its rim, but for the ground, along the hole at the ends of the rim.
    """

    lattice: Lattice
    along: int
    cells: Indices
    rim: Indices
    low: FloatArray
    high: FloatArray

    @property
    def across(self) -> tuple[int, int]:
        """The two axes of its plane."""
        one, two = (axis for axis in range(3) if axis != self.along)
        return one, two

    @property
    def extents(self) -> tuple[float, float]:
        """Its length and width in its plane."""
        sides = (self.high - self.low)[list(self.across)] * self.lattice.cell
        return float(sides.max()), float(sides.min())

    @property
    def corners(self) -> FloatArray:
        """The corners (8, 3) of its box in the scene's frame."""
        ends = np.array([self.low, self.high])
        each = np.stack(np.meshgrid(*ends.T, indexing="ij"), axis=-1).reshape(-1, 3)
        corners: FloatArray = (each * self.lattice.cell + self.lattice.corner) @ self.lattice.axes
        return corners

    def places(self, cells: Indices) -> FloatArray:
        """Return the middles (m, 3) of cells (m, 3) of the lattice in the scene's frame."""
        local = (cells + 0.5) * self.lattice.cell + self.lattice.corner
        places: FloatArray = local @ self.lattice.axes
        return places


def find_openings(space: Space, *, on_ground: bool) -> tuple[Opening, ...]:
    """Return the openings of the thing in its space, the largest first; `on_ground` says that it
    stands.

    Nothing that is unseen bounds one, and most of it is seen to be free.
    """
    every = (
        opening
        for axis in range(3)
        for opening in _along(space.least(), space.most(), axis, on_ground=on_ground and axis < 2)
    )
    return tuple(sorted(every, key=lambda opening: -len(opening.cells)))


def _along(least: Grid, most: Grid, axis: int, *, on_ground: bool) -> Iterator[Opening]:
    through = ~np.asarray(most.solid.any(axis=axis))
    inner = _enclosed(~np.asarray(least.solid.any(axis=axis)), on_ground=on_ground)
    for number in range(1, int(inner.max(initial=0)) + 1):
        hole = inner == number
        if is_wide(hole) and float(through[hole].mean()) >= SEEN_THROUGH:
            yield _opening(least, axis, hole)


def has_room_for_openings(
    space: Space, found: Sequence[Opening], *, on_ground: bool | None
) -> bool:
    """Return whether the space may have an opening besides those that were `found` in it, if what
    nobody saw, or what is only assumed, is full here and free there.

    A hole takes columns without surface, and none that leads out through free ones. Where it is
    not known whether the thing stands on the ground (`on_ground` is None), nor on which of its
    sides, the ground may close whatever lies within the thing's convex outline.
    """
    known_free = np.asarray(space.cells == State.FREE)
    sure = np.asarray(space.cells == State.FULL)
    for axis in range(3):
        room = ~np.asarray(sure.any(axis=axis))
        free = np.asarray(known_free.all(axis=axis))
        if on_ground is None:
            closed = _find_within_outline(free)
        else:
            closed = _enclosed(free, on_ground=on_ground and axis < 2) > 0
        room &= ~free | closed
        for opening in found:
            if opening.along == axis:
                one, two = opening.cells.T
                room[one, two] &= ~free[one, two]
                if not _is_one_opening(opening, free):
                    return True
        if is_wide(room):
            return True
    return False


def _enclosed(free: _Plan, *, on_ground: bool) -> Indices:
    """Return the free places (n, m) that others enclose, numbered from 1 on hole by hole, 0
    elsewhere.
    """
    from scipy import ndimage

    around = np.pad(free, 1, constant_values=True)
    if on_ground:
        around[:, 0] = False
    labels, count = ndimage.label(around)
    outside = np.union1d(labels[[0, -1]], labels[:, [0, -1]])
    numbers = np.zeros(count + 1, dtype=np.intp)
    enclosed = np.setdiff1d(np.arange(1, count + 1), outside)
    numbers[enclosed] = np.arange(1, len(enclosed) + 1)
    return np.asarray(numbers[labels[1:-1, 1:-1]])


def _find_within_outline(free: _Plan) -> _Plan:
    """Return places (n, m) within the convex outline of those that are not free, which a flat
    ground reaches and no further.
    """
    import shapely

    outline = shapely.convex_hull(shapely.multipoints(np.argwhere(~free)))
    places = np.indices(free.shape)
    return np.asarray(shapely.intersects_xy(outline, places[0], places[1]))


def _is_one_opening(opening: Opening, free: _Plan) -> bool:
    """Return whether it is one opening if what nobody saw of it is full: that may part it, or close
    it.
    """
    from scipy import ndimage

    hole = np.zeros(free.shape, dtype=bool)
    hole[tuple(opening.cells.T)] = True
    labels, count = ndimage.label(hole & free)
    return sum(is_wide(labels == number) for number in range(1, count + 1)) == 1


def is_wide(hole: _Plan) -> bool:
    """Return whether a hole is somewhere as wide as it must be."""
    from scipy import ndimage

    square = np.ones((FEWEST_CELLS, FEWEST_CELLS), dtype=bool)
    return bool(ndimage.binary_opening(hole, square).any())


def _opening(grid: Grid, axis: int, hole: _Plan) -> Opening:
    from scipy import ndimage

    beside = ndimage.binary_dilation(hole) & ~hole
    rim = np.argwhere(grid.solid & np.expand_dims(beside, axis))
    cells = np.argwhere(hole)
    low, high = np.zeros(3), np.zeros(3)
    across = [other for other in range(3) if other != axis]
    low[across], high[across] = cells.min(axis=0) - HALF, cells.max(axis=0) + 1 + HALF
    low[2] = max(low[2], 0.0)
    low[axis], high[axis] = rim[:, axis].min(), rim[:, axis].max() + 1
    return Opening(grid.lattice, axis, cells, rim, low, high)
