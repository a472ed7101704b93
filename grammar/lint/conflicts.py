"""Conditions that contradict one another, or stand there twice.

Bounds between measured values are the edges of a graph: one value is at least so many times
another. They follow one another along paths, the factors multiplied; a circle whose factors make
more than one is a contradiction.
"""

import math
from collections import deque
from collections.abc import Hashable, Iterable, Iterator, Mapping, Set
from dataclasses import dataclass, field, replace

from facetlog.grammar import syntax as s
from facetlog.grammar.checking.measures import DIMENSIONS
from facetlog.grammar.claims import Atom, Claim, Claims, Linear, Origin, Place, shorten
from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.scope import THIS, PartSymbol, SetSymbol
from facetlog.grammar.source import Source
from facetlog.grammar.units import Dimension
from facetlog.grammar.vocabulary import PIECE, THING, VOCABULARY

SolidBound = tuple[Atom, Atom, float, bool]
"""The first is at least so many times the second; whether that is sure."""

# For one face, edge or thing the first measure is at least the second. The middle of a face is as
# high as most of it in all but ragged shapes: not certain.
_OF_ONE = (
    ("top_of", "elevation", True),
    ("elevation", "bottom_of", True),
    ("top_of", "bottom_of", True),
    ("top_of", "height", True),
    ("top_of", "clear_below", True),
    ("elevation", "clear_below", False),
    ("length", "width", True),
    ("width", "thickness", True),
)

# The height of a thing is at least any height of its parts.
_HIGHEST = ("top_of", "height")
_HEIGHTS = ("top_of", "elevation", "bottom_of", "height", "clear_below")

# No two points of a thing are further apart than the corners of its box, whose longest side is its
# length.
_DIAGONAL = 1 / math.sqrt(3)
_REACHES = ("length", "width", "height", "edge_length", "protrusion", "reach_behind")

THIN, SLENDER = 0.35, 0.35
"""The thickness of a board is at most this share of its width, the width of a bar at most this of
its length (rules/vocabulary.pl)."""

AT_MOST: Mapping[str, tuple[str, float]] = {"level": ("tilt", 10.0), "convex": ("dihedral", 180.0)}
AT_LEAST: Mapping[str, tuple[str, float]] = {
    "upright": ("tilt", 80.0),
    "concave": ("dihedral", 180.0),
}
"""Conditions as bounds of an angle in degrees (rules/vocabulary.pl, docs/facts.md)."""

# Conditions of the same elements that cannot both hold, and of two in the other order.
_EXCLUDES = {
    "convex": ("concave",),
    "concave": ("convex",),
    "upward": ("downward",),
    "downward": ("upward",),
    "level": ("upright",),
    "upright": ("level",),
    "above": ("below",),
    "below": ("above",),
    "board": ("bar", "block"),
    "bar": ("board", "block"),
    "block": ("board", "bar"),
}
_ONE_WAY = frozenset({"above", "below", "underside_of", "closes", "supports"})


def iter_solid_bounds(atoms: Iterable[Atom], this_holds_all: bool) -> Iterator[SolidBound]:
    """Iterate over what holds between measured values, whatever solid they are of.

    `this_holds_all`: every element that is named belongs to the thing that is judged.
    """
    of_one: dict[Hashable, dict[str, Atom]] = {}
    for atom in atoms:
        if len(atom) == 2 and isinstance(atom[0], str) and isinstance(atom[1], str):
            of_one.setdefault(atom[1], {})[atom[0]] = atom
        elif this_holds_all and atom[0] == "shared_length":
            yield ("length", f"${THIS}"), atom, _DIAGONAL, True
    for words in of_one.values():
        for greater, lesser, sure in _OF_ONE:
            if greater in words and lesser in words:
                yield words[greater], words[lesser], 1.0, sure
    this = of_one.pop(f"${THIS}", {})
    if "top_of" in this and "height" in this:
        yield this["height"], this["top_of"], 1.0, True
    for name, words in of_one.items():
        if not this_holds_all or "." in str(name):
            continue
        for greater in _HIGHEST:
            if greater in this:
                yield from ((this[greater], words[x], 1.0, True) for x in _HEIGHTS if x in words)
        if "length" in this:
            yield from ((this["length"], words[x], _DIAGONAL, True) for x in _REACHES if x in words)


