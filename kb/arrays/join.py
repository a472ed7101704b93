"""Rows of a table for each row of another one, in the order in which Prolog finds them."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from facetlog.kb.arrays.values import Index, Kind, NotOnArraysError, Values

__all__ = ["JoinIndex", "expanded"]

_Rows: TypeAlias = NDArray[np.intp]

MOST_KEYS = 1 << 62
"""Different combinations of values that one integer can tell apart."""

DENSE = 16
"""Of at most so many possible keys for each row, each key has its place in a list."""


@dataclass(frozen=True, slots=True)
class _KeyPart:
    """One of the values that a join goes by: the known ones in order, or any place of a name."""

    kind: Kind
    size: int
    known: NDArray[Any] | None

    @classmethod
    def of(cls, values: Values) -> "tuple[_KeyPart, NDArray[Any]]":
        if values.kind is Kind.NAME:
            return cls(values.kind, len(values.names.atoms), None), values.keys
        known, places = np.unique(values.keys, return_inverse=True)
        return cls(values.kind, len(known), known), places

    def places(self, values: Values) -> tuple[NDArray[Any], Any]:
        """The place of each value, and whether it has one."""
        keys = values.keys
        if values.kind is not self.kind or not self.size:
            return np.zeros(len(keys), np.intp), False
        if self.known is None:
            return np.minimum(keys, self.size - 1), keys < self.size
        places = np.minimum(np.searchsorted(self.known, keys), self.size - 1)
        return places, self.known[places] == keys


class JoinIndex:
    """Finds the rows of a table by some of its columns."""

    def __init__(self, columns: Sequence[Values], rows: int) -> None:
        self._parts: list[_KeyPart] = []
        self._size = 1
        key: NDArray[Any] = np.zeros(rows, np.int64)
        for column in columns:
            part, places = _KeyPart.of(column)
            self._size *= max(1, part.size)
            if self._size > MOST_KEYS:
                raise NotOnArraysError
            key = key * part.size + places
            self._parts.append(part)
        self.order: _Rows = np.argsort(key, kind="stable")
        """The rows, those of equal keys together and in their order."""
        self._sorted = key[self.order]
        self._begins: NDArray[Any] | None = None
        if self._size <= DENSE * rows:
            counts = np.bincount(key, minlength=self._size)
            self._begins = np.concatenate([[0], np.cumsum(counts)])

    def ranges(self, columns: Sequence[Values]) -> tuple[_Rows, _Rows]:
        """For each row of these columns where its matches begin in `order`, and how many follow."""
        key: Any = 0
        found: Any = True
        for part, column in zip(self._parts, columns, strict=True):
            places, known = part.places(column)
            key = key * part.size + places.astype(np.int64, copy=False)
            found = found & known
        if self._begins is not None:
            begins, ends = self._begins[key], self._begins[key + 1]
        else:
            begins = np.searchsorted(self._sorted, key, "left")
            ends = np.searchsorted(self._sorted, key, "right")
        return begins, np.where(found, ends - begins, 0)


def expanded(
    begins: _Rows, counts: _Rows, step: Callable[[], int]
) -> Iterator[tuple[_Rows, Index]]:
    """Pairs of a row and each of its matches, row by row, in parts of at most `step()` pairs.

    Of row i the matches are begins[i], begins[i] + 1, ..., counts[i] of them.
    """
    ends = np.cumsum(counts)
    total = int(ends[-1]) if len(ends) else 0
    low = 0
    while low < total:
        high = min(total, low + step())
        first, last = (int(row) for row in np.searchsorted(ends, (low, high - 1), "right"))
        start = int(begins[first]) + low - int(ends[first] - counts[first])
        if first == last:
            yield np.full(high - low, first), slice(start, start + high - low)
        else:
            sizes = counts[first : last + 1].copy()
            starts = begins[first : last + 1].copy()
            sizes[0] = ends[first] - low
            starts[0] = start
            sizes[-1] -= ends[last] - high
            before = np.cumsum(sizes) - sizes
            yield (
                np.repeat(np.arange(first, last + 1), sizes),
                np.arange(high - low) + np.repeat(starts - before, sizes),
            )
        low = high
