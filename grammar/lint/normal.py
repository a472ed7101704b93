"""Models into claims: definitions opened, `each x of a, b` written out, constants folded.

Two conditions that say the same have the same form, whatever stands first and whatever their
variables are called.
"""

from collections.abc import Hashable, Iterator, Mapping
from contextlib import contextmanager
from itertools import combinations

from facetlog.grammar import syntax as s
from facetlog.grammar.lint.claims import Bound, Claim, Claims, Origin, Region
from facetlog.grammar.lint.regions import RegionReader
from facetlog.grammar.resolve import Owned
from facetlog.grammar.scope import Local, Scope, SetSymbol
from facetlog.grammar.source import Source

__all__ = ["claims_of"]


def claims_of(scope: Scope, main: s.File, most: int) -> Claims | None:
    """The claims of a model without faults; None if they are more than `most` steps make.

    What stands in `main` under the model's own name, or before all models, is its own.
    """
    normaliser = _Normaliser(scope, main, most)
    try:
        normaliser.model()
    except OverflowError:
        return None
    return Claims(
        scope,
        tuple(normaliser.claims),
        tuple(normaliser.regions),
        normaliser.ranges,
        frozenset(normaliser.positive),
        most - normaliser.left,
        frozenset(normaliser.used),
        tuple(dict.fromkeys(normaliser.in_vain)),
    )


