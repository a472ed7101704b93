"""The facts of one scene as arrays, which are made when a fact is first looked up."""

import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import NamedTuple, TypeAlias

from facetlog.kb.arrays.cliques import PairGraph
from facetlog.kb.arrays.values import Names, Values
from facetlog.kb.engine.columns import Column
from facetlog.kb.engine.terms import Atom, Term

__all__ = ["FactKind", "FactTable", "KindColumns", "LoadedColumn", "SceneColumns"]

FactKind: TypeAlias = tuple[str, int]
"""Functor and number of arguments."""


MOST_GRAPHS = 64
"""Tests of pairs that a scene remembers; then the oldest goes."""


class LoadedColumn(NamedTuple):
    """The values of an argument of facts of one kind: as text of its layout, and as they came."""

    layout: str
    text: str
    values: Sequence[str | int | float]

    def decoded(self, names: Names) -> Values:
        """The same as an array."""
        match self.layout:
            case "a":
                return Values.of_names(self.values, names)  # type: ignore[arg-type]
            case "f":
                floats = Column.of_float_bytes(self.text.encode("latin-1"))
                return Values.of_columns((floats,), names)
            case _:
                return Values.of_terms(list(map(_term, self.values)), names)


def _term(value: str | int | float) -> Term:
    if isinstance(value, str):
        return Atom(value)
    return float(value) if isinstance(value, float) else int(value)


KindColumns: TypeAlias = Mapping[FactKind, tuple[LoadedColumn, ...]]
"""Some facts of each kind, a column for each argument."""

FactTable: TypeAlias = tuple[Values, ...]
"""All facts of a kind in the order in which they were loaded, an array for each argument."""


class SceneColumns:
    """The facts of a scene by their kinds.

    They are kept as they are loaded. What was not kept is read from Prolog: all facts of a scene
    that was loaded compiled, and of a kind that was changed after it was asked for.
    """

    def __init__(self) -> None:
        self.names = Names()
        self._kept = True
        self._parts: dict[FactKind, list[FactTable]] = {}
        self._tables: dict[FactKind, tuple[int, FactTable]] = {}
        self._graphs: dict[str, tuple[tuple[int, ...], PairGraph]] = {}
        self._lock = threading.Lock()

    @contextmanager
    def adding(self, facts: KindColumns) -> Iterator[None]:
        """Keeps facts that are loaded into Prolog meanwhile."""
        with self._lock:
            try:
                yield
            except BaseException:
                self._kept = False  # who knows which of them are there
                raise
            for kind, columns in facts.items():
                if self._kept and kind not in self._tables:
                    part = tuple(column.decoded(self.names) for column in columns)
                    self._parts.setdefault(kind, []).append(part)

    def forget(self) -> None:
        """Prolog has other facts than those that were added."""
        self._kept = False

    def table(
        self,
        kind: FactKind,
        generation: int,
        read: Callable[[FactKind], Sequence[Sequence[Column]]],
    ) -> FactTable:
        """The facts of a kind as they are in a generation; `read` gets them from Prolog."""
        with self._lock:
            known, table = self._tables.get(kind, (generation, None))
            if table is None and self._kept:
                table = self._joined(kind, self._parts.pop(kind, []))
            elif table is None or known != generation:
                parts = read(kind)
                table = tuple(
                    Values.of_columns([part[at] for part in parts], self.names)
                    for at in range(kind[1])
                )
            self._tables[kind] = generation, table
        return table

    def graph(
        self, test: str, generations: tuple[int, ...], make: Callable[[], PairGraph]
    ) -> PairGraph:
        """The graph of a test, made once for facts as they are in these generations."""
        known, graph = self._graphs.get(test, (generations, None))
        if graph is None or known != generations:
            graph = make()
            with self._lock:
                self._graphs[test] = generations, graph
                if len(self._graphs) > MOST_GRAPHS:
                    del self._graphs[next(iter(self._graphs))]
        return graph

    def _joined(self, kind: FactKind, parts: Sequence[FactTable]) -> FactTable:
        return tuple(
            Values.of_parts([part[at] for part in parts], self.names) for at in range(kind[1])
        )
