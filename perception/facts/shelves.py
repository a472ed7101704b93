"""How many shelves lie beneath a level: boards on which something could stand."""

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.facts.levels import Slab
from facetlog.perception.space.space import Space, State

__all__ = ["shelves_below"]

# A shelf faces up over this share of the level's plan: less is a rung, a rail or a drawer's rim.
BROAD = 0.5
# It lies in one layer of cells or across two: a surface beside the border of two is in either.
LAYERS = 2


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
    """How many times neighbouring layers, from the top on, face up in enough of the columns of
    cells (n, layers).
    """
    found, layer = 0, upper.shape[1]
    while layer > 0:
        first = max(0, layer - LAYERS)
        if float(upper[:, first:layer].any(axis=1).mean()) >= BROAD:
            found, layer = found + 1, first
        else:
            layer -= 1
    return found
