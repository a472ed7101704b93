"""Conditions of a model in a normal form: equal forms say the same."""

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from facetlog.grammar import syntax as s
from facetlog.grammar.resolve import Owned
from facetlog.grammar.scope import PartSymbol, Scope, SetSymbol
from facetlog.grammar.source import Source
from facetlog.grammar.traversal import Node
from facetlog.grammar.units import Dimension

Atom: TypeAlias = tuple[Hashable, ...]
"""One measured value: the word, and what it is measured of."""

Interval: TypeAlias = tuple[float, float]
"""Least and greatest value."""


DIGITS = 12
"""Significant digits of a factor; what differs behind them differs by rounding."""


@dataclass(frozen=True, slots=True)
class Linear:
    """A constant and multiples of measured values, all of one dimension."""

    constant: float
    terms: Mapping[Atom, float]
    dimension: Dimension

    @property
    def key(self) -> Hashable:
        """Equal for equal sums."""
        return _round(self.constant), frozenset((a, _round(c)) for a, c in self.terms.items())

    @property
    def is_constant(self) -> bool:
        """Whether nothing is measured."""
        return not self.terms

    def times(self, factor: float, dimension: Dimension | None = None) -> "Linear":
        """Return the sum multiplied by a number."""
        terms = {a: _round(c * factor) for a, c in self.terms.items()} if factor else {}
        return Linear(_round(self.constant * factor), terms, dimension or self.dimension)

    def plus(self, other: "Linear", factor: float = 1.0) -> "Linear":
        """Return the sum with so many times another; terms that cancel are left out."""
        terms = dict(self.terms)
        for atom, coefficient in other.terms.items():
            value = _round(terms.get(atom, 0.0) + factor * coefficient)
            if value:
                terms[atom] = value
            else:
                terms.pop(atom, None)
        return Linear(_round(self.constant + factor * other.constant), terms, self.dimension)

    def interval(self, ranges: Mapping[Atom, Interval]) -> Interval:
        """Return its least and greatest value, from those of what is measured."""
        low = high = self.constant
        for atom, coefficient in self.terms.items():
            least, most = ranges[atom]
            if coefficient < 0:
                least, most = most, least
            low += coefficient * least
            high += coefficient * most
        return low, high


def _round(value: float) -> float:
    return float(f"{value:.{DIGITS}g}") if value % 1 else value


Place: TypeAlias = tuple[int, int]
"""A condition of the text: the ids of its statement and of itself."""

LONGEST_QUOTE = 60
"""Letters of a condition that is quoted: a message should be read at a glance."""


@dataclass(frozen=True, slots=True, eq=False)
class Origin:
    """The statement that a claim is made in.

    `required`: the model fails without it. `own`: it is written in the model that is checked, not
    inherited. `symbol` is the part or set whose `where` it is, or empty.
    """

    statement: Owned[s.Line] | Owned[s.Part]
    required: bool
    if_known: bool
    own: bool
    symbol: str = ""

    @property
    def source(self) -> Source:
        """The text that it stands in."""
        return self.statement.source


@dataclass(frozen=True, slots=True)
class Bound:
    """One end of a region: `full` is not negative within it.

    `half` is not negative where membership is at least one half: a condition of degree 1/2 needs
    the measured value to lie there. Both are the same without `fading`.
    """

    full: Linear
    half: Linear


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """A comparison with its sides as sums and its ends, `tolerance` and `fading` as given.

    `node` stands in `source`; `shown` is the place in the statement itself, which is another one
    if a definition was used.
    """

    node: s.Comparison
    source: Source
    own: bool
    shown: s.Expression
    origin: Origin
    measure: Linear
    low: Linear | None
    high: Linear | None
    tolerance: Linear | None
    fading: Linear | None
    low_bound: Bound | None
    high_bound: Bound | None

    @property
    def place(self) -> Place:
        """The place of the claim that it makes, if it is one by itself."""
        return id(self.origin.statement.node), id(self.shown)

    @property
    def bounds(self) -> tuple[Bound, ...]:
        """Its ends."""
        return tuple(b for b in (self.low_bound, self.high_bound) if b is not None)


@dataclass(frozen=True, slots=True, eq=False)
class Claim:
    """One condition that cannot be taken apart, said of certain parts.

    Equal claims have equal keys. `parts` are the parts and sets that it names. `of_set` is the set
    of whose every member it is said, or that it says who belongs to.
    """

    key: Hashable
    node: s.Expression
    origin: Origin
    parts: frozenset[str]
    bounds: tuple[Bound, ...] = ()
    of_set: str = ""

    @property
    def said(self) -> Hashable:
        """The form of the condition itself, without the set of whose members it is said."""
        match self.key:
            case ("every", _, inner):
                return inner
            case _:
                return self.key

    @property
    def place(self) -> Place:
        """Equal for what one condition of the text says of different parts."""
        return id(self.origin.statement.node), id(self.node)


@dataclass(frozen=True, slots=True, eq=False)
class Claims:
    """All claims of a model, its comparisons, and the range of each measured value.

    `positive` are measured values that are never zero. `used` are the names that were looked up,
    `sizes` the measures of each size, `in_vain` the names that `each` or `there` introduces and
    that nothing refers to.
    """

    scope: Scope
    claims: tuple[Claim, ...]
    regions: tuple[Region, ...]
    ranges: Mapping[Atom, Interval]
    positive: frozenset[Atom]
    used: frozenset[str]
    sizes: tuple[tuple[Linear, ...], ...]
    in_vain: tuple[tuple[s.Name, Source], ...]

    def iter_premises(self) -> Iterator[tuple[Claim, bool]]:
        """Iterate over the claims that hold where the model does, and whether that is sure.

        Lines that name an optional part do not apply where it is absent. Of a set's members
        something follows only if there must be one, and then not surely: a member counts from a
        degree of 1/2, at which nothing need be so of it.
        """
        parts = {
            n: x.owned.node
            for n, x in self.scope.symbols.items()
            if isinstance(x, PartSymbol | SetSymbol)
        }
        optional = {name for name, node in parts.items() if node.optional}
        for claim in self.claims:
            if not claim.origin.required or claim.parts & optional:
                continue
            if not claim.of_set:
                yield claim, True
            elif (count := parts[claim.of_set].count) is not None and count.least > 0:
                yield claim, False


def shorten(source: Source, node: Node) -> str:
    """Return the text of a node on one line, cut where it is long."""
    text = " ".join(source.text[node.span.start : node.span.end].split())
    return text if len(text) <= LONGEST_QUOTE else f"{text[: LONGEST_QUOTE - 1]}…"
