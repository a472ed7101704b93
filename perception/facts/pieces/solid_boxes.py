"""How the boxes of pieces and openings lie to one another: one beside, or inside, another.

A box may reach on into space that nobody saw. What is said of two boxes is said as they were found,
and as far as they may reach; where that makes a difference, nobody knows.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import permutations, product
from typing import Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.pieces.shown_pieces import Piece
from facetlog.perception.polygons import find_intersection
from facetlog.perception.space.openings import Opening
from facetlog.perception.space.space import Space, State
from facetlog.perception.types import FloatArray

# Two stand beside each other where both take this share of the height of the lower one ...
ABREAST = 0.5
# ... no more than this share of the smaller one is sunk into the other (half of it, as it is
# measured, is a usual way of building) ...
SUNK = 2.0 / 3.0
# ... and no more than this share of the rest is over or under the other.
OVER = 0.1
# The number of columns along each axis in which one box is tested for being sunk into another.
WITHIN = 10
# One is inside another but for this share of its extent at each side.
BEYOND = 0.05
# A side may reach on if more than this share of what lies right before it is unseen.
UNSEEN_SHARE = 0.5
# A side is looked at in so many places along each axis.
PLACES = 6
# What touches is not over or under one another: so much is left out at each end, in cells.
HALF_CELL = 0.5
# An end lies anywhere within its cell.
CELL_SD = 1.0 / np.sqrt(12.0)
# A direction is square to up where its share of it is no more than rounding.
ROUNDED = 1e-12
# What has no thickness has this one, in cells.
THIN = 1e-3

Related: TypeAlias = NDArray[np.bool_]

_ENDS = np.array(tuple(product((-1.0, 1.0), repeat=3)))
_STEPS = (2.0 * np.arange(PLACES) + 1.0) / PLACES - 1.0
_COLUMN = (2.0 * np.arange(WITHIN) + 1.0) / WITHIN - 1.0
_IN_BOX = np.stack(np.meshgrid(_COLUMN, _COLUMN, _COLUMN), axis=-1).reshape(-1, 3)
_ON_SIDE = np.stack(np.meshgrid(_STEPS, _STEPS), axis=-1).reshape(-1, 2)


@dataclass(frozen=True, eq=False, slots=True)
class SolidBox:
    """The box round a piece or opening: its `middle` (3,), its directions as rows of `axes` (3, 3),
    and half its extents (3,) along them; `reaches` (3, 2) says how far past each of its sides, the
    lower and the upper one along each axis, unseen space goes on. A length is exact to a `cell`.
    """

    middle: FloatArray
    axes: FloatArray
    half: FloatArray
    cell: float
    reaches: FloatArray

    @classmethod
    def of_piece(cls, piece: Piece, space: Space) -> Self:
        """Return the box of a piece in its thing's space."""
        extents = (piece.length.value, piece.width.value, piece.thickness.value)
        cell = piece.thickness.sd / CELL_SD
        box = cls(piece.middle, piece.axes, np.array(extents) / 2.0, cell, np.zeros((3, 2)))
        return replace(box, reaches=_measure_unseen_beyond(box, space)) if space.unseen else box

    @classmethod
    def of_opening(cls, opening: Opening) -> Self:
        """Return the box of an opening: its ends lie within its rim, which was seen."""
        lattice = opening.lattice
        low, high = (each * lattice.cell + lattice.corner for each in (opening.low, opening.high))
        middle: FloatArray = (low + high) / 2.0 @ lattice.axes
        return cls(middle, lattice.axes, (high - low) / 2.0, lattice.cell, np.zeros((3, 2)))

    def at(self, places: FloatArray) -> FloatArray:
        """Return places (n, 3) in the scene's frame, from such in its half extents: -1 to 1 each
        way.
        """
        found: FloatArray = self.middle + (places * self.half) @ self.axes
        return found

    @property
    def widest(self) -> "SolidBox":
        """The box as far as it may go on."""
        low, high = self.reaches.T
        middle = self.middle + (high - low) / 2.0 @ self.axes
        return replace(self, middle=middle, half=self.half + (high + low) / 2.0)


