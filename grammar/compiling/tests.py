"""Conditions into tests, and the goals that find what they range over.

A test is a term that the knowledge base evaluates (docs/model-reference.md); what it goes through,
other faces or the members of a set, is found by goals before it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from facetlog.grammar import syntax as s
from facetlog.grammar.compiling.writer import (
    NOTHING,
    UNSEEN,
    Bound,
    MeasureWriter,
    SetShape,
    amount,
    conjunction,
    is_number,
    join_goals,
    scaled,
    state_only,
    write_amount_test,
    write_elements_goal,
    write_some_test,
    write_word,
)
from facetlog.grammar.constants import constant
from facetlog.grammar.fading import ABOUT, get_soft_share
from facetlog.grammar.scope import SetSymbol
from facetlog.grammar.terms import Atom, Struct, Term, Var
from facetlog.grammar.traversal import walk
from facetlog.grammar.vocabulary import PIECE, Kind, Kinds


@dataclass(slots=True)
class Writer(MeasureWriter):
    """Writes the tests of one clause."""

    def test(self, node: s.Expression) -> Term:
        """Return the test that a condition is."""
        match node:
            case s.And(conditions):
                return join_goals([self.test(c) for c in conditions])
            case s.Or(conditions):
                return Struct("any", (tuple(self.test(c) for c in conditions),))
            case s.Not(condition):
                return Struct("not", (self.test(condition),))
            case s.Comparison():
                return self._write_comparison(node)
            case s.Property():
                found = self._write_applied(node.name.text, (node.subject,))
                return Struct("not", (found,)) if node.negated else found
            case s.Relation():
                return self._write_applied(node.name.text, (node.left, node.right))
            case s.Call():
                return self._write_applied(node.name.text, node.arguments)
            case s.Each():
                return self._write_each(node)
            case s.EachOf():
                return self._write_each_of(node)
            case s.There():
                return self._write_there(node)
        raise TypeError(node)

    def _write_applied(self, name: str, arguments: tuple[s.Expression, ...]) -> Term:
        if name in self.scope.defines:
            return self.expanded(name, arguments).test(self.scope.defines[name].node.body)
        word = self.scope.words.get(name)
        if word is None:
            return Struct("is_a", (self.argument(arguments[0]).term, Atom(name)))
        if word.number_last is not None:
            *first, last = arguments
            value = constant(last, self.scope.lets)
            bound = tuple(map(self.argument, first))
            given = amount(value) if value is not None else self.measure(last)
            said = write_word(name, bound)
            return Struct(said.functor, (*said.args, given))
        bound = tuple(map(self.argument, arguments))
        if word.many:
            return Struct(name, (tuple(b.term for b in bound),))
        return write_word(name, bound)

    def _write_comparison(self, node: s.Comparison) -> Term:
        counted = self._write_counted(node)
        if counted is not None:
            return counted
        measure, limit = self.measure(node.measure), self.measure(node.limit)
        match node.comparator:
            case s.Comparator.AT_LEAST:
                test = Struct("at_least", (measure, limit))
            case s.Comparator.AT_MOST:
                test = Struct("at_most", (measure, limit))
            case s.Comparator.BETWEEN:
                assert node.second is not None  # noqa: S101  the grammar says so
                test = Struct("between", (measure, limit, self.measure(node.second)))
            case s.Comparator.ABOUT:
                test = self._write_near(measure, limit, ABOUT)
                return Struct("fading", (test, scaled(ABOUT, _drop_sign(limit))))
            case _:
                if node.second is None:
                    test = Struct("near", (measure, limit, 0))
                else:
                    share = self._get_share(node.second)
                    test = (
                        self._write_near(measure, limit, share)
                        if share is not None
                        else Struct("near", (measure, limit, self.measure(node.second)))
                    )
        if node.fading is not None:
            share = self._get_share(node.fading)
            width = (
                scaled(share, _drop_sign(limit)) if share is not None else self.measure(node.fading)
            )
            return Struct("fading", (test, width))
        share = get_soft_share(node, self.scope)
        return Struct("soft", (test, share)) if share and limit != 0 else test

    def _write_near(self, measure: Term, target: Term, share: float) -> Struct:
        """Return the test that a measure is within a share of the target."""
        if is_number(target):
            return Struct("near", (measure, target, scaled(share, _drop_sign(target))))
        # The target's own deviation counts once at either edge.
        return Struct("between", (measure, scaled(1 - share, target), scaled(1 + share, target)))

    def _get_share(self, node: s.Expression) -> float | None:
        value = constant(node, self.scope.lets)
        return value.value if value is not None and value.percent else None

    def _write_counted(self, node: s.Comparison) -> Term | None:
        """Write the test of `count(set)` against a number, by its members' own degrees."""
        if _is_count(node.limit) and not _is_count(node.measure):
            turned = _TURNED.get(node.comparator)
            if turned is None:
                return None
            node = replace(node, comparator=turned, measure=node.limit, limit=node.measure)
        match node.measure:
            case s.Call(name, (s.Reference(of),)) if name.text == "count":
                limit = constant(node.limit, self.scope.lets)
                second = constant(node.second, self.scope.lets) if node.second else None
                if limit is None or node.fading is not None or (node.second and second is None):
                    return None
                shape = self.shapes[of.text]
            case _:
                return None
        low, high = limit.value, limit.value
        match node.comparator:
            case s.Comparator.AT_LEAST:
                high = math.inf
            case s.Comparator.AT_MOST:
                low = -math.inf
            case s.Comparator.BETWEEN if second is not None:
                high = second.value
            case s.Comparator.EQUAL if second is not None:
                width = second.value * abs(low) if second.percent else second.value
                low, high = low - width, high + width
            case s.Comparator.ABOUT:
                low, high = low * (1 - 2 * ABOUT), high * (1 + 2 * ABOUT)
        return self.write_count_test(shape, low, high)

    def write_count_test(self, shape: SetShape, low: float, high: float) -> Term:
        """Return the test that a set has so many members."""
        groups, kinds = self._write_groups(shape), shape.symbol.kinds
        return write_amount_test(
            shape.pattern(self.names), groups, shape.test(self), low, high, kinds
        )

    def has_elements(self, kinds: Kinds, least: int) -> Term:
        """Return the test that the thing has so many pieces or openings, whichever they are."""
        name = "piece" if kinds == PIECE else next(iter(kinds)).value
        one = self.names.fresh(name)
        goal = write_elements_goal(kinds, one)
        groups = self.once(
            f"{name}s", f"{name.title()}s", lambda var: [Struct("findall", ((one,), goal, var))]
        )
        return write_amount_test(one, groups, NOTHING, least, math.inf, kinds)

    def _write_groups(self, shape: SetShape) -> Var:
        members = self.members(shape)
        name = shape.symbol.name
        if shape.separate:
            return self.once(
                f"groups {name}",
                f"{name}_groups",
                lambda var: [Struct("separate", (members, var))],
            )
        one = self.names.fresh("member")
        return self.once(
            f"groups {name}",
            f"{name}_groups",
            lambda var: [Struct("findall", ((one,), Struct("member", (one, members)), var))],
        )

    def _write_each(self, node: s.Each) -> Term:
        if node.kind is None:
            shape = self.shapes[node.name.text]
            members = self.members(shape)
            inner = self.with_locals(**shape.bound(self.names))
            body = shape.implied(self, inner.test(node.body))
            return Struct("each", (shape.pattern(self.names), members, body))
        demanded = self.scope.demanded(node, node.name)
        variable, kinds, inner = self._introduce_element(node.kind, node.name)
        others, where = self._find_others(kinds, demanded, node.name.text, variable, inner)
        body = inner.test(node.body)
        if where is not None:
            body = Struct("implies", (where, body))
        return Struct("each", (variable, others, body))

    def _introduce_element(self, kind: s.Name, name: s.Name) -> tuple[Var, Kinds, "Writer"]:
        kinds = self.scope.get_element_kinds(kind.text)
        assert kinds is not None  # noqa: S101  the checker has seen to it
        variable, inner = self._introduce_local(name.text, kinds)
        return variable, kinds, inner

    def _introduce_local(self, name: str, kinds: Kinds, model: str = "") -> tuple[Var, "Writer"]:
        variable = self.names.fresh(name)
        return variable, self.with_locals(**{name: Bound(variable, kinds, model)})

    def _find_others(
        self, kinds: Kinds, where: s.Expression | None, name: str, variable: Var, inner: "Writer"
    ) -> tuple[Var, Term | None]:
        """Return the elements that are no singular part, and what must be so of each of them."""
        test = None if where is None else inner.test(where)
        one = variable
        goals: list[Term] = [write_elements_goal(kinds, one)]
        if self.scope.singular and not self.scope.of_things:
            goals.append(Struct("\\+", (Struct("memberchk", (one, self.parts())),)))
        # What follows from outer names cannot choose beforehand.
        free = test is not None and not self._is_mentioned(where, self.outer)
        if free and test is not None:
            goals.append(Struct("possible", (state_only(test),)))
        # Sorted: a verdict does not depend on the order of the facts.
        found, others = self.names.fresh("found"), self.names.fresh(f"{name}s")
        self.goals.append(Struct("findall", (one, conjunction(goals), found)))
        self.goals.append(Struct("sort", (found, others)))
        return others, test

    def _is_mentioned(self, node: s.Expression | None, names: frozenset[str]) -> bool:
        return node is not None and any(
            isinstance(inner, s.Name) and inner.text in names for inner in walk(node)
        )

    def _write_each_of(self, node: s.EachOf) -> Term:
        first = self.scope.symbols.get(node.of[0].text)
        if len(node.of) == 1 and isinstance(first, SetSymbol):
            return self._write_each_of_set(node, self.shapes[first.name])
        bound = [self.bound(name.text) for name in node.of]
        kinds = frozenset[Kind]().union(*(b.kinds for b in bound))
        variables = [self.names.fresh(name.text) for name in node.names]
        model = bound[0].model
        inner = self.with_locals(
            **{n.text: Bound(v, kinds, model) for n, v in zip(node.names, variables, strict=True)}
        )
        functor = "each" if len(variables) == 1 else "each_pair"
        terms = tuple(b.term for b in bound)
        return Struct(functor, (*variables, terms, inner.test(node.body)))

    def _write_each_of_set(self, node: s.EachOf, shape: SetShape) -> Term:
        members = self.members(shape)
        patterns, conditions = [], []
        inner = self
        for name in node.names:
            pattern, bound, test = shape.copy(self, name.text)
            patterns.append(pattern)
            conditions.append(test)
            inner = inner.with_locals(**bound)
        body = inner.test(node.body)
        wanted = [c for c in conditions if c != NOTHING]
        if wanted:
            body = Struct("implies", (join_goals(wanted), body))
        functor = "each" if len(patterns) == 1 else "each_pair"
        return Struct(functor, (*patterns, members, body))

    def _write_there(self, node: s.There) -> Term:
        low, high = (node.count.least, node.count.most) if node.count else (1.0, math.inf)
        demanded = self.scope.demanded(node, node.name)
        first = self.scope.symbols.get(node.of[0].text) if node.of else None
        among = frozenset[Kind]()
        if isinstance(first, SetSymbol) and len(node.of) == 1:
            shape = self.shapes[first.name]
            pattern, bound, own = shape.copy(self, node.name.text)
            inner = self.with_locals(**bound)
            where = inner.test(demanded) if demanded is not None else NOTHING
            some: Term = self.members(shape)
            test = join_goals([t for t in (own, where) if t != NOTHING] or [NOTHING])
        elif node.of:
            bounds = [self.bound(name.text) for name in node.of]
            kinds = frozenset[Kind]().union(*(b.kinds for b in bounds))
            pattern, inner = self._introduce_local(node.name.text, kinds, bounds[0].model)
            test = inner.test(demanded) if demanded is not None else NOTHING
            some = self._find_seen(tuple(b.term for b in bounds))
        else:
            variable, kinds, inner = self._introduce_element(node.kind, node.name)
            some, own_where = self._find_others(kinds, demanded, node.name.text, variable, inner)
            pattern, test = variable, own_where if own_where is not None else NOTHING
            among = kinds
        if node.count is None:
            found = Struct("some", (pattern, some, test))
            return write_some_test(found, among, some=node.some)
        one = self.names.fresh("member")
        groups = self.names.fresh(f"{node.name.text}_groups")
        self.goals.append(Struct("findall", ((one,), Struct("member", (one, some)), groups)))
        return write_amount_test(pattern, groups, test, low, high, among)

    def _find_seen(self, parts: tuple[Term, ...]) -> Term:
        """Return the goal that selects the parts that were seen: an unseen part is no witness."""
        return self.once(
            f"seen {parts}",
            "Seen",
            lambda var: [Struct("exclude", (Struct("==", (UNSEEN,)), parts, var))],
        )


_TURNED = {
    s.Comparator.AT_LEAST: s.Comparator.AT_MOST,
    s.Comparator.AT_MOST: s.Comparator.AT_LEAST,
    s.Comparator.EQUAL: s.Comparator.EQUAL,
    s.Comparator.ABOUT: s.Comparator.ABOUT,
}
"""What a comparison says when its sides are changed."""


def _is_count(node: s.Expression) -> bool:
    return isinstance(node, s.Call) and node.name.text == "count"


def _drop_sign(term: Term) -> Term:
    """Return a number or length without its sign; a measure as it is."""
    match term:
        case int() | float():
            return abs(term)
        case Struct("metres", (int() | float() as value,)):
            return Struct("metres", (abs(value),))
        case _:
            return term


WriterOf = Callable[[], Writer]
"""Makes a writer for a new clause."""
