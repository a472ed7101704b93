"""Choices among numbers, the same where some are equal but for rounding.

Cameras in a ring stand in equal distances, under equal angles and with equal weights, and each of
these numbers is right to its last digits only: a plain argmax or argsort would choose by the
rounding of one processor's arithmetic. Here numbers within TIE of each other are equal, further
keys decide between them, and in the end the place in the order given.
"""

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray

# Equal: numbers that differ by at most this share of the largest magnitude among them. Rounding
# makes 1e-16 to 1e-13 of angles and distances; what is measured differs by 1e-6 or more.
TIE = 1e-9


def ranks(values: FloatArray) -> NDArray[np.intp]:
    """Return the rank (n,) of each of finite values (n,), from 0 for the smallest; equal ones share
    it.

    >>> ranks(np.array([0.3, 0.1 + 0.2, 0.1])).tolist()
    [1, 1, 0]
    """
    rank = np.zeros(len(values), dtype=np.intp)
    order = np.argsort(values, kind="stable")
    apart = np.diff(values[order]) > TIE * np.abs(values).max(initial=0.0)
    rank[order[1:]] = np.cumsum(apart)
    return rank


def ascending(*keys: FloatArray) -> NDArray[np.intp]:
    """Return the order (n,) of things from small to large by the first key (n,), among equals by
    the next.

    >>> ascending(np.array([0.3, 0.1 + 0.2, 0.1]), np.array([2.0, 1.0, 0.0])).tolist()
    [2, 1, 0]
    """
    return np.lexsort([ranks(key) for key in reversed(keys)])


def descending(*keys: FloatArray) -> NDArray[np.intp]:
    """Return the order (n,) of things from large to small by the first key (n,), among equals by
    the next.
    """
    return ascending(*(-key for key in keys))


def largest(*keys: FloatArray) -> int:
    """Return the place of the largest of the first key (n,), among equals by the next key, then the
    first.

    >>> largest(np.array([0.3, 0.1 + 0.2, 0.1]))
    0
    """
    if len(keys) > 1:
        return int(descending(*keys)[0])
    # Needs no order: this is asked thousands of times.
    (values,) = keys
    return int((values >= values.max() - TIE * np.abs(values).max()).argmax())


def at_least(values: FloatArray, limit: float | FloatArray) -> NDArray[np.bool_]:
    """Return whether values (...) reach a limit, one for all or one each, be it but for rounding.

    >>> at_least(np.array([3 * (0.1 + 0.2), 0.8]), 0.9 + 1e-15).tolist()
    [True, False]
    """
    reach: NDArray[np.bool_] = values >= limit - TIE * np.abs(limit)
    return reach


def choose_farthest_points(apart: FloatArray, count: int) -> list[int]:
    """Return at most `count` of n things, each next one the farthest from all chosen (Gonzalez
    1985).

    `apart` (n, n) are distances. The first is the one farthest from all in sum; of equally far
    ones the next is that whose second nearest of the chosen is farthest, then the third, so that
    a ring is divided evenly. Fewer where none is left that differs from those chosen.

    >>> ring = np.arange(6)
    >>> steps = np.abs(ring[:, None] - ring)
    >>> choose_farthest_points(np.minimum(steps, 6 - steps).astype(float), 3)
    [0, 3, 1]
    """
    chosen = [largest(apart.sum(axis=1))] if len(apart) else []
    least = TIE * apart.max(initial=0.0)
    while len(chosen) < min(count, len(apart)):
        near = np.sort(apart[:, chosen], axis=1)
        best = largest(*near.T)
        if near[best, 0] <= least:
            break
        chosen.append(best)
    return chosen
