"""How many shelves lie beneath a level: boards on which something could stand."""

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.facts.levels.levels import Slab
from facetlog.perception.space.space import Space, State

__all__ = ["shelves_below"]

# A shelf faces up over this share of the level's plan: less is a rung, a rail or a drawer's rim.
BROAD = 0.5


def shelves_below(space: Space, height: float) -> tuple[int, int] | None:
    """The fewest and the most shelves beneath the level at a height (along up, in the scene's
    frame), None if nothing faces up there.

    The fewest are those that were seen, the most those that could lie in unseen space besides.
    """
    least = space.least()
    slab = Slab.at(least, height)
    plan = slab.plan(least)
    if not plan.any():
        return None
    seen = least.upper[:, :, : slab.low][plan]
    unseen = space.cells[:, :, : slab.low][plan] == State.UNSEEN
    return _count(seen), _count(seen | unseen)


def _count(upper: NDArray[np.bool_]) -> int:
    """How many times, from the top on, enough of the columns of cells (n, layers) face up.

    They do so in one layer or across two: a surface beside the border of two is in either.
    """
    broad = _across_two(upper).mean(axis=0) >= BROAD
    found, layer = 0, len(broad) - 1
    while layer >= 0:
        found += int(broad[layer])
        layer -= 2 if broad[layer] else 1
    return found


def _across_two(upper: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """What faces up in each layer or the one below it."""
    found = upper.copy()
    found[:, 1:] |= upper[:, :-1]
    return found
