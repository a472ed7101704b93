"""Models into claims: definitions opened, `each x of a, b` written out, constants folded.

Measures become sums, comparisons the ends of their regions. Two conditions that say the same have
the same form, whatever stands first and whatever their variables are called.
"""

import math
from collections.abc import Hashable, Iterator, Mapping
from contextlib import contextmanager
from itertools import combinations

from facetlog.grammar import syntax as s
from facetlog.grammar.checking.measures import DIMENSIONS
from facetlog.grammar.claims import (
    Atom,
    Bound,
    Claim,
    Claims,
    Interval,
    Linear,
    Origin,
    Region,
)
from facetlog.grammar.constants import Constant, combine_dimensions, constant, quantity
from facetlog.grammar.fading import ABOUT, get_soft_share
from facetlog.grammar.resolve import Owned
from facetlog.grammar.scope import THIS, Local, Scope, SetSymbol
from facetlog.grammar.source import Source
from facetlog.grammar.units import Dimension

DEEPEST = 100
"""Expressions and definitions within one another; each level takes a few calls, and Python allows a
thousand of them."""

POSITIVE = frozenset(
    ("length", "width", "thickness", "area", "edge_length", "shared_length", "fill", "share")
)
"""Words whose measures are never zero: a face has an area, an edge a length."""

Names = Mapping[str, str]
"""Keys of names: `$top` of a part or set, `?2` of a name that `each` or `there` introduces."""


MOST_STEPS = 20_000
"""Expressions of one model, its definitions opened. A large model has some hundreds."""


def read_claims(scope: Scope, main: s.File, *, degrees: bool = False) -> Claims | None:
    """Return the claims of a model without faults; None if they take more than MOST_STEPS.

    What stands in `main` under the model's own name, or before all models, is its own. With
    `degrees`, comparisons have the same form only if they fade alike, too.
    """
    reader = _Reader(scope, main, degrees)
    try:
        reader.model()
    except OverflowError:
        return None
    return Claims(
        scope,
        tuple(reader.claims),
        tuple(reader.regions),
        reader.ranges,
        frozenset(reader.positive),
        frozenset(reader.used),
        tuple(reader.sizes),
        tuple(dict.fromkeys(reader.in_vain)),
    )


