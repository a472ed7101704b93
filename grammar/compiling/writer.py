"""What stands in a clause: the terms of names and measures, and the goals that find them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Self

from facetlog.grammar import syntax as s
from facetlog.grammar.compiling.measures import (
    Bound,
    aggregate_functor,
    amount,
    scaled,
    word_term,
)
from facetlog.grammar.compiling.names import Names
from facetlog.grammar.compiling.sets import SetShape
from facetlog.grammar.constants import constant, quantity
from facetlog.grammar.scope import THIS, Scope
from facetlog.grammar.terms import Atom, Struct, Term, Var
from facetlog.grammar.vocabulary import OPENING, PIECE, THING, Kind, Kinds

__all__ = [
    "NOTHING",
    "UNSEEN",
    "MeasureWriter",
    "all_of",
    "conjunction",
    "elements_goal",
    "state_only",
]

UNSEEN = Atom("unseen")
NOTHING = Struct("all", ((),))
"""The test that always holds."""

_FINDERS = {
    frozenset({Kind.FACE}): "face_of",
    frozenset({Kind.EDGE}): "edge_of",
    frozenset({Kind.VERTEX}): "vertex_of",
    frozenset({Kind.FACE, Kind.EDGE}): "element_of",
    PIECE: "piece_in",
    OPENING: "opening_of",
}


def elements_goal(kinds: Kinds, term: Term) -> Struct:
    """The goal that finds elements of some kinds in the thing; things for objects."""
    if kinds == THING:
        return Struct("thing", (term,))
    return Struct(_FINDERS[kinds], (Var("Thing"), term))


def all_of(tests: list[Term]) -> Term:
    """One test of several."""
    flat: list[Term] = []
    for test in tests:
        match test:
            case Struct("all", (tuple() as inner,)):
                flat.extend(inner)
            case _:
                flat.append(test)
    return flat[0] if len(flat) == 1 else Struct("all", (tuple(flat),))


def state_only(test: Term) -> Term:
    """A test without what changes its degree alone: who asks whether it holds needs no more."""
    match test:
        case Struct("soft", (comparison, _)):
            return comparison
        case Struct(functor, args):
            return Struct(functor, tuple(map(state_only, args)))
        case tuple():
            return tuple(map(state_only, test))
        case _:
            return test


def conjunction(goals: list[Term]) -> Term:
    """Several goals in the place of one."""
    return goals[0] if len(goals) == 1 else Struct(",", tuple(goals))


@dataclass(slots=True)
class MeasureWriter:
    """Writes the measures of one clause; `goals` are what must be found before."""

    scope: Scope
    shapes: Mapping[str, SetShape]
    names: Names = field(default_factory=Names)
    goals: list[Term] = field(default_factory=list)
    locals: dict[str, Bound] = field(default_factory=dict)
    outer: frozenset[str] = frozenset()
    found: dict[str, Var] = field(default_factory=dict)

    def bound(self, name: str) -> Bound:
        """What a name stands for."""
        if name in self.locals:
            return self.locals[name]
        if name == THIS:
            return Bound(Var("Thing"), THING)
        symbol = self.scope.symbols[name]
        return Bound(self.names[name], symbol.kinds, symbol.model)

    def parts(self) -> tuple[Term, ...]:
        """The singular parts, as the head of a clause names them."""
        return tuple(self.names[part.name] for part in self.scope.singular)

    def with_locals(self, **bound: Bound) -> Self:
        """The same clause with more names; what it finds comes before this clause's test."""
        return replace(self, locals={**self.locals, **bound}, outer=self.outer | frozenset(bound))

    def once(self, key: str, stem: str, goal_of: Callable[[Var], list[Term]]) -> Var:
        """A variable that a goal binds, the same goal once for a clause."""
        if key not in self.found:
            found = self.names.fresh(stem)
            self.found[key] = found
            self.goals.extend(goal_of(found))
        return self.found[key]

    def argument(self, node: s.Expression) -> Bound:
        """What a word is said of."""
        match node:
            case s.Reference(name):
                return self.bound(name.text)
            case s.Member(owner, part):
                return self._member(owner.text, part.text)
        raise TypeError(node)

    def _member(self, owner: str, part: str) -> Bound:
        key = f"{owner}.{part}"
        if key in self.locals:
            return self.locals[key]
        of = self.bound(owner)
        kinds = self.scope.roles[of.model][part]
        found = self.once(
            key,
            f"{owner}_{part}",
            lambda var: [Struct("part_in", (of.term, Atom(of.model), Atom(part), var))],
        )
        return Bound(found, kinds)

    def expanded(self, name: str, arguments: tuple[s.Expression, ...]) -> Self:
        """The same clause, where a definition's parameters stand for its arguments."""
        parameters = self.scope.defines[name].node.parameters
        bound = [self.argument(argument) for argument in arguments]
        given = {p.text: b for p, b in zip(parameters, bound, strict=True)}
        return replace(self, locals={**self.locals, **given}, outer=self.outer | frozenset(given))

    def members(self, shape: SetShape) -> Var:
        """The variable of all that may be members of a set."""
        name = shape.symbol.name
        model = Atom(self.scope.model.name)
        return self.once(
            f"members {name}",
            f"{name}_members",
            lambda var: [Struct("members", (model, Atom(name), Var("Thing"), self.parts(), var))],
        )

    def held(self, shape: SetShape) -> Var:
        """The members of a set of which it is known that they are."""
        members = self.members(shape)
        pattern, _, test = shape.copy(self, shape.symbol.name)
        goals: list[Term] = [Struct("member", (pattern, members))]
        if test != NOTHING:
            goals.append(Struct("holds", (state_only(test),)))
        return self.once(
            f"held {shape.symbol.name}",
            f"{shape.symbol.name}_held",
            lambda var: [Struct("findall", (pattern, conjunction(goals), var))],
        )

    def measure(self, node: s.Expression) -> Term:
        """The term that a measure is."""
        value = constant(node, self.scope.lets)
        if value is not None:
            return amount(value)
        match node:
            case s.Call(name, arguments):
                return self._measured(name.text, arguments)
            case s.Arithmetic(sign, left, right):
                return Struct(sign, (self.measure(left), self.measure(right)))
            case s.Negative(operand):
                return Struct("-", (self.measure(operand),))
            case s.Share(share, whole):
                part = quantity(share)
                assert part is not None  # noqa: S101  the checker has seen to it
                return scaled(part.value, self.measure(whole))
            case s.Aggregate():
                return self._aggregate(node)
        raise TypeError(node)

    def _measured(self, name: str, arguments: tuple[s.Expression, ...]) -> Term:
        if name == "count":
            (of,) = arguments
            assert isinstance(of, s.Reference)  # noqa: S101  the checker has seen to it
            shape = self.shapes[of.name.text]
            held = self.held(shape)
            if not shape.separate:
                return Struct("count", (held,))
            name = f"{shape.symbol.name}_held_groups"
            groups = self.once(name, name, lambda var: [Struct("separate", (held, var))])
            return Struct("count", (groups,))
        if name in self.scope.defines:
            return self.expanded(name, arguments).measure(self.scope.defines[name].node.body)
        return word_term(name, tuple(map(self.argument, arguments)))

    def _aggregate(self, node: s.Aggregate) -> Term:
        shape = next(
            self.shapes[inner.text]
            for inner in s.walk(node.operand)
            if isinstance(inner, s.Name) and inner.text in self.shapes
        )
        held = self.held(shape)
        pattern, bound, _ = shape.copy(self, shape.symbol.name)
        inner = self.with_locals(**bound)
        of = (
            inner.argument(node.operand).term
            if node.how.endswith("gap")
            else inner.measure(node.operand)
        )
        values = self.names.fresh(f"{shape.symbol.name}_values")
        self.goals.append(Struct("findall", (of, Struct("member", (pattern, held)), values)))
        return Struct(aggregate_functor(node.how), (values,))
