"""What lines do where they meet in a picture: the types of junctions, after Guzmán.

A. Guzmán, "Decomposition of a visual scene into three-dimensional bodies", 1968, sorts the vertices
of a line drawing by how many lines meet there and by the angles between them; D. A. Huffman and
M. B. Clowes (both 1971) label the lines of a drawing by these types (rules/line_labels.pl).
"""

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray

__all__ = ["Junction", "collinear", "junction_type", "rays_in_order"]

# Two lines are one straight line if their directions are opposite within so many deviations.
COLLINEAR_SDS = 3.0
# What rounding leaves of a direction, radians: lines without any error are no surer than this.
ROUNDING_SD = 1e-6


class Junction(StrEnum):
    """How lines meet at a vertex of a drawing."""

    END = "end"
    """One line, which ends alone: mostly at the picture's border."""
    STRAIGHT = "straight"
    """Two lines that go on along each other."""
    L = "l"
    """Two lines at an angle."""
    FORK = "fork"
    """Three lines, each two less than a straight angle apart; also called Y."""
    ARROW = "arrow"
    """Three lines within less than a straight angle; also called W."""
    T = "t"
    """Three lines, two of them along each other."""
    K = "k"
    """Four lines, two of them along each other and the others on one side of these."""
    X = "x"
    """Four lines, two of them along each other and the others on either side of these."""
    PEAK = "peak"
    """Four lines or more within less than a straight angle."""
    MULTI = "multi"
    """Any other way in which four lines or more meet."""


def collinear(angles: FloatArray, sds: FloatArray) -> NDArray[np.bool_]:
    """Which two of n directions (n,) of these deviations (n,), radians, are opposite: (n, n)."""
    # the remainder of a straight angle, in -pi .. pi
    off = (angles[:, None] - angles[None, :]) % (2 * np.pi) - np.pi
    variance = sds[:, None] ** 2 + sds[None, :] ** 2 + 2 * ROUNDING_SD**2
    return np.asarray(off**2 <= COLLINEAR_SDS**2 * variance, dtype=np.bool_)


def rays_in_order(angles: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
    """The directions (n,) as indices in ascending order, and the gap (n,) behind each, radians.

    The widest gap comes last: it is that from the last direction to the first. Of gaps that are
    equal but for rounding it is the first one from 0 on.

    >>> order, gaps = rays_in_order(np.deg2rad([10.0, 200.0, 100.0]))
    >>> order.tolist(), np.rad2deg(gaps).round().tolist()
    ([0, 2, 1], [90.0, 100.0, 170.0])
    """
    turned = angles % (2 * np.pi)
    order = np.argsort(turned, kind="stable")
    ascending = turned[order]
    gaps = np.append(ascending[1:], ascending[:1] + 2 * np.pi) - ascending
    widest = np.flatnonzero(gaps >= gaps.max(initial=0.0) - ROUNDING_SD)
    first = (int(widest[0]) + 1) % len(angles) if len(angles) else 0
    return np.roll(order, -first), np.roll(gaps, -first)


def junction_type(angles: FloatArray, sds: FloatArray) -> Junction:
    """The type of a junction from the directions (n,) of its lines and their deviations, radians.

    Directions point away from the vertex; it makes no difference which way they are counted, or
    from where. ValueError for no line at all.

    >>> junction_type(np.deg2rad([0.0, 90.0, 180.5]), np.deg2rad([0.5, 0.5, 0.5])).value
    't'
    >>> junction_type(np.deg2rad([0.0, 90.0, 180.5]), np.deg2rad([0.1, 0.1, 0.1])).value
    'fork'
    """
    count = len(angles)
    if not count:
        raise ValueError("a junction has at least one line")
    if count == 1:
        return Junction.END
    straight = collinear(angles, sds)
    if count == 2:
        return Junction.STRAIGHT if straight[0, 1] else Junction.L
    order, gaps = rays_in_order(angles)
    within = bool(gaps[-1] > np.pi)
    if count == 3:
        if straight.any():
            return Junction.T
        return Junction.ARROW if within else Junction.FORK
    if count == 4 and straight.any():
        # between which places of the order the straight line runs
        places = np.nonzero(straight[np.ix_(order, order)])
        across = any(abs(int(a - b)) == 2 for a, b in zip(*places, strict=True))
        return Junction.X if across else Junction.K
    return Junction.PEAK if within and not straight.any() else Junction.MULTI
