"""Measures of the level of a face, and of the four sides of its object.

The *level* of a face is all of the object that faces up at the height of the face's middle: a seat
of slats is one level, and so is a table top of two leaves. The *space beneath* reaches from there
to the ground. It is measured in cells of the object's space, exact to about one of them, and twice
where some of it is unseen: as if that were free, and as if it were full.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.flat_faces import Estimate
from facetlog.perception.space.grid import ROUNDING, Grid
from facetlog.perception.space.space import Space, State

# A back stands within this share of a level's extent from its rim, or beyond that.
RIM = 0.3
# A side is hollow where it lies deeper than this share of the longest: a panel's frame does not.
DEEP = 0.07
# A shelf faces up over this share of the level's plan: less is a rung, a rail or a drawer's rim.
BROAD = 0.5
# A level is as thick as this share of the object's height, up and down: seats and cushions sag.
THICKNESS = 0.02
# Gaps between slats, in cells, that still belong to a level.
GAP = 2
# A back begins this share of the way up from a seat to the highest point: arms are lower.
ABOVE_ARMS = 0.35

# A room beneath a level begins at its rim and on the ground. It is so deep and high, as shares of
# the level's depth and height, and so much of each layer is free: lines of sight miss single cells.
# The lowest layer holds the ground's own roughness.
ROOM_DEPTH, ROOM_HEIGHT, ROOM_SHARE = 0.5, 0.5, 0.5
GROUND_LAYERS = 1

_Plan = NDArray[np.bool_]

_RISE = dict.fromkeys(("rise_side", "rise_off_middle", "rise_span")).keys()


class Bounded(NamedTuple):
    """A value with its sd, and the values if all unseen space is free, and if all is full.

    Where these two differ the value is their middle.
    """

    value: float
    sd: float
    if_free: float
    if_full: float

    @classmethod
    def sure(cls, one: Estimate) -> "Bounded":
        """Return a measure that no unseen space could change."""
        return cls(*one, one.value, one.value)

    @classmethod
    def between(cls, if_free: Estimate, if_full: Estimate) -> "Bounded":
        """Return the measure with these two readings.

        >>> Bounded.between(Estimate(0.5, 0.01), Estimate(0.25, 0.02))
        Bounded(value=0.375, sd=0.02, if_free=0.5, if_full=0.25)
        """
        sd = max(if_free.sd, if_full.sd)
        if if_free.value == if_full.value:
            return cls(if_free.value, sd, if_free.value, if_full.value)
        middle = (if_free.value + if_full.value) / 2.0
        return cls(middle, sd, if_free.value, if_full.value)

    @property
    def open(self) -> bool:
        """Whether the two readings differ."""
        return self.if_free != self.if_full


@dataclass(frozen=True, slots=True)
class Level:
    """The `measures` of a level that are known, by the names of their facts (fact_schema.py).

    `along_front` is the axis of the space, 0 or 1, along which the side that `closed_behind`
    measures and the opposite one lie; None where unseen space could make it the other, or where no
    side is closed more than its opposite.
    """

    measures: dict[str, Bounded]
    along_front: int | None


@dataclass(frozen=True, eq=False, slots=True)
class Slab:
    """The layers of cells of a level: that of its height is `layer`, all from `low` to `high`."""

    layer: int
    low: int
    high: int

    @classmethod
    def at(cls, grid: Grid, height: float) -> "Slab":
        """Return the layers at a height along up, in the scene's frame."""
        layers = grid.solid.shape[2]
        thickness = max(1, round(THICKNESS * layers))
        layer = grid.layer(height)
        return cls(layer, max(0, layer - thickness), min(layers, layer + thickness + 1))

    def plan(self, grid: Grid) -> _Plan:
        """Return the plan (nx, ny) of all that faces up in it."""
        return closed(_project_cells(grid.upper[:, :, self.low : self.high])) & grid.footprint

    def tall(self, grid: Grid) -> _Plan:
        """Return the plan (nx, ny) of all that rises high above it."""
        begin = self.high + max(1, int(ABOVE_ARMS * (grid.solid.shape[2] - self.high)))
        return _project_cells(grid.solid[:, :, begin:])


