"""The floor as cells: free, occupied, or nobody looked.

- Free is floor that the camera saw: points of the ground that several views show (seen_ground.py),
  whose lines of sight end on it. Free is also where the robot's body was.
- Occupied is what stands within the outlines of things, whatever is seen beneath them.
- Sonars look at one height, some 20 cm. Where most of their beams ended, something is: that counts
  as occupied, unless the camera saw the floor there. Where most of them passed, nothing is of that
  height, which does not make the floor free: that is a state of its own.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.errors import InputError
from facetlog.mapping.beam_counts import BeamCounts, sector
from facetlog.mapping.sonar_beams import Beam
from facetlog.perception.scene import SeenLattice
from facetlog.perception.types import FloatArray
from facetlog.robot.pose2 import Pose2

RESOLUTION = 0.05
"""The side of a cell, metres, as maps of robots usually have it."""
# So many cells of unseen floor lie round all that is known.
BORDER = 1
# A grid of more cells is a mistake in its unit, or a view that looks at the horizon.
MOST_CELLS = 25_000_000
# Places of an arc that say how far it reaches.
FEW = 5


class Cell(IntEnum):
    """State of a cell."""

    UNSEEN = 0
    PASSED = 1
    """Only sonars looked there, and found nothing at their height."""
    FREE = 2
    OCCUPIED = 3


@dataclass(frozen=True, eq=False, slots=True)
class Seen:
    """Observations that a map's floor is made from, in the world, metres.

    `lattices` are points of the ground and which views show them; `way` are the robot's places, of
    a circle of `radius`; `plans` are those of things; `beams` those of sonars.
    """

    lattices: tuple[SeenLattice, ...] = ()
    way: tuple[Pose2, ...] = ()
    radius: float = 0.0
    plans: tuple[shapely.Geometry, ...] = ()
    beams: tuple[Beam, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class FloorGrid:
    """Cells (rows, columns) of `Cell`; row 0 is at the lowest y, column 0 at the lowest x.

    `low` (2,) is the corner of cell (0, 0) in the world, `side` that of a cell, metres.
    """

    cells: NDArray[np.uint8]
    low: tuple[float, float]
    side: float

    def area(self, state: Cell) -> float:
        """Return how much floor is in a state, m²."""
        return float((self.cells == state).sum()) * self.side**2

    @property
    def high(self) -> tuple[float, float]:
        """The corner opposite to `low`."""
        rows, columns = self.cells.shape
        return self.low[0] + columns * self.side, self.low[1] + rows * self.side

    @property
    def middles(self) -> FloatArray:
        """The middles (rows, columns, 2) of the cells."""
        rows, columns = self.cells.shape
        x = self.low[0] + (np.arange(columns) + 0.5) * self.side
        y = self.low[1] + (np.arange(rows) + 0.5) * self.side
        return np.stack(np.meshgrid(x, y), axis=-1)

    def at(self, x: float, y: float) -> Cell:
        """Return the state of a place; unseen outside of the grid."""
        column, row = (
            math.floor((v - o) / self.side) for v, o in zip((x, y), self.low, strict=True)
        )
        rows, columns = self.cells.shape
        inside = 0 <= row < rows and 0 <= column < columns
        return Cell(int(self.cells[row, column])) if inside else Cell.UNSEEN


def floor_grid(seen: Seen, side: float = RESOLUTION) -> FloorGrid:
    """Return the floor of what was seen, in cells of a side (m)."""
    coarse = [list_shown_points(lattice, np.inf) for lattice in seen.lattices]
    low, high = _extent(seen, coarse)
    first = np.floor(low / side).astype(int) - BORDER
    columns, rows = (np.ceil(high / side).astype(int) + BORDER - first).tolist()
    if rows * columns > MOST_CELLS:
        raise InputError(
            f"the map would have {columns} × {rows} cells of {side:g} m: give a larger --resolution"
        )
    canvas = _Canvas(first * side, side, (rows, columns))
    lowest = float(first[0] * side), float(first[1] * side)
    counts = BeamCounts(lowest, side, (rows, columns))
    for beam in seen.beams:
        counts.add(beam)
    cells = np.full((rows, columns), Cell.UNSEEN, np.uint8)
    cells[counts.passed] = Cell.PASSED
    cells[counts.echoed] = Cell.OCCUPIED
    free = canvas.bodies(seen.way, seen.radius)
    for lattice in seen.lattices:
        free |= canvas.holding(list_shown_points(lattice, side))
    cells[free] = Cell.FREE
    cells[canvas.filled(seen.plans)] = Cell.OCCUPIED
    return FloorGrid(cells, lowest, side)


def list_shown_points(lattice: SeenLattice, side: float) -> FloatArray:
    """Return points (n, 2) of the floor that are shown, as dense as cells ask for."""
    shown = lattice.shown.any(axis=0)
    at = np.argwhere(shown)
    pitch = float(np.linalg.norm(lattice.steps[0]))
    # Each point stands for the square round it; several to a cell where cells are smaller.
    parts = max(math.ceil(pitch / side), 1)
    offsets = (np.arange(parts) + 0.5) / parts - 0.5
    fine = np.stack(np.meshgrid(offsets, offsets), axis=-1).reshape(-1, 2)
    places = (at[:, None] + fine).reshape(-1, 2) @ lattice.steps + lattice.corner
    flat: FloatArray = places[:, :2]
    return flat


def _extent(seen: Seen, points: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and highest corner (2,) of all that is known."""
    boxes = [(*p.min(axis=0), *p.max(axis=0)) for p in points if len(p)]
    boxes += [shapely.bounds(plan) for plan in seen.plans]
    boxes += [
        (p.x - seen.radius, p.y - seen.radius, p.x + seen.radius, p.y + seen.radius)
        for p in seen.way
    ]
    for beam in seen.beams:
        ring = sector(beam, FEW)
        boxes.append((*ring.min(axis=0), *ring.max(axis=0)))
    if not boxes:
        return np.zeros(2), np.zeros(2)
    found = np.array(boxes, dtype=np.float64)
    return found[:, :2].min(axis=0), found[:, 2:].max(axis=0)


