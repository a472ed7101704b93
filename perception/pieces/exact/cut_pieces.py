"""The solid pieces of a closed triangle mesh: the convex parts that it is made of, and how they
meet.

A piece is bounded by the mesh's own faces, not by cells of a grid, so its extents are exact.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class CutPiece:
    """One solid part: the least box round it, and how round it is.

    `hull` (n, 3) are the vertices of its convex hull in the mesh's coordinates; `axes` (3, 3) unit
    rows, right-handed, along its `extents` (3,), the longest first, about its `middle` (3,).
    `round` is how round its section across its axis is, 1 for a circle, 0 for a box.
    """

    hull: FloatArray
    axes: FloatArray
    middle: FloatArray
    extents: FloatArray
    round: float
    volume: float

    def __post_init__(self) -> None:
        right_handed = np.where(np.linalg.det(self.axes) < 0.0, [[1.0], [1.0], [-1.0]], 1.0)
        object.__setattr__(self, "axes", self.axes * right_handed)
        for name in ("hull", "axes", "middle", "extents"):
            object.__setattr__(self, name, _freeze(np.asarray(getattr(self, name), np.float64)))


@dataclass(frozen=True, slots=True, eq=False)
class CutPieces:
    """The pieces, the largest first; false, with the reason, where a mesh has none to be found.

    `contacts` are pairs of pieces that touch, the lower number first. `explained` is the share of
    the enclosed volume that pieces fill; `unexplained` (m, 2, 3) are boxes, low and high corner,
    round what no piece fills, and `left` (m,) how much that is: nothing where the surface is open.
    """

    pieces: tuple[CutPiece, ...] = ()
    contacts: tuple[tuple[int, int], ...] = ()
    explained: float = 0.0
    unexplained: FloatArray = field(default_factory=lambda: np.zeros((0, 2, 3)))
    left: FloatArray = field(default_factory=lambda: np.zeros(0))
    reason: str = ""

    def __post_init__(self) -> None:
        boxes = np.asarray(self.unexplained, np.float64).reshape(-1, 2, 3)
        object.__setattr__(self, "unexplained", _freeze(boxes))

    def __bool__(self) -> bool:
        """Return whether pieces were found."""
        return bool(self.pieces)


def _freeze(array: NDArray[Any]) -> NDArray[Any]:
    frozen = array.copy()
    frozen.setflags(write=False)
    return frozen
