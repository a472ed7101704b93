"""Facts as terms, and the kinds of their arguments."""

from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

Value = str | int | float


class Fact(NamedTuple):
    """A ground, flat term: strings are atoms, whole numbers integers, all else floats.

    >>> str(Fact("area", ("f1", 2.0, 0.01)))
    'area(f1, 2.0, 0.01)'
    """

    functor: str
    args: tuple[Value, ...]

    def __str__(self) -> str:
        return f"{self.functor}({', '.join(str(a) for a in self.args)})"

    @property
    def row(self) -> tuple[Value, ...]:
        """Functor and arguments in one tuple, as the knowledge base takes facts."""
        return (self.functor, *self.args)


class ArgumentKind(StrEnum):
    """The kind of an argument, and its unit."""

    TEXT = "text"
    SYMBOL = "symbol"
    VIEW = "view"
    VERTEX = "vertex"
    EDGE = "edge"
    FACE = "face"
    THING = "thing"
    PIECE = "piece"
    OPENING = "opening"
    HOLLOW = "hollow"
    HOLE = "opening or hollow"
    JUNCTION = "junction"
    PART = "face or edge"
    LEVEL = "face or piece"
    SOLID = "piece, opening or hollow"
    BODY = "face, edge or thing"
    COUNT = "count"
    NUMBER = "number"
    SHARE = "share"
    DEGREES = "deg"
    LENGTH = "length"
    AREA = "length²"
    PIXELS = "px"

    @property
    def is_atom(self) -> bool:
        """Whether the argument is an atom; otherwise it is a number."""
        return self not in _NUMBERS

    @property
    def is_name(self) -> bool:
        """Whether the argument names something of the scene."""
        return self.is_atom and self not in (ArgumentKind.TEXT, ArgumentKind.SYMBOL)


_NUMBERS = frozenset(
    {
        ArgumentKind.COUNT,
        ArgumentKind.NUMBER,
        ArgumentKind.SHARE,
        ArgumentKind.DEGREES,
        ArgumentKind.LENGTH,
        ArgumentKind.AREA,
        ArgumentKind.PIXELS,
    }
)


class Solutions(StrEnum):
    """How many facts there are for given keys (different ones, where they are of one kind)."""

    ONE = "det"
    AT_MOST_ONE = "semidet"
    ANY = "nondet"


@dataclass(frozen=True, slots=True)
class Argument:
    """Name and kind of one argument."""

    name: str
    kind: ArgumentKind


@dataclass(frozen=True, slots=True)
class FactKind:
    """One functor: its arguments, of which the first `keys` are what a question starts from.

    Facts `on_demand` are worked out only for who asks for them by name.
    """

    functor: str
    arguments: tuple[Argument, ...]
    keys: int
    solutions: Solutions
    meaning: str
    absent: str = ""
    on_demand: bool = False

    @property
    def arity(self) -> int:
        """Number of arguments."""
        return len(self.arguments)


def parse_fact_kind(
    text: str, solutions: Solutions, meaning: str, absent: str = "", *, on_demand: bool = False
) -> FactKind:
    """Return a kind from "functor +Key:kind Name:kind ...", in the manner of a mode line."""
    functor, *words = text.split()
    arguments = []
    for word in words:
        name, _, kind = word.lstrip("+").partition(":")
        arguments.append(Argument(name, _SHORT[kind]))
    keys = sum(word.startswith("+") for word in words)
    return FactKind(functor, tuple(arguments), keys, solutions, meaning, absent, on_demand)


_SHORT = {kind.name.lower(): kind for kind in ArgumentKind} | {
    "deg": ArgumentKind.DEGREES,
    "px": ArgumentKind.PIXELS,
}
