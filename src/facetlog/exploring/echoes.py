"""What sonars met: cells in which beams ended, in clusters that are to be looked at.

What stands on legs is met by its legs alone: what is near to one another is one. A cluster is a
place to look at, no thing yet: pictures say what stands there.
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
    """A cluster: the middle (2,) of its `cells` (n, 2), and how far it reaches from there, m."""

    middle: FloatArray
    reach: float
    cells: NDArray[np.intp]


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
        cells = np.argwhere(own)
        places = lattice.middles[cells[:, 0], cells[:, 1]]
        middle = (places.min(axis=0) + places.max(axis=0)) / 2
        reach = float(np.linalg.norm(places - middle, axis=1).max()) + lattice.side / 2
        yield Echo(middle, reach, cells)


def within(cells: NDArray[np.bool_], distance: float, side: float) -> NDArray[np.bool_]:
    """The cells (rows, columns) whose middles are within a distance (m) of one of those given."""
    if not cells.any():
        return np.zeros(cells.shape, np.bool_)
    away = cv2.distanceTransform((~cells).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(away * side <= distance)