def level_at(space: Space, height: float, kinds: Collection[str] | None = None) -> Level | None:
    """Return the level at a height (along up, in the scene's frame), with the measures of some
    `kinds` or of all; None if nothing faces up there.
    """
    least, most = space.least(), space.most()
    slab = Slab.at(least, height)
    plan = slab.plan(least)
    taken, footprint = int(plan.sum()), least.footprint
    if not taken:
        return None
    # unseen space may be more of the level, or of the plan round it
    wide = plan if most is least else slab.plan(most) | plan
    side, rounding = _compute_share_sd(plan), ROUNDING * least.cell
    cover = (
        taken / int((footprint | most.footprint).sum()),
        int(wide.sum()) / int((footprint | wide).sum()),
    )
    (width, length), (wider, longer) = (sorted(_extents(each)[1]) for each in (plan, wide))
    found = {
        "cover": Bounded.between(*(Estimate(each, side) for each in cover)),
        "level_length": Bounded.between(
            *(Estimate(n * least.cell, rounding) for n in (length, longer))
        ),
        "level_width": Bounded.between(
            *(Estimate(n * least.cell, rounding) for n in (width, wider))
        ),
    }
    one, front = _readings(least, plan, slab, kinds)
    other, other_front = (one, front) if most is least else _readings(most, plan, slab, kinds)
    found |= {
        name: Bounded.between(each, other[name]) for name, each in one.items() if name in other
    }
    tall = slab.tall(least)
    if (kinds is None or not _RISE.isdisjoint(kinds)) and tall.any():  # unseen space does not rise
        rise = zip(_RISE, _measure_rise(plan, tall), strict=True)
        found |= {name: Bounded.sure(Estimate(each, 2.0 * side)) for name, each in rise}
    return Level(found, front if front == other_front else None)


def _readings(
    grid: Grid, plan: _Plan, slab: Slab, kinds: Collection[str] | None
) -> tuple[dict[str, Estimate], int | None]:
    """Return what lies over and under a level, by the names of facts of some `kinds` or of all, and
    the axis of its front.
    """
    side, depth = _compute_share_sd(plan), ROUNDING / max(slab.layer, 1)
    below = max(1, int(0.9 * slab.low))
    sides = measure_closed_sides(plan, slab.tall(grid))
    back = find_back(sides)
    extents = _extents(plan)[1]
    rim = ROUNDING / float(np.sqrt(max(extents)))
    # the first two sides lie at the ends of the first axis
    around = np.repeat(extents[::-1], 2)
    rounding, seen_sd = ROUNDING * grid.cell, float(np.hypot(side, depth))
    makers: dict[str, Callable[[], tuple[float, float]]] = {
        "built_over": lambda: (_measure_built_over(grid, plan, slab), side),
        "room_below": lambda: (_room(_find_free(grid, plan, slab)[:, ::-1]) * grid.cell, rounding),
        "room_width": lambda: (_measure_room_width(grid, plan, below) * grid.cell, 2.0 * rounding),
        "room_above": lambda: (_room(_find_free_above(grid, plan, slab)) * grid.cell, rounding),
        "free_below": lambda: (float(_find_free(grid, plan, slab).mean()), seen_sd),
        "see_through": lambda: (max(_measure_see_through(grid, plan, below)), seen_sd),
        "see_across": lambda: (min(_measure_see_through(grid, plan, below)), seen_sd),
        "open_from_two_sides": lambda: (open_from_two_sides(grid, below), seen_sd),
        "enclosed": lambda: (float(around @ sides / around.sum()), rim),
        "closed_behind": lambda: (sides[back], rim),
        "closed_in_front": lambda: (sides[back ^ 1], rim),
    }
    found = {
        name: Estimate(*make()) for name, make in makers.items() if kinds is None or name in kinds
    }
    if not sides[back] > sides[back ^ 1]:
        return found, None
    found["side_behind"] = Estimate(float(around[back]) * grid.cell, rounding)
    return found, 1 - back // 2


