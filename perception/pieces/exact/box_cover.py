"""Boards, bars and blocks of the solid cells of a lattice: the fewest boxes that cover them.

A box of cells that can grow to no side is a candidate. One that covers a cell which no other covers
is needed: a leg for what is below the top, the top for what is between the legs. Where two meet,
both reach through at first; joints are settled thereafter, by shape alone:

- where one ends at another that goes on, it ends there (a rung at a rail);
- at a corner the one with the larger face goes through (a top over its legs);
- where both go on, both stay whole (a shelf through an upright).

A plate of one thickness, whatever its outline, is one board while it has no hole: the top of an
L-shaped desk. A frame round a hole is cut into bars.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.pieces.exact.lattice import Lattice
from facetlog.perception.ragged import Bools, Indices, joined, unique_rows
from facetlog.perception.types import FloatArray

# A board is thinner than this share of its width: so wide are the bars of frames and legs.
BOARD = 0.35
# Faces whose areas differ by less are equal, and the direction decides.
EQUAL = 1e-3
# Uncovered solid of less than this share of a body is no part of its own.
CRUMB = 1e-4
# Boxes that are compared with one another, some tenth of a second.
MOST_BOXES = 1500


@dataclass(frozen=True, eq=False, slots=True)
class Parts:
    """Boxes of cells (n, 2, 3), and which of them make one plate (n,)."""

    boxes: Indices
    plate: Indices


def find_boxes(lattice: Lattice, solid: Bools) -> Parts | None:
    """Return the boxes of a lattice's solid cells (nx, ny, nz); None where there are too many."""
    candidates = _grow(solid)
    if candidates is None:
        return None
    volumes = lattice.volumes
    boxes = candidates[_choose(candidates, solid, volumes)]
    boxes = _settle_joints(boxes, lattice)
    return Parts(boxes, _find_plates(boxes, lattice))


def _grow(solid: Bools) -> Indices | None:
    """Return the boxes (n, 2, 3) of solid cells that rows of them grow to, along one axis after
    another, in every order.
    """
    found: list[Indices] = []
    for along, across, last in (
        (0, 1, 2),
        (0, 2, 1),
        (1, 0, 2),
        (1, 2, 0),
        (2, 0, 1),
        (2, 1, 0),
    ):
        turned = np.transpose(solid, (along, across, last))
        sums = np.pad(turned.astype(np.int64), ((1, 0),) * 3)
        for axis in range(3):
            sums = sums.cumsum(axis=axis)
        boxes = _widen(sums, _widen(sums, _find_rows(turned), 1), 2)
        if len(boxes) > 20 * MOST_BOXES:
            return None
        back = np.argsort((along, across, last))
        found.append(boxes[:, :, back])
    unique = unique_rows(np.concatenate(found).reshape(-1, 6))
    return unique.reshape(-1, 2, 3) if len(unique) <= MOST_BOXES else None


def _find_rows(solid: Bools) -> Indices:
    """Return the longest rows (n, 2, 3) of solid cells along the first axis."""
    padded = np.pad(solid, ((1, 1), (0, 0), (0, 0))).astype(np.int8)
    change = np.diff(padded, axis=0)
    # row by row, so that starts and ends come in pairs
    starts = np.argwhere(np.moveaxis(change, 0, 2) == 1)
    ends = np.argwhere(np.moveaxis(change, 0, 2) == -1)
    low = np.column_stack([starts[:, 2], starts[:, 0], starts[:, 1]])
    high = np.column_stack([ends[:, 2], starts[:, 0] + 1, starts[:, 1] + 1])
    return np.stack([low, high], axis=1)


def _widen(sums: Indices, boxes: Indices, axis: int) -> Indices:
    """Return boxes (n, 2, 3) grown along an axis to both sides as far as all is solid; each once.

    `sums` are of the cells before each place.
    """
    boxes = boxes.copy()
    for end in (0, 1):
        growing = np.arange(len(boxes))
        while len(growing):
            slab = boxes[growing].copy()
            slab[:, 1 - end, axis] = slab[:, end, axis]
            slab[:, end, axis] += 2 * end - 1
            there = (slab[:, 0, axis] >= 0) & (slab[:, 1, axis] < sums.shape[axis])
            growing, slab = growing[there], slab[there]
            full = _count(sums, slab) == np.diff(slab, axis=1)[:, 0].prod(axis=1)
            growing, slab = growing[full], slab[full]
            boxes[growing, end, axis] = slab[:, end, axis]
        boxes = unique_rows(boxes.reshape(-1, 6)).reshape(-1, 2, 3)
    return boxes


