"""Facts as columns of arguments.

Faces are named f1 …, edges e1 …, vertices v1 …, views view1 …, things t1 …, in a scene's order.
"""

from collections.abc import Collection, Iterable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.facts.fact_schema import Value
from facetlog.perception.types import FloatArray

FactRows: TypeAlias = dict[str, list[tuple[Value, ...]]]
"""Arguments of facts by functor."""

Names: TypeAlias = NDArray[np.object_]

Column: TypeAlias = NDArray[Any]
"""Values (n,) of one argument: names as Python has them, floats, or whole numbers."""

FactColumns: TypeAlias = dict[str, tuple[list[str] | list[int] | FloatArray, ...]]
"""Arguments by functor, column by column; no columns where there are no facts."""


def make_names(letter: str, count: int) -> Names:
    """Return names of all that there are of a kind.

    >>> make_names("f", 2).tolist()
    ['f1', 'f2']
    """
    return np.array([f"{letter}{i}" for i in range(1, count + 1)], dtype=np.object_)


def convert_to_rows(
    columns: Sequence[list[str] | list[int] | FloatArray],
) -> list[tuple[Value, ...]]:
    """Return rows of columns of one length."""
    plain = (c.tolist() if isinstance(c, np.ndarray) else c for c in columns)
    return list(zip(*plain, strict=True))


class CollectedFacts:
    """Facts of the functors `wanted`; others that are added are left out."""

    def __init__(self, wanted: Collection[str]) -> None:
        self._pieces: dict[str, list[tuple[Column, ...]]] = {functor: [] for functor in wanted}

    def wants(self, functor: str) -> bool:
        """Return whether its facts are asked for."""
        return functor in self._pieces

    def add(self, functor: str, *columns: Column) -> None:
        """Add facts, column by column."""
        if functor in self._pieces and columns and len(columns[0]):
            self._pieces[functor].append(columns)

    def add_rows(self, functor: str, rows: Iterable[tuple[Value, ...]]) -> None:
        """Add facts, row by row."""
        if functor in self._pieces:
            self.add(functor, *map(_column, zip(*rows, strict=True)))

    def add_both_ways(self, functor: str, one: Names, two: Names, *columns: Column) -> None:
        """Add a fact for each pair of names, and after it that for the two in the other order."""
        first, last = np.column_stack([one, two]).ravel(), np.column_stack([two, one]).ravel()
        self.add(functor, first, last, *(np.repeat(column, 2) for column in columns))

    def to_columns(self) -> FactColumns:
        """Return the facts."""
        return {
            functor: tuple(c if c.dtype == np.float64 else c.tolist() for c in _joined(own))
            for functor, own in self._pieces.items()
        }


def _joined(pieces: list[tuple[Column, ...]]) -> tuple[Column, ...]:
    if len(pieces) < 2:
        return pieces[0] if pieces else ()
    return tuple(map(np.concatenate, zip(*pieces, strict=True)))


def _column(values: tuple[Value, ...]) -> Column:
    kind = type(values[0])
    return np.array(values, dtype={float: np.float64, int: np.intp}.get(kind, np.object_))
