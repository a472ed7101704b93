"""What sonars met: cells in which beams ended, in clusters that are to be looked at.

What stands on legs is met by its legs alone: what is near to one another is one. A cluster is a
place to look at, no thing yet: pictures say what stands there. What stands at a wall, or in a row,
is one with it: where that is too large to be looked at from round it, its halves are.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.exploring.floor_ways import Lattice
from facetlog.perception.types import FloatArray

__all__ = ["Echo", "clusters", "within"]

# Echoes by which a cluster counts: a single one is a beam that came back by way of something else.
FEWEST_ECHOES = 5.0


@dataclass(frozen=True, eq=False, slots=True)
class Echo:
    """A cluster of cells of a `side` (m), whose middles are `places` (n, 2)."""

    places: FloatArray
    side: float

    @property
    def middle(self) -> FloatArray:
        """The middle (2,) of their extents."""
        return np.asarray((self.places.min(axis=0) + self.places.max(axis=0)) / 2)

    @property
    def reach(self) -> float:
        """How far they reach from there, m."""
        return float(np.linalg.norm(self.places - self.middle, axis=1).max()) + self.side / 2

    @property
    def nearest(self) -> FloatArray:
        """The place (2,) that is nearest to the middle: of what stands about that nothing may."""
        away = np.linalg.norm(self.places - self.middle, axis=1)
        return np.asarray(self.places[int(away.argmin())])

    def halves(self) -> "tuple[Echo, Echo]":
        """Both parts of a cluster of two cells or more: cut across its longer extent, where the
        widest gap is, and of gaps as wide where the middle is nearest.
        """
        along = self.places[:, int(np.ptp(self.places, axis=0).argmax())]
        order = np.argsort(along, kind="stable")
        row = along[order]
        gaps = np.round(np.diff(row) / self.side)
        cuts = (row[1:] + row[:-1]) / 2
        off = np.abs(cuts - (row[0] + row[-1]) / 2)
        cut = 1 + int(np.lexsort((off, -gaps))[0])
        one, other = self.places[order[:cut]], self.places[order[cut:]]
        return Echo(one, self.side), Echo(other, self.side)


def clusters(
    echoed: NDArray[np.bool_], hits: NDArray[np.float32], lattice: Lattice, gap: float
) -> Iterator[Echo]:
    """Clusters of the cells (rows, columns) in which beams ended, `hits` times each; what is
    nearer to one another than a `gap` (m) is one.
    """
    joined = within(echoed, gap / 2, lattice.side).astype(np.uint8)
    count, labels = cv2.connectedComponents(joined, connectivity=8)
    for label in range(1, count):
        own = echoed & (labels == label)
        if float(hits[own].sum()) < FEWEST_ECHOES:
            continue
        yield Echo(lattice.middles[own], lattice.side)


def within(cells: NDArray[np.bool_], distance: float, side: float) -> NDArray[np.bool_]:
    """The cells (rows, columns) whose middles are within a distance (m) of one of those given."""
    if not cells.any():
        return np.zeros(cells.shape, np.bool_)
    away = cv2.distanceTransform((~cells).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(away * side <= distance)
