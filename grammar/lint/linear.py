"""Measures as sums: so many times each measured value, and a constant.

What stands on both sides of a comparison is thus cancelled before it is judged.
"""

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from facetlog.grammar.units import Dimension

__all__ = ["EVERYTHING", "NOTHING_BUT_ZERO", "Atom", "Interval", "Linear", "constant_sum", "single"]

Atom: TypeAlias = tuple[Hashable, ...]
"""One measured value: the word, and what it is measured of."""

Interval: TypeAlias = tuple[float, float]
"""Least and greatest value."""

EVERYTHING: Interval = (-math.inf, math.inf)
NOTHING_BUT_ZERO: Interval = (0.0, 0.0)

DIGITS = 12
"""Of a factor: what differs behind them differs by rounding."""


@dataclass(frozen=True, slots=True)
class Linear:
    """A constant and multiples of measured values, all of one dimension.

    `absolute` if metres are written in it, so that it has no value where the scale is not known.
    """

    constant: float
    terms: Mapping[Atom, float]
    dimension: Dimension
    absolute: bool = False

    @property
    def key(self) -> Hashable:
        """Equal for equal sums."""
        return _rounded(self.constant), frozenset((a, _rounded(c)) for a, c in self.terms.items())

    @property
    def is_constant(self) -> bool:
        """Whether nothing is measured."""
        return not self.terms

    def times(self, factor: float, dimension: Dimension | None = None) -> "Linear":
        """So many times it."""
        terms = {a: _rounded(c * factor) for a, c in self.terms.items()} if factor else {}
        value = _rounded(self.constant * factor)
        return Linear(value, terms, dimension or self.dimension, self.absolute)

    def plus(self, other: "Linear", factor: float = 1.0) -> "Linear":
        """The sum with so many times another; what cancels is left out."""
        terms = dict(self.terms)
        for atom, coefficient in other.terms.items():
            value = _rounded(terms.get(atom, 0.0) + factor * coefficient)
            if value:
                terms[atom] = value
            else:
                terms.pop(atom, None)
        constant = _rounded(self.constant + factor * other.constant)
        return Linear(constant, terms, self.dimension, self.absolute or other.absolute)

    def interval(self, ranges: Mapping[Atom, Interval]) -> Interval:
        """Its least and greatest value, from those of what is measured."""
        low = high = self.constant
        for atom, coefficient in self.terms.items():
            least, most = ranges[atom]
            if coefficient < 0:
                least, most = most, least
            low += coefficient * least
            high += coefficient * most
        return low, high


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}") if value % 1 else value


def constant_sum(value: float, dimension: Dimension) -> Linear:
    """A number alone; zero is the same in every unit."""
    lengths = dimension in (Dimension.LENGTH, Dimension.AREA)
    return Linear(value, {}, dimension, lengths and value != 0)


def single(atom: Atom, dimension: Dimension, absolute: bool = False) -> Linear:
    """One measured value."""
    return Linear(0.0, {atom: 1.0}, dimension, absolute)
