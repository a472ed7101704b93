"""Sums over numbered groups, groups that pairs make, and indices group by group."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from facetlog.perception.types import FloatArray

__all__ = ["Indices", "by_group", "group_sums", "joined"]

Indices = NDArray[np.int64]


def group_sums(groups: Indices, values: ArrayLike, count: int) -> FloatArray:
    """Sums (count,) or (count, k) of values (n,) or (n, k), by the group (n,) of each.

    >>> group_sums(np.array([0, 2, 0]), [1.0, 2.0, 3.0], 3)
    array([4., 0., 2.])
    """
    what = np.asarray(values, dtype=np.float64)
    if what.ndim == 1:
        return np.bincount(groups, what, minlength=count).astype(np.float64)
    columns = [np.bincount(groups, column, minlength=count) for column in what.T]
    return np.column_stack(columns).astype(np.float64)


def by_group(groups: Indices) -> Iterator[Indices]:
    """The indices of each group that has any, by the groups' numbers.

    >>> [own.tolist() for own in by_group(np.array([5, 0, 5]))]
    [[1], [0, 2]]
    """
    order = np.argsort(groups, kind="stable").astype(np.int64)
    if len(order):
        yield from np.split(order, np.flatnonzero(np.diff(groups[order])) + 1)


def joined(count: int, pairs: ArrayLike) -> tuple[int, Indices]:
    """How many groups `count` nodes make that are joined by pairs (k, 2), and each node's.

    >>> joined(4, [(3, 1)])
    (3, array([0, 1, 2, 1]))
    """
    ends = np.asarray(pairs, dtype=np.int64).reshape(-1, 2)
    if not count:
        return 0, np.zeros(0, dtype=np.int64)
    graph = coo_array((np.ones(len(ends), np.int8), (ends[:, 0], ends[:, 1])), shape=(count, count))
    groups, labels = connected_components(graph, directed=False)
    return int(groups), labels.astype(np.int64)
