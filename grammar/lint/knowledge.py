"""What follows from a model: bounds in a graph, conditions by their forms, and contradictions."""

import math
from collections import deque
from collections.abc import Hashable, Iterable, Iterator, Mapping, Set
from dataclasses import dataclass, field

from facetlog.grammar.checking.types import DIMENSIONS
from facetlog.grammar.lint.bound_graph import EQUAL, ONE, Edge, Graph, edge_of, is_one
from facetlog.grammar.lint.claims import Claim, Claims
from facetlog.grammar.lint.linear import Atom
from facetlog.grammar.lint.premises import premises
from facetlog.grammar.lint.solids import (
    HIGHER,
    THROUGH_AT_LEAST,
    THROUGH_AT_MOST,
    TILT_AT_LEAST,
    TILT_AT_MOST,
    excluded,
    piece_bounds,
    solid_bounds,
)
from facetlog.grammar.scope import PartSymbol, SetSymbol
from facetlog.grammar.units import Dimension
from facetlog.grammar.vocabulary import THING

__all__ = ["Contradiction", "Knowledge", "claims_on", "given_on", "knowledge_of"]


@dataclass(frozen=True, slots=True)
class Contradiction:
    """A claim and others that cannot all hold; `only_zero` if they can where all measures are 0.

    `given` is what holds of every solid, by which they cannot.
    """

    claims: tuple[Claim, ...]
    sure: bool
    only_zero: bool = False
    given: tuple[Edge, ...] = ()


@dataclass(slots=True)
class Knowledge:
    """What a model says that must hold, without what contradicts what came before it.

    `brief` is the same in short (`briefs.brief_of`), once it was wanted.
    """

    claims: Claims
    graph: Graph = field(default_factory=Graph)
    conditions: dict[Hashable, tuple[Claim, bool]] = field(default_factory=dict)
    contradictions: list[Contradiction] = field(default_factory=list)
    brief: object = None
    heights: dict[str, list[tuple[str, Claim, bool]]] = field(default_factory=dict)

    def follows(
        self, claim: Claim, without: Iterable[object] = (), *, if_known: bool = True
    ) -> tuple[Edge, ...] | None:
        """The edges from which all bounds of a claim follow; None if they do not.

        `without` are claims that are not to be used. Unless `if_known`, neither are lines that are
        without effect where something is not known.
        """
        found: list[Edge] = []
        for bound in claim.bounds:
            if bound.full.interval(self.claims.ranges)[0] >= 0:
                continue
            edge = edge_of(bound.full, True, None)
            if edge is None:
                return None
            factor, path = self.graph.best(edge.greater, edge.lesser, without)
            if factor < edge.factor * (1 - EQUAL):
                return None
            found += path
        if not if_known and any(c.origin.if_known for c in claims_on(found)):
            return None
        return tuple(dict.fromkeys(found))

    def add(self, claim: Claim, sure: bool, atoms: Set[Atom]) -> None:
        """Adds a claim, or notes what it contradicts."""
        against = next((k for k in excluded(claim.key) if k in self.conditions), None)
        if against is not None:
            other, other_sure = self.conditions[against]
            found = Contradiction((claim, other), sure and other_sure)
            self.contradictions.append(found)
            return
        if not self._stack(claim, sure):
            return
        for edge in _edges(claim, sure, atoms):
            self._add(claim, edge)
        self.conditions.setdefault(claim.key, (claim, sure))

    def _stack(self, claim: Claim, sure: bool) -> bool:
        """Notes what is higher than what; False if that would make a circle, which is noted."""
        match claim.said:
            case (str() as word, (str() as one, str() as other)) if word in HIGHER:
                both = one, other
                upper, lower = (both[i] for i in HIGHER[word])
            case _:
                return True
        around = self._downward(lower, upper)
        if around:
            claims = tuple(dict.fromkeys((claim, *(c for c, _ in around))))
            certain = sure and all(x for _, x in around)
            self.contradictions.append(Contradiction(claims, certain))
            return False
        self.heights.setdefault(upper, []).append((lower, claim, sure))
        return True

    def _downward(self, upper: str, lower: str) -> tuple[tuple[Claim, bool], ...]:
        """The claims by which one is higher than another, directly or not; nothing if none say."""
        came: dict[str, tuple[tuple[Claim, bool], ...]] = {upper: ()}
        waiting = deque([upper])
        while waiting:
            at = waiting.popleft()
            for below, claim, sure in self.heights.get(at, ()):
                if below not in came:
                    came[below] = (*came[at], (claim, sure))
                    waiting.append(below)
        return came.get(lower, ())

    def _add(self, claim: Claim, edge: Edge) -> None:
        factor, path = self.graph.best(edge.lesser, edge.greater)
        if factor * edge.factor <= 1 + EQUAL:
            self.graph.add(edge)
            return
        # Of values that may be zero a circle says only that they are.
        around = {edge.greater, *(e.lesser for e in path), *(e.greater for e in path)}
        positive = any(n in self.claims.positive or is_one(n) for n in around)
        sure = edge.sure and all(e.sure for e in path)
        claims = (claim, *claims_on(path))
        found = Contradiction(claims, sure and positive, not positive, given_on(path))
        self.contradictions.append(found)


