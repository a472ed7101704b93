"""Bounds between measured values: which follow from which.

Each bound is an edge: one value is at least so many times another. Bounds follow one another along
paths, the factors multiplied; a circle whose factors make more than one is a contradiction.
"""

from collections import deque
from collections.abc import Hashable, Iterable
from dataclasses import dataclass, field

from facetlog.grammar.lint.linear import Linear

__all__ = ["EQUAL", "ONE", "Edge", "Graph", "edge_of", "is_one"]

ONE = "one"
"""The constant 1, of each dimension: `(ONE, dimension)` stands where a measured value may."""

MOST_EDGES = 400
"""Edges of a graph; what is beyond them is not looked at."""

MOST_VISITS = 200_000
"""Edges passed in all searches of a graph, some hundredths of a second: models pass hundreds."""

LEAST, MOST = 1e-30, 1e30
"""Factors beyond these are not looked at: products of a path's factors must stay finite."""

EQUAL = 1e-9
"""Relative: factors that differ by less differ by rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """`greater` is at least `factor` times `lesser`; `sure` if that is certain.

    `why` is what it comes from: a claim, or None if it holds of every solid.
    """

    greater: Hashable
    lesser: Hashable
    factor: float
    sure: bool
    why: object = None


@dataclass(slots=True)
class Graph:
    """Edges by what they are greater than."""

    edges: dict[Hashable, list[Edge]] = field(default_factory=dict)
    count: int = 0
    visits: int = 0
    _lesser: set[Hashable] = field(default_factory=set)
    _leading_on: set[Hashable] = field(default_factory=set)

    def add(self, edge: Edge) -> None:
        """Adds an edge, up to the limit."""
        if self.count < MOST_EDGES:
            self.count += 1
            self.edges.setdefault(edge.greater, []).append(edge)
            self._lesser.add(edge.lesser)
            if not is_one(edge.lesser):
                self._leading_on.add(edge.greater)

    def best(
        self, start: Hashable, goal: Hashable, without: Iterable[object] = ()
    ) -> tuple[float, tuple[Edge, ...]]:
        """The greatest factor by which `start` is at least `goal`, and the path; 0 if none found.

        `without`: edges from there are left out. No circle may make more than one: then each value
        improves at most once a round, and there are as many rounds as values.
        """
        if start not in self.edges or goal not in self._lesser or self.visits > MOST_VISITS:
            return 0.0, ()
        left_out = {id(one) for one in without}
        best: dict[Hashable, float] = {start: 1.0}
        came: dict[Hashable, Edge] = {}
        waiting = deque([start])
        steps = 0
        while waiting and steps <= MOST_EDGES:
            steps += 1
            one = waiting.popleft()
            self.visits += len(self.edges.get(one, ()))
            # Most values are compared with constants alone: from there they lead nowhere else.
            constant = is_one(one)
            for edge in self.edges.get(one, ()):
                if constant and edge.lesser not in self._leading_on and edge.lesser != goal:
                    continue
                if edge.lesser == start or id(edge.why) in left_out:
                    continue
                factor = best[one] * edge.factor
                if factor > MOST:
                    continue
                if factor > best.get(edge.lesser, 0.0) * (1 + EQUAL):
                    best[edge.lesser] = factor
                    came[edge.lesser] = edge
                    waiting.append(edge.lesser)
        if goal not in best:
            return 0.0, ()
        path: list[Edge] = []
        at = goal
        while at != start and len(path) <= len(came):
            path.append(came[at])
            at = came[at].greater
        return best[goal], tuple(reversed(path))


def is_one(node: Hashable) -> bool:
    """Whether a node of the graph is the constant 1."""
    return isinstance(node, tuple) and node[0] == ONE


def edge_of(rest: Linear, sure: bool, why: object) -> Edge | None:
    """The edge that says that a sum is not negative; None if it is about more than two values."""
    one = (ONE, rest.dimension)
    terms = list(rest.terms.items())
    found: Edge | None = None
    if len(terms) == 2 and rest.constant == 0:
        (first, a), (second, b) = terms
        if a < 0:
            first, a, second, b = second, b, first, a
        if a > 0 > b:
            found = Edge(first, second, -b / a, sure, why)
    elif len(terms) == 1:
        ((atom, factor),) = terms
        if factor > 0 > rest.constant:
            found = Edge(atom, one, -rest.constant / factor, sure, why)
        elif factor < 0 < rest.constant:
            found = Edge(one, atom, -factor / rest.constant, sure, why)
    # Numbers near the ends of what a computer holds are no sizes of anything.
    return found if found is not None and LEAST < found.factor < MOST else None
