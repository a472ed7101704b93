"""Pieces as exact as a body's surface: from the solids that its closed surface was cut into."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.flat_faces import Estimate
from facetlog.perception.pieces.shown_pieces import Piece, Pieces
from facetlog.perception.scene import SolidPiece, Solids
from facetlog.perception.types import FloatArray


def measure_solids(solids: Solids, up: FloatArray, sd: float, reach: float) -> Pieces:
    """Return the pieces of a body.

    Heights are along `up` (3,), and corners are known to `sd`, per axis. What ends within `reach`
    of the lowest place is on the ground, and within as much of another reaches as low as that.
    What would float touches the pieces from which no wider gap parts it.
    """
    pieces = tuple(_measure(each, up, sd) for each in solids.pieces)
    joins = np.zeros((len(pieces), len(pieces)), dtype=np.bool_)
    if solids.joins:
        one, other = np.array(solids.joins, dtype=np.intp).T
        joins[one, other] = joins[other, one] = True
    low = np.array([piece.low for piece in pieces])
    _close_gaps(solids.pieces, joins, low <= low.min(initial=np.inf) + reach, reach)
    off_ground = low >= low.min(initial=np.inf) + reach
    bears = joins & (low[:, None] <= low[None] + reach) & off_ground
    return Pieces(pieces, joins, bears, solids.explained, solids.gaps)


def _close_gaps(
    pieces: Sequence[SolidPiece], joins: NDArray[np.bool_], held: NDArray[np.bool_], reach: float
) -> None:
    """Join (p, p) pieces that nothing joins to those that are `held` (p,) to the nearest of them,
    as long as there are any within `reach`.
    """
    while True:
        while (wider := held | joins[:, held].any(axis=1)).sum() > held.sum():
            held = wider
        pairs = np.argwhere(~held[:, None] & held)
        near = [pair for pair in pairs.tolist() if _gap(*(pieces[i] for i in pair)) <= reach]
        if not near:
            return
        one, other = np.array(near).T
        joins[one, other] = joins[other, one] = True


def _gap(one: SolidPiece, other: SolidPiece) -> float:
    """Return how far apart two pieces are, at least: along the axes of either."""
    axes = np.concatenate([one.axes, other.axes])
    a, b = one.corners @ axes.T, other.corners @ axes.T
    return float(np.maximum(a.min(axis=0) - b.max(axis=0), b.min(axis=0) - a.max(axis=0)).max())


def _measure(solid: SolidPiece, up: FloatArray, sd: float) -> Piece:
    local, heights = solid.corners @ solid.axes.T, solid.corners @ up
    length, width, thickness = (Estimate(float(e), sd) for e in np.ptp(local, axis=0))
    middle = (local.min(axis=0) + local.max(axis=0)) / 2.0 @ solid.axes
    return Piece(
        length,
        width,
        thickness,
        solid.axes,
        middle,
        float(heights.min()),
        float(heights.max()),
        solid.faces,
        solid.round,
    )