class _Normaliser(RegionReader):
    """Goes through a model once; OverflowError if that takes too many steps or goes too deep."""

    def __init__(self, scope: Scope, main: s.File, most: int) -> None:
        super().__init__(scope, most)
        self.main = main
        self.claims: list[Claim] = []
        self.in_vain: list[tuple[s.Name, Source]] = []
        self.regions: list[Region] = []
        self._origin: Origin | None = None
        self._shown: s.Expression | None = None
        self._defined: Owned[s.Define] | None = None

    def model(self) -> None:
        for symbol in self.scope.symbols.values():
            where = None if isinstance(symbol, Local) else self.scope.where(symbol)
            if isinstance(symbol, Local) or where is None:
                continue
            part = symbol.owned
            name = symbol.name
            required = not part.node.optional
            own = self._is_own(part)
            self._origin = Origin(part, name, required, False, own, name)
            of_set = name if part.node.count is not None else ""
            before = name in self.used
            self.conjuncts(where, {name: f"${name}"}, of_set)
            if not before:
                # That it says something of itself is no use yet.
                self.used.discard(name)
        for label, line in self.scope.model.lines:
            node = line.node
            own = self._is_own(line)
            self._origin = Origin(line, label, node.expect is None, node.if_known, own)
            self.conjuncts(node.condition, {}, "")
        for size in self.scope.model.sizes:
            for measure in size.node.measures:
                self.measure(measure, {})

    def _is_own(self, owned: Owned[s.Line] | Owned[s.Part] | Owned[s.Define]) -> bool:
        return owned.file is self.main and owned.model in ("", self.scope.model.name)

    # ---------------------------------------------------------------- claims

    def conjuncts(self, node: s.Expression, names: Mapping[str, str], of_set: str) -> None:
        """Claims of a condition, each of which must hold."""
        self.enter()
        self._conjuncts(node, names, of_set)
        self.depth -= 1

    def _conjuncts(self, node: s.Expression, names: Mapping[str, str], of_set: str) -> None:
        match node:
            case s.And(conditions):
                for condition in conditions:
                    self.conjuncts(condition, names, of_set)
                return
            case s.EachOf(variables, of, body):
                if not self._is_set(of):
                    of_parts = [self.named(n.text, names) for n in of]
                    for some in combinations(of_parts, len(variables)):
                        given = {v.text: one for v, one in zip(variables, some, strict=True)}
                        with self._bringing(*variables):
                            self.conjuncts(body, {**names, **given}, of_set)
                    return
                if len(variables) == 1 and not of_set:
                    given = {variables[0].text: f"${of[0].text}"}
                    self.used.add(of[0].text)
                    with self._bringing(*variables):
                        self.conjuncts(body, {**names, **given}, of[0].text)
                    return
            case s.Each(None, name, _, body) if not of_set:
                with self._bringing(name):
                    self.conjuncts(body, {**names, name.text: f"${name.text}"}, name.text)
                return
        applied = self._defined_condition(node)
        if applied is None:
            self._claim(node, names, of_set)
            return
        for opened_body, bound in self.opened(*applied, names, node):
            self.conjuncts(opened_body, bound, of_set)

    def _defined_condition(self, node: s.Expression) -> tuple[str, tuple[s.Expression, ...]] | None:
        """The definition that a condition uses, and what of; None if it is none."""
        match node:
            case s.Call(name, arguments):
                found = name.text, arguments
            case s.Property(subject, name, False):
                found = name.text, (subject,)
            case s.Relation(left, name, right):
                found = name.text, (left, right)
            case _:
                return None
        return found if found[0] in self.scope.defines else None

    @contextmanager
    def _bringing(self, *new: s.Name) -> Iterator[None]:
        """Notes the names that are not used in what follows, though they were brought for it."""
        before = self.used
        self.used = set()
        yield
        assert self._origin is not None  # noqa: S101  set for each statement
        defined = self._defined
        if self._is_own(defined) if defined is not None else self._origin.own:
            source = defined.source if defined is not None else self._origin.source
            self.in_vain += [(name, source) for name in new if name.text not in self.used]
        self.used |= before
        self.used |= {name.text for name in new if name.text in self.scope.symbols}

    def _claim(self, node: s.Expression, names: Mapping[str, str], of_set: str) -> None:
        self.mentioned = {of_set} if of_set else set()
        before = len(self.regions)
        key = self.key(node, names)
        bounds: tuple[Bound, ...] = ()
        if isinstance(node, s.Comparison):
            # The comparison itself is read last, after those within its measures.
            bounds = self.regions[-1].bounds if len(self.regions) > before else ()
        if of_set:
            key = ("every", of_set, key)
        assert self._origin is not None  # noqa: S101  set for each statement
        shown = self._shown or node
        parts = frozenset(self.mentioned)
        self.claims.append(Claim(key, shown, self._origin, parts, bounds, of_set))

    def opened(
        self,
        name: str,
        arguments: tuple[s.Expression, ...],
        names: Mapping[str, str],
        node: s.Expression | None = None,
    ) -> Iterator[tuple[s.Expression, Mapping[str, str]]]:
        """The body of a definition, once, and what the names in it stand for."""
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

    def key(self, node: s.Expression, names: Mapping[str, str]) -> Hashable:
        """A condition in a form that is the same for all that say the same."""
        self.enter()
        found = self._key(node, names)
        self.depth -= 1
        return found

    def _key(self, node: s.Expression, names: Mapping[str, str]) -> Hashable:
        match node:
            case s.And(conditions):
                return "and", frozenset(self.key(c, names) for c in conditions)
            case s.Or(conditions):
                return "or", frozenset(self.key(c, names) for c in conditions)
            case s.Not(condition):
                return _negated(self.key(condition, names))
            case s.Comparison():
                return self._compared(node, names)
            case s.Property(subject, name, negated):
                found = self._applied(name.text, (subject,), names, node)
                return _negated(found) if negated else found
            case s.Relation(left, name, right):
                return self._applied(name.text, (left, right), names, node)
            case s.Call(name, arguments):
                return self._applied(name.text, arguments, names, node)
            case s.Each(kind, name, where, body):
                word = kind.text if kind is not None else f"set ${name.text}"
                inner = {**names, name.text: f"${name.text}"}
                if kind is not None:
                    inner = self._with_local(names, name)
                said = self.key(where, inner) if where is not None else True
                with self._bringing(name):
                    return "each", word, said, self.key(body, inner)
            case s.EachOf(variables, of, body):
                inner = self._with_local(names, *variables)
                among = frozenset(self.named(n.text, names) for n in of)
                with self._bringing(*variables):
                    return "each of", len(variables), among, self.key(body, inner)
            case s.There():
                return self._there(node, names)
            case _:
                raise OverflowError

    def _with_local(self, names: Mapping[str, str], *new: s.Name) -> dict[str, str]:
        """Names with those that `each` or `there` bring: numbered, for what they are called means
        nothing."""
        inner = dict(names)
        for name in new:
            inner[name.text] = f"?{sum(1 for one in inner.values() if one[0] == '?')}"
        return inner

    def _there(self, node: s.There, names: Mapping[str, str]) -> Hashable:
        inner = self._with_local(names, node.name)
        count = node.count
        many = (count.kind, str(count.low), str(count.high)) if count is not None else None
        among = frozenset(self.named(n.text, names) for n in node.of)
        kind = node.kind.text if not node.of else ""
        where: Hashable = True
        if node.where is not None:
            with self._bringing(node.name):
                where = self.key(node.where, inner)
        found = ("there", many, kind, among, where)
        return found if node.some else _negated(found)

    def _applied(
        self,
        name: str,
        arguments: tuple[s.Expression, ...],
        names: Mapping[str, str],
        node: s.Expression,
    ) -> Hashable:
        if name in self.scope.defines:
            found: Hashable = None
            for body, bound in self.opened(name, arguments, names, node):
                found = self.key(body, bound)
            return found
        word = self.scope.words.get(name)
        if word is None:
            return "is a", name, self.element(arguments[0], names)
        given = arguments
        extra: tuple[Hashable, ...] = ()
        if word.number_last is not None:
            *first, last = arguments
            given, extra = tuple(first), (self.measure(last, names).key,)
        elements = tuple(self.element(a, names) for a in given)
        return (name, frozenset(elements) if word.symmetric else elements, *extra)

    def _compared(self, node: s.Comparison, names: Mapping[str, str]) -> Hashable:
        assert self._origin is not None  # noqa: S101  set for each statement
        defined = self._defined
        source: Source = defined.source if defined is not None else self._origin.source
        own = self._is_own(defined) if defined is not None else self._origin.own
        shown = self._shown or node
        region = self.region(node, names, source, own, shown, self._origin)
        self.regions.append(region)
        # Whichever side of the comparison a measure stands on.
        return "within", frozenset((bound.full.key, bound.half.key) for bound in region.bounds)

    def _is_set(self, of: tuple[s.Name, ...]) -> bool:
        return len(of) == 1 and isinstance(self.scope.symbols.get(of[0].text), SetSymbol)


def _negated(key: Hashable) -> Hashable:
    """`not` before a form; two of them cancel."""
    match key:
        case ("not", inner):
            return inner
        case _:
            return "not", key
