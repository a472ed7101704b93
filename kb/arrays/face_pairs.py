"""Which two faces pass a test, worked out once for a scene.

Where one fact says it, arrays decide what is surely outside of the test's limits or surely inside.
What is near a limit is put to Prolog, and so is any other test.
"""

from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from facetlog.errors import EngineError
from facetlog.kb.arrays.cliques import PairGraph
from facetlog.kb.arrays.plan_terms import Measured
from facetlog.kb.arrays.scene_columns import FactKind, FactTable
from facetlog.kb.arrays.values import Kind, Mask, Names, NotOnArraysError, Values
from facetlog.kb.engine.terms import Atom, Struct, Term

__all__ = ["AskProlog", "graph_by_measure", "graph_by_prolog"]

AskProlog: TypeAlias = Callable[[Struct], Term]
"""Puts a request about the scene to Prolog, whose functor is the operation."""

SURE_DEVIATIONS = 0.7
"""A value so far inside of its limits is there with a probability above 1/2 (.516): it passes."""

MOST_PUT = 4096
"""Values near a limit that are put to Prolog; of more it is faster to make the graph there."""

FACES, EVIDENCE = ("face", 1), ("evidence", 2)


def graph_by_prolog(text: str, ask: AskProlog, names: Names) -> PairGraph:
    """The graph that Prolog makes, and remembers."""
    match ask(Struct("pair_graph", (text,))):
        case Struct("graph", (tuple(faces), tuple(later))):
            count = len(faces)
            width = -(-count // 8)
            # Prolog counts bits from 1.
            rows = [
                (bits >> 1).to_bytes(width, "little") for bits in later if isinstance(bits, int)
            ]
            bits = np.frombuffer(b"".join(rows), np.uint8).reshape(count, width)
            return PairGraph(names.places([str(face) for face in faces]), bits)
    raise EngineError("Prolog's answer cannot be read")


def graph_by_measure(
    way: Measured, text: str, tables: Mapping[FactKind, FactTable], ask: AskProlog
) -> PairGraph:
    """The graph of a test that compares a measured value of each two faces with numbers."""
    (face,), (about, kind), measured = (tables[of] for of in (FACES, EVIDENCE, way.kind))
    names = face.names
    seen = _places(about)[kind.equal(Atom("measured"))]
    known = np.intersect1d(_places(face), seen)
    nodes = known[np.argsort(names.ranks[known])]
    number = np.full(len(names.atoms), -1)
    number[nodes] = np.arange(len(nodes))

    values, deviations = measured[way.value].exact_floats(), measured[way.deviation].exact_floats()
    rows = np.flatnonzero(_inside(way, values))
    left = number[_places(measured[way.first])[rows]]
    right = number[_places(measured[way.second])[rows]]
    ordered = (left >= 0) & (left < right)
    rows, left, right = rows[ordered], left[ordered], right[ordered]
    unsure = np.flatnonzero(_margin(way, values[rows]) < SURE_DEVIATIONS * np.abs(deviations[rows]))
    passes = np.ones(len(rows), np.bool_)
    passes[unsure] = False
    if len(unsure) > MOST_PUT:
        return graph_by_prolog(text, ask, names)
    if len(unsure):
        put = tuple(
            Struct("-", (float(values[row]), float(deviations[row]))) for row in rows[unsure]
        )
        passing = ask(Struct("passing_values", (text, put)))
        passes[unsure[np.array(passing, dtype=np.intp)]] = True
    matrix = np.zeros((len(nodes), len(nodes)), np.bool_)
    matrix[left[passes], right[passes]] = True
    return PairGraph.of_matrix(nodes, matrix)


def _places(column: Values) -> NDArray[np.int32]:
    """The names of a column by their places."""
    if len(column) and column.kind is not Kind.NAME:
        raise NotOnArraysError
    places: NDArray[np.int32] = column.data.astype(np.int32, copy=False)
    return places


def _inside(way: Measured, values: NDArray[np.float64]) -> Mask:
    """Where the test may hold at all: compare.pl wants a value inside of its limits."""
    match way.bounds, way.limits:
        case "near", (target, tolerance):
            return np.asarray(np.abs(values - target) <= tolerance)
        case "between", (low, high):
            return np.asarray((values >= low) & (values <= high))
        case "at_least", (low,):
            return np.asarray(values >= low)
        case "at_most", (high,):
            return np.asarray(values <= high)
    raise NotOnArraysError


def _margin(way: Measured, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far values are from the nearest limit."""
    match way.bounds, way.limits:
        case "near", (target, tolerance):
            return tolerance - np.abs(values - target)
        case "between", (low, high):
            return np.minimum(values - low, high - values)
        case _, (limit,):
            return np.abs(values - limit)
    raise NotOnArraysError