class _Reader:
    """Goes through a model once; OverflowError if that takes too many steps or goes too deep."""

    def __init__(self, scope: Scope, main: s.File, degrees: bool) -> None:
        self.scope = scope
        self.main = main
        self.degrees = degrees
        self.left = MOST_STEPS
        self.depth = 0
        self.mentioned: set[str] = set()
        self.ranges: dict[Atom, Interval] = {}
        self.positive: set[Atom] = set()
        self.used: set[str] = set()
        self.claims: list[Claim] = []
        self.in_vain: list[tuple[s.Name, Source]] = []
        self.regions: list[Region] = []
        self.sizes: list[tuple[Linear, ...]] = []
        self._lets: dict[str, Constant | None] = {}
        self._origin: Origin
        self._shown: s.Expression | None = None
        self._defined: Owned[s.Define] | None = None

    def model(self) -> None:
        for name, symbol in self.scope.symbols.items():
            where = None if isinstance(symbol, Local) else self.scope.where(symbol)
            if isinstance(symbol, Local) or where is None:
                continue
            part = symbol.owned
            self._origin = Origin(part, not part.node.optional, False, self._is_own(part), name)
            before = name in self.used
            self.conjuncts(where, {name: f"${name}"}, name if part.node.count is not None else "")
            if not before:
                # That it says something of itself is no use yet.
                self.used.discard(name)
        for _, line in self.scope.model.lines:
            node = line.node
            self._origin = Origin(line, node.expect is None, node.if_known, self._is_own(line))
            self.conjuncts(node.condition, {}, "")
        for size in self.scope.model.sizes:
            self.sizes.append(tuple([self.measure(m, {}) for m in size.node.measures]))

    def _is_own(self, owned: Owned[s.Line] | Owned[s.Part] | Owned[s.Define]) -> bool:
        return owned.file is self.main and owned.model in ("", self.scope.model.name)

    @contextmanager
    def _go_deeper(self) -> Iterator[None]:
        self.left -= 1
        self.depth += 1
        if self.left < 0 or self.depth > DEEPEST:
            raise OverflowError
        yield
        self.depth -= 1

    # ---------------------------------------------------------------- claims

    def conjuncts(self, node: s.Expression, names: Names, of_set: str) -> None:
        """Add the claims of a condition, each of which must hold."""
        with self._go_deeper():
            self._add_conjuncts(node, names, of_set)

    def _add_conjuncts(self, node: s.Expression, names: Names, of_set: str) -> None:
        match node:
            case s.And(conditions):
                for condition in conditions:
                    self.conjuncts(condition, names, of_set)
                return
            case s.EachOf(variables, of, body):
                if not self._is_set(of):
                    for given in self._write_out(node, names):
                        self.conjuncts(body, given, of_set)
                    return
                self.named(of[0].text, names)
                if len(variables) == 1 and not of_set:
                    with self._introduce(*variables):
                        inner = {**names, variables[0].text: f"${of[0].text}"}
                        self.conjuncts(body, inner, of[0].text)
                    return
            case s.Each(None, name, _, body) if not of_set:
                with self._introduce(name):
                    self.conjuncts(body, {**names, name.text: f"${name.text}"}, name.text)
                return
            case s.Call() | s.Relation() | s.Property(negated=False):
                used = _get_application(node)
                if used[0] in self.scope.defines:
                    with self._open(*used, names, node) as (body, bound):
                        self.conjuncts(body, bound, of_set)
                    return
        self._add_claim(node, names, of_set)

    def _is_set(self, of: tuple[s.Name, ...]) -> bool:
        return len(of) == 1 and isinstance(self.scope.symbols.get(of[0].text), SetSymbol)

    def _write_out(self, node: s.EachOf, names: Names) -> Iterator[Names]:
        """Iterate over what the names of `each x, y of a, b` stand for in turn."""
        parts = [self.named(n.text, names) for n in node.of]
        for some in combinations(parts, len(node.names)):
            given = {v.text: one for v, one in zip(node.names, some, strict=True)}
            with self._introduce(*node.names):
                yield {**names, **given}

    @contextmanager
    def _introduce(self, *new: s.Name) -> Iterator[None]:
        """Note the names that are not used in what follows, though they were introduced for it."""
        before = self.used
        self.used = set()
        yield
        defined = self._defined
        if self._is_own(defined) if defined is not None else self._origin.own:
            source = defined.source if defined is not None else self._origin.source
            self.in_vain += [(name, source) for name in new if name.text not in self.used]
        self.used |= before
        self.used |= {name.text for name in new if name.text in self.scope.symbols}

    def _add_claim(self, node: s.Expression, names: Names, of_set: str) -> None:
        self.mentioned = {of_set} if of_set else set()
        before = len(self.regions)
        key = self.key(node, names)
        bounds: tuple[Bound, ...] = ()
        if isinstance(node, s.Comparison) and len(self.regions) > before:
            # The comparison itself is read last, after those within its measures.
            bounds = self.regions[-1].bounds
        if of_set:
            key = ("every", of_set, key)
        parts = frozenset(self.mentioned)
        self.claims.append(Claim(key, self._shown or node, self._origin, parts, bounds, of_set))

    @contextmanager
    def _open(
        self,
        name: str,
        arguments: tuple[s.Expression, ...],
        names: Names,
        node: s.Expression | None = None,
    ) -> Iterator[tuple[s.Expression, Names]]:
        """Give the body of a definition and what the names in it stand for."""
        define = self.scope.defines[name]
        self.used.add(name)
        given = [self.element(a, names) for a in arguments]
        bound = {p.text: one for p, one in zip(define.node.parameters, given, strict=True)}
        before = self._shown, self._defined
        if node is not None and self._shown is None:
            self._shown = node
        self._defined = define
        yield define.node.body, bound
        self._shown, self._defined = before

    # ------------------------------------------------------------------ keys

    def key(self, node: s.Expression, names: Names) -> Hashable:
        """Return a condition in a form that is the same for all that say the same."""
        with self._go_deeper():
            return self._make_key(node, names)

    def _make_key(self, node: s.Expression, names: Names) -> Hashable:
        match node:
            case s.And(conditions):
                return "and", frozenset(self.key(c, names) for c in conditions)
            case s.Or(conditions):
                return "or", frozenset(self.key(c, names) for c in conditions)
            case s.Not(condition):
                return _negate(self.key(condition, names))
            case s.Comparison():
                # Whichever side of the comparison a measure stands on.
                region = self._add_region(node, names)
                if self.degrees:
                    return self._make_exact_key(region)
                return "within", frozenset((b.full.key, b.half.key) for b in region.bounds)
            case s.Call() | s.Relation() | s.Property():
                said = self._apply(*_get_application(node), names, node)
                return _negate(said) if isinstance(node, s.Property) and node.negated else said
            case s.Each(kind, name, where, body):
                word = kind.text if kind is not None else f"set ${name.text}"
                inner = {**names, name.text: f"${name.text}"}
                if kind is not None:
                    inner = _with_local(names, name)
                chosen = self.key(where, inner) if where is not None else True
                with self._introduce(name):
                    return "each", word, chosen, self.key(body, inner)
            case s.EachOf(variables, of, body):
                if not self._is_set(of):
                    every = [self.key(body, given) for given in self._write_out(node, names)]
                    return "and", frozenset(every)
                among = self.named(of[0].text, names)
                with self._introduce(*variables):
                    inner = _with_local(names, *variables)
                    return "each of", len(variables), among, self.key(body, inner)
            case s.There():
                return self._make_there_key(node, names)
            case _:
                raise OverflowError

    def _make_exact_key(self, region: Region) -> Hashable:
        """Return a form of a comparison that says over which width it fades, too."""
        sides = region.measure, region.low, region.high, region.fading
        soft = get_soft_share(region.node, self.scope)
        keys = tuple(side.key if side is not None else None for side in sides)
        return region.node.comparator, keys, soft

    def _make_there_key(self, node: s.There, names: Names) -> Hashable:
        inner = _with_local(names, node.name)
        count = node.count
        many = (count.kind, str(count.low), str(count.high)) if count is not None else None
        among = frozenset(self.named(n.text, names) for n in node.of)
        kind = node.kind.text if not node.of else ""
        where: Hashable = True
        demanded = self.scope.demanded(node, node.name) if node.of else node.where
        if demanded is not None:
            with self._introduce(node.name):
                where = self.key(demanded, inner)
        found = ("there", many, kind, among, where)
        return found if node.some else _negate(found)

    def _apply(
        self, name: str, arguments: tuple[s.Expression, ...], names: Names, node: s.Expression
    ) -> Hashable:
        if name in self.scope.defines:
            with self._open(name, arguments, names, node) as (body, bound):
                return self.key(body, bound)
        word = self.scope.words.get(name)
        if word is None:
            return "is a", name, self.element(arguments[0], names)
        extra: tuple[Hashable, ...] = ()
        if word.number_last is not None:
            *first, last = arguments
            arguments, extra = tuple(first), (self.measure(last, names).key,)
        elements = tuple(self.element(a, names) for a in arguments)
        return (name, frozenset(elements) if word.symmetric else elements, *extra)

    # -------------------------------------------------------------- elements

    def named(self, name: str, names: Names) -> str:
        """Return what a name stands for."""
        self.used.add(name)
        found = names.get(name) or f"${name}"
        if found[0] == "$" and name != THIS:
            self.mentioned.add(found[1:].partition(".")[0])
        return found

    def element(self, node: s.Expression, names: Names) -> str:
        """Return the element that an expression names."""
        match node:
            case s.Reference(name):
                return self.named(name.text, names)
            case s.Member(owner, part):
                return f"{self.named(owner.text, names)}.{part.text}"
            case _:
                raise OverflowError

    # -------------------------------------------------------------- measures

    def measure(self, node: s.Expression, names: Names) -> Linear:
        """Return a measure as a sum."""
        with self._go_deeper():
            return self._make_measure(node, names)

    def _make_measure(self, node: s.Expression, names: Names) -> Linear:
        match node:
            case s.Quantity():
                return _make_sum(quantity(node))
            case s.Reference(name):
                self.used.add(name.text)
                if name.text not in self._lets:
                    let = self.scope.lets.get(name.text)
                    value = constant(let.node.value, self.scope.lets) if let else None
                    self._lets[name.text] = value
                return _make_sum(self._lets[name.text])
            case s.Call(name, arguments):
                return self._measure_word(name.text, arguments, names)
            case s.Negative(operand):
                return self.measure(operand, names).times(-1.0)
            case s.Share(share, whole):
                return self.measure(whole, names).times(_make_sum(quantity(share)).constant)
            case s.Arithmetic(sign, left, right):
                return self._join(sign, self.measure(left, names), self.measure(right, names))
            case s.Aggregate(how, operand) if how.endswith(("gap", "spacing")):
                atom = (how, self.element(operand, names))
                return self._add_atom(atom, Dimension.LENGTH, (0.0, math.inf))
            case s.Aggregate(how, operand):
                inner = self.measure(operand, names)
                low, high = inner.interval(self.ranges)
                if how.endswith("step"):
                    low, high = 0.0, high - low if math.isfinite(high - low) else math.inf
                if how == "order":
                    return self._add_atom((how, inner.key), Dimension.NUMBER, (0.0, 1.0))
                if how == "sum":
                    # A sum of any number of members, each between low and high.
                    low, high = (0.0 if low >= 0 else -math.inf), (0.0 if high <= 0 else math.inf)
                return self._add_atom((how, inner.key), inner.dimension, (low, high))
            case _:
                raise OverflowError

    def _measure_word(self, name: str, arguments: tuple[s.Expression, ...], names: Names) -> Linear:
        if name in self.scope.defines:
            with self._open(name, arguments, names) as (body, given):
                return self.measure(body, given)
        elements = tuple(self.element(a, names) for a in arguments)
        if name == "count":
            symbol = self.scope.symbols.get(elements[0][1:])
            return self._add_atom((name, *elements), Dimension.NUMBER, _set_size(symbol))
        word = self.scope.words[name]
        low = -math.inf if word.low is None else word.low
        high = math.inf if word.high is None else word.high
        atom: Atom = (name, frozenset(elements)) if word.symmetric else (name, *elements)
        if name in POSITIVE:
            self.positive.add(atom)
        return self._add_atom(atom, DIMENSIONS[word.gives], (low, high))

    def _add_atom(self, atom: Atom, dimension: Dimension, values: Interval) -> Linear:
        self.ranges[atom] = values
        return Linear(0.0, {atom: 1.0}, dimension)

    def _join(self, sign: str, left: Linear, right: Linear) -> Linear:
        dimension = combine_dimensions(sign, left.dimension, right.dimension)
        if dimension is None or (sign == "/" and right.is_constant and right.constant == 0):
            raise OverflowError
        if sign in "+-":
            return left.plus(right, 1.0 if sign == "+" else -1.0)
        if right.is_constant:
            return left.times(right.constant if sign == "*" else 1 / right.constant, dimension)
        if left.is_constant and sign == "*":
            return right.times(left.constant, dimension)
        a, b = left.interval(self.ranges), right.interval(self.ranges)
        values = (-math.inf, math.inf)
        if sign == "*":
            if a[0] >= 0 and b[0] >= 0:
                high = a[1] * b[1]
                values = a[0] * b[0], math.inf if math.isnan(high) else high
            return self._add_atom(("*", frozenset({left.key, right.key})), dimension, values)
        # Nothing that is measured is less than nothing, or the quotient may be anything.
        if a[0] >= 0 and b[0] >= 0:
            values = (0.0, math.inf)
        return self._add_atom(("/", left.key, right.key), dimension, values)

    # ----------------------------------------------------------- comparisons

    def _add_region(self, node: s.Comparison, names: Names) -> Region:
        """Add and return a comparison with its ends."""
        measure, limit = self.measure(node.measure, names), self.measure(node.limit, names)
        low = high = tolerance = fading = None
        if node.fading is not None:
            fading = self._get_width(node.fading, limit, names)
        match node.comparator:
            case s.Comparator.AT_LEAST:
                low = limit
            case s.Comparator.AT_MOST:
                high = limit
            case s.Comparator.BETWEEN:
                low = limit
                high = self.measure(node.second, names) if node.second else None
            case s.Comparator.ABOUT:
                tolerance = fading = _take_share(limit, ABOUT)
            case _:
                tolerance = self._get_width(node.second, limit, names) if node.second else None
                if node.second is None:
                    low = high = limit
        if tolerance is not None:
            low, high = limit.plus(tolerance, -1.0), limit.plus(tolerance)
        defined = self._defined
        found = Region(
            node,
            defined.source if defined is not None else self._origin.source,
            self._is_own(defined) if defined is not None else self._origin.own,
            self._shown or node,
            self._origin, measure, low, high, tolerance, fading,
            _make_bound(measure, low, 1.0, fading), _make_bound(measure, high, -1.0, fading),
        )  # fmt: skip
        self.regions.append(found)
        return found

    def _get_width(self, node: s.Expression, target: Linear, names: Names) -> Linear:
        """Return a tolerance or fading: in % of its target, or as it stands."""
        width = self.measure(node, names)
        value = constant(node, self.scope.lets) if width.is_constant else None
        return _take_share(target, value.value) if value is not None and value.percent else width