def knowledge_of(claims: Claims) -> Knowledge:
    """What follows from a model: its claims one after another, on top of what is always so."""
    found = Knowledge(claims)
    atoms = {atom for c in claims.claims for b in c.bounds for atom in b.half.terms}
    for edge in _given(claims, sorted(atoms, key=repr)):
        found.graph.add(edge)
    for claim, sure in premises(claims):
        found.add(claim, sure, atoms)
    found.contradictions.extend(_too_large(found, atoms))
    return found


def _too_large(known: Knowledge, atoms: Set[Atom]) -> Iterator[Contradiction]:
    """Areas that are larger than the longest sides allow: no face is larger than its rectangle."""
    one, one_area = (ONE, Dimension.LENGTH), (ONE, Dimension.AREA)
    for atom in sorted((a for a in atoms if a[0] == "area"), key=repr):
        least, path = known.graph.best(atom, one_area)
        long, by_length = known.graph.best(one, ("length", *atom[1:]))
        wide, by_width = known.graph.best(one, ("width", *atom[1:]))
        if wide < long:
            wide, by_width = long, by_length  # the width is no more than the length
        edges = (*path, *by_length, *by_width)
        if least * long * wide > 1 + EQUAL and claims_on(edges):
            yield Contradiction(tuple(dict.fromkeys(claims_on(edges))), all(e.sure for e in edges))


def claims_on(path: Iterable[Edge]) -> list[Claim]:
    """The claims that the edges of a path come from."""
    return [e.why for e in path if isinstance(e.why, Claim)]


def given_on(path: Iterable[Edge]) -> tuple[Edge, ...]:
    """The edges of a path that hold of every solid."""
    return tuple(e for e in path if not isinstance(e.why, Claim))


def _given(claims: Claims, atoms: list[Atom]) -> Iterator[Edge]:
    """What holds whatever the model says: of solids, of each value's range, of sets' numbers."""
    one_thing = not any(
        isinstance(x, PartSymbol | SetSymbol) and x.kinds == THING
        for x in claims.scope.symbols.values()
    )
    for greater, lesser, factor, sure in solid_bounds(atoms, one_thing):
        yield Edge(greater, lesser, factor, sure)
    for atom in atoms:
        word = claims.scope.words.get(str(atom[0]))
        if word is None and atom[0] != "count":
            continue
        one = (ONE, DIMENSIONS[word.gives] if word is not None else Dimension.NUMBER)
        low, high = claims.ranges[atom]
        if low > 0:
            yield Edge(atom, one, low, True)
        if 0 < high < math.inf:
            yield Edge(one, atom, 1 / high, True)


def _edges(claim: Claim, sure: bool, atoms: Set[Atom]) -> Iterator[Edge]:
    """The bounds that a claim makes, those of the condition that it says among them."""
    for edge in _bounds(claim, sure, atoms):
        yield Edge(edge.greater, edge.lesser, edge.factor, sure, claim)


def _angle_edges(
    word: str,
    atom: Atom,
    at_most: Mapping[str, float],
    at_least: Mapping[str, float],
    atoms: Set[Atom],
) -> Iterator[Edge]:
    one = (ONE, Dimension.ANGLE)
    if atom in atoms and word in at_most:
        yield Edge(one, atom, 1 / at_most[word], True)
    elif atom in atoms and word in at_least:
        yield Edge(atom, one, at_least[word], True)


def _bounds(claim: Claim, sure: bool, atoms: Set[Atom]) -> Iterator[Edge]:
    for bound in claim.bounds:
        edge = edge_of(bound.half, sure, claim)
        if edge is not None:
            yield edge
    match claim.said:
        case (str() as word, (str() as of,)):
            yield from _angle_edges(word, ("tilt", of), TILT_AT_MOST, TILT_AT_LEAST, atoms)
            for greater, lesser, factor, certain in piece_bounds(word, of):
                if greater in atoms and lesser in atoms:
                    yield Edge(greater, lesser, factor, certain)
        case (str() as word, frozenset() as pair):
            through = ("dihedral", pair)
            yield from _angle_edges(word, through, THROUGH_AT_MOST, THROUGH_AT_LEAST, atoms)
