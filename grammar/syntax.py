"""The syntax tree of a model file: frozen, with the place of everything.

Names are not looked up yet: a `Reference` may be a part, a constant or a name that `each` brought.
One ladder of expressions serves conditions and measures; check.py says which is which.
"""

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import TypeAlias

from facetlog.grammar.source import Source, Span


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
    def least(self) -> float:
        """The fewest members there may be: a whole number wherever the text has no fault."""
        if self.low is None or self.kind is CountKind.AT_MOST:
            return 0.0
        return float(self.low.text)

    @property
    def most(self) -> float:
        """The greatest number of members there may be."""
        if self.high is None or self.kind in (CountKind.AT_LEAST, CountKind.ANY):
            return math.inf
        return float(self.high.text)


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


@dataclass(frozen=True, slots=True)
class Comment:
    """A comment from its # to the end of the line; `alone` if nothing stands before it."""

    text: str
    span: Span
    alone: bool


# ---------------------------------------------------------------- statements


@dataclass(frozen=True, slots=True)
class Use:
    """Another file: of models, or of Prolog with words of the user's own."""

    path: Text
    span: Span


@dataclass(frozen=True, slots=True)
class Let:
    """A constant."""

    name: Name
    value: Expression
    doc: Text | None
    span: Span


@dataclass(frozen=True, slots=True)
class Define:
    """A condition or measure with a name and parameters."""

    name: Name
    parameters: tuple[Name, ...]
    body: Expression
    doc: Text | None
    span: Span


@dataclass(frozen=True, slots=True)
class Part:
    """Singular parts (`count` None), or a set of all that satisfy `where`.

    `kind` as written: face, faces, edge, ... or the name of a model.
    """

    optional: bool
    count: Count | None
    separate: bool
    kind: Name
    names: tuple[Name, ...]
    where: Expression | None
    reason: Text | None
    span: Span


@dataclass(frozen=True, slots=True)
class Line:
    """One line of conditions.

    `expect` is the weight as written ("weakly", "", "30 %"), None if the line must hold.
    """

    label: Name | None
    expect: str | None
    if_known: bool
    condition: Expression
    reason: Text | None
    span: Span


@dataclass(frozen=True, slots=True)
class Drop:
    """Lines of a `like` model that are left out."""

    labels: tuple[Name, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Size:
    """Lengths that the verdict reports; sorted by value if `longest_first`."""

    names: tuple[Name, ...]
    measures: tuple[Expression, ...]
    longest_first: bool
    span: Span


@dataclass(frozen=True, slots=True)
class Stated:
    """An option for reading a file, as written: `up z`, `sensor "0,-1,2"`."""

    name: Name
    value: Text
    span: Span


@dataclass(frozen=True, slots=True)
class SceneFile:
    """A scene, mesh or cloud in a file, relative to the model's, and what the file does not say."""

    path: Text
    stated: tuple[Stated, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Setting:
    """One dimension of a thing to be built."""

    name: Name
    quantity: Quantity
    span: Span


@dataclass(frozen=True, slots=True)
class Solid:
    """A solid built to measure."""

    builder: Name
    settings: tuple[Setting, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class SceneBuilt:
    """A scene with one thing, built of one solid or of several."""

    solids: tuple[Solid, ...]
    span: Span


class Outcome(StrEnum):
    """The outcome that an example expects."""

    HOLDS = "holds"
    FAILS = "fails"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Example:
    """A scene and what the model should say of it."""

    title: Text
    scene: SceneFile | SceneBuilt
    outcome: Outcome
    at_least: Quantity | None
    because: tuple[Name, ...]
    span: Span


Statement: TypeAlias = Use | Let | Define | Part | Line | Drop | Size | Example


class Ancestry(StrEnum):
    """How a model follows from another: it adds lines only, or it starts from its lines."""

    IS = "is"
    LIKE = "like"


@dataclass(frozen=True, slots=True)
class Model:
    """A model as written; `span` is that of its first line.

    `rather_than` are the models whose names stand after its own where both hold.
    """

    name: Name
    ancestry: Ancestry | None
    parent: Name | None
    rather_than: tuple[Name, ...]
    doc: Text | None
    statements: tuple[Statement, ...]
    span: Span

    @property
    def parts(self) -> tuple[Part, ...]:
        """The statements that declare parts."""
        return tuple(s for s in self.statements if isinstance(s, Part))

    @property
    def lines(self) -> tuple[Line, ...]:
        """The lines of conditions."""
        return tuple(s for s in self.statements if isinstance(s, Line))

    @property
    def examples(self) -> tuple[Example, ...]:
        """The examples."""
        return tuple(s for s in self.statements if isinstance(s, Example))


@dataclass(frozen=True, slots=True)
class File:
    """A file as written: what stands before the first model, and the models."""

    source: Source
    statements: tuple[Statement, ...]
    models: tuple[Model, ...]
    comments: tuple[Comment, ...]

    @property
    def uses(self) -> tuple[Use, ...]:
        """The files that it uses, wherever that is said."""
        own = tuple(s for s in self.statements if isinstance(s, Use))
        return own + tuple(s for m in self.models for s in m.statements if isinstance(s, Use))
