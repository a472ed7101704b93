"""Straight sides of a jagged ring: few corners, lines fitted through what lies between them."""

from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray

# The jagged rim of points at random is within so many spacings of the true one.
JAG = 1.5
# A ring is a rectangle if no point of either is further than this, in spacings, from the other.
RECTANGLE_JAG = 3.0
# Sides shorter than this, in spacings, are what is left of a corner that no point fell into.
SHORTEST = 4.0
# A side's direction is uncertain by about a spacing over its length; within this multiple of that,
# and never more than 12 degrees, it is made parallel or perpendicular to the others.
SQUARE_SPACINGS = 1.5
MOST_SQUARED = np.deg2rad(12.0)
# A side this short, in spacings, is a corner cut off, if it is between two that lie where planes
# meet (of three faces' points there, the nearest to the corner are dealt to any of them), or
# between two that are so many times longer (points at random fill a corner up).
CUT = 8.0
LONGER = 3.0
# Lines that meet under less than this have no well-defined corner (15 degrees).
MEETING = np.deg2rad(15.0)
# A corner where two lines meet is within so many spacings of where the ring turns.
CORNER_REACH = 6.0
# Points at random end half a spacing before the rim of what they are on.
INSET = 0.5


@dataclass(frozen=True, eq=False, slots=True)
class SideLine:
    """A side: a point of its line and its unit direction (2,), as the ring runs; its length.

    `fixed` says that it lies where two planes meet, and `start` (2,) is where the ring turned
    into it.
    """

    point: FloatArray
    direction: FloatArray
    length: float
    start: FloatArray
    fixed: bool = False

    @property
    def outward(self) -> FloatArray:
        """Unit vector to the right of the direction: outside, where the ring runs left-handed."""
        return np.array([self.direction[1], -self.direction[0]])

    def distance(self, points: FloatArray) -> FloatArray:
        """Return distances outwards of points (n, 2) from the line."""
        distance: FloatArray = (points - self.point) @ self.outward
        return distance


def fit_side_lines(
    ring: FloatArray, spacing: float, *, inwards: bool = False
) -> tuple[SideLine, ...]:
    """Return sides of a counter-clockwise ring (n, 2); `inwards` for a hole's, which points are
    around.
    """
    dense = shapely.segmentize(shapely.LinearRing(ring), spacing)
    rim = shapely.get_coordinates(dense)[:-1]
    corners = _corners(ring, spacing)
    if len(corners) < 3:
        return ()
    ends = np.roll(corners, -1, axis=0)
    segments = shapely.linestrings(np.stack([corners, ends], axis=1))
    nearest = shapely.distance(shapely.points(rim)[:, None], segments[None]).argmin(axis=1)
    lines = []
    for nth, (start, end) in enumerate(zip(corners, ends, strict=True)):
        span = end - start
        length = float(np.linalg.norm(span))
        direction = span / length
        own = rim[nearest == nth]
        along = (own - start) @ direction
        # at its ends a side's rim is already round
        inner = own[(along > spacing) & (along < length - spacing)]
        point = (start + end) / 2.0
        if len(inner) > 2:
            point = inner.mean(axis=0)
            fitted = np.linalg.eigh((inner - point).T @ (inner - point))[1][:, 1]
            direction = fitted if fitted @ direction > 0.0 else -fitted
        outward = np.array([direction[1], -direction[0]])
        shift = (-INSET if inwards else INSET) * spacing
        lines.append(SideLine(point + shift * outward, direction, length, start))
    return tuple(lines)


def _corners(ring: FloatArray, spacing: float) -> FloatArray:
    """Return corners (k, 2) of the simplest ring within the jaggedness, counter-clockwise."""
    polygon = shapely.Polygon(ring)
    box = shapely.minimum_rotated_rectangle(polygon)
    if box.geom_type == "Polygon" and box.area > 0.0:
        # the rectangle round all points is moved in by half of what sticks out
        gap = shapely.hausdorff_distance(box.exterior, polygon.exterior, densify=0.05)
        if gap <= RECTANGLE_JAG * spacing:
            return _loop(box)
    simple = shapely.simplify(polygon, JAG * spacing, preserve_topology=True)
    return _drop_chamfers(_loop(simple), SHORTEST * spacing)


def _loop(polygon: shapely.Polygon) -> FloatArray:
    """Return the rim of a polygon (k, 2), counter-clockwise, without the first point repeated."""
    rim: FloatArray = shapely.get_coordinates(shapely.geometry.polygon.orient(polygon).exterior)
    return rim[:-1]


