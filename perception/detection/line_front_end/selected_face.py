"""A face that was selected among candidates."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray

__all__ = ["SelectedFace"]


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