def iter_piece_bounds(word: str, of: str) -> Iterator[SolidBound]:
    """Iterate over the bounds of a piece that is a board, a bar or a block; else over nothing."""
    long, wide, thick = (("length", of), ("width", of), ("thickness", of))
    if word == "board":
        yield wide, thick, 1.0 / THIN, True
    elif word in {"bar", "block"}:
        yield thick, wide, THIN, True
    if word == "bar":
        yield long, wide, 1.0 / SLENDER, True
    elif word == "block":
        yield wide, long, SLENDER, True


def iter_excluded(key: Hashable) -> Iterator[Hashable]:
    """Iterate over the conditions that cannot hold where this one does."""
    match key:
        case ("every", of_set, inner):
            for other in iter_excluded(inner):
                yield "every", of_set, other
        case ("not", inner):
            yield inner
        case (str() as word, tuple() | frozenset() as of):
            yield "not", key
            for other in _EXCLUDES.get(word, ()):
                yield other, of
            if word in _ONE_WAY and isinstance(of, tuple) and len(of) == 2:
                yield word, (of[1], of[0])
        case _:
            yield "not", key


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
    blocks = _Blocks(claims)
    for claim, sure in claims.iter_premises():
        key = blocks.replace_level(claim.key)
        against = next((k for k in iter_excluded(key) if k in conditions), None)
        if against is not None:
            other, other_sure = conditions[against]
            yield from _report((claim, other), (), sure and other_sure, reported)
            continue
        for edge in _iter_edges(replace(claim, key=key), sure, atoms):
            factor, path = graph.find_best(edge.lesser, edge.greater)
            if factor * edge.factor <= 1 + EQUAL:
                graph.add(edge)
                continue
            # A circle of values that may be zero implies only that they are zero.
            around = {edge.greater, *(e.lesser for e in path), *(e.greater for e in path)}
            positive = any(n in claims.positive or _is_one(n) for n in around)
            certain = positive and all(e.sure for e in (edge, *path))
            involved = (claim, *(e.why for e in path if e.why is not None))
            given = tuple(e for e in path if e.why is None)
            yield from _report(involved, given, certain, reported, only_zero=not positive)
        conditions.setdefault(key, (claim, sure))


class _Blocks:
    """The parts that may be blocks: these are level on any side, and their tilt is that of one."""

    def __init__(self, claims: Claims) -> None:
        said = [claim.said for claim in claims.claims]
        self._others = {x[1] for x in said if isinstance(x, tuple) and x[0] in ("board", "bar")}
        self._symbols = claims.scope.symbols

    def replace_level(self, key: Hashable) -> Hashable:
        """Return the key of a condition, where a part that may be a block is level that of one that
        says nothing of its tilt."""
        match key:
            case ("not", inner):
                return "not", self.replace_level(inner)
            case ("every", of_set, inner):
                return "every", of_set, self.replace_level(inner)
            case ("level", (str() as one,) as of) if of not in self._others:
                symbol = self._symbols.get(one[1:])
                if not isinstance(symbol, PartSymbol | SetSymbol) or symbol.kinds == PIECE:
                    return "level on a side", of
        return key


def _report(
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
        edge = _make_edge(bound.half, sure, claim)
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


def _make_edge(rest: Linear, sure: bool, why: Claim) -> Edge | None:
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
        # A condition that defines a set is not superfluous if all its members meet it.
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
    """Return the words for other conditions in a message that stands at a claim."""
    said = [
        f"`{shorten(c.origin.source, c.node)}` ({_describe_place(c.origin, at.origin.source)})"
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
