"""The syntax tree of a model file: frozen, with the place of everything.

Names are not looked up yet: a `Reference` may be a part, a constant or a name that `each` brought.
One ladder of expressions serves conditions and measures; check.py says which is which.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any, TypeAlias, get_args

from facetlog.grammar.expressions import (
    Aggregate,
    And,
    Arithmetic,
    Call,
    Comparator,
    Comparison,
    Count,
    CountKind,
    Each,
    EachOf,
    Expression,
    Member,
    Name,
    Negative,
    Not,
    Or,
    Property,
    Quantity,
    Reference,
    Relation,
    Share,
    Text,
    There,
)
from facetlog.grammar.source import Source, Span

__all__ = [
    "Aggregate",
    "Ancestry",
    "And",
    "Arithmetic",
    "Call",
    "Comment",
    "Comparator",
    "Comparison",
    "Count",
    "CountKind",
    "Define",
    "Drop",
    "Each",
    "EachOf",
    "Example",
    "Expression",
    "File",
    "Let",
    "Line",
    "Member",
    "Model",
    "Name",
    "Negative",
    "Node",
    "Not",
    "Or",
    "Outcome",
    "Part",
    "Property",
    "Quantity",
    "Reference",
    "Relation",
    "SceneBuilt",
    "SceneFile",
    "Setting",
    "Share",
    "Size",
    "Statement",
    "Text",
    "There",
    "Use",
    "children",
    "moved",
    "walk",
]


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
class SceneFile:
    """A scene in a file, relative to the model's."""

    path: Text
    span: Span


@dataclass(frozen=True, slots=True)
class Setting:
    """One dimension of a thing to be built."""

    name: Name
    quantity: Quantity
    span: Span


@dataclass(frozen=True, slots=True)
class SceneBuilt:
    """A scene with a thing built to measure."""

    builder: Name
    settings: tuple[Setting, ...]
    span: Span


class Outcome(StrEnum):
    """What an example expects."""

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


Node: TypeAlias = (
    Name | Text | Count | Setting | SceneFile | SceneBuilt | Expression | Statement | Model
)
"""Whatever has a place."""

_LEAVES = frozenset({str, bool, float, type(None), Outcome, Ancestry, Comparator, CountKind})
"""What stands in the fields of nodes and has no place."""

_Read = Callable[[Any], Any]
_Write = Callable[[Any, Any], None]
_INNER: dict[type, tuple[tuple[_Read, bool], ...]] = {}
_SLOTS: dict[type, tuple[tuple[_Read, _Write, str], ...]] = {}


def children(node: object) -> "list[Node]":
    """The nodes directly inside a node, in the order of their fields."""
    inner = _INNER.get(node.__class__)
    if inner is None:
        slots = _slots(node.__class__)
        inner = _INNER[node.__class__] = tuple(
            (read, held == "many") for read, _, held in slots if held in ("one", "many")
        )
    found: list[Node] = []
    for read, many in inner:
        value = read(node)
        if many:
            found += value
        elif value is not None:
            found.append(value)
    return found


def walk(node: object) -> "list[Node]":
    """A node and all nodes inside it, outer ones first."""
    found: list[Node] = []
    waiting = [node]
    while waiting:
        one = waiting.pop()
        found.append(one)  # type: ignore[arg-type]
        inner = children(one)
        inner.reverse()
        waiting += inner
    return found


def moved(node: Any, by: int) -> Any:
    """A copy of a node, with all inside it, so many letters further on in its text."""
    copy = _NEW(node.__class__)
    for read, write, held in _SLOTS.get(node.__class__) or _slots(node.__class__):
        value = read(node)
        if held == "span":
            start, end = value
            if end:  # What is nowhere, as a name that was left out, stays so.
                value = _NEW_TUPLE(Span, (start + by, end + by))
        elif held == "one":
            if value is not None:
                value = moved(value, by)
        elif held == "many":
            value = tuple([moved(one, by) for one in value])
        write(copy, value)
    return copy


_NEW, _NEW_TUPLE = object.__new__, tuple.__new__  # Twice as fast as the calls that check.


def _slots(kind: Any) -> tuple[tuple[_Read, _Write, str], ...]:
    """How each field is read and, in a new copy of a frozen node, written, and what it holds.

    That is its `span`, a `leaf` without a place, `one` node or None, or `many` nodes.
    """
    found = []
    for field in fields(kind):
        slot = kind.__dict__[field.name]
        annotation = str(field.type).strip("\"'")
        if field.name in ("span", "source"):
            held = field.name
        elif annotation.startswith("tuple"):
            held = "many"
        else:
            kinds = get_args(field.type) or (field.type,)
            held = "leaf" if _LEAVES.issuperset(kinds) else "one"
        found.append((slot.__get__, slot.__set__, held))
    return _SLOTS.setdefault(kind, tuple(found))
