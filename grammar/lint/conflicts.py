"""Conditions that contradict one another, or stand there twice.

Bounds between measured values are the edges of a graph: one value is at least so many times
another. They follow one another along paths, the factors multiplied; a circle whose factors make
more than one is a contradiction.
"""

import math
from collections import deque
from collections.abc import Hashable, Iterable, Iterator, Set
from dataclasses import dataclass, field

from facetlog.grammar import syntax as s
from facetlog.grammar.checking.types import DIMENSIONS
from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.lint.claims import Claim, Claims, Origin, Place, in_short
from facetlog.grammar.lint.linear import Atom, Linear
from facetlog.grammar.lint.solids import (
    AT_LEAST,
    AT_MOST,
    iter_excluded,
    iter_piece_bounds,
    iter_solid_bounds,
)
from facetlog.grammar.scope import PartSymbol, SetSymbol
from facetlog.grammar.source import Source
from facetlog.grammar.units import Dimension
from facetlog.grammar.vocabulary import THING, VOCABULARY

ONE = "one"
"""The constant 1, of each dimension: `(ONE, dimension)` stands where a measured value may."""

MOST_EDGES = 400
"""Edges of a graph; more are ignored."""

MOST_VISITS = 200_000
"""Edges passed in all searches of a graph, some hundredths of a second: models pass hundreds."""

LEAST, MOST = 1e-30, 1e30
"""Factors beyond these are ignored: products of a path's factors must stay finite."""

EQUAL = 1e-9
"""Relative: factors that differ by less differ by rounding."""

MOST_NAMED = 3
"""Other lines that a message names."""

_UNITS = {Dimension.LENGTH: " m", Dimension.AREA: " m²", Dimension.ANGLE: "°"}


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """`greater` is at least `factor` times `lesser`; `sure` if that is certain.

    `why` is the claim that it comes from; None if it holds of every solid.
    """

    greater: Hashable
    lesser: Hashable
    factor: float
    sure: bool
    why: Claim | None = None


@dataclass(slots=True)
class _Graph:
    """Edges by what they are greater than."""

    edges: dict[Hashable, list[Edge]] = field(default_factory=dict)
    count: int = 0
    visits: int = 0

    def add(self, edge: Edge) -> None:
        if self.count < MOST_EDGES:
            self.count += 1
            self.edges.setdefault(edge.greater, []).append(edge)

    def find_best(self, start: Hashable, goal: Hashable) -> tuple[float, tuple[Edge, ...]]:
        """Return the greatest factor by which `start` is at least `goal`, and the path; else 0.

        No circle may make more than one: then each value improves at most once a round, and there
        are as many rounds as values.
        """
        if start not in self.edges or self.visits > MOST_VISITS:
            return 0.0, ()
        best: dict[Hashable, float] = {start: 1.0}
        came: dict[Hashable, Edge] = {}
        waiting = deque([start])
        steps = 0
        while waiting and steps <= MOST_EDGES:
            steps += 1
            one = waiting.popleft()
            self.visits += len(self.edges.get(one, ()))
            for edge in self.edges.get(one, ()):
                factor = best[one] * edge.factor
                if edge.lesser == start or factor > MOST:
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


# ------------------------------------------------------------- contradictions


def find_contradictions(claims: Claims, reported: set[Place]) -> Iterator[Fault]:
    """Find claims that cannot hold with those before them, or with what holds of every solid.

    `reported` are the places of claims that have a fault already, and grows.
    """
    graph = _Graph()
    conditions: dict[Hashable, tuple[Claim, bool]] = {}
    atoms = {atom for c in claims.claims for b in c.bounds for atom in b.half.terms}
    for edge in _iter_given(claims, atoms):
        graph.add(edge)
    for claim, sure in claims.iter_premises():
        against = next((k for k in iter_excluded(claim.key) if k in conditions), None)
        if against is not None:
            other, other_sure = conditions[against]
            yield from _contradiction((claim, other), (), sure and other_sure, reported)
            continue
        for edge in _iter_edges(claim, sure, atoms):
            factor, path = graph.find_best(edge.lesser, edge.greater)
            if factor * edge.factor <= 1 + EQUAL:
                graph.add(edge)
                continue
            # Of values that may be zero a circle says only that they are.
            around = {edge.greater, *(e.lesser for e in path), *(e.greater for e in path)}
            positive = any(n in claims.positive or _is_one(n) for n in around)
            certain = positive and all(e.sure for e in (edge, *path))
            involved = (claim, *(e.why for e in path if e.why is not None))
            given = tuple(e for e in path if e.why is None)
            yield from _contradiction(involved, given, certain, reported, only_zero=not positive)
        conditions.setdefault(claim.key, (claim, sure))


def _contradiction(
    claims: tuple[Claim, ...],
    given: tuple[Edge, ...],
    sure: bool,
    reported: set[Place],
    *,
    only_zero: bool = False,
) -> Iterator[Fault]:
    own = [c for c in claims if c.origin.own]
    if not own or any(c.place in reported for c in claims):
        return
    reported.update(c.place for c in claims)
    at = max(own, key=lambda c: c.node.span.start)
    others = [c for c in claims if c.place != at.place]
    kinds = [c.said[0] for c in claims if isinstance(c.said, tuple)]
    meant = [k for k in dict.fromkeys(kinds) if k in ("board", "bar", "block")]
    hint = "; ".join(f"a {kind}: {VOCABULARY[str(kind)].meaning}" for kind in meant)
    if only_zero:
        hint = "both hold only of what is 0"
    sure = sure and not any(c.origin.if_known for c in claims)
    severity = Severity.ERROR if sure else Severity.WARNING
    message = f"this contradicts {_quote(others, at) or _describe(given)}"
    yield Fault("contradiction", message, at.origin.source, at.node.span, hint, severity)


