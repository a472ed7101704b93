"""What a model asks for and what it gives, in short: to see quickly which cannot imply which."""

from collections.abc import Hashable, Iterator
from dataclasses import dataclass

from facetlog.grammar.lint.bound_graph import EQUAL, ONE, Edge, edge_of
from facetlog.grammar.lint.claims import Claim
from facetlog.grammar.lint.knowledge import Knowledge
from facetlog.grammar.lint.solids import IMPLIES
from facetlog.grammar.scope import PartSymbol, SetSymbol

__all__ = ["Given", "Needed", "Required", "brief_of"]

# Measures that bound one another; what one must be may follow from what another must be.
_SIZES = frozenset({
    "length", "width", "height", "elevation", "top_of", "bottom_of", "clear_below", "protrusion",
    "reach_behind", "edge_length", "shared_length", "offset",
})  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Needed:
    """A claim that must follow; `edges` are its bounds, None if they cannot be edges."""

    claim: Claim
    edges: tuple[Edge, ...] | None


@dataclass(frozen=True, slots=True, eq=False)
class Required:
    """What a model asks for.

    `whole`: it speaks of all other elements, so that its parts must be all of the other's.
    `shapes` are those of its claims, `strengths` how much one measure must be.
    """

    known: Knowledge
    needed: tuple[Needed, ...]
    parts: tuple[PartSymbol, ...]
    sets: tuple[SetSymbol, ...]
    whole: bool
    shapes: frozenset[Hashable]
    strengths: tuple[tuple[Hashable, float], ...]

    @property
    def name(self) -> str:
        """The model's name."""
        return self.known.claims.scope.model.name


@dataclass(frozen=True, slots=True, eq=False)
class Given:
    """What follows from a model, in short."""

    shapes: frozenset[Hashable]
    strengths: dict[Hashable, float]

    def may_imply(self, required: Required) -> bool:
        """Whether a model may follow: no if a shape is missing or a bound is too weak."""
        return required.shapes <= self.shapes and all(
            self.strengths.get(of, 0.0) >= factor * (1 - EQUAL) for of, factor in required.strengths
        )


def brief_of(known: Knowledge) -> "tuple[Required | None, Given]":
    """What a model asks for (None if that cannot be compared) and gives; worked out once."""
    if not isinstance(known.brief, tuple):
        known.brief = required_of(known), given_by(known)
    return known.brief


def required_of(known: Knowledge) -> Required | None:
    """What a model asks for; None if that cannot be compared."""
    scope = known.claims.scope
    claims = [c for c in known.claims.claims if c.origin.required]
    optional = {p.name for p in scope.singular if p.owned.node.optional}
    optional |= {x.name for x in scope.sets if x.owned.node.optional}
    if known.contradictions or any(c.parts & optional for c in claims):
        return None
    needed = [Needed(c, _bounds(c, known)) for c in claims if not (c.origin.symbol and c.of_set)]
    parts = tuple(p for p in scope.singular if p.name not in optional)
    sets = tuple(x for x in scope.sets if x.name not in optional)
    whole = bool(sets) or any(_quantified(n.claim.key) for n in needed)
    shapes = frozenset(_shape(n.claim) for n in needed)
    strengths = {of: k for n in needed for e in n.edges or () for of, k in _strength(e)}
    return Required(known, tuple(needed), parts, sets, whole, shapes, tuple(strengths.items()))


def _bounds(claim: Claim, known: Knowledge) -> tuple[Edge, ...] | None:
    found = []
    for bound in claim.bounds:
        if bound.full.interval(known.claims.ranges)[0] < 0:
            edge = edge_of(bound.full, True, None)
            if edge is None:
                return None
            found.append(edge)
    return tuple(found) if claim.bounds else None


def given_by(known: Knowledge) -> Given:
    """What follows from a model, in short."""
    shapes: set[Hashable] = set()
    for claim, _ in known.conditions.values():
        shapes.add(_shape(claim))
        match claim.said:
            case (str() as word, _) if word in IMPLIES:
                shapes |= {("bare", other) for other in IMPLIES[word]}
    strengths: dict[Hashable, float] = {}
    for edges in known.graph.edges.values():
        for edge in edges:
            for of, factor in _strength(edge):
                strengths[of] = max(factor, strengths.get(of, 0.0))
    return Given(frozenset(shapes), strengths)


def _strength(edge: Edge) -> Iterator[tuple[Hashable, float]]:
    """How strongly one measure is bounded by a number from below or above."""
    ends = ((edge.greater, edge.lesser, "low"), (edge.lesser, edge.greater, "high"))
    for value, other, side in ends:
        if isinstance(other, tuple) and other[0] == ONE and isinstance(value, tuple):
            yield (side, value[0]), edge.factor


def _shape(claim: Claim) -> Hashable:
    """What a claim has in common with all from which it can follow."""
    if claim.bounds:
        words = {str(atom[0]) for b in claim.bounds for atom in b.full.terms}
        return "sizes" if words & _SIZES else ("bound", frozenset(words))
    match claim.said:
        case (str() as word, tuple() | frozenset()):
            return "bare", word
        case _:
            return _bare(claim.said)


def _bare(key: Hashable) -> Hashable:
    """A form without the names of parts."""
    if isinstance(key, str):
        return "$" if key.startswith("$") else key
    if isinstance(key, tuple):
        return tuple(map(_bare, key))
    if isinstance(key, frozenset):
        return "of", frozenset(map(_bare, key))
    return key


def _quantified(key: Hashable) -> bool:
    if isinstance(key, tuple | frozenset):
        return any(map(_quantified, key))
    return key in ("each", "there", "count")
