"""What an expression can be: a condition, an element, or a measure of some dimension."""

from dataclasses import dataclass
from typing import TypeAlias

from facetlog.grammar.units import Dimension
from facetlog.grammar.vocabulary import Gives, Kind, Kinds


@dataclass(frozen=True, slots=True)
class Condition:
    """The type of what holds or fails."""

    def __str__(self) -> str:
        return "a condition"


@dataclass(frozen=True, slots=True)
class Element:
    """The type of what is a face, an edge, a vertex or a thing."""

    kinds: Kinds
    model: str = ""

    def __str__(self) -> str:
        names = sorted(self.kinds)
        return " or ".join(("an " if n[0] in "aeiou" else "a ") + n for n in names)


CONDITION = Condition()
Type: TypeAlias = Condition | Element | Dimension

DIMENSIONS = {
    Gives.ANGLE: Dimension.ANGLE,
    Gives.LENGTH: Dimension.LENGTH,
    Gives.AREA: Dimension.AREA,
    Gives.RATIO: Dimension.NUMBER,
    Gives.COUNT: Dimension.NUMBER,
}

EVERY = frozenset(Kind)
"""What the parameter of a definition may be, as long as nobody names it."""


def unit_hint(left: Dimension, right: Dimension) -> str:
    if Dimension.NUMBER not in (left, right):
        return ""
    other = left if right is Dimension.NUMBER else right
    example = {Dimension.LENGTH: "40 cm", Dimension.AREA: "2 m2", Dimension.ANGLE: "15 deg"}
    share = ", or a share: `50 % of ...`" if other is not Dimension.ANGLE else ""
    return f"write a unit: `{example[other]}`{share}"
