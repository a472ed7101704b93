"""What follows from a model: bounds in a graph, conditions by their forms, and contradictions."""

import math
from collections.abc import Hashable, Iterable, Iterator, Set
from dataclasses import dataclass, field

from facetlog.grammar.checking.types import DIMENSIONS
from facetlog.grammar.lint.bound_graph import EQUAL, ONE, Edge, Graph, edge_of, is_one
from facetlog.grammar.lint.claims import Claim, Claims
from facetlog.grammar.lint.linear import Atom
from facetlog.grammar.lint.premises import premises
from facetlog.grammar.lint.solids import excluded, solid_bounds
from facetlog.grammar.scope import PartSymbol, SetSymbol
from facetlog.grammar.units import Dimension
from facetlog.grammar.vocabulary import THING

__all__ = ["Contradiction", "Knowledge", "knowledge_of"]

# `level` and `upright` as bounds of the tilt in degrees (rules/vocabulary.pl).
_TILT_AT_MOST = {"level": 10.0}
_TILT_AT_LEAST = {"upright": 80.0}


@dataclass(frozen=True, slots=True)
class Contradiction:
    """A claim and others that cannot all hold; `only_zero` if they can where all measures are 0."""

    claims: tuple[Claim, ...]
    sure: bool
    only_zero: bool = False


@dataclass(slots=True)
class Knowledge:
    """What a model says that must hold, without what contradicts what came before it."""

    claims: Claims
    graph: Graph = field(default_factory=Graph)
    conditions: dict[Hashable, tuple[Claim, bool]] = field(default_factory=dict)
    contradictions: list[Contradiction] = field(default_factory=list)

    def follows(
        self, claim: Claim, without: Iterable[object] = (), *, if_known: bool = True
    ) -> tuple[Claim, ...] | None:
        """The claims from which all bounds of a claim follow; None if they do not.

        `without` are claims that are not to be used. Unless `if_known`, neither are lines that are
        not asked where something is not known.
        """
        found: list[Claim] = []
        for bound in claim.bounds:
            if bound.full.interval(self.claims.ranges)[0] >= 0:
                continue
            edge = edge_of(bound.full, True, None)
            if edge is None:
                return None
            factor, path = self.graph.best(edge.greater, edge.lesser, without)
            if factor < edge.factor * (1 - EQUAL):
                return None
            found += claims_on(path)
        if not if_known and any(c.origin.if_known for c in found):
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
        for edge in _edges(claim, sure, atoms):
            self._add(claim, edge)
        self.conditions.setdefault(claim.key, (claim, sure))

    def _add(self, claim: Claim, edge: Edge) -> None:
        factor, path = self.graph.best(edge.lesser, edge.greater)
        if factor * edge.factor <= 1 + EQUAL:
            self.graph.add(edge)
            return
        # Of values that may be zero a circle says only that they are.
        around = {edge.greater, *(e.lesser for e in path), *(e.greater for e in path)}
        positive = any(n in self.claims.positive or is_one(n) for n in around)
        sure = edge.sure and all(e.sure for e in path)
        found = Contradiction((claim, *claims_on(path)), sure and positive, not positive)
        self.contradictions.append(found)


def knowledge_of(claims: Claims) -> Knowledge:
    """What follows from a model: its claims one after another, on top of what is always so."""
    found = Knowledge(claims)
    atoms = {atom for c in claims.claims for b in c.bounds for atom in b.half.terms}
    for edge in _given(claims, sorted(atoms, key=repr)):
        found.graph.add(edge)
    for claim, sure in premises(claims):
        found.add(claim, sure, atoms)
    return found


def claims_on(path: Iterable[Edge]) -> list[Claim]:
    """The claims that the edges of a path come from."""
    return [e.why for e in path if isinstance(e.why, Claim)]


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
    for bound in claim.bounds:
        edge = edge_of(bound.half, sure, claim)
        if edge is not None:
            yield edge
    match claim.said:
        case (str() as word, (str() as of,)) if ("tilt", of) in atoms:
            one = (ONE, Dimension.ANGLE)
            if word in _TILT_AT_MOST:
                yield Edge(one, ("tilt", of), 1 / _TILT_AT_MOST[word], sure, claim)
            elif word in _TILT_AT_LEAST:
                yield Edge(("tilt", of), one, _TILT_AT_LEAST[word], sure, claim)