def _measure_built_over(grid: Grid, plan: _Plan, slab: Slab) -> float:
    """Return the share of a level's plan with something above it."""
    over = _project_cells(grid.solid[:, :, slab.high :]) & plan
    return float(over.sum()) / int(plan.sum())


def _find_free(grid: Grid, plan: _Plan, slab: Slab) -> _Plan:
    """Return the free cells (columns, layers) of a level's plan from the ground to its height."""
    return ~grid.solid[:, :, : slab.layer + 1][plan]


def _find_free_above(grid: Grid, plan: _Plan, slab: Slab) -> _Plan:
    """Return the free cells (columns, layers) above the uppermost surface of the level in each
    column, or, in its gaps, above its height.
    """
    own = grid.upper[:, :, slab.low : slab.high][plan]
    topmost = slab.high - 1 - own[:, ::-1].argmax(axis=1)
    topmost = np.where(own.any(axis=1), topmost, slab.layer - 1)
    above: _Plan = ~grid.solid[plan] & (np.arange(grid.solid.shape[2]) > topmost[:, None])
    return above


def shelves_below(space: Space, height: float) -> tuple[int, int] | None:
    """Return the fewest and the most shelves beneath the level at a height (along up, in the
    scene's frame), None if nothing faces up there.

    The fewest are those that were seen, the most those that could lie in unseen space besides.
    """
    least = space.least()
    slab = Slab.at(least, height)
    plan = slab.plan(least)
    if not plan.any():
        return None
    seen = least.upper[:, :, : slab.low][plan]
    unseen = space.cells[:, :, : slab.low][plan] == State.UNSEEN
    return _count_shelves(seen), _count_shelves(seen | unseen)


def _count_shelves(upper: NDArray[np.bool_]) -> int:
    """Count how many times, from the top on, enough of the columns of cells (n, layers) face up.

    They do so in one layer or across two: a surface beside the border of two is in either.
    """
    across_two = upper.copy()
    across_two[:, 1:] |= upper[:, :-1]
    broad = across_two.mean(axis=0) >= BROAD
    found, layer = 0, len(broad) - 1
    while layer >= 0:
        found += int(broad[layer])
        layer -= 2 if broad[layer] else 1
    return found


