"""What lies beneath, on and above the level of a face: what tells furniture apart.

The *level* of a face is all of the thing that faces up at the height of the face's middle: a seat
of slats is one level, and so is a table top of two leaves. The *space beneath* reaches from there
to the ground. It is measured in cells of the thing's space, exact to about one of them, and twice
where some of it is unseen: as if that were free, and as if it were full.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.facts.levels.bounded import Bounded
from facetlog.perception.facts.levels.sides import closed_at_back, closed_sides, open_from_two_sides
from facetlog.perception.flat_faces import Estimate
from facetlog.perception.space.grid import ROUNDING, Grid
from facetlog.perception.space.space import Space

__all__ = ["GAP", "Level", "Slab", "closed", "level_at"]

# A level is as thick as this share of the thing's height, up and down: seats and cushions sag.
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


@dataclass(frozen=True, slots=True)
class Level:
    """What the level of a face is like; shares 0..1 but for `side` and `off_middle`, which are
    in half extents of the level, lengths in the scene's unit.

    - `cover`: how much of the thing's footprint it takes.
    - `length`, `width`: its extents, the longer one first, along the sides of the thing's plan.
    - `built_over`: how much of it has something above.
    - `room_width`: how wide the widest room beneath is, along either axis of the plan: as far as,
      from the rim to half its depth, most is free from the ground to half its height.
    - `room_below`: free height right beneath it, on average; `room_above` the same above it, up
      to the thing's highest point.
    - `free_below`: how much of the space beneath, board and all, is free.
    - `see_through`: how much of the space beneath one sees through, along or across it, whichever
      is more; `see_across` whichever is less.
    - `open_sides`: how much of the space beneath one sees to the thing's middle through, from the
      second most open of its four sides.
    - `enclosed`: how much of its rim has something high above it.
    - `behind`: how much of the length of one of its sides has something high above it, of the side
      where that exceeds the opposite one's most; `in_front` the same of the opposite one.
    - `side_behind`: the length of that side; None where no side is closed more than its opposite.
    - `along_front`: the axis of the space, 0 or 1, along which that side and the opposite one lie;
      None where unseen space could make it the other.
    - `side`: how far from its middle what rises high above it stands (1 at the rim), towards the
      side where it is farthest; `off_middle` the same along that side; `span`: how much of the
      side's length it takes. None where nothing rises; what is unseen does not.
    """

    cover: Bounded
    length: Bounded
    width: Bounded
    built_over: Bounded
    room_below: Bounded
    room_width: Bounded
    room_above: Bounded
    free_below: Bounded
    see_through: Bounded
    see_across: Bounded
    open_sides: Bounded
    enclosed: Bounded
    behind: Bounded
    in_front: Bounded
    side_behind: Bounded | None = None
    along_front: int | None = None
    side: Bounded | None = None
    off_middle: Bounded | None = None
    span: Bounded | None = None

    def measures(self) -> Iterator[tuple[str, Bounded]]:
        """The names of the facts and their values, of those that are known."""
        named = (
            ("cover", self.cover),
            ("level_length", self.length),
            ("level_width", self.width),
            ("built_over", self.built_over),
            ("room_below", self.room_below),
            ("room_width", self.room_width),
            ("room_above", self.room_above),
            ("free_below", self.free_below),
            ("see_through", self.see_through),
            ("see_across", self.see_across),
            ("open_from_two_sides", self.open_sides),
            ("enclosed", self.enclosed),
            ("closed_behind", self.behind),
            ("closed_in_front", self.in_front),
            ("side_behind", self.side_behind),
            ("rise_side", self.side),
            ("rise_off_middle", self.off_middle),
            ("rise_span", self.span),
        )
        return ((name, estimate) for name, estimate in named if estimate is not None)


def _any(cells: _Plan) -> _Plan:
    """Columns (nx, ny) of cells (nx, ny, nz) that hold something."""
    return np.asarray(cells.any(axis=2))


def _grown(plan: _Plan) -> _Plan:
    """The plan and all cells beside it; outermost ones are to be free."""
    grown = plan.copy()
    grown[1:] |= plan[:-1]
    grown[:-1] |= plan[1:]
    grown[:, 1:] |= plan[:, :-1]
    grown[:, :-1] |= plan[:, 1:]
    return grown


def closed(plan: _Plan) -> _Plan:
    """The plan with gaps of a few cells filled: grown, and then what is free grown back.

    On plans so small this takes a tenth of the time of scipy.ndimage.binary_closing.
    """
    cells = np.pad(plan, GAP + 1)
    for _ in range(GAP):
        cells = _grown(cells)
    cells = ~cells
    for _ in range(GAP):
        cells = _grown(cells)
    closed: _Plan = ~cells[GAP + 1 : -GAP - 1, GAP + 1 : -GAP - 1]
    return closed | plan


def _room(free: _Plan) -> float:
    """The first run of free cells in each row (n, layers), on average over the rows."""
    count, layers = free.shape
    if not layers:
        return 0.0
    begins = np.where(free.any(axis=1), free.argmax(axis=1), layers)
    taken_again = ~free & (np.arange(layers) >= begins[:, None])
    ends = np.where(taken_again.any(axis=1), taken_again.argmax(axis=1), layers)
    return float((ends - begins).sum() / count)


def _longest_run(places: NDArray[np.bool_]) -> int:
    """How many places (n,) in a row hold, at most.

    >>> _longest_run(np.array([True, False, True, True]))
    2
    """
    ends = np.flatnonzero(~np.concatenate([[False], places, [False]]))
    return int(np.diff(ends).max()) - 1


def _room_width(grid: Grid, plan: _Plan, below: int) -> int:
    """The width of the widest room beneath a level's plan, in cells."""
    rows, columns = (np.flatnonzero(plan.any(axis=axis)) for axis in (1, 0))
    solid = grid.solid[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1, :below]
    low = ~solid[:, :, GROUND_LAYERS : max(GROUND_LAYERS + 1, round(ROOM_HEIGHT * below))]
    widest = 0
    for across in (low, low.swapaxes(0, 1)):  # each row of cells leads from rim to rim
        depth = max(1, round(ROOM_DEPTH * across.shape[1]))
        for half in (across[:, :depth], across[:, -depth:]):
            each_layer = half.mean(axis=1) >= ROOM_SHARE
            widest = max(widest, _longest_run(each_layer.all(axis=1)))
    return widest


