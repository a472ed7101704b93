"""What a model claims, in a form that can be compared: what lint works on."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from facetlog.grammar import syntax as s
from facetlog.grammar.lint.linear import Atom, Interval, Linear
from facetlog.grammar.resolve import Owned
from facetlog.grammar.scope import Scope
from facetlog.grammar.source import Source

__all__ = [
    "Bound",
    "Claim",
    "Claims",
    "Origin",
    "Place",
    "Region",
    "in_short",
    "where_it_stands",
]

Place: TypeAlias = tuple[int, int]
"""A condition of the text: the ids of its statement and of itself."""


@dataclass(frozen=True, slots=True, eq=False)
class Origin:
    """The statement that a claim is made in.

    `required`: the model fails without it. `own`: it is written in the model that is looked at,
    not inherited. `symbol` is the part or set whose `where` it is, or empty.
    """

    statement: Owned[s.Line] | Owned[s.Part]
    label: str
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
    """A comparison as it was met, its sides as sums.

    `low` and `high` are the ends, `tolerance` and `fading` as given. `node` stands in `source`;
    `shown` is the place in the statement itself, which is another one if a definition was used.
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
        """That of the claim that it makes, if it is one by itself."""
        return id(self.origin.statement.node), id(self.shown)

    @property
    def bounds(self) -> tuple[Bound, ...]:
        """Its ends."""
        return tuple(b for b in (self.low_bound, self.high_bound) if b is not None)

    @property
    def absolute(self) -> bool:
        """Whether metres are written in it."""
        return any(b.full.absolute for b in self.bounds)


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

    `positive` are measured values that are never zero; `steps` is how long it took to find them.
    `used` are the names that were looked up, `in_vain` those that `each` or `there` brings and
    nobody looked up in what they are brought for.
    """

    scope: Scope
    claims: tuple[Claim, ...]
    regions: tuple[Region, ...]
    ranges: Mapping[Atom, Interval]
    positive: frozenset[Atom]
    steps: int
    used: frozenset[str]
    in_vain: tuple[tuple[s.Name, Source], ...]


def in_short(source: Source, node: s.Node) -> str:
    """The text of a node on one line, cut where it is long."""
    text = " ".join(source.text[node.span.start : node.span.end].split())
    return text if len(text) <= LONGEST_QUOTE else f"{text[: LONGEST_QUOTE - 1]}…"


LONGEST_QUOTE = 60
"""Letters of a condition that is quoted: a message should be read at a glance."""


def where_it_stands(origin: Origin, seen_from: Source) -> str:
    """How a message names another statement: its label, or its line, and the file if another's."""
    name, line = origin.statement.place
    file = "" if origin.source is seen_from else f" of {name}"
    if origin.symbol:
        return f"`{origin.symbol}` in line {line}{file}"
    node = origin.statement.node
    if isinstance(node, s.Line) and node.label is not None:
        return f"`{node.label}` in line {line}{file}"
    return f"line {line}{file}"