class _Canvas:
    """Shapes into cells whose middles they hold."""

    def __init__(self, low: FloatArray, side: float, shape: tuple[int, int]) -> None:
        self._low, self._side, self._shape = low, side, shape

    def holding(self, points: FloatArray) -> NDArray[np.bool_]:
        """Return the cells in which at least one of the points (n, 2) lies."""
        found = np.zeros(self._shape, np.bool_)
        column, row = np.floor((points - self._low) / self._side).astype(int).T
        inside = (row >= 0) & (row < self._shape[0]) & (column >= 0) & (column < self._shape[1])
        found[row[inside], column[inside]] = True
        return found

    def bodies(self, way: Sequence[Pose2], radius: float) -> NDArray[np.bool_]:
        """Return where the robot's body was."""
        if not way or radius <= 0.0:
            return np.zeros(self._shape, np.bool_)
        line = [(p.x, p.y) for p in way]
        path = (
            shapely.linestrings([*line, line[-1]]) if len(line) == 1 else shapely.linestrings(line)
        )
        return self.filled([shapely.buffer(path, radius)], touched=False)

    def filled(
        self, shapes: Sequence[shapely.Geometry], *, touched: bool = True
    ) -> NDArray[np.bool_]:
        """Return the cells that shapes touch, or else whose middles they hold."""
        found = np.zeros(self._shape, np.bool_)
        for shape in shapes:
            low_x, low_y, high_x, high_y = shapely.bounds(shape)
            first = np.floor((np.array([low_x, low_y]) - self._low) / self._side).astype(int)
            last = np.floor((np.array([high_x, high_y]) - self._low) / self._side).astype(int)
            (c0, r0), (c1, r1) = (
                np.maximum(first, 0),
                np.minimum(last, np.array(self._shape)[::-1] - 1),
            )
            if r1 < r0 or c1 < c0:
                continue
            x = self._low[0] + np.arange(c0, c1 + 1) * self._side
            y = self._low[1] + np.arange(r0, r1 + 1) * self._side
            across, up = np.meshgrid(x, y)
            shapely.prepare(shape)
            if touched:
                boxes = shapely.box(across, up, across + self._side, up + self._side)
                inside = shapely.intersects(shape, boxes)
            else:
                half = self._side / 2
                inside = shapely.contains_xy(shape, across + half, up + half)
            found[r0 : r1 + 1, c0 : c1 + 1] |= inside
        return found
