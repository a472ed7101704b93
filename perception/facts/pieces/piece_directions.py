"""Which way pieces lie, and how each two of them are turned to one another."""

from collections.abc import Iterator, Sequence
from itertools import permutations

import numpy as np

from facetlog.perception.flat_faces import Estimate
from facetlog.perception.pieces.shown_pieces import Kind, Piece
from facetlog.perception.space.grid import ROUNDING
from facetlog.perception.types import FloatArray


def find_broad_axis(piece: Piece, up: FloatArray) -> int:
    """Return the axis that is square to its broad side: of those along which it is as thin within a
    cell, as all are of a cube, the most upright one.
    """
    cell = piece.thickness.sd / ROUNDING
    extents = (piece.length.value, piece.width.value, piece.thickness.value)
    thin = [i for i, extent in enumerate(extents) if extent <= piece.thickness.value + cell]
    return max(thin, key=lambda i: abs(float(piece.axes[i] @ up)))


def measure_tilt(piece: Piece, up: FloatArray) -> Estimate:
    """Return the tilt of a piece's direction or broad side, degrees from level."""
    rise = min(1.0, abs(float(_direction(piece, up) @ up)))
    angle = np.arcsin(rise) if piece.kind is Kind.BAR else np.arccos(rise)
    return Estimate(float(np.rad2deg(angle)), float(np.rad2deg(_sd(piece))))


def measure_side_tilt(piece: Piece, up: FloatArray) -> Estimate:
    """Return the tilt of the most level side of a piece's least box, degrees from level."""
    rise = min(1.0, float(np.abs(piece.axes @ up).max()))
    return Estimate(float(np.rad2deg(np.arccos(rise))), float(np.rad2deg(_sd(piece))))


def iter_angles(
    pieces: Sequence[Piece], up: FloatArray | None
) -> Iterator[tuple[int, int, Estimate]]:
    """Yield the angle between each two, by their indices, in degrees: 0 along each other, 90
    square.
    """
    directions = [_direction(piece, up) for piece in pieces]
    for i, j in permutations(range(len(pieces)), 2):
        along = min(1.0, abs(float(directions[i] @ directions[j])))
        # what is slender lies along a broad side where it is square to its normal
        alike = (pieces[i].kind is Kind.BAR) == (pieces[j].kind is Kind.BAR)
        angle = np.arccos(along) if alike else np.arcsin(along)
        sd = float(np.hypot(_sd(pieces[i]), _sd(pieces[j])))
        yield i, j, Estimate(float(np.rad2deg(angle)), float(np.rad2deg(sd)))


def _direction(piece: Piece, up: FloatArray | None) -> FloatArray:
    """Return unit vector (3,) along its length if it is slender, else square to its broad side."""
    square = 2 if up is None else find_broad_axis(piece, up)
    direction: FloatArray = piece.axes[0 if piece.kind is Kind.BAR else square]
    return direction


def _sd(piece: Piece) -> float:
    """Return the sd of a piece's direction, radians: its ends are each known to a cell."""
    across = piece.length if piece.kind is Kind.BAR else piece.width
    if not across.value > 0.0:
        return float(np.pi) / 2.0
    return float(np.arctan2(np.sqrt(2.0) * across.sd, across.value))