def _get_application(
    node: s.Call | s.Relation | s.Property,
) -> tuple[str, tuple[s.Expression, ...]]:
    """Return the word or definition that a condition uses, and its arguments."""
    match node:
        case s.Call(name, arguments):
            return name.text, arguments
        case s.Property(subject, name):
            return name.text, (subject,)
        case s.Relation(left, name, right):
            return name.text, (left, right)


def _negate(key: Hashable) -> Hashable:
    """Return `not` before a form; two of them cancel."""
    match key:
        case ("not", inner):
            return inner
        case _:
            return "not", key


def _with_local(names: Names, *new: s.Name) -> dict[str, str]:
    """Add names of `each` or `there`: numbered, for what they are called means nothing."""
    inner = dict(names)
    for name in new:
        inner[name.text] = f"?{sum(1 for one in inner.values() if one[0] == '?')}"
    return inner


def _take_share(target: Linear, share: float) -> Linear:
    """Return so much of a target; of a negative number as of a positive one."""
    turned = target.is_constant and target.constant < 0
    return target.times(-share if turned else share)


def _make_bound(
    measure: Linear, end: Linear | None, sign: float, fading: Linear | None
) -> Bound | None:
    """Return one end: sign * (measure - end) is not negative within the region."""
    if end is None:
        return None
    full = measure.plus(end, -1.0).times(sign)
    return Bound(full, full.plus(fading, 0.5) if fading is not None else full)


def _make_sum(value: Constant | None) -> Linear:
    if value is None:
        raise OverflowError
    return Linear(value.value, {}, value.dimension)


def _set_size(symbol: object) -> Interval:
    """Return how many members a set must have for its model to hold."""
    count = symbol.owned.node.count if isinstance(symbol, SetSymbol) else None
    if not isinstance(symbol, SetSymbol) or count is None or symbol.owned.node.optional:
        return 0.0, math.inf
    return count.least, count.most