def _see_through(grid: Grid, plan: _Plan, below: int) -> tuple[float, float]:
    """Shares of the space beneath that one sees through along either axis of the plan."""
    within = grid.solid[:, :, :below] & plan[:, :, None]
    rows, columns = np.flatnonzero(plan.any(axis=1)), np.flatnonzero(plan.any(axis=0))
    along = np.asarray(within.any(axis=0))[columns[0] : columns[-1] + 1]
    across = np.asarray(within.any(axis=1))[rows[0] : rows[-1] + 1]
    return 1.0 - float(along.mean()), 1.0 - float(across.mean())


def _extents(plan: _Plan) -> tuple[list[float], list[float]]:
    """Middles and extents of a plan along its two axes, in cells."""
    middles, extents = [], []
    for axis in (1, 0):
        own = np.flatnonzero(plan.any(axis=axis))
        middles.append(float(own[0] + own[-1]) / 2.0)
        extents.append(float(own[-1] - own[0]) + 1.0)
    return middles, extents


def _rise(plan: _Plan, tall: _Plan) -> tuple[float, float, float]:
    """`side`, `off_middle` and `span` of what rises (`tall`) from a level's plan."""
    middles, extents = _extents(plan)
    where = np.argwhere(tall).mean(axis=0)
    offsets = 2.0 * np.abs(where - middles) / np.array(extents)
    first = int(np.argmax(offsets))
    own = np.flatnonzero(tall.any(axis=first))
    span = float(own[-1] - own[0] + 1.0) / extents[1 - first]
    return float(offsets[first]), float(offsets[1 - first]), float(min(span, 1.0))


@dataclass(frozen=True, eq=False, slots=True)
class Slab:
    """The layers of cells of a level: that of its height is `layer`, all from `low` to `high`."""

    layer: int
    low: int
    high: int

    @classmethod
    def at(cls, grid: Grid, height: float) -> "Slab":
        layers = grid.solid.shape[2]
        thickness = max(1, round(THICKNESS * layers))
        layer = grid.layer(height)
        return cls(layer, max(0, layer - thickness), min(layers, layer + thickness + 1))

    def plan(self, grid: Grid) -> _Plan:
        """The plan (nx, ny) of what faces up in it."""
        return closed(_any(grid.upper[:, :, self.low : self.high])) & grid.footprint

    def tall(self, grid: Grid) -> _Plan:
        """The plan (nx, ny) of what rises high above it."""
        begin = self.high + max(1, int(ABOVE_ARMS * (grid.solid.shape[2] - self.high)))
        return _any(grid.solid[:, :, begin:])


