"""A face that was selected among candidates."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.flat_faces import make_ring_sides
from facetlog.perception.types import FloatArray

# A face has a neighbour at each side that is this share of its ring's length: curves have none.
LONG_SIDE = 0.08


@dataclass(frozen=True, eq=False, slots=True)
class SelectedFace:
    """An outline judged a face, its corners counter-clockwise seen from the side that views see.

    `shown` (V,) says which views show it; `support` is the share of its sides on edges in those,
    `seen` (n, 3) are points of its inside, none in its `holes` (k, 3), which run clockwise.
    `plane_cov` is the covariance of its plane's heights at its corners, then at those of the holes,
    where it has one of its own. Where it has no edges its outline is only its known extent.
    """

    corners: FloatArray
    normal: FloatArray
    shown: NDArray[np.bool_]
    support: float
    seen: FloatArray
    plane_cov: FloatArray | None = None
    holes: tuple[FloatArray, ...] = ()
    has_edges: bool = True

    @property
    def long_sides(self) -> FloatArray:
        """The sides (n, 2, 3) of its outline and its holes at which it may have a neighbour."""
        long = []
        for ring in (self.corners, *self.holes):
            sides = make_ring_sides(ring)
            length = np.linalg.norm(sides[:, 1] - sides[:, 0], axis=1)
            long.append(sides[length >= LONG_SIDE * length.sum()])
        return np.concatenate(long)
