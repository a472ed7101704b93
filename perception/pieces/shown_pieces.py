"""The pieces of a scene as one looks at them: by name, kind and colour, in what nobody saw."""

from dataclasses import dataclass
from itertools import product

import numpy as np

from facetlog.perception.pieces.pieces import Kind, Piece
from facetlog.perception.space.space import Space
from facetlog.perception.types import FloatArray

COLOURS = {Kind.BOARD: (214, 147, 66), Kind.BAR: (64, 130, 201), Kind.BLOCK: (105, 165, 88)}
"""Red, green, blue of each kind; distinguished by people who do not see red or green, too."""


@dataclass(frozen=True, eq=False, slots=True)
class ShownPiece:
    """A piece, its name in facts (p1, p2, …), and whether all its faces are `implied`."""

    name: str
    piece: Piece
    implied: bool

    @property
    def label(self) -> str:
        """Name and kind: "p1 board"."""
        return f"{self.name} {self.piece.kind}"


@dataclass(frozen=True, eq=False, slots=True)
class ShownPieces:
    """All pieces of a scene, and the spaces of its things, of which some may be unseen.

    `things` are the names of these things in facts (t1, t2, …).
    """

    pieces: tuple[ShownPiece, ...]
    spaces: tuple[Space, ...]
    things: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.pieces)


# Corners of a box by the sides along each axis, and its six sides, counter-clockwise from outside.
_CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))
SIDES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
"""The sides of a box as indices of its corners, as `compute_box_corners` gives them."""


def compute_box_corners(piece: Piece) -> FloatArray:
    """Return the corners (8, 3) of a piece's box, in the scene's frame."""
    sizes = np.array([piece.length.value, piece.width.value, piece.thickness.value])
    corners: FloatArray = piece.middle + (_CORNERS * sizes) @ piece.axes
    return corners