def _iter_given(claims: Claims, atoms: Set[Atom]) -> Iterator[Edge]:
    """Iterate over what holds whatever the model says: of solids, of each value's range."""
    ordered = sorted(atoms, key=repr)
    one_thing = not any(
        isinstance(x, PartSymbol | SetSymbol) and x.kinds == THING
        for x in claims.scope.symbols.values()
    )
    for greater, lesser, factor, sure in iter_solid_bounds(ordered, one_thing):
        yield Edge(greater, lesser, factor, sure)
    for atom in ordered:
        word = claims.scope.words.get(str(atom[0]))
        if word is None and atom[0] != "count":
            continue
        one = (ONE, DIMENSIONS[word.gives] if word is not None else Dimension.NUMBER)
        low, high = claims.ranges[atom]
        if low > 0:
            yield Edge(atom, one, low, True)
        if 0 < high < math.inf:
            yield Edge(one, atom, 1 / high, True)


def _iter_edges(claim: Claim, sure: bool, atoms: Set[Atom]) -> Iterator[Edge]:
    """Iterate over the bounds that a claim makes, by itself or by the condition that it states."""
    for bound in claim.bounds:
        edge = _edge_of(bound.half, sure, claim)
        if edge is not None:
            yield edge
    match claim.said:
        case (str() as word, (str() as one,)) | (str() as word, frozenset() as one):
            angle = (ONE, Dimension.ANGLE)
            name, limit = AT_MOST.get(word) or AT_LEAST.get(word) or ("", 0.0)
            if (name, one) in atoms:
                atom: Hashable = (name, one)
                if word in AT_MOST:
                    yield Edge(angle, atom, 1 / limit, sure, claim)
                else:
                    yield Edge(atom, angle, limit, sure, claim)
            if isinstance(one, str):
                for greater, lesser, factor, _ in iter_piece_bounds(word, one):
                    if greater in atoms and lesser in atoms:
                        yield Edge(greater, lesser, factor, sure, claim)


def _edge_of(rest: Linear, sure: bool, why: Claim) -> Edge | None:
    """Return the edge that says that a sum is not negative; None if of more than two values."""
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


def _is_one(node: Hashable) -> bool:
    return isinstance(node, tuple) and node[0] == ONE


# ------------------------------------------------------------------- twice


def find_repeats(claims: Claims, reported: set[Place]) -> Iterator[Fault]:
    """Find conditions that others say already."""
    groups: dict[Place, list[Claim]] = {}
    for claim in claims.claims:
        groups.setdefault(claim.place, []).append(claim)
    before: dict[Hashable, Claim] = {}
    for group in sorted(groups.values(), key=lambda g: not g[0].origin.required):
        first = group[0]
        # A line that does not always apply does not make another one superfluous.
        same = [
            k for k in (before.get(c.key) for c in group)
            if k is not None and (first.origin.if_known or not k.origin.if_known)
        ]  # fmt: skip
        # Who belongs to a set is not superfluous because all members do it.
        if len(same) < len(group) or (first.origin.symbol and first.of_set):
            for claim in group:
                if claim.origin.required:
                    before.setdefault(claim.key, claim)
        elif first.origin.own and first.place not in reported:
            reported.add(first.place)
            message = f"this is said already: {_quote(same, first)}"
            source, span = first.origin.source, first.node.span
            hint = "leave one of them out"
            yield Fault("said-twice", message, source, span, hint, Severity.WARNING)


# ------------------------------------------------------------------- words


def _quote(claims: Iterable[Claim], at: Claim) -> str:
    """Return other conditions as a message names them that stands at a claim."""
    said = [
        f"`{in_short(c.origin.source, c.node)}` ({_describe_place(c.origin, at.origin.source)})"
        for c in {c.place: c for c in claims}.values()
    ]
    return " and ".join(said[:MOST_NAMED])


def _describe_place(origin: Origin, seen_from: Source) -> str:
    """Name a statement by its label, or its line, and the file if another's."""
    name, line = origin.statement.place
    node = origin.statement.node
    label = node.label if isinstance(node, s.Line) else origin.symbol
    file = "" if origin.source is seen_from else f" of {name}"
    return (f"`{label}` in " if label else "") + f"line {line}{file}"


def _describe(edges: Iterable[Edge]) -> str:
    """Say what holds of every solid.

    >>> _describe([Edge(("height", "$this"), ("height", "$top"), 1.0, True)])
    'what holds of every solid: height(top) is at most height(this)'
    """
    said = [words for words in map(_describe_edge, edges) if words]
    return "what holds of every solid" + (f": {' and '.join(said)}" if said else "")


def _describe_edge(edge: Edge) -> str:
    """Return an edge in words; nothing where it names what has no name in the text."""
    greater, lesser = (_describe_measure(each) for each in (edge.greater, edge.lesser))
    for one, words, side, value in (
        (edge.greater, lesser, "most", 1.0 / edge.factor),
        (edge.lesser, greater, "least", edge.factor),
    ):
        if isinstance(one, tuple) and _is_one(one) and words:
            return f"{words} is at {side} {value:.4g}{_UNITS.get(one[1], '')}"
    if not (greater and lesser):
        return ""
    times = "" if edge.factor == 1.0 else f"{100.0 / edge.factor:.3g} % of "
    return f"{lesser} is at most {times}{greater}"


def _describe_measure(atom: Hashable) -> str:
    match atom:
        case (str() as word, str() as of):
            return f"{word}({of.lstrip('$')})"
        case (str() as word, tuple() | frozenset() as of) if all(isinstance(x, str) for x in of):
            return f"{word}({', '.join(sorted(x.lstrip('$') for x in of))})"
    return ""
