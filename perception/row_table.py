"""Rows of different lengths that stand end to end in one array, as a table and as sums."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray

__all__ = [
    "Bools",
    "Indices",
    "chosen_places",
    "padded_sums",
    "pairs_in_rows",
    "row_starts",
    "row_sums",
    "row_table",
    "stacked",
]

Indices = NDArray[np.intp]
Bools = NDArray[np.bool_]


def row_starts(lengths: Indices) -> Indices:
    """Where each row begins (r,).

    >>> row_starts(np.array([3, 2])).tolist()
    [0, 3]
    """
    return np.cumsum(lengths) - lengths


def row_table(lengths: Indices) -> tuple[Indices, Bools]:
    """Places (r, k) of the rows' entries, k the longest, and which of them are there (r, k).

    A row that is shorter repeats its last entry.

    >>> places, there = row_table(np.array([3, 2]))
    >>> places.tolist(), there[1].tolist()
    ([[0, 1, 2], [3, 4, 4]], [True, True, False])
    """
    steps = np.arange(int(lengths.max(initial=0)))
    there = steps < lengths[:, None]
    last = np.maximum(lengths - 1, 0)
    return row_starts(lengths)[:, None] + np.minimum(steps, last[:, None]), there


def row_sums(values: FloatArray, lengths: Indices) -> FloatArray:
    """Sums (r, ...) of the rows' entries (n, ...); every row has one at least."""
    if not len(lengths):
        return np.zeros((0, *values.shape[1:]))
    sums: FloatArray = np.add.reduceat(values, row_starts(lengths), axis=0)
    return sums


def chosen_places(lengths: Indices, chosen: Indices) -> Indices:
    """Places of all entries of some rows, row by row.

    >>> chosen_places(np.array([3, 2, 1]), np.array([2, 0])).tolist()
    [5, 0, 1, 2]
    """
    counts = lengths[chosen]
    first = row_starts(lengths)[chosen] - row_starts(counts)
    return np.arange(int(counts.sum())) + np.repeat(first, counts)


def padded_sums(table: FloatArray) -> FloatArray:
    """Sums (r,) of rows (r, k) that end in zeros: the same to the last bit, however many.

    >>> padded_sums(np.array([[1.0, 2.0, 0.0]]))
    array([3.])
    """
    if not table.shape[1]:
        return np.zeros(len(table))
    return np.asarray(table.cumsum(axis=1)[:, -1], dtype=np.float64)


def pairs_in_rows(firsts: Indices, seconds: Indices) -> tuple[Indices, Indices]:
    """Places (p,) of every pair of an entry of one kind with one of another in the same row.

    The rows have `firsts` (r,) and `seconds` (r,) entries.

    >>> [each.tolist() for each in pairs_in_rows(np.array([2, 1]), np.array([1, 2]))]
    [[0, 1, 2, 2], [0, 0, 1, 2]]
    """
    counts = np.repeat(seconds, firsts)
    begins = np.repeat(row_starts(seconds), firsts)
    one = np.repeat(np.arange(len(counts)), counts)
    return one, np.arange(len(one)) - np.repeat(row_starts(counts) - begins, counts)


def stacked(arrays: Sequence[FloatArray], *shape: int) -> FloatArray:
    """Arrays of one shape as rows (n, ...)."""
    if not arrays:
        return np.zeros((0, *shape))
    return np.concatenate(arrays).reshape(-1, *shape)
