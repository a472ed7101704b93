"""Whether coordinates can be those of a shape: fine enough where they are, and no degrees."""

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.types import FloatArray

# Numbers farther apart than this share of the extent leave ten places for a corner along it.
COARSEST = 0.1
# A degree of latitude, in metres; a shape in degrees is so much too narrow for its height.
METRES_PER_DEGREE = 111_000.0
# The widths of a shape are its height times or over so much at most, as of a mast or a field.
MOST_SLENDER = 1000.0
LONGITUDE, LATITUDE = 180.0, 90.0


def check_resolution(points: FloatArray, name: str) -> None:
    """Raise InputError where neighbouring numbers are too far apart for points (n, 3), all finite.

    Points that all are 32-bit numbers were kept as such: at 1e9 these are 64 apart.
    """
    if not len(points):
        return
    farthest = float(np.abs(points).max())
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    # most shapes are at their origin, and need no look at each number
    if extent == 0.0 or COARSEST * extent >= np.finfo(np.float32).eps * farthest:
        return
    with np.errstate(over="ignore"):
        short = np.array_equal(points.astype(np.float32), points)
    step = float(np.finfo(np.float32 if short else np.float64).eps) * farthest
    if step > COARSEST * extent:
        raise InputError(
            f"{name}: lies {farthest:.2g} from the origin, where its numbers are {step:.2g} apart, "
            f"too coarse for a shape of {extent:.2g}: move it to the origin before it is exported"
        )


def check_degrees(points: FloatArray, name: str) -> None:
    """Raise InputError where x and y of points (n, 3) are longitude and latitude in degrees.

    Then they are within a shape's size only if a degree is 111 km, and far from 0 for their extent.
    """
    if not len(points):
        return
    wide, deep, high = np.ptp(points, axis=0).tolist()
    plane = np.abs(points[:, :2]).max(axis=0)
    across = max(wide, deep)
    if not 0.0 < min(wide, deep) <= across or across * MOST_SLENDER > high:
        return
    if plane.max() > LONGITUDE or plane.min() > LATITUDE or plane.max() < MOST_SLENDER * across:
        return
    if high / MOST_SLENDER <= METRES_PER_DEGREE * across <= MOST_SLENDER * high:
        raise InputError(
            f"{name}: x and y are degrees, it seems ({wide:.2g} by {deep:.2g} at a height of "
            f"{high:.2g}): project them to metres, as UTM"
        )