@dataclass(frozen=True, slots=True)
class _Beneath:
    """What lies over and under a level in one reading of its thing's space."""

    built_over: Estimate
    room_below: Estimate
    room_width: Estimate
    room_above: Estimate
    free_below: Estimate
    see_through: Estimate
    see_across: Estimate
    open_sides: Estimate
    enclosed: Estimate
    behind: Estimate
    in_front: Estimate
    side_behind: Estimate | None
    along_front: int | None

    @classmethod
    def of(cls, grid: Grid, plan: _Plan, slab: Slab) -> "_Beneath":
        taken = int(plan.sum())
        side, depth = _side(plan), ROUNDING / max(slab.layer, 1)
        built_over = float((_any(grid.solid[:, :, slab.high :]) & plan).sum()) / taken
        below = max(1, int(0.9 * slab.low))
        across, through = sorted(_see_through(grid, plan, below))
        sides = closed_sides(plan, slab.tall(grid))
        back = closed_at_back(sides)
        has_back = sides[back] > sides[back ^ 1]
        extents = _extents(plan)[1]
        rim = ROUNDING / float(np.sqrt(max(extents)))
        # the first two sides lie at the ends of the first axis
        around = np.repeat(extents[::-1], 2)
        free = ~grid.solid[:, :, : slab.layer + 1][plan]
        # above the uppermost surface of the level in each column, or, in its gaps, its height
        own = grid.upper[:, :, slab.low : slab.high][plan]
        topmost = slab.high - 1 - own[:, ::-1].argmax(axis=1)
        topmost = np.where(own.any(axis=1), topmost, slab.layer - 1)
        above = ~grid.solid[plan] & (np.arange(grid.solid.shape[2]) > topmost[:, None])
        rounding, seen_sd = ROUNDING * grid.cell, float(np.hypot(side, depth))
        return cls(
            Estimate(built_over, side),
            Estimate(_room(free[:, ::-1]) * grid.cell, rounding),
            Estimate(_room_width(grid, plan, below) * grid.cell, 2.0 * rounding),
            Estimate(_room(above) * grid.cell, rounding),
            Estimate(float(free.mean()), seen_sd),
            Estimate(through, seen_sd),
            Estimate(across, seen_sd),
            Estimate(open_from_two_sides(grid, below), seen_sd),
            Estimate(float(around @ sides / around.sum()), rim),
            Estimate(sides[back], rim),
            Estimate(sides[back ^ 1], rim),
            Estimate(float(around[back]) * grid.cell, rounding) if has_back else None,
            1 - back // 2 if has_back else None,
        )


def _side(plan: _Plan) -> float:
    """The sd of a share of a plan: a cell at its rim."""
    return ROUNDING / float(np.sqrt(plan.sum()))


def _risen(grid: Grid, plan: _Plan, slab: Slab) -> tuple[Bounded, Bounded, Bounded] | None:
    """`side`, `off_middle` and `span` of what rises high above a level, if anything does."""
    tall = slab.tall(grid)
    if not tall.any():
        return None
    side, off_middle, span = (
        Bounded.sure(Estimate(each, 2.0 * _side(plan))) for each in _rise(plan, tall)
    )
    return side, off_middle, span


def _of_both(one: Estimate | None, other: Estimate | None) -> Bounded | None:
    """What is known in both readings of a space, else None."""
    return None if one is None or other is None else Bounded.between(one, other)


def level_at(space: Space, height: float) -> Level | None:
    """The level at a height (along up, in the scene's frame); None if nothing faces up there."""
    least, most = space.least(), space.most()
    slab = Slab.at(least, height)
    plan = slab.plan(least)
    taken, footprint = int(plan.sum()), least.footprint
    if not taken:
        return None
    # what is unseen may be more of the level, or of the plan round it
    wide = plan if most is least else slab.plan(most) | plan
    side, rounding = _side(plan), ROUNDING * least.cell
    cover = (
        taken / int((footprint | most.footprint).sum()),
        int(wide.sum()) / int((footprint | wide).sum()),
    )
    (width, length), (wider, longer) = (sorted(_extents(each)[1]) for each in (plan, wide))
    one = _Beneath.of(least, plan, slab)
    other = one if most is least else _Beneath.of(most, plan, slab)
    rise = _risen(least, plan, slab) or (None, None, None)
    return Level(
        cover=Bounded.between(*(Estimate(each, side) for each in cover)),
        length=Bounded.between(*(Estimate(n * least.cell, rounding) for n in (length, longer))),
        width=Bounded.between(*(Estimate(n * least.cell, rounding) for n in (width, wider))),
        built_over=Bounded.between(one.built_over, other.built_over),
        room_below=Bounded.between(one.room_below, other.room_below),
        room_width=Bounded.between(one.room_width, other.room_width),
        room_above=Bounded.between(one.room_above, other.room_above),
        free_below=Bounded.between(one.free_below, other.free_below),
        see_through=Bounded.between(one.see_through, other.see_through),
        see_across=Bounded.between(one.see_across, other.see_across),
        open_sides=Bounded.between(one.open_sides, other.open_sides),
        enclosed=Bounded.between(one.enclosed, other.enclosed),
        behind=Bounded.between(one.behind, other.behind),
        in_front=Bounded.between(one.in_front, other.in_front),
        side_behind=_of_both(one.side_behind, other.side_behind),
        along_front=one.along_front if one.along_front == other.along_front else None,
        side=rise[0],
        off_middle=rise[1],
        span=rise[2],
    )