def measure_closed_sides(plan: _Plan, tall: _Plan) -> tuple[float, float, float, float]:
    """Return the share of each side's length of a level above whose rim something is `tall`.

    `plan` (nx, ny) is that of the level, `tall` (nx, ny) of all high above it. Opposite sides
    follow one another.

    >>> seat = np.ones((10, 10), dtype=bool)
    >>> back = seat & (np.arange(10) == 9) & (np.arange(10) < 8)[:, None]
    >>> measure_closed_sides(seat, back)
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


def find_back(sides: tuple[float, float, float, float]) -> int:
    """Return the side that is closed most over its opposite: where a back is, if anywhere."""
    return max(range(4), key=lambda side: sides[side] - sides[side ^ 1])


def open_from_two_sides(grid: Grid, below: int) -> float:
    """Return the share of level sight lines beneath a layer that reach the object's middle, from
    the second most open of its four sides.
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
    """Return the share of the most hollow side that lies deep behind the least box, 0..1.

    An object that stands `on_ground` has no side below.
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


def _project_cells(cells: _Plan) -> _Plan:
    """Return the columns (nx, ny) of cells (nx, ny, nz) that hold something."""
    return np.asarray(cells.any(axis=2))


def closed(plan: _Plan) -> _Plan:
    """Return the plan with gaps of a few cells filled: grown, and then its outside grown back.

    On plans so small this takes a tenth of the time of scipy.ndimage.binary_closing.
    """
    cells = np.pad(plan, GAP + 1)
    for _ in range(GAP):
        cells = _grow(cells)
    cells = ~cells
    for _ in range(GAP):
        cells = _grow(cells)
    closed: _Plan = ~cells[GAP + 1 : -GAP - 1, GAP + 1 : -GAP - 1]
    return closed | plan


def _grow(plan: _Plan) -> _Plan:
    grown = plan.copy()
    grown[1:] |= plan[:-1]
    grown[:-1] |= plan[1:]
    grown[:, 1:] |= plan[:, :-1]
    grown[:, :-1] |= plan[:, 1:]
    return grown


def _room(free: _Plan) -> float:
    """Return the mean length of the first run of free cells in each row (n, layers)."""
    count, layers = free.shape
    if not layers:
        return 0.0
    begins = np.where(free.any(axis=1), free.argmax(axis=1), layers)
    taken_again = ~free & (np.arange(layers) >= begins[:, None])
    ends = np.where(taken_again.any(axis=1), taken_again.argmax(axis=1), layers)
    return float((ends - begins).sum() / count)


def _find_longest_run(places: NDArray[np.bool_]) -> int:
    """Return the length of the longest run of places (n,) that hold.

    >>> _find_longest_run(np.array([True, False, True, True]))
    2
    """
    ends = np.flatnonzero(~np.concatenate([[False], places, [False]]))
    return int(np.diff(ends).max()) - 1


def _measure_room_width(grid: Grid, plan: _Plan, below: int) -> int:
    """Return the width of the widest room beneath a level's plan, in cells."""
    rows, columns = (np.flatnonzero(plan.any(axis=axis)) for axis in (1, 0))
    solid = grid.solid[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1, :below]
    low = ~solid[:, :, GROUND_LAYERS : max(GROUND_LAYERS + 1, round(ROOM_HEIGHT * below))]
    widest = 0
    for across in (low, low.swapaxes(0, 1)):  # each row of cells leads from rim to rim
        depth = max(1, round(ROOM_DEPTH * across.shape[1]))
        for half in (across[:, :depth], across[:, -depth:]):
            each_layer = half.sum(axis=1, dtype=np.int16) >= ROOM_SHARE * half.shape[1]
            widest = max(widest, _find_longest_run(each_layer.all(axis=1)))
    return widest


def _measure_see_through(grid: Grid, plan: _Plan, below: int) -> tuple[float, float]:
    """Return the shares of the space beneath that one sees through along either axis."""
    within = grid.solid[:, :, :below] & plan[:, :, None]
    rows, columns = np.flatnonzero(plan.any(axis=1)), np.flatnonzero(plan.any(axis=0))
    along = np.asarray(within.any(axis=0))[columns[0] : columns[-1] + 1]
    across = np.asarray(within.any(axis=1))[rows[0] : rows[-1] + 1]
    return 1.0 - float(along.mean()), 1.0 - float(across.mean())


def _extents(plan: _Plan) -> tuple[list[float], list[float]]:
    """Return middles and extents of a plan along its two axes, in cells."""
    middles, extents = [], []
    for axis in (1, 0):
        own = np.flatnonzero(plan.any(axis=axis))
        middles.append(float(own[0] + own[-1]) / 2.0)
        extents.append(float(own[-1] - own[0]) + 1.0)
    return middles, extents


def _measure_rise(plan: _Plan, tall: _Plan) -> tuple[float, float, float]:
    """Return `rise_side`, `rise_off_middle` and `rise_span` of what is `tall` on a level's plan."""
    middles, extents = _extents(plan)
    where = np.argwhere(tall).mean(axis=0)
    offsets = 2.0 * np.abs(where - middles) / np.array(extents)
    first = int(np.argmax(offsets))
    own = np.flatnonzero(tall.any(axis=first))
    span = float(own[-1] - own[0] + 1.0) / extents[1 - first]
    return float(offsets[first]), float(offsets[1 - first]), float(min(span, 1.0))


def _compute_share_sd(plan: _Plan) -> float:
    """Return the sd of a share of a plan: a cell at its rim."""
    return ROUNDING / float(np.sqrt(plan.sum()))
