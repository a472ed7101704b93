"""The facts of one scene as arrays, which are made when a fact is first looked up."""

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

from facetlog.kb.arrays.values import Names, Values
from facetlog.kb.engine.columns import Column

__all__ = ["FactKind", "FactTable", "KindColumns", "SceneColumns"]

FactKind: TypeAlias = tuple[str, int]
"""Functor and number of arguments."""

KindColumns: TypeAlias = Mapping[FactKind, tuple[Column, ...]]
"""Some facts of each kind, a column for each argument."""

FactTable: TypeAlias = tuple[Values, ...]
"""All facts of a kind in the order in which they were loaded, an array for each argument."""


class SceneColumns:
    """The facts of a scene by their kinds.

    Columns are kept as they were loaded until they are decoded, and then only decoded. What was not
    kept is read from Prolog: all facts of a scene that was loaded compiled, and of a kind that was
    changed after it was decoded.
    """

    def __init__(self) -> None:
        self.names = Names()
        self._compiled = False
        self._parts: dict[FactKind, list[tuple[Column, ...]]] = {}
        self._tables: dict[FactKind, tuple[int, FactTable]] = {}
        self._lock = threading.Lock()

    def add(self, facts: KindColumns) -> None:
        """Keeps facts that were loaded."""
        with self._lock:
            for kind, columns in facts.items():
                if not self._compiled and kind not in self._tables:
                    self._parts.setdefault(kind, []).append(columns)

    def compiled(self) -> None:
        """The scene has other facts than those that were added."""
        self._compiled = True

    def table(
        self,
        kind: FactKind,
        generation: int,
        read: Callable[[FactKind], Sequence[tuple[Column, ...]]],
    ) -> FactTable:
        """The facts of a kind as they are in a generation; `read` gets them from Prolog."""
        with self._lock:
            known, table = self._tables.get(kind, (generation, None))
            if table is None or known != generation:
                kept = self._parts.pop(kind, None) if table is None else None
                parts = read(kind) if kept is None and (self._compiled or table) else kept or ()
                table = tuple(
                    Values.of_columns([part[at] for part in parts], self.names)
                    for at in range(kind[1])
                )
                self._tables[kind] = generation, table
        return table