def _drop_chamfers(corners: FloatArray, shortest: float) -> FloatArray:
    """Return corners in which short sides between two that meet are one corner, or the middle of
    both.
    """
    while len(corners) > 3:
        spans = np.roll(corners, -1, axis=0) - corners
        lengths = np.linalg.norm(spans, axis=1)
        nth = int(lengths.argmin())
        if lengths[nth] >= shortest:
            break
        count = len(corners)
        before, after = spans[nth - 1], spans[(nth + 1) % count]
        meeting = _meeting(corners[nth - 1], before, corners[(nth + 1) % count], after)
        middle = (corners[nth] + corners[(nth + 1) % count]) / 2.0
        if meeting is None or np.linalg.norm(meeting - middle) > shortest:
            meeting = middle
        corners = corners.copy()
        corners[nth] = meeting
        corners = np.delete(corners, (nth + 1) % count, axis=0)
    return corners


def _meeting(p: FloatArray, d: FloatArray, q: FloatArray, e: FloatArray) -> FloatArray | None:
    """Return where the lines p + s d and q + t e meet; None if they are within 15 degrees of
    parallel.
    """
    turn = float(d[0] * e[1] - d[1] * e[0])
    if abs(turn) < np.sin(MEETING) * float(np.linalg.norm(d) * np.linalg.norm(e)):
        return None
    gap = q - p
    met: FloatArray = p + d * float(gap[0] * e[1] - gap[1] * e[0]) / turn
    return met


def squared(lines: tuple[SideLine, ...], spacing: float) -> tuple[SideLine, ...]:
    """Return sides made parallel or perpendicular to the most certain one, within their errors.

    Sides where planes meet are most certain, then long ones; they are not rotated themselves.
    """
    if not lines:
        return ()
    surest = max(lines, key=lambda line: (line.fixed, line.length))
    reference = float(np.arctan2(surest.direction[1], surest.direction[0]))
    turned = []
    for line in lines:
        angle = float(np.arctan2(line.direction[1], line.direction[0]))
        square = reference + np.round((angle - reference) / (np.pi / 2.0)) * (np.pi / 2.0)
        slack = min(SQUARE_SPACINGS * spacing / line.length * 2.0, MOST_SQUARED)
        if not line.fixed and abs(angle - square) <= slack:
            direction = np.array([np.cos(square), np.sin(square)])
            line = SideLine(line.point, direction, line.length, line.start)
        turned.append(line)
    return tuple(turned)


def find_meeting_corners(lines: tuple[SideLine, ...], spacing: float) -> FloatArray:
    """Return corners (k, 2) of the ring whose sides lie on the lines.

    Where two in succession do not meet near the place where the ring turned, as parallel ones do
    not, both end there, and a short side joins them.
    """
    lines = _drop_cuts(lines, CUT * spacing)
    corners: list[FloatArray] = []
    for nth, line in enumerate(lines):
        before = lines[nth - 1]
        met = _meeting(before.point, before.direction, line.point, line.direction)
        if met is not None and np.linalg.norm(met - line.start) <= CORNER_REACH * spacing:
            corners.append(met)
            continue
        ends = [
            one.point + (line.start - one.point) @ one.direction * one.direction
            for one in (before, line)
        ]
        if np.linalg.norm(ends[0] - ends[1]) <= JAG * spacing:
            ends = [(ends[0] + ends[1]) / 2.0]
        corners.extend(ends)
    return _drop_straight_corners(np.array(corners), JAG * spacing)


def _drop_cuts(lines: tuple[SideLine, ...], longest: float) -> tuple[SideLine, ...]:
    """Return sides without short ones between two that are fixed, or much longer, and meet near
    them.
    """
    cuts = [_is_cut(lines, nth, longest) for nth in range(len(lines))]
    if len(lines) - sum(cuts) < 3:
        return lines
    # the side after a cut now begins where the cut did
    return tuple(
        replace(line, start=lines[nth - 1].start) if cuts[nth - 1] else line
        for nth, line in enumerate(lines)
        if not cuts[nth]
    )


def _is_cut(lines: tuple[SideLine, ...], nth: int, longest: float) -> bool:
    """Return whether a side only cuts off the corner of its neighbours."""
    before, line, after = lines[nth - 1], lines[nth], lines[(nth + 1) % len(lines)]
    longer = min(before.length, after.length) >= LONGER * line.length
    if line.fixed or line.length > longest or not ((before.fixed and after.fixed) or longer):
        return False
    met = _meeting(before.point, before.direction, after.point, after.direction)
    return met is not None and float(np.linalg.norm(met - line.start)) <= longest


def _drop_straight_corners(corners: FloatArray, jag: float) -> FloatArray:
    """Return corners without those on the line between their neighbours, within a tenth of
    `jag`.
    """
    keep: NDArray[np.bool_] = np.ones(len(corners), dtype=bool)
    for nth in range(len(corners)):
        rest = np.flatnonzero(keep)
        if len(rest) <= 3:
            break
        place = int(np.searchsorted(rest, nth))
        a, b = corners[rest[place - 1]], corners[rest[(place + 1) % len(rest)]]
        span = b - a
        length = float(np.linalg.norm(span))
        gap = corners[nth] - a
        if length > 0.0 and abs(span[0] * gap[1] - span[1] * gap[0]) / length < 0.1 * jag:
            keep[nth] = False
    return corners[keep]
