"""The space round one thing: full, free, assumed to be full, or unseen."""

from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.space.grid import Grid, Lattice
from facetlog.perception.types import FloatArray

# More than this share of cells neither free nor full, and a thing is not known from all sides:
# less is the rounding of a surface in cells.
LEAST_UNKNOWN = 0.01

# Along each axis every second cell stands for its neighbours, which show from where it shows.
EVERY = 2


class State(IntEnum):
    """Knowledge of a cell.

    `FREE`: a line of sight passed it, or it lies outside of a closed surface. `UNSEEN`: nobody
    looked into it. `ASSUMED`: it lies behind a surface that was seen, within the seen extent of the
    thing, and nothing says that it is free; it counts as full. `FULL`: it holds surface, or surface
    encloses it.
    """

    FREE = 0
    UNSEEN = 1
    ASSUMED = 2
    FULL = 3


@dataclass(frozen=True, eq=False, slots=False)
class Space:
    """The state (uint8) of each of the `cells` (nx, ny, nz) of a lattice round a thing.

    `closed` says that the thing's surface leaves nothing open behind it; then `rooms` (nx, ny, nz)
    are cells that count as full because their surface is nearly closed, but can be reached.
    """

    lattice: Lattice
    cells: NDArray[np.uint8]
    closed: bool
    rooms: NDArray[np.bool_] | None = None

    @property
    def cell(self) -> float:
        """The side of a cell."""
        return self.lattice.cell

    @property
    def axes(self) -> FloatArray:
        """The lattice's directions (3, 3) as rows, the last one up."""
        return self.lattice.axes

    @property
    def corner(self) -> FloatArray:
        """The lattice's lowest corner (3,), in its axes."""
        return self.lattice.corner

    def share(self, state: State) -> float:
        """Return how much of the lattice is in a state, 0..1."""
        return float((self.cells == state).mean())

    @property
    def unseen(self) -> float:
        """How much of the lattice nobody looked into, 0..1."""
        return self.share(State.UNSEEN)

    @cached_property
    def known(self) -> bool:
        """Whether the thing is known from all sides: closed, and nothing unseen or assumed."""
        unknown = (self.cells == State.UNSEEN) | (self.cells == State.ASSUMED)
        return self.closed and float(unknown.mean()) <= LEAST_UNKNOWN

    def measure_visible_unseen(self, axis: int, sense: int) -> float:
        """Return how much of what is unseen shows to who looks along that axis, 0..1, from beyond
        its end if `sense` is 1, from before its beginning if -1: all that nothing full hides.
        """
        unseen = self.cells == State.UNSEEN
        count = int(unseen.sum())
        if not count:
            return 0.0
        layers = np.moveaxis(self.cells > State.UNSEEN, axis, 0)[::-sense]
        hidden = np.moveaxis(np.logical_or.accumulate(layers, axis=0)[::-sense], 0, axis)
        return int((unseen & ~hidden).sum()) / count

    @cached_property
    def _least(self) -> Grid:
        # what is assumed reaches up to what is unseen, and shows no surface there
        return Grid(self.lattice, self.cells >= State.ASSUMED, self.cells == State.FULL)

    @cached_property
    def _most(self) -> Grid:
        if not self.unseen:
            return self._least
        solid = self.cells >= State.UNSEEN
        return Grid(self.lattice, solid, solid)

    def least(self) -> Grid:
        """Return the least that the thing may fill: what is unseen is free."""
        return self._least

    def most(self) -> Grid:
        """Return the most that the thing may fill: what is unseen is full; `least()` if
        nothing is.
        """
        return self._most


@dataclass(frozen=True, eq=False, slots=True)
class UnseenSpace:
    """The middles `points` (n, 3) of unseen cells of a space that stand for all of them."""

    space: Space
    points: FloatArray

    @classmethod
    def of(cls, space: Space) -> "UnseenSpace":
        """Choose cells that stand for the unseen part of a space."""
        cells = np.argwhere(space.cells == State.UNSEEN)
        some = cells[(cells % EVERY == 0).all(axis=1)]
        chosen = some if len(some) else cells
        lattice = space.lattice
        return cls(space, ((chosen + 0.5) * lattice.cell + lattice.corner) @ lattice.axes)

    def shown_from(self, place: FloatArray) -> NDArray[np.bool_]:
        """Return which points (n,) show from a place (3,) in the scene's frame.

        `Space.measure_visible_unseen` does so for a place far away along an axis.
        """
        lattice = self.space.lattice
        full = np.append((self.space.cells > State.UNSEEN).ravel(), np.False_)  # last: outside
        at = lattice.local(self.points)
        ray = lattice.local(place[None]) - at
        length = np.linalg.norm(ray, axis=1)
        ray = ray / np.maximum(length, 1.0)[:, None]
        shown = np.ones(len(at), np.bool_)
        # Beyond the lattice's diagonal there is nothing of the thing.
        for step in range(1, int(np.linalg.norm(lattice.shape)) + 1):
            on = np.flatnonzero(shown & (step < length))
            shown[on[full[lattice.numbers(at[on] + step * ray[on])]]] = False
        return shown
