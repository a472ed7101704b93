"""Constants: numbers with their dimension, in metres, square metres, degrees or ones."""

from collections.abc import Mapping
from dataclasses import dataclass

from facetlog.grammar import syntax as s
from facetlog.grammar.resolve import Owned
from facetlog.grammar.units import UNITS, Dimension

DEEPEST = 50
"""Constants made of constants; a circle is no constant either."""

LEAST, GREATEST = 1e-12, 1e12
"""What a constant may be, in its dimension's own unit: nothing seen is smaller or larger."""


@dataclass(frozen=True, slots=True)
class Constant:
    """A value in metres, square metres, degrees or ones; `percent` if it was written in %."""

    value: float
    dimension: Dimension
    percent: bool = False


def quantity(node: s.Quantity) -> Constant | None:
    """Return the value of a number with its unit; None if the unit is unknown or it is too
    large."""
    unit = UNITS.get(node.unit.text) if node.unit else None
    if node.unit is not None and unit is None:
        return None
    factor, dimension = (unit.factor, unit.dimension) if unit else (1.0, Dimension.NUMBER)
    return _check_bounds(
        _multiply(node.value, factor), dimension, node.unit is not None and unit is UNITS["%"]
    )


def _multiply(value: float, factor: float) -> float:
    """80 % is 0.8 and not 0.8000000000000002: the decimal that a person means."""
    return float(f"{value * factor:.15g}")


def _check_bounds(value: float, dimension: Dimension, percent: bool = False) -> Constant | None:
    sound = value == 0 or LEAST <= abs(value) <= GREATEST
    return Constant(value, dimension, percent) if sound else None


def constant(
    node: s.Expression,
    lets: Mapping[str, Owned[s.Let]],
    known: dict[str, Constant | None] | None = None,
) -> Constant | None:
    """Return the value of an expression without measures; None if it is not constant or not sound.

    `known` holds the constants that were worked out: each is, once.
    """
    known = {} if known is None else known
    match node:
        case s.Quantity():
            return quantity(node)
        case s.Reference(name):
            return _look_up(name.text, lets, known)
        case s.Negative(operand):
            found = constant(operand, lets, known)
            return found and Constant(-found.value, found.dimension, found.percent)
        case s.Share(share, whole):
            part, of = quantity(share), constant(whole, lets, known)
            if part is None or of is None or part.dimension is not Dimension.NUMBER:
                return None
            return _check_bounds(_multiply(part.value, of.value), of.dimension)
        case s.Arithmetic():
            left = constant(node.left, lets, known)
            right = constant(node.right, lets, known)
            if left is None or right is None:
                return None
            return _combine(node.sign, left, right)
        case _:
            return None


def _look_up(
    name: str, lets: Mapping[str, Owned[s.Let]], known: dict[str, Constant | None]
) -> Constant | None:
    if name not in known:
        if name not in lets or len(known) >= DEEPEST:
            return None
        known[name] = None  # of a circle
        known[name] = constant(lets[name].node.value, lets, known)
    return known[name]


def _combine(sign: str, left: Constant, right: Constant) -> Constant | None:
    dimension = combine_dimensions(sign, left.dimension, right.dimension)
    if dimension is None:
        return None
    a, b = left.value, right.value
    if sign == "/" and b == 0:
        return None
    value = {"+": a + b, "-": a - b, "*": a * b}[sign] if sign != "/" else a / b
    percent = left.percent and right.percent and sign in "+-"
    return _check_bounds(float(f"{value:.15g}"), dimension, percent)


def combine_dimensions(sign: str, left: Dimension, right: Dimension) -> Dimension | None:
    """Return the dimension of two measures joined by a sign, None if they cannot be."""
    number, length, area = Dimension.NUMBER, Dimension.LENGTH, Dimension.AREA
    if sign in "+-":
        return left if left is right else None
    if sign == "*":
        if number in (left, right):
            return left if right is number else right
        return area if left is right is length else None
    if right is number:
        return left
    if left is right:
        return number
    return length if (left, right) == (area, length) else None
