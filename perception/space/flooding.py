"""Which cells the surface of a thing encloses: flooded from outside, as far as gaps let through.

It does not matter which way a surface is turned, whether it is doubled, or whether parts cross;
gaps narrower than a cell are closed. Where outlines are known less well than to a cell, as those of
clouds are, neighbouring faces miss each other by as much: then the flood does not pass through gaps
that narrow either. Nor do wider gaps empty a box: cells from which surface is met along all six
axes are a room, and a room that is open over less than one of a cube's sides is enclosed. The frame
beneath a table is open over more; an open shelf and a bin without a lid are no rooms.
"""

import numpy as np

from facetlog.perception.space.grid import Cells
from facetlog.perception.types import FloatArray

# What is nearer than this share of the way to the shell stands before it; noise of a shell, or a
# board on it, is further off.
BEFORE = 0.8
# Less than this share of the points is noise, or a rim that stands out.
LEAST_SHARE = 0.05
# Numbers in a table of points and sides: 80 MB.
MOST_AT_ONCE = 10_000_000


def is_empty_shell(shell: FloatArray, points: FloatArray, place: FloatArray) -> bool:
    """Return whether next to nothing of points (n, 3) stands between a place (3,) and the convex
    hull of the `shell` (k, 3); False where the place is not within it.

    Of a shell nothing tells whether it is a room or a thing: that differs in size alone.
    """
    from scipy.spatial import ConvexHull, QhullError  # loaded only now: few scenes need it

    try:
        sides = ConvexHull(shell).equations
    except (QhullError, ValueError):  # flat, or too few points
        return False
    depth = -(sides[:, :3] @ place + sides[:, 3])
    if not (depth > 0.0).all():
        return False
    # along a ray p + t r a side is met at t = depth / (n · r)
    outwards = (sides[:, :3] / depth[:, None]).T  # 1 at the hull
    # A curved shell has as many sides as points: few points at a time, or they take all memory.
    several = max(1, MOST_AT_ONCE // len(sides))
    before = sum(
        int((((points[k : k + several] - place) @ outwards).max(axis=1) < BEFORE).sum())
        for k in range(0, len(points), several)
    )
    return before <= LEAST_SHARE * len(points)


# Two faces' outlines miss each other by less than this many sd of a corner, to either side.
MISSED_SDS = 2.0
# Less than this share of a cell, to either side, closes itself: both reach into it.
LEAST_MISSED = 0.25
# A room is enclosed if it is open over no more of its rim: one side of a cube is 1/6 of it.
OPEN_SHARE = 0.15


def count_missed_cells(corner_sd: float) -> int:
    """Return by how many cells an outline may miss its neighbour's, for a corner's sd in cells.

    >>> count_missed_cells(0.1), count_missed_cells(0.2), count_missed_cells(0.6)
    (0, 1, 2)
    """
    missed = MISSED_SDS * corner_sd
    return int(np.ceil(missed)) if missed > LEAST_MISSED else 0


def enclosed(surface: Cells, *, on_ground: bool, missed: int = 0) -> tuple[Cells, Cells]:
    """Return cells that are surface or are enclosed by it, and those of rooms that are nearly so;
    the ground closes what stands on it.
    """
    missed = min(missed, max(surface.shape))  # from there on all gaps are closed
    within = ~find_reached_from_outside(surface, on_ground=on_ground, missed=missed)
    rooms = _find_met_along_all_axes(surface, on_ground=on_ground) & ~within
    return within, _find_nearly_closed(rooms, within) if rooms.any() else rooms


def find_reached_from_outside(surface: Cells, *, on_ground: bool, missed: int = 0) -> Cells:
    """Return cells that can be reached from outside; on the ground not from below.

    Gaps of up to twice as many cells as `missed` do not let the flood through, only in.
    """
    from scipy import ndimage  # loaded only now: what has no space does without

    below = 0 if on_ground else 1
    margin = max(1, missed)
    rim = ((margin, margin), (margin, margin), (below * margin, margin))
    free = np.pad(~surface, rim, constant_values=True)
    open_ = free & ~_closed(free, on_ground, missed) if missed else free
    regions, _ = ndimage.label(open_)
    reached = regions == regions[0, 0, -1]
    if missed:
        reached = ndimage.binary_dilation(
            reached, iterations=missed, mask=reached | (free & ~open_)
        )
    nx, ny, nz = surface.shape
    low = below * margin
    found: Cells = reached[margin : margin + nx, margin : margin + ny, low : low + nz]
    return found


def _closed(free: Cells, on_ground: bool, missed: int) -> Cells:
    """Return the surface in a grid of which these cells are `free`, and the gaps in it."""
    from scipy import ndimage

    # what stands on the ground goes on beneath it
    full = np.pad(~free, ((0, 0), (0, 0), (missed, 0)), constant_values=False)
    if on_ground:
        full[:, :, :missed] = full[:, :, missed : missed + 1]
    closed: Cells = ndimage.binary_closing(full, iterations=missed)[:, :, missed:]
    return closed | ~free


def _find_met_along_all_axes(surface: Cells, *, on_ground: bool) -> Cells:
    """Return cells from which surface is met along all six axes, down at the ground at the
    latest.
    """
    met = np.ones_like(surface)
    for axis in range(3):
        met &= np.logical_or.accumulate(surface[_make_reversed_slice(axis)], axis)[
            _make_reversed_slice(axis)
        ]
        if axis < 2 or not on_ground:
            met &= np.logical_or.accumulate(surface, axis)
    return met


def _find_nearly_closed(rooms: Cells, within: Cells) -> Cells:
    """Return the cells of rooms that are open over little of their rim; `within` is their walls."""
    from scipy import ndimage

    room, count = ndimage.label(rooms)
    rim, opened = np.zeros(count + 1), np.zeros(count + 1)
    for axis in range(3):
        for here, walls in (
            (room, within),
            (room[_make_reversed_slice(axis)], within[_make_reversed_slice(axis)]),
        ):
            along, beside = np.moveaxis(here, axis, 0), np.moveaxis(walls, axis, 0)
            last = (along[:-1] > 0) & (along[1:] == 0)
            of, closed = along[:-1][last], beside[1:][last]
            rim += np.bincount(of, minlength=count + 1)
            opened += np.bincount(of[~closed], minlength=count + 1)
    rim += np.bincount(room[:, :, 0].ravel(), minlength=count + 1)  # on the ground
    kept = opened <= OPEN_SHARE * rim
    kept[0] = False
    return np.asarray(kept[room], dtype=np.bool_)


def _make_reversed_slice(axis: int) -> tuple[slice, ...]:
    return tuple(slice(None, None, -1 if k == axis else None) for k in range(3))
