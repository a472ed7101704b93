"""Visibility in and round an object: free rays through a grid of cubes in 26 directions."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray

# Cubes along the object's diagonal: a board of 2 % of it is two cubes thick.
CUBES = 96
# Directions flatter than this against the surface run into its own cubes: sine of 17°.
LEAST_RISE = 0.3


def _directions() -> Iterator[tuple[int, int, int]]:
    for x in (-1, 0, 1):
        for y in (-1, 0, 1):
            for z in (-1, 0, 1):
                if x or y or z:
                    yield x, y, z


@dataclass(frozen=True, eq=False, slots=True)
class FreeWays:
    """Whether a cube with surface lies in each direction (26, ...) from each cube (nx, ny, nz).

    `low` (3,) is the lowest corner of the grid, `cube` the side of its cubes.
    """

    blocked: NDArray[np.bool_]
    low: FloatArray
    cube: float

    @classmethod
    def of(cls, points: FloatArray, cube: float, *, margin: float = 0.0) -> "FreeWays":
        """Return the free ways round the cubes that have a point (n, 3), and `margin` cubes
        beyond.
        """
        low = np.array([column.min() for column in points.T])
        high = np.array([column.max() for column in points.T])
        layers = int(np.ceil(margin)) + 1  # one is empty all round
        start = low - layers * cube
        shape = np.ceil((high - low) / cube).astype(int) + 2 * layers + 1
        full = np.zeros(shape, dtype=bool)
        full[tuple(((points - start) / cube).astype(int).T)] = True
        return cls(np.array([_blocked(full, way) for way in _directions()]), start, cube)

    def share(self, places: FloatArray, ahead: FloatArray) -> FloatArray:
        """Return share (n,) of the directions before `ahead` (n, 3) that are free from places (n,
        3).
        """
        ways = np.array(list(_directions()), dtype=np.float64)
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        rise = np.maximum(ahead @ ways.T, 0.0)
        rise[rise < LEAST_RISE] = 0.0
        share: FloatArray = (rise * self._free(places)).sum(axis=1) / rise.sum(axis=1)
        return share

    def open_share(self, places: FloatArray) -> FloatArray:
        """Return share (n,) of all 26 directions that are free from places (n, 3)."""
        share: FloatArray = self._free(places).mean(axis=1)
        return share

    def _free(self, places: FloatArray) -> NDArray[np.bool_]:
        """Return whether each direction (n, 26) is free from the cubes of places (n, 3)."""
        index = np.floor((places - self.low) / self.cube).astype(int)
        index = np.clip(index, 0, np.array(self.blocked.shape[1:]) - 1)
        return ~self.blocked[:, *index.T].T


def _blocked(full: NDArray[np.bool_], direction: tuple[int, int, int]) -> NDArray[np.bool_]:
    """Return cubes from which a full one lies somewhere in a direction: b(v) = full(v + d) or b(v +
    d).
    """
    axis = next(k for k in range(3) if direction[k])
    ahead = np.moveaxis(full, axis, 0)
    blocked = np.zeros(ahead.shape, dtype=bool)
    across = [d for k, d in enumerate(direction) if k != axis]
    to = tuple(
        slice(max(-d, 0), n - max(d, 0)) for d, n in zip(across, ahead.shape[1:], strict=True)
    )
    of = tuple(
        slice(max(d, 0), n - max(-d, 0)) for d, n in zip(across, ahead.shape[1:], strict=True)
    )
    step = direction[axis]
    count = len(ahead)
    for nth in range(count - 2, -1, -1) if step > 0 else range(1, count):
        beyond = ahead[nth + step] | blocked[nth + step]
        blocked[nth][to] = beyond[of]
    return np.moveaxis(blocked, 0, axis)
