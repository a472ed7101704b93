"""Pieces as exact as a body's surface: from the solids that its closed surface was cut into."""

import numpy as np

from facetlog.perception.flat_faces import Estimate
from facetlog.perception.pieces.shown_pieces import Piece, Pieces
from facetlog.perception.scene import SolidPiece, Solids
from facetlog.perception.types import FloatArray


def measure_solids(solids: Solids, up: FloatArray, sd: float, reach: float) -> Pieces:
    """Return the pieces of a body.

    Heights are along `up` (3,), and corners are known to `sd`, per axis. What ends within `reach`
    of the lowest place is on the ground, and within as much of another reaches as low as that.
    """
    pieces = tuple(_measure(each, up, sd) for each in solids.pieces)
    joins = np.zeros((len(pieces), len(pieces)), dtype=np.bool_)
    if solids.joins:
        one, other = np.array(solids.joins, dtype=np.intp).T
        joins[one, other] = joins[other, one] = True
    low = np.array([piece.low for piece in pieces])
    off_ground = low >= low.min(initial=np.inf) + reach
    bears = joins & (low[:, None] <= low[None] + reach) & off_ground
    return Pieces(pieces, joins, bears, solids.explained, solids.gaps)


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
