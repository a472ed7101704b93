"""Measures as sums: so many times each measured value, and a constant.

What stands on both sides of a comparison is thus cancelled before it is judged.
"""

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from facetlog.grammar.units import Dimension

Atom: TypeAlias = tuple[Hashable, ...]
"""One measured value: the word, and what it is measured of."""

Interval: TypeAlias = tuple[float, float]
"""Least and greatest value."""

EVERYTHING: Interval = (-math.inf, math.inf)

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
