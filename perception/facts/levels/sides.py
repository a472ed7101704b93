"""The four sides of a thing: closed above a level, open beneath it, or hollow.

All are measured in a grid (space/grid.py), over the thing's plan, along the grid's axes.
"""

from itertools import product

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.space.grid import Grid

__all__ = ["closed_at_back", "closed_sides", "hollow", "open_from_two_sides"]

# A back stands within this share of a level's extent from its rim, or beyond that.
RIM = 0.3
# A side is hollow where it lies deeper than this share of the longest: a panel's frame does not.
DEEP = 0.07

_Plan = NDArray[np.bool_]


def closed_sides(plan: _Plan, tall: _Plan) -> tuple[float, float, float, float]:
    """How much of each side's length of a level, 0..1, has something `tall` (nx, ny) above its rim.

    `plan` (nx, ny) is that of the level. Opposite sides follow one another.

    >>> seat = np.ones((10, 10), dtype=bool)
    >>> back = seat & (np.arange(10) == 9) & (np.arange(10) < 8)[:, None]
    >>> closed_sides(seat, back)
    (0.1, 0.1, 0.0, 0.8)
    """
    found = []
    for axis in (0, 1):
        own, risen = (plan, tall) if axis == 0 else (plan.T, tall.T)
        along, across = (np.flatnonzero(own.any(axis=k)) for k in (1, 0))
        first, last = int(along[0]), int(along[-1]) + 1
        depth = max(1, round(RIM * (last - first)))
        within = slice(int(across[0]), int(across[-1]) + 1)
        strips = slice(None, first + depth), slice(last - depth, None)
        found += [float(risen[strip, within].any(axis=0).mean()) for strip in strips]
    one, two, three, four = found
    return one, two, three, four


def closed_at_back(sides: tuple[float, float, float, float]) -> int:
    """The side that is closed most over its opposite: where a back is, if anywhere."""
    return max(range(4), key=lambda side: sides[side] - sides[side ^ 1])


def open_from_two_sides(grid: Grid, below: int) -> float:
    """The share of level sight lines beneath a layer that reach the thing's middle, 0..1.

    Of its four sides that which is open second most.
    """
    solid = grid.solid[:, :, :below]
    found = []
    for axis, backwards in product((0, 1), (False, True)):
        cells = np.moveaxis(solid, axis, 0)
        if backwards:
            cells = cells[::-1]
        half = cells[: (len(cells) + 1) // 2]
        found.append(1.0 - float(half.any(axis=0).mean()))
    return sorted(found)[-2]


def hollow(grid: Grid, *, on_ground: bool) -> float:
    """Of the side that is hollow most the share that lies deep behind the least box, 0..1.

    What stands `on_ground` has no side below.
    """
    deep = DEEP * max(grid.solid.shape)
    found = []
    for axis, backwards in product((0, 1, 2), (False, True)):
        if on_ground and axis == 2 and not backwards:
            continue
        cells = np.moveaxis(grid.solid, axis, 0)
        if backwards:
            cells = cells[::-1]
        depth = np.where(cells.any(axis=0), cells.argmax(axis=0), len(cells))
        found.append(float((depth > deep).mean()))
    return max(found)