def _count(sums: NDArray[Any], boxes: Indices) -> NDArray[Any]:
    """Return how much there is in boxes (n, 2, 3) of cells, by sums before each place."""
    (x, y, z), (x2, y2, z2) = np.moveaxis(boxes, 0, 2)
    upper = sums[x2, y2, z2] - sums[x, y2, z2] - sums[x2, y, z2] + sums[x, y, z2]
    lower = sums[x2, y2, z] - sums[x, y2, z] - sums[x2, y, z] + sums[x, y, z]
    return np.asarray(upper - lower)


def _slices(box: Indices) -> tuple[slice, ...]:
    return tuple(slice(int(low), int(high)) for low, high in box.T)


def _choose(boxes: Indices, solid: Bools, volumes: FloatArray) -> Indices:
    """Return which boxes cover the solid cells: those needed, then those that cover the most."""
    times = np.zeros(solid.shape, dtype=np.int32)
    only = np.full(solid.shape, -1)
    for number, box in enumerate(boxes):
        own = _slices(box)
        times[own] += 1
        only[own] = number
    chosen = np.unique(only[times == 1]).tolist()
    free = solid.copy()
    for number in chosen:
        free[_slices(boxes[number])] = False
    least = CRUMB * float(volumes[solid].sum())
    while float(volumes[free].sum()) > least:
        weights = np.where(free, volumes, 0.0)
        sums = np.pad(weights, ((1, 0),) * 3).cumsum(0).cumsum(1).cumsum(2)
        best = int(np.argmax(_count(sums, boxes)))
        if not free[_slices(boxes[best])].any():
            break
        chosen.append(best)
        free[_slices(boxes[best])] = False
    return np.array(_drop_spare(boxes, chosen, solid, volumes), dtype=np.int64)


def _drop_spare(boxes: Indices, chosen: list[int], solid: Bools, volumes: FloatArray) -> list[int]:
    """Return the chosen boxes without those of which others cover all but crumbs."""
    times = np.zeros(solid.shape, dtype=np.int32)
    for number in chosen:
        times[_slices(boxes[number])] += 1
    kept = []
    least = CRUMB * float(volumes[solid].sum())
    for number in sorted(chosen, key=lambda n: float(volumes[_slices(boxes[n])].sum())):
        own = _slices(boxes[number])
        if float(volumes[own][times[own] == 1].sum()) > least:
            kept.append(number)
        else:
            times[own] -= 1
    return kept


def _settle_joints(boxes: Indices, lattice: Lattice) -> Indices:
    """Return boxes (n, 2, 3) of which each ends where another goes through.

    Those with the least face are settled first: a block ends at the boards above and below it
    before it is seen whether these end at it.
    """
    boxes = boxes.copy()
    times = np.zeros(lattice.solid.shape, dtype=np.int32)
    for box in boxes:
        times[_slices(box)] += 1
    ranks = _rank(boxes, lattice)
    losers = _decide_corners(boxes, ranks)
    order = sorted(range(len(boxes)), key=lambda number: ranks[number])
    changed = True
    while changed:
        changed = False
        for number in order:
            while (shorter := _shorten(number, boxes, times, ranks, losers)) is not None:
                times[_slices(boxes[number])] -= 1
                times[_slices(shorter)] += 1
                boxes[number] = shorter
                changed = True
    return boxes


def _shorten(
    number: int,
    boxes: Indices,
    times: NDArray[np.int32],
    ranks: list[tuple[float, ...]],
    losers: dict[tuple[int, int], int],
) -> Indices | None:
    """Return a box without what it loses to another, None if it loses nothing."""
    box = boxes[number]
    low, high = np.maximum(box[0], boxes[:, 0]), np.minimum(box[1], boxes[:, 1])
    for other in np.flatnonzero((low < high).all(axis=1)).tolist():
        if other == number:
            continue
        lost = np.stack([low[other], high[other]])
        shorter = _cut_end(box, lost)
        if shorter is None or (times[_slices(lost)] < 2).any():
            continue
        pair = (min(number, other), max(number, other))
        if pair in losers:
            loser = losers[pair]
        elif _cut_end(boxes[other], lost) is None:
            loser = number  # the other goes on
        else:
            loser = min(pair, key=lambda each: ranks[each])
        if loser == number:
            return shorter
    return None


def _cut_end(box: Indices, lost: Indices) -> Indices | None:
    """Return the box without an end, if what is lost is one."""
    differs = (lost != box).any(axis=0)
    if differs.sum() != 1:
        return None
    axis = int(differs.argmax())
    shorter = box.copy()
    if lost[0, axis] == box[0, axis]:
        shorter[0, axis] = lost[1, axis]
    elif lost[1, axis] == box[1, axis]:
        shorter[1, axis] = lost[0, axis]
    else:
        return None
    return shorter


