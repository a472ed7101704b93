"""Measures into sums, and comparisons into the ends of their regions."""

import math
from abc import ABC, abstractmethod
from collections.abc import Hashable, Iterator, Mapping
from dataclasses import replace

from facetlog.grammar import syntax as s
from facetlog.grammar.checking.types import DIMENSIONS
from facetlog.grammar.constants import Constant, combined_dimension, constant, quantity
from facetlog.grammar.fading import ABOUT
from facetlog.grammar.lint.claims import Bound, Origin, Region
from facetlog.grammar.lint.linear import Atom, Interval, Linear, constant_sum, single
from facetlog.grammar.scope import THIS, Scope, SetSymbol
from facetlog.grammar.source import Source
from facetlog.grammar.units import Dimension

__all__ = ["RegionReader"]

DEEPEST = 100
"""Expressions and definitions within one another; each level takes a few calls, and Python allows a
thousand of them."""

POSITIVE = frozenset(
    ("length", "width", "thickness", "area", "edge_length", "shared_length", "fill", "share")
)
"""Words whose measures are never zero: a face has an area, an edge a length."""


class RegionReader(ABC):
    """Reads measures and comparisons of one model; `opened` is left to who knows definitions."""

    def __init__(self, scope: Scope, most: int) -> None:
        self.scope = scope
        self.left = most
        self.depth = 0
        self.mentioned: set[str] = set()
        self.ranges: dict[Atom, Interval] = {}
        self.positive: set[Atom] = set()
        self.used: set[str] = set()
        self._lets: dict[str, Constant | None] = {}

    @abstractmethod
    def opened(
        self, name: str, arguments: tuple[s.Expression, ...], names: Mapping[str, str]
    ) -> Iterator[tuple[s.Expression, Mapping[str, str]]]:
        """The body of a definition, once, and what the names in it stand for."""

    def enter(self) -> None:
        """One step, one level further in; OverflowError after too many. Who leaves goes back."""
        self.left -= 1
        self.depth += 1
        if self.left < 0 or self.depth > DEEPEST:
            raise OverflowError

    # -------------------------------------------------------------- elements

    def named(self, name: str, names: Mapping[str, str]) -> str:
        """What a name stands for: `$top` a part or set, `?2` what `each` or `there` brings."""
        self.used.add(name)
        found = names.get(name)
        if found is None:
            found = f"${name}"
        if found[0] == "$" and name != THIS:
            self.mentioned.add(found[1:].partition(".")[0])
        return found

    def element(self, node: s.Expression, names: Mapping[str, str]) -> str:
        """The element that an expression names."""
        match node:
            case s.Reference(name):
                return self.named(name.text, names)
            case s.Member(owner, part):
                return f"{self.named(owner.text, names)}.{part.text}"
            case _:
                raise OverflowError

    # -------------------------------------------------------------- measures

    def measure(self, node: s.Expression, names: Mapping[str, str]) -> Linear:
        """A measure as a sum."""
        self.enter()
        found = self._measure(node, names)
        self.depth -= 1
        return found

    def _measure(self, node: s.Expression, names: Mapping[str, str]) -> Linear:
        match node:
            case s.Quantity():
                return _sum_of(quantity(node))
            case s.Reference(name):
                return _sum_of(self._let(name.text))
            case s.Call(name, arguments):
                return self._word(name.text, arguments, names)
            case s.Negative(operand):
                return self.measure(operand, names).times(-1.0)
            case s.Share(share, whole):
                part = quantity(share)
                if part is None:
                    raise OverflowError
                return self.measure(whole, names).times(part.value)
            case s.Arithmetic(sign, left, right):
                return self._joined(sign, self.measure(left, names), self.measure(right, names))
            case s.Aggregate():
                return self._aggregate(node, names)
            case _:
                raise OverflowError

    def _let(self, name: str) -> Constant | None:
        self.used.add(name)
        if name not in self._lets:
            let = self.scope.lets.get(name)
            self._lets[name] = constant(let.node.value, self.scope.lets) if let else None
        return self._lets[name]

    def _word(
        self, name: str, arguments: tuple[s.Expression, ...], names: Mapping[str, str]
    ) -> Linear:
        if name in self.scope.defines:
            for body, given in self.opened(name, arguments, names):
                found = self.measure(body, given)
            return found
        elements = tuple(self.element(a, names) for a in arguments)
        if name == "count":
            symbol = self.scope.symbols.get(elements[0][1:])
            return self._atom((name, *elements), Dimension.NUMBER, _set_size(symbol))
        word = self.scope.words[name]
        low = -math.inf if word.low is None else word.low
        high = math.inf if word.high is None else word.high
        atom: Atom = (name, frozenset(elements)) if word.symmetric else (name, *elements)
        if name in POSITIVE:
            self.positive.add(atom)
        return self._atom(atom, DIMENSIONS[word.gives], (low, high))

    def _atom(
        self, atom: Atom, dimension: Dimension, values: Interval, absolute: bool = False
    ) -> Linear:
        self.ranges[atom] = values
        return single(atom, dimension, absolute)

    def _joined(self, sign: str, left: Linear, right: Linear) -> Linear:
        dimension = combined_dimension(sign, left.dimension, right.dimension)
        if dimension is None:
            raise OverflowError
        if sign in "+-":
            return left.plus(right, 1.0 if sign == "+" else -1.0)
        if right.is_constant:
            if sign == "/" and right.constant == 0:
                raise OverflowError
            factor = right.constant if sign == "*" else 1 / right.constant
            return _with_unit(left, right, left.times(factor, dimension))
        if left.is_constant and sign == "*":
            return _with_unit(right, left, right.times(left.constant, dimension))
        a, b = left.interval(self.ranges), right.interval(self.ranges)
        absolute = left.absolute or right.absolute
        if sign == "*":
            product: Hashable = frozenset({left.key, right.key})
            return self._atom(("*", product), dimension, _product(a, b), absolute)
        # Nothing that is measured is less than nothing, or the quotient may be anything.
        quotient = (0.0, math.inf) if a[0] >= 0 and b[0] >= 0 else (-math.inf, math.inf)
        return self._atom(("/", left.key, right.key), dimension, quotient, absolute)

    def _aggregate(self, node: s.Aggregate, names: Mapping[str, str]) -> Linear:
        if node.how.endswith("gap"):
            atom = (node.how, self.element(node.operand, names))
            return self._atom(atom, Dimension.LENGTH, (0.0, math.inf))
        inner = self.measure(node.operand, names)
        low, high = inner.interval(self.ranges)
        if node.how == "sum":
            # Of any number of members, each at least and at most so much.
            low, high = (0.0 if low >= 0 else -math.inf), (0.0 if high <= 0 else math.inf)
        return self._atom((node.how, inner.key), inner.dimension, (low, high), inner.absolute)

    # ----------------------------------------------------------- comparisons

    def region(
        self,
        node: s.Comparison,
        names: Mapping[str, str],
        source: Source,
        own: bool,
        shown: s.Expression,
        origin: Origin,
    ) -> Region:
        """A comparison with its ends."""
        measure, limit = self.measure(node.measure, names), self.measure(node.limit, names)
        low = high = tolerance = fading = None
        if node.fading is not None:
            fading = self._width(node.fading, limit, names)
        match node.comparator:
            case s.Comparator.AT_LEAST:
                low = limit
            case s.Comparator.AT_MOST:
                high = limit
            case s.Comparator.BETWEEN:
                low = limit
                high = self.measure(node.second, names) if node.second else None
            case s.Comparator.ABOUT:
                tolerance = fading = _share_of(limit, ABOUT)
            case _:
                tolerance = self._width(node.second, limit, names) if node.second else None
                if node.second is None:
                    low = high = limit
        if tolerance is not None:
            low, high = limit.plus(tolerance, -1.0), limit.plus(tolerance)
        return Region(
            node, source, own, shown, origin, measure, low, high, tolerance, fading,
            _bound(measure, low, 1.0, fading), _bound(measure, high, -1.0, fading),
        )  # fmt: skip

    def _width(self, node: s.Expression, target: Linear, names: Mapping[str, str]) -> Linear:
        """A tolerance or fading: in % of its target, or as it stands."""
        width = self.measure(node, names)
        value = constant(node, self.scope.lets) if width.is_constant else None
        if value is not None and value.percent:
            return _share_of(target, value.value)
        return width


