"""The extreme points of a surface in every direction."""

import numpy as np

from facetlog.perception.types import FloatArray

__all__ = ["outermost"]

# Directions evenly over the sphere: the farthest point to any side is missed by less than .5 % of
# the surface's size (the nearest direction is within 6°).
DIRECTIONS = 256
# Products of points and directions that are held at a time: 2 MB. All of a depth camera's frame at
# once are 600 MB, and most of the time is the system's, which clears them.
BLOCK = 1 << 18


def _directions() -> FloatArray:
    """Unit vectors (n, 3) along a spiral of golden angles."""
    step = np.arange(DIRECTIONS) + 0.5
    height = 1.0 - 2.0 * step / DIRECTIONS
    angle = np.pi * (3.0 - np.sqrt(5.0)) * step
    radius = np.sqrt(1.0 - height**2)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


def outermost(points: FloatArray, *exactly: FloatArray) -> list[int]:
    """Return the rows of the points (n, 3) that lie farthest out, in many directions evenly over
    the sphere and along each given vector (3,), both ways.

    >>> outermost(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.2, 0.2, 0.2]]))
    [0, 1, 2, 3]
    """
    both = [side for d in exactly for side in (d, -d)]
    sides = np.concatenate([_directions(), *(side[None] for side in both)])
    at_once = max(1, BLOCK // len(points))
    blocks = (sides[k : k + at_once] for k in range(0, len(sides), at_once))
    found: list[int] = np.unique(
        np.concatenate([(points @ block.T).argmax(axis=0) for block in blocks])
    ).tolist()
    return found
