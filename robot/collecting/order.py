"""A short order of the tour's views: nearest first, then untangled.

The order of a tour is free, and its own may cross the floor many times. Nearest neighbour and
2-opt (Croes 1958) come within some percent of the shortest for a few dozen stops.
"""

from collections.abc import Sequence

import numpy as np

from facetlog.perception.types import FloatArray
from facetlog.robot.collecting.route import Circle, Point, route_length, shortest_route

__all__ = ["short_order"]

# Metres that stand for "no route": more than any tour has, and finite, since two of them are
# subtracted. The plan leaves such places out.
NO_ROUTE = 1e6


def short_order(
    start: Point, places: Sequence[Point], circles: tuple[Circle, ...] = ()
) -> tuple[int, ...]:
    """Indices of all places in an order with a short route from `start` round the circles.

    >>> short_order((0.0, 0.0), [(3.0, 0.0), (1.0, 0.0), (2.0, 0.0)])
    (1, 2, 0)
    """
    lengths = _lengths([start, *places], circles)
    order, left = [0], set(range(1, len(places) + 1))
    while left:
        order.append(min(left, key=lambda i: (lengths[order[-1], i], i)))
        left.remove(order[-1])
    return tuple(i - 1 for i in _untangled(order, lengths)[1:])


def _lengths(places: Sequence[Point], circles: tuple[Circle, ...]) -> FloatArray:
    lengths = np.zeros((len(places), len(places)))
    for i, a in enumerate(places):
        for j in range(i):
            route = shortest_route(a, places[j], circles)
            lengths[i, j] = lengths[j, i] = NO_ROUTE if route is None else route_length(route)
    return lengths


def _untangled(order: list[int], lengths: FloatArray) -> list[int]:
    """The order with pieces reversed as long as that shortens it (2-opt); its first place stays."""
    shorter = True
    while shorter:
        shorter = False
        for i in range(1, len(order) - 1):
            for j in range(i + 1, len(order)):
                before, after = order[i - 1], order[j + 1] if j + 1 < len(order) else None
                gain = lengths[before, order[i]] - lengths[before, order[j]]
                if after is not None:
                    gain += lengths[order[j], after] - lengths[order[i], after]
                # Rounding differences between two equal orders must not reverse them for ever.
                if gain > 1e-9:
                    order[i : j + 1] = reversed(order[i : j + 1])
                    shorter = True
    return order