def _decide_corners(boxes: Indices, ranks: list[tuple[float, ...]]) -> dict[tuple[int, int], int]:
    """Return which of two boxes ends at a corner, where it is not just the one with less face.

    Three or more that all meet one another between the same two axes are cut alike, along the axis
    that takes less face: so solid steps become a stack of slabs or a row of blocks.
    """
    low = np.maximum(boxes[:, None, 0], boxes[None, :, 0])
    high = np.minimum(boxes[:, None, 1], boxes[None, :, 1])
    by_axes: dict[tuple[int, int], list[tuple[int, int, int, int]]] = {}
    for one, two in np.argwhere(np.triu((low < high).all(axis=2), 1)).tolist():
        lost = np.stack([low[one, two], high[one, two]])
        if all(_cut_end(boxes[each], lost) is not None for each in (one, two)):
            cut = [int((lost != boxes[each]).any(axis=0).argmax()) for each in (one, two)]
            if cut[0] != cut[1]:
                by_axes.setdefault((min(cut), max(cut)), []).append((one, two, cut[0], cut[1]))
    losers: dict[tuple[int, int], int] = {}
    for axes, own in by_axes.items():
        _, group = joined(len(boxes), [corner[:2] for corner in own])
        for number in np.flatnonzero(np.bincount(group) > 2).tolist():
            corners = [corner for corner in own if group[corner[0]] == number]
            count = int((group == number).sum())
            if len(corners) < count * (count - 1) // 2:
                continue
            costs = dict.fromkeys(axes, 0.0)
            for one, two, cut_one, cut_two in corners:
                costs[cut_one] += float(np.exp(ranks[one][0] * EQUAL))
                costs[cut_two] += float(np.exp(ranks[two][0] * EQUAL))
            axis = axes[0] if costs[axes[0]] < costs[axes[1]] * (1.0 - EQUAL) else axes[1]
            losers |= {(one, two): one if cut == axis else two for one, two, cut, _ in corners}
    return losers


def _rank(boxes: Indices, lattice: Lattice) -> list[tuple[float, ...]]:
    """Return what orders boxes: their largest faces, then how they lie, then where."""
    bounds = lattice.bounds(boxes)
    sides = bounds[:, 1] - bounds[:, 0]
    order = np.sort(sides, axis=1)
    faces = np.round(np.log(order[:, 2] * order[:, 1]) / EQUAL)
    lying = sides.argmin(axis=1) * 3 + sides.argmax(axis=1)
    return [
        (float(face), float(-way), *where)
        for face, way, where in zip(faces, lying, bounds[:, 0].tolist(), strict=True)
    ]


def _find_plates(boxes: Indices, lattice: Lattice) -> Indices:
    """Return the number of the plate (n,) of each box; most are one by themselves."""
    n = len(boxes)
    bounds = lattice.bounds(boxes)
    sides = bounds[:, 1] - bounds[:, 0]
    thin = sides.argmin(axis=1)
    order = np.sort(sides, axis=1)
    board = order[:, 0] < BOARD * order[:, 1]
    pairs = []
    for one in range(n):
        for two in range(one + 1, n):
            if not (board[one] and board[two] and thin[one] == thin[two]):
                continue
            axis = int(thin[one])
            level = (boxes[one, :, axis] == boxes[two, :, axis]).all()
            low = np.maximum(boxes[one, 0], boxes[two, 0])
            high = np.minimum(boxes[one, 1], boxes[two, 1])
            # they share more than a corner
            if level and (low <= high).all() and ((low < high).sum() >= 2):
                pairs.append((one, two))
    _, plate = joined(n, pairs)
    for number in np.flatnonzero(np.bincount(plate) > 1).tolist():
        own = np.flatnonzero(plate == number)
        if _has_hole(boxes[own], int(thin[own[0]])):
            plate[own] = plate.max() + 1 + np.arange(len(own))
    return np.unique(plate, return_inverse=True)[1].astype(np.int64)


def _has_hole(boxes: Indices, thin: int) -> bool:
    """Return whether the outline of level boxes has a hole."""
    from scipy import ndimage

    flat = np.delete(boxes, thin, axis=2)
    outline = np.zeros(tuple(flat[:, 1].max(axis=0) + 2), dtype=np.bool_)
    for low, high in flat:
        outline[low[0] + 1 : high[0] + 1, low[1] + 1 : high[1] + 1] = True
    return int(ndimage.label(~outline)[1]) > 1