def _measure_unseen_beyond(box: SolidBox, space: Space) -> FloatArray:
    """Return how far (3, 2) from each side most of what lies right before it is unseen all
    the way.
    """
    found = np.zeros((3, 2))
    for axis, side in product(range(3), range(2)):
        sense = 2.0 * side - 1.0
        places = box.at(np.insert(_ON_SIDE, axis, sense, axis=1))
        unseen = np.ones(len(places), dtype=np.bool_)
        for _ in range(sum(space.lattice.shape)):
            places += sense * space.cell * box.axes[axis]
            numbers = space.lattice.numbers(space.lattice.local(places))
            unseen &= (space.cells.ravel()[numbers] == State.UNSEEN) & (numbers >= 0)
            if float(unseen.mean()) <= UNSEEN_SHARE:
                break
            found[axis, side] += space.cell
    return found


def inside(boxes: Sequence[SolidBox]) -> Related:
    """Return which box lies within which (n, n), but for a little at each side."""
    ends = np.concatenate([box.at((1.0 - 2.0 * BEYOND) * _ENDS) for box in boxes])
    found = np.zeros((len(boxes), len(boxes)), dtype=np.bool_)
    for number, box in enumerate(boxes):
        within = np.abs((ends - box.middle) @ box.axes.T) <= box.half
        found[:, number] = within.reshape(len(boxes), -1).all(axis=1)
    return found


def beside(boxes: Sequence[SolidBox], up: FloatArray) -> Related:
    """Return which box stands beside which (n, n) along up (3,): they are about as high above the
    ground, and neither is over or under the other.
    """
    return _are_beside(*compute_beside_shares(boxes, up))


def _are_beside(abreast: FloatArray, sunk: FloatArray, over: FloatArray) -> Related:
    related: Related = (abreast >= ABREAST) & (sunk <= SUNK) & (over <= OVER)
    return related


