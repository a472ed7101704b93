"""Facts as columns of arguments, for all scenes of a block together, and each scene's part of them.

Faces are named f1 …, edges e1 …, vertices v1 …, views view1 …, things t1 …, in a scene's order.
"""

from collections.abc import Collection, Iterable, Sequence
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.facts.fact_schema import Value
from facetlog.perception.ragged import Indices
from facetlog.perception.types import FloatArray

FactRows: TypeAlias = dict[str, list[tuple[Value, ...]]]
"""Arguments of facts by functor."""

Names: TypeAlias = NDArray[np.object_]

Column: TypeAlias = NDArray[Any]
"""Values (n,) of one argument: names as Python has them, floats, or whole numbers."""

FactColumns: TypeAlias = dict[str, tuple[list[str] | list[int] | FloatArray, ...]]
"""Arguments by functor, column by column; no columns where there are no facts."""


@lru_cache(maxsize=64)
def names(letter: str, count: int) -> tuple[str, ...]:
    """Return names of all that there are of a kind.

    >>> names("f", 2)
    ('f1', 'f2')
    """
    return tuple(f"{letter}{i}" for i in range(1, count + 1))


def make_names_in_order(letter: str, counts: Indices) -> NDArray[np.object_]:
    """Return names of all that the scenes have of a kind, so many each, scene by scene.

    >>> make_names_in_order("f", np.array([2, 1])).tolist()
    ['f1', 'f2', 'f1']
    """
    every = np.array(names(letter, int(counts.max(initial=0))), dtype=np.object_)
    return np.concatenate([every[:0], *(every[:count] for count in counts.tolist())])


def convert_to_rows(
    columns: Sequence[list[str] | list[int] | FloatArray],
) -> list[tuple[Value, ...]]:
    """Return rows of columns of one length."""
    plain = (c.tolist() if isinstance(c, np.ndarray) else c for c in columns)
    return list(zip(*plain, strict=True))


class BlockFacts:
    """Facts of the functors `wanted`, of so many scenes; others that are added are left out."""

    def __init__(self, wanted: Collection[str], count: int) -> None:
        self._count = count
        self._pieces: dict[str, list[list[tuple[Column, ...]]]] = {
            functor: [[] for _ in range(count)] for functor in wanted
        }

    def wants(self, functor: str) -> bool:
        """Return whether its facts are asked for."""
        return functor in self._pieces

    def add(self, functor: str, scenes: Indices, *columns: Column) -> None:
        """Add facts, each of the scene (n,) that is given for it, ascending."""
        if functor not in self._pieces or not len(scenes):
            return
        ends = np.searchsorted(scenes, np.arange(1, self._count + 1)).tolist()
        begin = 0
        for pieces, end in zip(self._pieces[functor], ends, strict=True):
            if end > begin:
                pieces.append(tuple(column[begin:end] for column in columns))
            begin = end

    def add_rows(self, functor: str, scene: int, rows: Iterable[tuple[Value, ...]]) -> None:
        """Add facts of one scene, row by row."""
        found = list(rows)
        if functor in self._pieces and found:
            columns = tuple(_column(column) for column in zip(*found, strict=True))
            self._pieces[functor][scene].append(columns)

    def add_both_ways(
        self, functor: str, scenes: Indices, one: Names, two: Names, *columns: Column
    ) -> None:
        """Add a fact for each pair of names, and after it that for the two in the other order."""
        if functor in self._pieces:
            order = np.repeat(np.arange(len(scenes)), 2)
            second = np.arange(len(order)) % 2 == 1
            names = np.concatenate((one, two))
            first = order + np.where(second, len(scenes), 0)
            last = order + np.where(second, 0, len(scenes))
            twice = (column[order] for column in columns)
            self.add(functor, scenes[order], names[first], names[last], *twice)

    def of_scene(self, scene: int) -> FactColumns:
        """Return the facts of one scene."""
        return {
            functor: tuple(c if c.dtype == np.float64 else c.tolist() for c in _joined(own[scene]))
            for functor, own in self._pieces.items()
        }


def _joined(pieces: list[tuple[Column, ...]]) -> tuple[Column, ...]:
    if len(pieces) < 2:
        return pieces[0] if pieces else ()
    return tuple(map(np.concatenate, zip(*pieces, strict=True)))


def _column(values: tuple[Value, ...]) -> Column:
    kind = type(values[0])
    return np.array(values, dtype={float: np.float64, int: np.intp}.get(kind, np.object_))
