"""The answers of a plan in one scene: steps on batches of rows, the first one's rows outermost.

Prolog takes the steps for one row after the other. Here a step takes many rows at once, and gives
its own in the same order: for each row all that it comes to, in the order of the facts.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from facetlog.kb.arrays.arithmetic import passing
from facetlog.kb.arrays.cliques import PairGraph, clique_count, cliques
from facetlog.kb.arrays.join import JoinIndex, expanded
from facetlog.kb.arrays.pace import Pace
from facetlog.kb.arrays.plan_terms import (
    Absent,
    Compare,
    Constant,
    Fact,
    Order,
    Pairs,
    Step,
    Summed,
    Variable,
    variables_of,
)
from facetlog.kb.arrays.scene_columns import FactKind, FactTable
from facetlog.kb.arrays.summaries import Summary
from facetlog.kb.arrays.values import Index, Mask, Names, Values

__all__ = ["Batch", "SceneTables", "batches"]


@dataclass(frozen=True, slots=True)
class Batch:
    """Some rows: the values of variables by their numbers."""

    length: int
    values: Mapping[int, Values]


@dataclass(frozen=True, slots=True)
class SceneTables:
    """What the steps look at, and at what pace; `graph` is that of a step of pairs."""

    tables: Mapping[FactKind, FactTable]
    names: Names
    pace: Pace
    graph: Callable[[Pairs], PairGraph]


def batches(steps: Sequence[Step], needed: frozenset[int], scene: SceneTables) -> Iterator[Batch]:
    """All rows that the steps find, with the values of the variables that are `needed`."""
    return _ran(_stages(steps, frozenset(), needed, scene), Batch(1, {}))


class _Stage(Protocol):
    def rows(self, batch: Batch) -> Iterator[Batch]:
        """What each row of the batch comes to."""


def _ran(stages: Sequence[_Stage], batch: Batch) -> Iterator[Batch]:
    if not stages:
        yield batch
        return
    for part in stages[0].rows(batch):
        if part.length:
            yield from _ran(stages[1:], part)


def _stages(
    steps: Sequence[Step], bound: frozenset[int], needed: frozenset[int], scene: SceneTables
) -> list[_Stage]:
    stages: list[_Stage] = []
    steps, early = _tests_at_facts(steps)
    for place, step in enumerate(steps):
        later = needed | frozenset(variables_of(steps[place + 1 :]))
        match step:
            case Fact():
                stages.append(_Lookup(step, early[place], bound, later, scene))
                bound |= frozenset(variables_of([step]))
            case Pairs():
                stages.append(_FacePairs(step, later, scene))
                bound |= frozenset(variables_of([step]))
            case Absent(inner):
                stages.append(_Absence(inner, bound, scene))
            case Summed():
                stages.append(_Summing(step, scene))
                bound |= {step.result}
            case _:
                stages.append(_Test(step, scene))
    return stages


def _tests_at_facts(
    steps: Sequence[Step],
) -> tuple[list[Step], dict[int, list[Compare | Order]]]:
    """The steps without the tests of one fact's own values, and those by the place of that fact.

    They are made of each fact once, and not of each row that it is joined to.
    """
    kept: list[Step] = []
    tests: dict[int, list[Compare | Order]] = {}
    for step in steps:
        if isinstance(step, Compare | Order):
            asked = set(variables_of([step]))
            places = (
                place
                for place, fact in enumerate(kept)
                if isinstance(fact, Fact) and asked and asked <= set(variables_of([fact]))
            )
            if (place := next(places, None)) is not None:
                tests[place].append(step)
                continue
        if isinstance(step, Fact):
            tests[len(kept)] = []
        kept.append(step)
    return kept, tests


class _Lookup:
    """The rows of a fact that agree with those of a batch."""

    def __init__(
        self,
        step: Fact,
        tests: Sequence[Compare | Order],
        bound: frozenset[int],
        needed: frozenset[int],
        scene: SceneTables,
    ) -> None:
        self._step, self._tests, self._scene = step, tests, scene
        self._table = scene.tables[step.kind]
        # Where each variable stands first.
        self._places: dict[int, int] = {}
        for place, argument in enumerate(step.args):
            if isinstance(argument, Variable):
                self._places.setdefault(argument.number, place)
        self._keys = [number for number in self._places if number in bound]
        self._kept = [n for n in self._places if n in needed and n not in bound]
        self._passed_on = needed & bound
        self._ready: tuple[NDArray[np.intp] | None, JoinIndex | None] | None = None

    def rows(self, batch: Batch) -> Iterator[Batch]:
        if self._ready is None:
            self._ready = self._prepared()
        rows, index = self._ready
        if index is None:
            count = len(self._table[0]) if rows is None else len(rows)
            begins = np.zeros(batch.length, np.intp)
            counts = np.full(batch.length, count)
        else:
            begins, counts = index.ranges([batch.values[number] for number in self._keys])
        for outer, inner in expanded(begins, counts, self._scene.pace.step):
            if index is not None:
                inner = index.order[inner]
            if rows is not None:
                inner = rows[inner]
            yield Batch(
                len(outer),
                {
                    **{n: batch.values[n].take(outer) for n in self._passed_on},
                    **{n: self._column(n, inner) for n in self._kept},
                },
            )

    def _column(self, number: int, rows: Index) -> Values:
        return self._table[self._places[number]].take(rows)

    def _prepared(self) -> tuple[NDArray[np.intp] | None, JoinIndex | None]:
        """The rows that can agree with any, if not all, and how to find those that do."""
        rows = self._own_rows()
        if not self._keys:
            return rows, None
        taken: Index = slice(None) if rows is None else rows
        columns = [self._column(number, taken) for number in self._keys]
        return rows, JoinIndex(columns, len(columns[0]))

    def _own_rows(self) -> NDArray[np.intp] | None:
        length = len(self._table[0])
        if not length:
            return None
        masks: list[Mask] = []
        for place, argument in enumerate(self._step.args):
            column = self._table[place]
            if isinstance(argument, Constant):
                masks.append(column.equal(argument.value))
            elif self._places[argument.number] != place:
                masks.append(column.same(self._table[self._places[argument.number]]))
        rows = np.flatnonzero(np.logical_and.reduce(masks)) if masks else None
        for test in self._tests:
            taken: Index = slice(None) if rows is None else rows
            asked = {number: self._column(number, taken) for number in set(variables_of([test]))}
            mask = passing(test, asked, length if rows is None else len(rows), self._scene.names)
            rows = np.flatnonzero(mask) if rows is None else rows[mask]
        return rows


class _FacePairs:
    """The faces of which each two pass a test; the step is the first of its plan."""

    def __init__(self, step: Pairs, needed: frozenset[int], scene: SceneTables) -> None:
        self._step, self._scene = step, scene
        self._needed = [
            (place, face.number)
            for place, face in enumerate(step.faces)
            if isinstance(face, Variable) and face.number in needed
        ]
        self._given = [face for face in step.faces if isinstance(face, Constant)]

    def rows(self, batch: Batch) -> Iterator[Batch]:
        del batch  # of one row, in which nothing is known
        graph, names, pace = self._scene.graph(self._step), self._scene.names, self._scene.pace
        if not self._needed and not self._given:
            for count in clique_count(graph, len(self._step.faces), pace):
                yield Batch(count, {})
            return
        given: list[int | None] = [
            graph.number(str(face.value), names) if isinstance(face, Constant) else None
            for face in self._step.faces
        ]
        if sum(number is not None for number in given) < len(self._given):
            return
        for chosen in cliques(graph, given, pace):
            values = {n: graph.values(chosen[at], names) for at, n in self._needed}
            yield Batch(len(chosen[0]), values)


class _Test:
    """The rows of which a test holds."""

    def __init__(self, test: Compare | Order, scene: SceneTables) -> None:
        self._test, self._scene = test, scene

    def rows(self, batch: Batch) -> Iterator[Batch]:
        yield _where(batch, passing(self._test, batch.values, batch.length, self._scene.names))


def _where(batch: Batch, mask: Mask) -> Batch:
    rows = np.flatnonzero(mask)
    if len(rows) == batch.length:
        return batch
    return Batch(len(rows), {n: values.take(rows) for n, values in batch.values.items()})


class _Absence:
    """The rows of which the steps find nothing."""

    def __init__(self, steps: Sequence[Step], bound: frozenset[int], scene: SceneTables) -> None:
        # A variable of its own: the number of the row. Those of a question are above 0.
        self._row = min((0, *bound)) - 1
        self._stages = _stages(steps, bound | {self._row}, frozenset({self._row}), scene)
        self._scene = scene

    def rows(self, batch: Batch) -> Iterator[Batch]:
        numbers = Values.of_rows(batch.length, self._scene.names)
        free = np.ones(batch.length, np.bool_)
        for found in _ran(self._stages, Batch(batch.length, {**batch.values, self._row: numbers})):
            free[found.values[self._row].data] = False
        yield _where(batch, free)


class _Summing:
    """One row with what all rows come to that the steps find; none where that has no value."""

    def __init__(self, step: Summed, scene: SceneTables) -> None:
        self._step, self._scene = step, scene
        needed = frozenset() if step.of is None else frozenset({step.of.number})
        self._stages = _stages(step.steps, frozenset(), needed, scene)

    def rows(self, batch: Batch) -> Iterator[Batch]:
        summary = Summary(self._step.functor)
        for found in _ran(self._stages, batch):
            of = self._step.of
            summary.add(found.length, None if of is None else found.values[of.number])
        total = summary.value
        if total is not None:
            values = Values.of_terms((total,), self._scene.names)
            yield Batch(1, {self._step.result: values})
