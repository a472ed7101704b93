"""Parallelograms that two sides propose: a faint side has no 3-D segment of its own."""

from itertools import combinations

import numpy as np

from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import (
    PlaneHypothesis,
    plane_basis,
)
from facetlog.perception.flat_faces import crossing
from facetlog.perception.stable_order import descending
from facetlog.perception.types import FloatArray

# Segments of a plane that take part, the longest first, and parallelograms of a plane.
MAX_SEGMENTS, KEEP = 14, 12
# Two sides meet where their lines cross not farther beyond an end, or before it, than so many px
# or this share of the side; as near, two parallelograms are one and a segment lies on a side.
MEET_PX, MEET_SHARE = 6.0, 0.1
# Shorter sides, px, are below what a segment detector finds.
MIN_SIDE_PX = 10.0


def parallelograms(
    segments: FloatArray, plane: PlaneHypothesis, pixel: float
) -> tuple[FloatArray, ...]:
    """Return parallelograms (4, 3) of a plane with two of their sides on segments (n, 2, 3) that
    meet.

    From the corner the sides reach to their segments' ends; the segments lie near the plane,
    `pixel` is a pixel's length there. Those come first whose sides the segments leave out least.
    """
    basis = plane_basis(plane.normal)
    flat = segments @ basis
    length = np.linalg.norm(flat[:, 1] - flat[:, 0], axis=1)
    longest = [k for k in descending(length)[:MAX_SEGMENTS] if length[k] > MIN_SIDE_PX * pixel]
    flat, near = flat[longest], MEET_PX * pixel
    found = []
    for one, other in combinations(flat, 2):
        at = crossing((one[0], one[1] - one[0]), (other[0], other[1] - other[0]))
        if at is not None:
            found += [
                np.array([at, at + a, at + a + b, at + b])
                for a in _arms(one, at, pixel)
                for b in _arms(other, at, pixel)
            ]
    missing = np.array([_left_out(corners, flat, near) for corners in found])
    distinct: list[FloatArray] = []
    for k in descending(-missing):
        if all(_apart(found[k], other) > near for other in distinct):
            distinct.append(found[k])
        if len(distinct) == KEEP:
            break
    foot = plane.normal * plane.distance
    return tuple(corners @ basis.T + foot for corners in distinct)


def _arms(segment: FloatArray, at: FloatArray, pixel: float) -> list[FloatArray]:
    # From a place (2,) on the line of a segment (2, 2) to the segment's ends, if it passes there.
    along = segment[1] - segment[0]
    length = float(np.linalg.norm(along))
    near = max(MEET_PX * pixel, MEET_SHARE * length)
    place = float((at - segment[0]) @ along) / length
    if not -near <= place <= length + near:
        return []
    least = max(near, MIN_SIDE_PX * pixel)
    reaches = zip(segment, (place, length - place), strict=True)
    return [end - at for end, reach in reaches if reach > least]


def _apart(one: FloatArray, other: FloatArray) -> float:
    # How far a corner of one is from all of the other's, at most.
    return float(np.linalg.norm(one[:, None] - other, axis=-1).min(axis=1).max())


def _left_out(corners: FloatArray, segments: FloatArray, near: float) -> float:
    # Length of a polygon's sides that no segment lies along.
    missing = 0.0
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        size = float(np.linalg.norm(end - start))
        unit = (end - start) / size
        offset = segments - start
        off = np.abs(offset[..., 0] * unit[1] - offset[..., 1] * unit[0]).max(axis=1)
        place = np.sort(offset @ unit, axis=1)
        beside = np.minimum(place[:, 1], size) - np.maximum(place[:, 0], 0.0)
        missing += size - float(np.clip(beside[off < near], 0.0, size).max(initial=0.0))
    return missing
