"""Whether coordinates resolve their shape: far from the origin floating-point is coarse."""

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.types import FloatArray

__all__ = ["check_resolution"]

# Numbers farther apart than this share of the extent leave ten places for a corner along it.
COARSEST = 0.1


def check_resolution(points: FloatArray, name: str) -> None:
    """Raises InputError where neighbouring numbers are too far apart for points (n, 3), all finite.

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
