"""Ragged arrays (rows of different lengths, end to end in one array) and numbered groups."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from facetlog.perception.types import FloatArray

__all__ = [
    "Bools",
    "Indices",
    "find_entries_of_rows",
    "find_pairs_in_rows",
    "find_row_starts",
    "iter_groups",
    "joined",
    "row_table",
    "stacked",
    "sum_by_group",
    "sum_padded_rows",
    "sum_rows",
]

Indices = NDArray[np.intp]
Bools = NDArray[np.bool_]


def find_row_starts(lengths: Indices) -> Indices:
    """Return where each row begins (r,).

    >>> find_row_starts(np.array([3, 2])).tolist()
    [0, 3]
    """
    return np.cumsum(lengths) - lengths


def row_table(lengths: Indices) -> tuple[Indices, Bools]:
    """Return places (r, k) of the rows' entries, k the longest, and which of them are there (r, k).

    A row that is shorter repeats its last entry.

    >>> places, there = row_table(np.array([3, 2]))
    >>> places.tolist(), there[1].tolist()
    ([[0, 1, 2], [3, 4, 4]], [True, True, False])
    """
    steps = np.arange(int(lengths.max(initial=0)))
    there = steps < lengths[:, None]
    last = np.maximum(lengths - 1, 0)
    return find_row_starts(lengths)[:, None] + np.minimum(steps, last[:, None]), there


def sum_rows(values: FloatArray, lengths: Indices) -> FloatArray:
    """Return sums (r, ...) of the rows' entries (n, ...); every row has one at least."""
    if not len(lengths):
        return np.zeros((0, *values.shape[1:]))
    sums: FloatArray = np.add.reduceat(values, find_row_starts(lengths), axis=0)
    return sums


def find_entries_of_rows(lengths: Indices, chosen: Indices) -> Indices:
    """Return places of all entries of some rows, row by row.

    >>> find_entries_of_rows(np.array([3, 2, 1]), np.array([2, 0])).tolist()
    [5, 0, 1, 2]
    """
    counts = lengths[chosen]
    first = find_row_starts(lengths)[chosen] - find_row_starts(counts)
    return np.arange(int(counts.sum())) + np.repeat(first, counts)


def sum_padded_rows(table: FloatArray) -> FloatArray:
    """Return sums (r,) of rows (r, k) that end in zeros: the same to the last bit, however many.

    >>> sum_padded_rows(np.array([[1.0, 2.0, 0.0]]))
    array([3.])
    """
    if not table.shape[1]:
        return np.zeros(len(table))
    return np.asarray(table.cumsum(axis=1)[:, -1], dtype=np.float64)


def find_pairs_in_rows(firsts: Indices, seconds: Indices) -> tuple[Indices, Indices]:
    """Return places (p,) of every pair of an entry of one kind with one of another in the same row.

    The rows have `firsts` (r,) and `seconds` (r,) entries.

    >>> [each.tolist() for each in find_pairs_in_rows(np.array([2, 1]), np.array([1, 2]))]
    [[0, 1, 2, 2], [0, 0, 1, 2]]
    """
    counts = np.repeat(seconds, firsts)
    begins = np.repeat(find_row_starts(seconds), firsts)
    one = np.repeat(np.arange(len(counts)), counts)
    return one, np.arange(len(one)) - np.repeat(find_row_starts(counts) - begins, counts)


def stacked(arrays: Sequence[FloatArray], *shape: int) -> FloatArray:
    """Return arrays of one shape as rows (n, ...)."""
    if not arrays:
        return np.zeros((0, *shape))
    return np.concatenate(arrays).reshape(-1, *shape)


def sum_by_group(groups: Indices, values: ArrayLike, count: int) -> FloatArray:
    """Return sums (count,) or (count, k) of values (n,) or (n, k), by the group (n,) of each.

    >>> sum_by_group(np.array([0, 2, 0]), [1.0, 2.0, 3.0], 3)
    array([4., 0., 2.])
    """
    what = np.asarray(values, dtype=np.float64)
    if what.ndim == 1:
        return np.bincount(groups, what, minlength=count).astype(np.float64)
    columns = [np.bincount(groups, column, minlength=count) for column in what.T]
    return np.column_stack(columns).astype(np.float64)


def iter_groups(groups: Indices) -> Iterator[Indices]:
    """Return the indices of each group that has any, by the groups' numbers.

    >>> [own.tolist() for own in iter_groups(np.array([5, 0, 5]))]
    [[1], [0, 2]]
    """
    order = np.argsort(groups, kind="stable").astype(np.int64)
    if len(order):
        yield from np.split(order, np.flatnonzero(np.diff(groups[order])) + 1)


def joined(count: int, pairs: ArrayLike) -> tuple[int, Indices]:
    """Return how many groups `count` nodes make that are joined by pairs (k, 2), and each node's.

    >>> joined(4, [(3, 1)])
    (3, array([0, 1, 2, 1]))
    """
    ends = np.asarray(pairs, dtype=np.int64).reshape(-1, 2)
    if not count:
        return 0, np.zeros(0, dtype=np.int64)
    # Loaded here: a worker that judges scenes alone needs no scipy.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(ends), np.int8), (ends[:, 0], ends[:, 1])), shape=(count, count))
    groups, labels = connected_components(graph, directed=False)
    return int(groups), labels.astype(np.int64)
