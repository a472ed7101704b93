"""Pieces: their records, and those of a scene as one looks at them, by name, kind and colour."""

from dataclasses import dataclass
from enum import StrEnum
from itertools import product

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.flat_faces import Estimate
from facetlog.perception.space.space import Space
from facetlog.perception.types import FloatArray

# A board is no thicker than this share of its width, a bar no wider than this share of its length.
THIN, SLENDER = 0.35, 0.35


class Kind(StrEnum):
    """Words for a piece by its proportions: the words of models, which are soft there."""

    BOARD = "board"
    BAR = "bar"
    BLOCK = "block"


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """A solid part. `axes` (3, 3) are the directions of its length, width and thickness, as rows,
    `middle` (3,) is the middle of its box, all in the scene's frame.

    `faces` are indices of faces that are mostly its own; `round` is the share of its section's
    outline that is curved, 0..1, or of its surface where no more is known. `low` and `high` are
    heights along the grid's last axis, of the scene's frame.
    """

    length: Estimate
    width: Estimate
    thickness: Estimate
    axes: FloatArray
    middle: FloatArray
    low: float
    high: float
    faces: tuple[int, ...]
    round: float

    @property
    def kind(self) -> Kind:
        """The word for it by its proportions."""
        return choose_kind(self.length.value, self.width.value, self.thickness.value)


def choose_kind(length: float, width: float, thickness: float) -> Kind:
    """Return the word for a piece of these extents."""
    if thickness <= THIN * width:
        return Kind.BOARD
    return Kind.BAR if width <= SLENDER * length else Kind.BLOCK


@dataclass(frozen=True, eq=False, slots=True)
class Pieces:
    """The pieces of a thing, the largest first. `joins` (p, p) says which touch, `bears` (p, p)
    which carries which directly: it touches what is off the ground and reaches as low, within a
    cell, or lower. `explained` is the share of the thing's volume that they fill, 0..1; `gaps` are
    boxes round what none fills, as a body's `Solids` have them.
    """

    pieces: tuple[Piece, ...]
    joins: NDArray[np.bool_]
    bears: NDArray[np.bool_]
    explained: float
    gaps: tuple[tuple[float, ...], ...] = ()

    @property
    def carries(self) -> NDArray[np.bool_]:
        """Which carries which (p, p), directly or through others."""
        carried = self.bears.copy()
        for middle in range(len(self.pieces)):
            carried |= carried[:, middle : middle + 1] & carried[middle]
        np.fill_diagonal(carried, val=False)
        return carried


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
