"""What lies beneath, on and above the level of a face: what tells furniture apart.

The *level* of a face is all of the thing that faces up at the height of the face's middle: a seat
of slats is one level, and so is a table top of two leaves. The *space beneath* reaches from there
to the ground. What is measured comes from a grid (occupancy.py), so it is known of things whose
surface is known from all sides, and exact to about a cell.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.facts.sides import closed_at_back, closed_sides, open_from_two_sides
from facetlog.perception.flat_faces import Estimate
from facetlog.perception.surfaces.occupancy import Grid

__all__ = ["GAP", "Level", "closed", "level_at"]

# A level is as thick as this share of the thing's height, up and down: seats and cushions sag.
THICKNESS = 0.02
# Gaps between slats, in cells, that still belong to a level.
GAP = 2
# Less than this share of the footprint is no level: a rail, the end of a leg.
LEAST = 0.1
# A back begins this share of the way up from a seat to the highest point: arms are lower.
ABOVE_ARMS = 0.35
# A uniform error of one cell.
ROUNDING = 1.0 / np.sqrt(12.0)

_Plan = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Level:
    """What the level of a face is like; shares 0..1 but for `side` and `off_middle`, which are
    in half extents of the level, lengths in the scene's unit.

    - `cover`: how much of the thing's footprint it takes.
    - `length`, `width`: its extents, the longer one first, along the sides of the thing's plan.
    - `built_over`: how much of it has something above.
    - `room_below`: free height right beneath it, on average; `room_above` the same above it, up
      to the thing's highest point.
    - `free_below`: how much of the space beneath, board and all, is free.
    - `see_through`: how much of the space beneath one sees through, along or across it, whichever
      is more; `see_across` whichever is less.
    - `open_sides`: how much of the space beneath one sees to the thing's middle through, from the
      second most open of its four sides.
    - `behind`: how much of the length of one of its sides has something high above it, of the side
      where that exceeds the opposite one's most; `in_front` the same of the opposite one.
    - `side`: how far from its middle what rises high above it stands (1 at the rim), towards the
      side where it is farthest; `off_middle` the same along that side; `span`: how much of the
      side's length it takes. None where nothing rises.
    """

    cover: Estimate
    length: Estimate
    width: Estimate
    built_over: Estimate
    room_below: Estimate
    room_above: Estimate
    free_below: Estimate
    see_through: Estimate
    see_across: Estimate
    open_sides: Estimate
    behind: Estimate
    in_front: Estimate
    side: Estimate | None = None
    off_middle: Estimate | None = None
    span: Estimate | None = None

    def measures(self) -> Iterator[tuple[str, Estimate]]:
        """The names of the facts and their values, of those that are known."""
        named = (
            ("cover", self.cover),
            ("level_length", self.length),
            ("level_width", self.width),
            ("built_over", self.built_over),
            ("room_below", self.room_below),
            ("room_above", self.room_above),
            ("free_below", self.free_below),
            ("see_through", self.see_through),
            ("see_across", self.see_across),
            ("open_from_two_sides", self.open_sides),
            ("closed_behind", self.behind),
            ("closed_in_front", self.in_front),
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


def level_at(grid: Grid, height: float) -> Level | None:
    """The level at a height (along up, in the scene's frame); None if next to nothing is there."""
    layers = grid.solid.shape[2]
    thickness = max(1, round(THICKNESS * layers))
    layer = grid.layer(height)
    low, high = max(0, layer - thickness), min(layers, layer + thickness + 1)
    plan = closed(_any(grid.upper[:, :, low:high])) & grid.footprint
    taken, footprint = int(plan.sum()), int(grid.footprint.sum())
    if taken < LEAST * footprint:
        return None
    side = ROUNDING / np.sqrt(taken)  # of a share of the plan: a cell at its rim
    depth = ROUNDING / max(layer, 1)
    rounding = ROUNDING * grid.cell
    built_over = float((_any(grid.solid[:, :, high:]) & plan).sum()) / taken
    below = max(1, int(0.9 * low))
    across, through = sorted(_see_through(grid, plan, below))
    seen_sd = float(np.hypot(side, depth))
    free = ~grid.solid[:, :, : layer + 1][plan]
    tall = _any(grid.solid[:, :, high + max(1, int(ABOVE_ARMS * (layers - high))) :])
    rise = _rise(plan, tall) if tall.any() else None
    sides = closed_sides(plan, tall)
    back = closed_at_back(sides)
    rim = ROUNDING / float(np.sqrt(max(_extents(plan)[1])))
    width, length = sorted(_extents(plan)[1])
    return Level(
        cover=Estimate(taken / footprint, side),
        length=Estimate(length * grid.cell, rounding),
        width=Estimate(width * grid.cell, rounding),
        built_over=Estimate(built_over, side),
        room_below=Estimate(_room(free[:, ::-1]) * grid.cell, rounding),
        room_above=Estimate(_room(~grid.solid[:, :, layer:][plan]) * grid.cell, rounding),
        free_below=Estimate(float(free.mean()), seen_sd),
        see_through=Estimate(through, seen_sd),
        see_across=Estimate(across, seen_sd),
        open_sides=Estimate(open_from_two_sides(grid, below), seen_sd),
        behind=Estimate(sides[back], rim),
        in_front=Estimate(sides[back ^ 1], rim),
        side=Estimate(rise[0], 2.0 * side) if rise else None,
        off_middle=Estimate(rise[1], 2.0 * side) if rise else None,
        span=Estimate(rise[2], 2.0 * side) if rise else None,
    )
