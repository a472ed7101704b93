"""The hollows of a thing: spaces within it that are open at one side, at the top or in front.

A hollow is what walls stand round on four sides and a floor closes behind, and all that lies
between that and the floor. Its mouth is where the walls end and the space goes on: something may
hang over it. Where the thing stands on the ground, the ground closes it below.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from facetlog.perception.space.grid import ROUNDING, Cells
from facetlog.perception.space.openings import FEWEST_CELLS, HALF, Opening, is_wide
from facetlog.perception.space.space import Space, State

# The directions in which a hollow may be open, by axis and sense: up, and to each side.
_WAYS = ((2, 1), (0, 1), (0, -1), (1, 1), (1, -1))
# Two hollows that share this much of the smaller one are one: the one with the larger mouth stays.
SHARED = 0.5
# Walls stand round most of a hollow: behind two posts lies none.
WALLED = 0.5


@dataclass(frozen=True, eq=False, slots=True)
class Hollow(Opening):
    """A hollow along the axis `along`, whose section has the `cells`; `at_top` says where it opens.

    `mouth` is the share of its section that is open, 0..1; its box reaches from its floor to where
    its walls end. `filled` (nx, ny, nz) are its cells.
    """

    at_top: bool
    mouth: float
    filled: Cells

    @property
    def mouth_sd(self) -> float:
        """The sd of `mouth`: each of its sides is known to a cell."""
        return 4.0 * ROUNDING / float(np.sqrt(len(self.cells)))

    @property
    def depth(self) -> float:
        """How far it reaches in from its mouth."""
        return float((self.high - self.low)[self.along]) * self.lattice.cell


def find_hollows(space: Space, *, on_ground: bool) -> tuple[Hollow, ...]:
    """Return the hollows of the thing in its space, the largest first; `on_ground` says that it
    stands.

    Nothing that is unseen or assumed bounds one or is part of one.
    """
    free = np.asarray(space.cells == State.FREE)
    if space.rooms is not None:
        free = free | space.rooms
    solid = np.asarray(space.cells == State.FULL) & ~free
    every = [hollow for way in _WAYS for hollow in _open_along(space, free, solid, *way, on_ground)]
    every.sort(key=lambda hollow: -hollow.mouth * len(hollow.cells))
    kept: list[Hollow] = []
    for hollow in every:
        taken = SHARED * hollow.filled.sum()
        if all(int((hollow.filled & other.filled).sum()) <= taken for other in kept):
            kept.append(hollow)
    return tuple(sorted(kept, key=lambda hollow: -int(hollow.filled.sum())))


def _open_along(
    space: Space, free: Cells, solid: Cells, axis: int, sense: int, on_ground: bool
) -> Iterator[Hollow]:
    from scipy import ndimage  # loaded only now: few ask for hollows

    walled = free.copy()
    for other in range(3):
        for way in (1, -1):
            if (other, way) == (axis, sense) or (on_ground and (other, way) == (2, -1)):
                continue
            walled &= _meets(solid, other, way)
    # Narrower spaces come from rounding surfaces to cells.
    walled = ndimage.binary_opening(walled, np.ones((FEWEST_CELLS,) * 3, dtype=np.bool_))
    # layers from the floor to the mouth, and one beyond what the lattice holds
    layers = np.moveaxis(walled, axis, 0)[::sense]
    empty = np.concatenate([np.moveaxis(free, axis, 0)[::sense], *[np.ones_like(layers[:1])] * 2])
    within = layers.copy()
    for here in range(len(within) - 2, -1, -1):
        within[here] |= within[here + 1] & empty[here]
    ends = within.copy()
    ends[:-1] &= ~within[1:]
    for step in range(1, FEWEST_CELLS + 1):
        ends &= empty[step : step + len(ends)]
    labels, _ = ndimage.label(within)
    for number in np.setdiff1d(labels[ends], [0]).tolist():
        hollow = labels == number
        mouth, section = (hollow & ends).any(axis=0), hollow.any(axis=0)
        if not is_wide(mouth) or float(layers[hollow].mean()) < WALLED:
            continue
        filled = np.moveaxis(hollow[::sense], 0, axis)
        cells = np.argwhere(filled)
        low, high = cells.min(axis=0) - HALF, cells.max(axis=0) + 1 + HALF
        (high if sense > 0 else low)[axis] -= sense * HALF
        low[2] = max(low[2], 0.0)
        yield Hollow(
            space.lattice,
            axis,
            np.argwhere(section),
            np.zeros((0, 3), dtype=np.intp),
            low,
            high,
            axis == 2,
            float(mouth.sum()) / float(section.sum()),
            filled,
        )


def _meets(solid: Cells, axis: int, sense: int) -> Cells:
    """Return the cells from which something solid is met along an axis."""
    layers = np.moveaxis(solid, axis, 0)[::-sense]
    return np.moveaxis(np.logical_or.accumulate(layers, axis=0)[::-sense], 0, axis)
