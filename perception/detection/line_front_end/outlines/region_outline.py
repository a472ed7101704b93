"""The border of a region on a plane as a polygon, its sides on lines where it runs along them."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.flat_faces import crossing
from facetlog.perception.polygons import find_symmetric_difference, make_polygon
from facetlog.perception.stable_order import largest
from facetlog.perception.types import FloatArray

# The border runs along a line where it is this near, in cells, and this parallel.
NEAR_CELLS = 2.2
PARALLEL_COSINE = 0.8
# A line goes on beyond its ends by this share of its length: where it fades, or corners hide it.
BEYOND = 0.25
# Shorter sides than this many cells are the grid's own steps.
MIN_SIDE_CELLS = 2.0
# What runs along no line is simplified to within so many cells.
CURVE_CELLS = 1.0
# A polygon whose border differs from the region's own by more than this is rejected.
MAX_OFF_CELLS = 5.0
MEAN_OFF_CELLS = 1.5
# A ragged border is simplified to within so many cells too.
ROUGH_CELLS = (3.0, 6.0)
# A curve within a pixel of its chords has fewer sides than this, however large it is in a picture.
MAX_SIDES = 40


@dataclass(frozen=True, eq=False, slots=True)
class _Side:
    ends: FloatArray  # (2, 2), of the line that it runs on
    line: int  # -1 where it runs along none


def border(region: NDArray[np.uint8]) -> FloatArray:
    """Return the outer border (m, 2) of a region of cells, counter-clockwise, in cells (x, y)."""
    twice = cv2.resize(region, None, fx=2, fy=2, interpolation=cv2.INTER_NEAREST)
    contours, _ = cv2.findContours(
        np.asarray(twice, dtype=np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE
    )
    ring = np.asarray(max(contours, key=cv2.contourArea)[:, 0], dtype=np.float64) / 2 + 0.25
    return ring if _area(ring) > 0 else ring[::-1]


def fit_outline_polygon(ring: FloatArray, lines: FloatArray) -> FloatArray | None:
    """Return corners (k, 2) of a polygon round a border (m, 2), counter-clockwise; None if there is
    none.

    `lines` (n, 2, 2) are what the sides may run on; all in cells. Where they lead away from the
    border, as chords of a curve do, the border itself is simplified.
    """
    region = make_polygon(ring)
    for corners in (_along_lines(ring, lines), _simplified(ring)):
        if corners is None or not 3 <= len(corners) <= MAX_SIDES:
            continue
        polygon = shapely.Polygon(corners)
        if not polygon.is_valid or _area(corners) <= 0:
            continue
        if polygon.hausdorff_distance(region) >= MAX_OFF_CELLS:  # quicker than the next
            continue
        if find_symmetric_difference(polygon, region).area < MEAN_OFF_CELLS * region.length:
            return corners
    return None


def iter_rough_polygons(ring: FloatArray, most: int) -> Iterator[FloatArray]:
    """Return polygons (k, 2) of ever fewer sides round a border (m, 2), less than `most` of them.

    Light and noise fray the border of a region whose true sides are straight.
    """
    for tolerance in ROUGH_CELLS:
        corners = _simplified(ring, tolerance)
        if 3 <= len(corners) < most and shapely.Polygon(corners).is_valid and _area(corners) > 0:
            yield corners
            most = len(corners)


def remove_short_sides(corners: FloatArray, least: float) -> FloatArray:
    """Return a polygon (k, 2) whose sides shorter than `least` became corners, the shortest first.

    The sides beside it go on to where they cross, if that is near; else the corner is midway.
    """
    while len(corners) > 3:
        length = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
        k = largest(-length)
        if length[k] >= least:
            break
        a, b, c, d = np.roll(corners, 1 - k, axis=0)[:4]
        middle = (b + c) / 2
        at = crossing((a, b - a), (d, c - d))
        near = at is not None and np.linalg.norm(at - middle) < 2 * least
        corners = np.concatenate(
            [[at if near else middle], np.roll(corners, -k - 2, axis=0)[: len(corners) - 2]]
        )
    return corners


def remove_straight_corners(corners: FloatArray, least: float) -> FloatArray:
    """Return a polygon (k, 2) without the corners nearer than `least` to the line past them."""
    while len(corners) > 3:
        before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
        past, to = after - before, corners - before
        length = np.maximum(np.linalg.norm(past, axis=1), 1e-300)
        off = np.abs(past[:, 0] * to[:, 1] - past[:, 1] * to[:, 0]) / length
        k = largest(-off)
        if off[k] >= least:
            break
        corners = np.delete(corners, k, axis=0)
    return corners


def _area(ring: FloatArray) -> float:
    following = np.roll(ring, -1, axis=0)
    return float((ring[:, 0] * following[:, 1] - ring[:, 1] * following[:, 0]).sum()) / 2


def _simplified(ring: FloatArray, tolerance: float = CURVE_CELLS) -> FloatArray:
    corners = cv2.approxPolyDP(ring.astype(np.float32)[:, None], tolerance, closed=True)
    return np.asarray(corners[:, 0], dtype=np.float64)


def _along_lines(ring: FloatArray, lines: FloatArray) -> FloatArray | None:
    sides = _sides(ring, lines)
    if len(sides) < 3:
        return None
    corners = np.array(
        [_corner(a, b, ring) for a, b in zip(sides[-1:] + sides, sides, strict=False)]
    )
    apart = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    kept: FloatArray = corners[apart > 1.0]
    return kept if len(kept) >= 3 else None


def _sides(ring: FloatArray, lines: FloatArray) -> list[_Side]:
    nearest = _find_nearest_lines(ring, lines)
    starts = np.nonzero(nearest != np.roll(nearest, 1))[0]
    if not len(starts):
        return []
    sides: list[_Side] = []
    for first, after in zip(starts, np.append(starts[1:], starts[0] + len(ring)), strict=True):
        run = ring[np.arange(first, after) % len(ring)]
        line = int(nearest[first])
        if line >= 0:
            if np.linalg.norm(run[-1] - run[0]) > MIN_SIDE_CELLS:
                sides.append(_Side(lines[line], line))
        elif len(run) > 2:
            curve = cv2.approxPolyDP(run.astype(np.float32)[:, None], CURVE_CELLS, closed=False)
            points = np.asarray(curve[:, 0], dtype=np.float64)
            sides += [
                _Side(np.array(ends), -1)
                for ends in pairwise(points)
                if np.hypot(*(ends[1] - ends[0])) > MIN_SIDE_CELLS
            ]
    joined = [s for k, s in enumerate(sides) if s.line < 0 or s.line != sides[k - 1].line]
    return joined if len(joined) > 1 else sides[:1]


def _find_nearest_lines(ring: FloatArray, lines: FloatArray) -> NDArray[np.intp]:
    # Of each point of the border the line that it runs along, or -1.
    reach = max(2, min(4, len(ring) // 8))
    along = np.roll(ring, -reach, axis=0) - np.roll(ring, reach, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    if not len(lines):
        return np.full(len(ring), -1, dtype=np.intp)
    start, end = lines[:, 0], lines[:, 1]
    length = np.linalg.norm(end - start, axis=1)
    unit = (end - start) / np.maximum(length, 1e-12)[:, None]
    across = np.stack([-unit[:, 1], unit[:, 0]], axis=1)
    off = np.abs(ring @ across.T - (start * across).sum(axis=1))  # (m, n)
    place = ring @ unit.T - (start * unit).sum(axis=1)
    slack = BEYOND * length + NEAR_CELLS
    runs = (np.abs(along @ unit.T) > PARALLEL_COSINE) & (off < NEAR_CELLS) & (length > 0)
    runs &= (place > -slack) & (place < length + slack)
    off = np.where(runs, off, np.inf)
    nearest = off.argmin(axis=1)
    return np.where(np.isfinite(off[np.arange(len(ring)), nearest]), nearest, -1)


def _corner(before: _Side, after: _Side, ring: FloatArray) -> FloatArray:
    # Where the two sides cross, if that is near the border; else the border's point between them.
    one, other = ((s.ends[0], s.ends[1] - s.ends[0]) for s in (before, after))
    at = crossing(one, other)
    if at is not None and np.hypot(*(ring - at).T).min() < MAX_OFF_CELLS:
        return at
    gaps = [(float(np.hypot(*(p - q))), (p + q) / 2) for p in before.ends for q in after.ends]
    between = min(gaps, key=lambda gap: gap[0])[1]
    return np.asarray(ring[np.hypot(*(ring - between).T).argmin()])