def compute_beside_shares(
    boxes: Sequence[SolidBox], up: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return for each two boxes (n, n) along up (3,) the share of the lower one's height that both
    take, that of the one with the smaller plan that is sunk into the other, and that of its rest
    which is over or under it. A column of one box that enters the other is sunk.
    """
    low, high = np.array([heights(box, up) for box in boxes]).T
    shared = np.minimum.outer(high, high) - np.maximum.outer(low, low)
    abreast = np.maximum(shared, 0.0) / np.minimum.outer(high - low, high - low)
    over = compute_plan_overlap(boxes, up, -HALF_CELL)
    sunk = np.zeros_like(over)
    for one, other in np.argwhere(np.triu((over > OVER) & (abreast >= ABREAST), 1)).tolist():
        inner, outer = sorted((boxes[one], boxes[other]), key=lambda box: _measure_plan(box, up))
        within, above = _measure_columns(inner, outer, up)
        if within > 0.0:
            pair = [one, other], [other, one]
            sunk[pair] = within
            over[pair] = above / (1.0 - within) if within < 1.0 else 0.0
    return abreast, sunk, over


def _measure_plan(box: SolidBox, up: FloatArray) -> float:
    """Return the area of a box's plan: of each side as much as it faces upwards."""
    sides = 4.0 * np.array([box.half[[1, 2]], box.half[[0, 2]], box.half[[0, 1]]]).prod(axis=1)
    return float(np.abs(box.axes @ up) @ sides)


def _measure_columns(inner: SolidBox, outer: SolidBox, up: FloatArray) -> tuple[float, float]:
    """Return which share of a box lies in columns that enter another, and in such that are over or
    under it without."""
    inner, outer = (  # what touches does not enter
        replace(box, half=np.maximum(box.half - HALF_CELL * box.cell, THIN * box.cell))
        for box in (inner, outer)
    )
    places = inner.at(_IN_BOX)
    (first, last), (low, high) = (_cut_columns(places, box, up) for box in (inner, outer))
    enters = np.minimum(last, high) > np.maximum(first, low)
    return float(enters.mean()), float(((high > low) & ~enters).mean())


def _cut_columns(
    places: FloatArray, box: SolidBox, up: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return from where to where (m,) the lines along up through places (m, 3) are in a box; to
    before from where they miss it."""
    along = box.axes @ up
    along = np.where(np.abs(along) < ROUNDED, ROUNDED, along)
    local = (places - box.middle) @ box.axes.T
    ends = np.stack([(-box.half - local) / along, (box.half - local) / along])
    begin: FloatArray = ends.min(axis=0).max(axis=1)
    end: FloatArray = ends.max(axis=0).min(axis=1)
    return begin, end


def compute_plan_overlap(
    boxes: Sequence[SolidBox], up: FloatArray, ends: float = 0.0, shift: Sequence[float] = (0, 0)
) -> FloatArray:
    """Return which share (n, n) of the smaller one's plan along up (3,) lies over or under the
    other's, if each end lies so many cells further out, and the other so many further along both
    axes.
    """
    import shapely  # loaded only now: few models ask for it

    outlines = [(_plan(box, up, ends), box.cell) for box in boxes]
    plans = shapely.convex_hull(shapely.multipoints([plan for plan, _ in outlines]))
    moved = shapely.convex_hull(
        shapely.multipoints([plan + np.multiply(shift, cell) for plan, cell in outlines])
    )
    areas = shapely.area(plans)
    share = np.zeros((len(boxes), len(boxes)))
    one, other = shapely.STRtree(moved).query(plans)  # of all others nothing is over the other
    over = shapely.area(find_intersection(plans[one], moved[other]))
    least = np.minimum(areas[one], areas[other])
    # Very far from the origin a plan may have no area left in numbers.
    share[one, other] = np.divide(over, least, out=np.zeros(len(over)), where=least > 0.0)
    return share


def heights(box: SolidBox, up: FloatArray) -> tuple[float, float]:
    """Return the lowest and highest reach along up (3,), half a cell wider, as it is known."""
    ends = box.at(_ENDS) @ up
    return float(ends.min()) - box.cell / 2.0, float(ends.max()) + box.cell / 2.0


def _plan(box: SolidBox, up: FloatArray, ends: float) -> FloatArray:
    """Return points (8, 2) of its plan, with each end so many cells further out."""
    least = replace(box, half=np.maximum(box.half + ends * box.cell, THIN * box.cell))
    first = np.cross(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    first /= np.linalg.norm(first)
    plan: FloatArray = least.at(_ENDS) @ np.array([first, np.cross(up, first)]).T
    return plan


def iter_known_relations(
    boxes: Sequence[SolidBox], up: FloatArray | None
) -> Iterator[tuple[str, int, int, bool]]:
    """Yield the known relations of each two boxes, by indices: `inside` or `beside`, and whether it
    is so. What hangs on unseen space is left out, and so is, without up, what stands beside what.
    """
    if len(boxes) < 2:
        return
    ways, least, most = _both_ways(boxes)
    found = [("inside", inside(ways))]
    if up is not None:
        found.append(("beside", beside(ways, up)))
    for name, related in found:
        each = [related[np.ix_(one, other)] for one in (least, most) for other in (least, most)]
        always, ever = np.logical_and.reduce(each), np.logical_or.reduce(each)
        for one, other in permutations(range(len(boxes)), 2):
            if always[one, other] or not ever[one, other]:
                yield name, one, other, bool(always[one, other])


def iter_missed_beside_shares(
    boxes: Sequence[SolidBox], up: FloatArray | None
) -> Iterator[tuple[int, int, float, float, float]]:
    """Yield for each two boxes, by indices, that are not beside each other as they were found, the
    three shares that this rests on; nothing without up."""
    if up is None or len(boxes) < 2:
        return
    shares = compute_beside_shares(boxes, up)
    for one, other in np.argwhere(~_are_beside(*shares)).tolist():
        if one != other:
            abreast, sunk, over = (float(share[one, other]) for share in shares)
            yield one, other, abreast, sunk, over


def iter_known_overlaps(
    boxes: Sequence[SolidBox], up: FloatArray | None
) -> Iterator[tuple[int, int, float, float]]:
    """Yield for each two boxes, by their indices, the share of the smaller one's plan that lies
    over or under the other's, with its standard deviation; nothing without up, and where unseen
    space makes a difference.
    """
    if up is None or len(boxes) < 2:
        return
    ways, least, most = _both_ways(boxes)
    share = compute_plan_overlap(ways, up)
    each = [share[np.ix_(one, other)] for one in (least, most) for other in (least, most)]
    found, range_ = each[0], np.ptp(each, axis=0)
    # The ends of either may be anywhere in their cells: those of what is thin move as one.
    both = CELL_SD * np.sqrt(2.0)
    moves = ((both, 0.0), (-both, 0.0), (0.0, both), (0.0, -both))
    other_ways = [compute_plan_overlap(boxes, up, shift=move) for move in moves]
    other_ways += [compute_plan_overlap(boxes, up, ends) for ends in (CELL_SD, -CELL_SD)]
    sd = np.abs(np.array(other_ways) - share[: len(boxes), : len(boxes)]).max(axis=0)
    for one, other in permutations(range(len(boxes)), 2):
        if range_[one, other] <= BEYOND:
            yield one, other, min(float(found[one, other]), 1.0), float(sd[one, other])


def iter_known_insets(
    boxes: Sequence[SolidBox], up: FloatArray | None
) -> Iterator[tuple[int, int, float, float, float]]:
    """Yield for each two boxes, by their indices, how far the first one's plan lies within the
    other's, below 0 if it projects: on the side where that is least, and on the farther one of the
    two sides of the nearest corner; with their standard deviation;
    nothing without up, and where unseen space makes a difference.
    """
    if up is None or len(boxes) < 2:
        return
    most = [box.widest for box in boxes]
    for one, other in permutations(range(len(boxes)), 2):
        inner, outer = boxes[one], boxes[other]
        sd = float(CELL_SD * np.hypot(inner.cell, outer.cell))
        found = _measure_insets(inner, outer, up)
        ways = [_measure_insets(most[one], outer, up), _measure_insets(inner, most[other], up)]
        if np.abs(np.array(ways) - found).max() <= sd:
            yield one, other, float(found[0]), float(found[1]), sd


def iter_known_distances(
    boxes: Sequence[SolidBox], up: FloatArray | None
) -> Iterator[tuple[int, int, float, float]]:
    """Yield for each two boxes, by their indices, how far apart their middles are seen from above,
    with its standard deviation; nothing without up, and where unseen space makes a difference.
    """
    if up is None or len(boxes) < 2:
        return
    flat = np.eye(3) - np.outer(up, up)
    middles = np.array([box.middle for box in boxes]) @ flat
    moved = np.linalg.norm(np.array([box.widest.middle for box in boxes]) @ flat - middles, axis=1)
    cells = CELL_SD * np.array([box.cell for box in boxes])
    known = moved <= cells
    for one, other in permutations(np.flatnonzero(known).tolist(), 2):
        apart = float(np.linalg.norm(middles[one] - middles[other]))
        yield one, other, apart, float(np.hypot(cells[one], cells[other]))


def _measure_insets(inner: SolidBox, outer: SolidBox, up: FloatArray) -> FloatArray:
    """Return how far (2,) a box's plan lies within another's: on the side where that is least, and
    on the nearest side along another direction.
    """
    # The sides of a box's plan are parallel to its edges: their normals are square to those and up.
    normals = np.cross(outer.axes, up)
    lengths = np.linalg.norm(normals, axis=1)
    square = lengths > THIN
    normals = np.concatenate([each := normals[square] / lengths[square, None], -each])
    inside, around = (box.at(_ENDS) @ normals.T for box in (inner, outer))
    insets = (around.max(axis=0) - inside.max(axis=0)).reshape(2, -1).min(axis=0)
    found: FloatArray = np.sort(insets)[:2]
    return found


def _both_ways(
    boxes: Sequence[SolidBox],
) -> tuple[list[SolidBox], NDArray[np.intp], NDArray[np.intp]]:
    """Return the boxes as they were found and as far as they may reach; of each the index
    of both.
    """
    on = [i for i, box in enumerate(boxes) if box.reaches.any()]
    least, most = np.arange(len(boxes)), np.arange(len(boxes))
    most[on] = len(boxes) + np.arange(len(on))
    return [*boxes, *(boxes[i].widest for i in on)], least, most
