"""Ways over floor that is known: shortest ones on cells in which the robot's middle may be.

Where it stands now may be no such cell: something was found beside it. Then it goes back by the way
it came, or else the shortest way to one, through cells that it touches nothing in.
"""

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from facetlog.perception.types import FloatArray
from facetlog.robot.collecting.route import Point, Route

__all__ = ["FloorWays", "Lattice"]

# Steps to the neighbours of a cell, half of them: the others are these the other way.
STEPS = ((0, 1), (1, 0), (1, 1), (1, -1))
# Places a cell along a straight line at which it is asked whether the line is free: a corner of a
# cell is cut by a quarter of its side at most.
PER_CELL = 2


class Lattice:
    """Where the cells (rows, columns) of a floor lie: `low` is the corner of cell (0, 0)."""

    def __init__(self, low: Point, side: float, shape: tuple[int, int]) -> None:
        self.low, self.side, self.shape = low, side, shape

    @classmethod
    def of_area(cls, area: tuple[float, float, float, float], side: float) -> "Lattice":
        """The cells of an area: x and y of its lowest corner, width and height."""
        x, y, width, height = area
        rows, columns = (max(math.floor(each / side + 0.5), 1) for each in (height, width))
        return cls((x, y), side, (rows, columns))

    def cell(self, place: Point) -> tuple[int, int]:
        """The cell of a place, beyond the rim too."""
        x, y = ((v - low) / self.side for v, low in zip(place, self.low, strict=True))
        return math.floor(y), math.floor(x)

    def holds(self, cell: tuple[int, int]) -> bool:
        """Whether there is such a cell."""
        return 0 <= cell[0] < self.shape[0] and 0 <= cell[1] < self.shape[1]

    @cached_property
    def middles(self) -> FloatArray:
        """The middles (rows, columns, 2) of the cells."""
        rows, columns = self.shape
        x = self.low[0] + (np.arange(columns) + 0.5) * self.side
        y = self.low[1] + (np.arange(rows) + 0.5) * self.side
        return np.stack(np.meshgrid(x, y), axis=-1)

    def away(self, place: Point) -> FloatArray:
        """How far the middle of each cell (rows, columns) is from a place."""
        found: FloatArray = np.linalg.norm(self.middles - np.array(place), axis=-1)
        return found


class FloorWays:
    """Ways from `here` over the cells that are `open_` (rows, columns) for the robot's middle, or
    that it `came` by.

    From where they lead to none that is open it goes `back` through more of the way it came, and
    where that leads to none through those that are `bare`: it fits in, no more.
    """

    def __init__(
        self,
        lattice: Lattice,
        open_: NDArray[np.bool_],
        bare: NDArray[np.bool_],
        here: Point,
        came: NDArray[np.bool_] | None = None,
        back: NDArray[np.bool_] | None = None,
    ) -> None:
        self._lattice, self._here = lattice, here
        self._start = lattice.cell(here)
        self.open = open_ if came is None else open_ | came
        if lattice.holds(self._start) and not np.isfinite(self._steps(self.open)[open_]).any():
            out = None if back is None else self._exit(open_, self.open | back)
            if out is None or not out.any():
                out = self._exit(open_, bare)
            self.open = self.open | out

    def _exit(self, open_: NDArray[np.bool_], bare: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """The cells by which it leaves a place that is not open: as few as lead to one that is."""
        away = self._lattice.away(self._here)
        usable = bare | (away <= self._lattice.side)
        usable[self._start] = True
        steps = self._steps(usable | open_)
        if not np.isfinite(steps[open_]).any():
            return np.zeros_like(open_)
        reach = float(steps[open_].min())
        found: NDArray[np.bool_] = usable & (steps <= reach)
        return found

    def _steps(self, usable: NDArray[np.bool_]) -> FloatArray:
        found = dijkstra(self._graph(usable), directed=False, indices=[self._number(self._start)])
        return np.asarray(found).reshape(usable.shape)

    def _number(self, cell: tuple[int, int]) -> int:
        return cell[0] * self._lattice.shape[1] + cell[1]

    def _graph(self, usable: NDArray[np.bool_]) -> csr_array:
        """Between neighbours that are usable, and not through the gap between two that are not."""
        rows, columns = usable.shape
        size = rows * columns
        row, column = np.nonzero(usable)
        ends, lengths = [], []
        # What is beyond the rim is not usable.
        wide = np.pad(usable, 1)
        for down, right in STEPS:
            free = wide[row + 1 + down, column + 1 + right]
            free = free & wide[row + 1 + down, column + 1] & wide[row + 1, column + 1 + right]
            first = row[free] * columns + column[free]
            ends.append((first, first + down * columns + right))
            lengths.append(np.full(len(first), self._lattice.side * math.hypot(down, right)))
        both = tuple(np.concatenate(each) for each in zip(*ends, strict=True))
        return csr_array((np.concatenate(lengths), both), shape=(size, size))

    @cached_property
    def _searched(self) -> tuple[FloatArray, NDArray[np.int32]]:
        """The length (n,) of the way to each cell, and the cell (n,) before it."""
        size = self.open.size
        if not self._lattice.holds(self._start):
            return np.full(size, np.inf), np.full(size, -1, np.int32)
        found, before = dijkstra(
            self._graph(self.open),
            directed=False,
            indices=[self._number(self._start)],
            return_predecessors=True,
        )
        return np.asarray(found[0]), np.asarray(before[0])

    @property
    def lengths(self) -> FloatArray:
        """The length (rows, columns) of the way to each cell, m; infinite where none leads."""
        return self._searched[0].reshape(self.open.shape)

    def length_to(self, place: Point) -> float:
        """The length of the way to a place, m; infinite where none leads there."""
        cell = self._lattice.cell(place)
        return float(self.lengths[cell]) if self._lattice.holds(cell) else math.inf

    def route_to(self, place: Point) -> Route | None:
        """The way there in few straight legs; None where none leads there."""
        if not math.isfinite(self.length_to(place)):
            return None
        cells = [self._number(self._lattice.cell(place))]
        before = self._searched[1]
        while before[cells[-1]] >= 0:
            cells.append(int(before[cells[-1]]))
        middles = self._lattice.middles.reshape(-1, 2)
        between = [(float(middles[c][0]), float(middles[c][1])) for c in cells[-2:0:-1]]
        return self._straightened([self._here, *between, place])

    def _is_free(self, one: Point, other: Point) -> bool:
        """Whether the robot's middle may go straight from one place to the other."""
        count = max(math.ceil(PER_CELL * math.dist(one, other) / self._lattice.side), 1)
        shares = np.linspace(0.0, 1.0, count + 1)[:, None]
        places = np.array(one) + shares * (np.array(other) - np.array(one))
        column, row = np.floor((places - self._lattice.low) / self._lattice.side).astype(int).T
        rows, columns = self.open.shape
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        return bool(inside.all() and self.open[row, column].all())

    def _straightened(self, points: list[Point]) -> Route:
        """The points without those that a straight leg passes by."""
        route = [points[0]]
        at, last = 0, len(points) - 1
        while at < last:
            at = next(
                (k for k in range(last, at + 1, -1) if self._is_free(points[at], points[k])), at + 1
            )
            route.append(points[at])
        return tuple(route)