def _with_unit(measure: Linear, constant: Linear, found: Linear) -> Linear:
    """A product or quotient with a constant: metres are noted, unless they cancel."""
    if measure.is_constant:
        return constant_sum(found.constant, found.dimension)
    return replace(found, absolute=measure.absolute or constant.absolute)


def _share_of(target: Linear, share: float) -> Linear:
    """So much of a target; of a negative number as of a positive one."""
    turned = target.is_constant and target.constant < 0
    return target.times(-share if turned else share)


def _bound(measure: Linear, end: Linear | None, sign: float, fading: Linear | None) -> Bound | None:
    """One end: sign * (measure - end) is not negative within the region."""
    if end is None:
        return None
    full = measure.plus(end, -1.0).times(sign)
    return Bound(full, full.plus(fading, 0.5) if fading is not None else full)


def _sum_of(value: Constant | None) -> Linear:
    if value is None:
        raise OverflowError
    return constant_sum(value.value, value.dimension)


def _set_size(symbol: object) -> Interval:
    """How many members a set must have for its model to hold."""
    if not isinstance(symbol, SetSymbol) or symbol.owned.node.optional:
        return 0.0, math.inf
    count = symbol.owned.node.count
    if count is None or count.kind is s.CountKind.ANY:
        return 0.0, math.inf
    low = float(count.low.text) if count.low and count.kind is not s.CountKind.AT_MOST else 0.0
    high = math.inf
    if count.high and count.kind is not s.CountKind.AT_LEAST:
        high = float(count.high.text)
    return low, high


def _product(a: Interval, b: Interval) -> Interval:
    if a[0] >= 0 and b[0] >= 0:
        high = a[1] * b[1]
        return a[0] * b[0], math.inf if math.isnan(high) else high
    return -math.inf, math.inf
