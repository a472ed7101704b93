"""Expressions: measures and conditions as written, on one ladder; check says which is which."""

from dataclasses import dataclass
from enum import StrEnum
from typing import TypeAlias

from facetlog.grammar.source import Span

__all__ = [
    "Aggregate",
    "And",
    "Arithmetic",
    "Call",
    "Comparator",
    "Comparison",
    "Count",
    "CountKind",
    "Each",
    "EachOf",
    "Expression",
    "Member",
    "Name",
    "Negative",
    "Not",
    "Or",
    "Property",
    "Quantity",
    "Reference",
    "Relation",
    "Share",
    "Text",
    "There",
]


@dataclass(frozen=True, slots=True)
class Name:
    """A word and its place."""

    text: str
    span: Span

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True, slots=True)
class Text:
    """A text in quotes, without them."""

    value: str
    span: Span


# ------------------------------------------------------------------ measures


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number as written, and its unit: a name, % or °."""

    number: Name
    unit: Name | None
    span: Span

    @property
    def value(self) -> float:
        """The number, in its own unit."""
        return float(self.number.text)


@dataclass(frozen=True, slots=True)
class Reference:
    """A name alone: part, set, constant, `this`, or what `each` and `there` bring."""

    name: Name
    span: Span


@dataclass(frozen=True, slots=True)
class Member:
    """A part of a part: `board.top`."""

    owner: Name
    part: Name
    span: Span


@dataclass(frozen=True, slots=True)
class Call:
    """A word of the vocabulary, or a definition, with its arguments."""

    name: Name
    arguments: tuple["Expression", ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """Two measures and a sign between them: + - * /."""

    sign: str
    left: "Expression"
    right: "Expression"
    span: Span


@dataclass(frozen=True, slots=True)
class Negative:
    """A measure with its sign turned."""

    operand: "Expression"
    span: Span


@dataclass(frozen=True, slots=True)
class Share:
    """`50 % of elevation(top)`."""

    share: Quantity
    whole: "Expression"
    span: Span


@dataclass(frozen=True, slots=True)
class Aggregate:
    """`lowest of elevation(leg)`: one value of a set's members; `how` as written."""

    how: str
    operand: "Expression"
    span: Span


# ---------------------------------------------------------------- conditions


class Comparator(StrEnum):
    """How a measure is compared."""

    EQUAL = "="
    AT_LEAST = "at least"
    AT_MOST = "at most"
    BETWEEN = "between"
    ABOUT = "about"


@dataclass(frozen=True, slots=True)
class Comparison:
    """A measure and the region that it should lie in.

    `limit` is the target, the bound or the lower bound; `second` the tolerance of `=` or the upper
    bound of `between`; `fading` how far beyond the region membership falls to nothing. One that is
    `sharp` does not fade at all.
    """

    comparator: Comparator
    measure: "Expression"
    limit: "Expression"
    second: "Expression | None"
    fading: "Expression | None"
    span: Span
    sharp: bool = False


@dataclass(frozen=True, slots=True)
class Property:
    """`top is level`, `top is not level`."""

    subject: "Expression"
    name: Name
    negated: bool
    span: Span


@dataclass(frozen=True, slots=True)
class Relation:
    """`x adjoins y`."""

    left: "Expression"
    name: Name
    right: "Expression"
    span: Span


@dataclass(frozen=True, slots=True)
class Not:
    """A condition that must not hold."""

    condition: "Expression"
    span: Span


@dataclass(frozen=True, slots=True)
class And:
    """Conditions that must all hold, joined by commas or `and`."""

    conditions: tuple["Expression", ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Or:
    """Alternatives."""

    conditions: tuple["Expression", ...]
    span: Span


class CountKind(StrEnum):
    """How many."""

    AT_LEAST = "at least"
    AT_MOST = "at most"
    EXACTLY = "exactly"
    BETWEEN = "between"
    ANY = "any number of"


@dataclass(frozen=True, slots=True)
class Count:
    """How many members there must be; numbers as written."""

    kind: CountKind
    low: Name | None
    high: Name | None
    span: Span

    @property
    def any_number(self) -> bool:
        """Whether there may be none, or as many as there are."""
        open_above = self.kind in (CountKind.AT_LEAST, CountKind.ANY)
        return open_above and self.least == 0

    @property
    def least(self) -> float:
        """The fewest members there may be: a whole number wherever the text has no fault."""
        if self.low is None or self.kind is CountKind.AT_MOST:
            return 0.0
        return float(self.low.text)


@dataclass(frozen=True, slots=True)
class Each:
    """Every member of a set, or every face (edge, ...) of the thing that satisfies `where`.

    `kind` is None for a set; the set's name is then also that of the member.
    """

    kind: Name | None
    name: Name
    where: "Expression | None"
    body: "Expression"
    span: Span


@dataclass(frozen=True, slots=True)
class EachOf:
    """Every one (one name) or every two (two names) of some parts, or of a set."""

    names: tuple[Name, ...]
    of: tuple[Name, ...]
    body: "Expression"
    span: Span


@dataclass(frozen=True, slots=True)
class There:
    """There is a face such that; `count` None and `some` false: there is none."""

    some: bool
    count: Count | None
    kind: Name
    name: Name
    of: tuple[Name, ...]
    where: "Expression | None"
    span: Span


Expression: TypeAlias = (
    Quantity
    | Reference
    | Member
    | Call
    | Arithmetic
    | Negative
    | Share
    | Aggregate
    | Comparison
    | Property
    | Relation
    | Not
    | And
    | Or
    | Each
    | EachOf
    | There
)
