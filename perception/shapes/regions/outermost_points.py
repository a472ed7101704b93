"""The extreme points of a surface in every direction."""

import numpy as np

from facetlog.perception.types import FloatArray

__all__ = ["outermost"]

# Directions evenly over the sphere: the farthest point to any side is missed by less than .5 % of
# the surface's size (the nearest direction is within 6°).
DIRECTIONS = 256


def _directions() -> FloatArray:
    """Unit vectors (n, 3) along a spiral of golden angles."""
    step = np.arange(DIRECTIONS) + 0.5
    height = 1.0 - 2.0 * step / DIRECTIONS
    angle = np.pi * (3.0 - np.sqrt(5.0)) * step
    radius = np.sqrt(1.0 - height**2)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


def outermost(points: FloatArray, *exactly: FloatArray) -> list[int]:
    """Rows of the points (n, 3) that lie farthest out, in many directions and the given ones (3,).

    >>> outermost(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.2, 0.2, 0.2]]))
    [0, 1, 2, 3]
    """
    both = [side for d in exactly for side in (d, -d)]
    sides = np.concatenate([_directions(), *(side[None] for side in both)])
    found: list[int] = np.unique((points @ sides.T).argmax(axis=0)).tolist()
    return found
