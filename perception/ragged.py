"""Ragged arrays (rows of different lengths, end to end in one array) and numbered groups."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from facetlog.perception.types import FloatArray

__all__ = [
    "Bools",
    "Indices",
    "find_distinct",
    "find_entries_of_rows",
    "find_row_starts",
    "iter_groups",
    "joined",
    "number_rows",
    "row_table",
    "stacked",
    "sum_by_group",
    "sum_padded_rows",
    "sum_rows",
    "unique_rows",
]

Indices = NDArray[np.intp]
Bools = NDArray[np.bool_]

MOST_NUMBERS = 2**62
"""Bound of the numbers that stand for rows."""


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


def number_rows(rows: NDArray[Any]) -> Indices:
    """Return a number (n,) for each row (n, k), equal for equal rows and in the rows' order.

    Sorting these takes a tenth of the time that `numpy.unique` takes for rows.

    >>> number_rows(np.array([[2, -1], [0, 7], [2, -1]])).tolist()
    [18, 8, 18]
    """
    numbers, most = np.zeros(len(rows), dtype=np.int64), 1
    for column in rows.T if len(rows) else ():
        if column.dtype.kind == "f":
            column = np.unique(column, return_inverse=True)[1]
        low = int(column.min())
        span = int(column.max()) - low + 1
        if most > MOST_NUMBERS // span:
            numbers = np.unique(numbers, return_inverse=True)[1]
            most = int(numbers.max()) + 1
        numbers, most = numbers * span + (column - low), most * span
    return numbers


def find_distinct(numbers: Indices) -> tuple[Indices, Indices]:
    """Return where each different number first is, by the numbers, and which of these each is (n,).

    As `numpy.unique` does, in half the time: places are sorted along with the numbers.

    >>> [each.tolist() for each in find_distinct(np.array([7, -2, 7]))]
    [[1, 0], [1, 0, 1]]
    """
    bits = len(numbers).bit_length()
    low, high = int(numbers.min(initial=0)), int(numbers.max(initial=0))
    if high - low >= MOST_NUMBERS >> bits:
        return np.unique(numbers, return_index=True, return_inverse=True)[1:]
    packed = np.sort(((numbers - low) << bits) + np.arange(len(numbers)))
    order, packed = packed & ((1 << bits) - 1), packed >> bits
    new = np.diff(packed, prepend=-1) != 0
    place = np.empty(len(numbers), dtype=np.int64)
    place[order] = np.cumsum(new) - 1
    return order[new], place


def unique_rows(rows: NDArray[Any]) -> NDArray[Any]:
    """Return the different rows (m, k) of rows (n, k), in their order.

    >>> unique_rows(np.array([[2, -1], [0, 7], [2, -1]])).tolist()
    [[0, 7], [2, -1]]
    """
    return rows[find_distinct(number_rows(rows))[0]]


def joined(count: int, pairs: ArrayLike) -> tuple[int, Indices]:
    """Return how many groups `count` nodes make that are joined by pairs (k, 2), and each node's.

    >>> joined(4, [(3, 1)])
    (3, array([0, 1, 2, 1]))
    """
    one, two = np.asarray(pairs, dtype=np.int64).reshape(-1, 2).T
    groups = np.arange(count)
    while len(one):
        low, high = np.minimum(groups[one], groups[two]), np.maximum(groups[one], groups[two])
        apart = np.flatnonzero(low != high)
        one, two = one[apart], two[apart]
        np.minimum.at(groups, high[apart], low[apart])
        while not np.array_equal(further := groups[groups], groups):
            groups = further
    first = groups == np.arange(count)
    return int(first.sum()), (np.cumsum(first) - 1)[groups]
