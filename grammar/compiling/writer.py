"""The parts of a clause: terms of names and measures, and the goals that find them."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Self

from facetlog.grammar import syntax as s
from facetlog.grammar.constants import Constant, constant, quantity
from facetlog.grammar.scope import THIS, Scope, SetSymbol, iter_conditions, names_in
from facetlog.grammar.terms import Atom, Struct, Term, Var
from facetlog.grammar.traversal import Node, walk
from facetlog.grammar.units import Dimension
from facetlog.grammar.vocabulary import (
    EACH_HOLE,
    HOLLOW,
    IN_SPACE,
    OPENING,
    PIECE,
    THING,
    VOCABULARY,
    Kind,
    Kinds,
)


class Names:
    """Variables for names, each different; asked for again a name keeps its variable."""

    def __init__(self) -> None:
        self._of: dict[str, Var] = {}
        self._taken: set[str] = {"Thing", "Parts", "_"}

    def __getitem__(self, name: str) -> Var:
        """Return the variable of a name: `top` becomes Top."""
        if name not in self._of:
            self._of[name] = self.fresh(name)
        return self._of[name]

    def fresh(self, name: str) -> Var:
        """Return a new variable that is called like a name."""
        first = name[:1].upper()
        # A Prolog variable begins with a capital letter; not every script has one.
        stem = first + name[1:] if first.isascii() and first.isalpha() else f"V_{name}"
        found = stem
        number = 2
        while found in self._taken:
            found = f"{stem}{number}"
            number += 1
        self._taken.add(found)
        return Var(found)

    def copy(self) -> "Names":
        """Return a copy to which names can be added."""
        other = Names()
        other._of = dict(self._of)
        other._taken = set(self._taken)
        return other


# Measures that exist for faces and for things: the vocabulary's names of those of things.
_OF_THINGS = {"length": "thing_length", "width": "thing_width", "height": "thing_height"}
# Words of pieces and of other parts. Those of pieces have names of their own in Prolog, so that a
# model of faces alone does not compute pieces.
_OF_PIECES_TOO = frozenset(word.name for word in VOCABULARY.values() if word.arguments[0] > PIECE)
# Words of pieces and openings, which share such a name.
_IN_SPACE = frozenset(word.name for word in VOCABULARY.values() if word.arguments[0] == IN_SPACE)
# How the middle of one thing is compared with that of another whose words have other names.
_BY_ELEVATION = {"above": "at_least", "below": "at_most"}


@dataclass(frozen=True, slots=True)
class Bound:
    """The meaning of a name in a clause: its term, kinds, and the model if it is an object."""

    term: Term
    kinds: Kinds
    model: str = ""


def amount(value: Constant) -> Term:
    """Return a constant as a test writes it."""
    if value.value == 0:
        return 0
    match value.dimension:
        case Dimension.LENGTH:
            return Struct("metres", (value.value,))
        case Dimension.AREA:
            return Struct("*", (Struct("metres", (value.value,)), Struct("metres", (1,))))
        case _:
            return value.value


def scaled(factor: float, term: Term) -> Term:
    """Return a measure times a factor."""
    factor = float(f"{factor:.15g}")
    if factor == 1:
        return term
    if isinstance(term, int | float):
        return float(f"{factor * term:.15g}")
    if isinstance(term, Struct) and term.functor == "metres":
        (value,) = term.args
        if isinstance(value, int | float):
            return Struct("metres", (float(f"{factor * value:.15g}"),))
    return Struct("*", (factor, term))


def write_word(name: str, arguments: tuple[Bound, ...]) -> Struct:
    """Return a measure or relation of the vocabulary with its arguments."""
    if name in _BY_ELEVATION and arguments[0].kinds != arguments[1].kinds:
        middles = tuple(write_word("elevation", (argument,)) for argument in arguments)
        return Struct(_BY_ELEVATION[name], middles)
    kinds = arguments[0].kinds
    if name in _OF_THINGS and kinds == THING:
        name = _OF_THINGS[name]
    elif (name in _OF_PIECES_TOO and kinds == PIECE) or (name in _IN_SPACE and kinds <= IN_SPACE):
        name = f"piece_{name}"
    elif kinds in EACH_HOLE:
        name = f"opening_{name}"
    return Struct(name, tuple(argument.term for argument in arguments))


def is_number(term: Term) -> bool:
    """Return whether a term is a number, or a length in metres."""
    return isinstance(term, int | float) or (isinstance(term, Struct) and term.functor == "metres")


@dataclass(frozen=True, slots=True)
class SetShape:
    """A set, the parts of its members that are asked for, and the word that says who is one.

    A member is the thing or element itself, or, where its own parts are asked for (`seat.back`),
    Member-Part-...; `needs` are the singular parts that its condition names.
    """

    symbol: SetSymbol
    roles: tuple[tuple[str, Kinds], ...]
    needs: tuple[str, ...]
    needs_thing: bool
    word: str
    where: s.Expression | None

    @property
    def separate(self) -> bool:
        """Whether members that belong together count once: no two pieces or openings do."""
        return self.symbol.owned.node.separate and not self.symbol.kinds <= IN_SPACE

    def variables(self, names: Names, stem: str) -> tuple[Var, ...]:
        return tuple(names[n] for n in (stem, *(f"{stem}_{role}" for role, _ in self.roles)))

    def pattern(self, names: Names) -> Term:
        """Return the term of a member."""
        return _join_variables(self.variables(names, self.symbol.name))

    def bound(self, names: Names) -> dict[str, Bound]:
        """Return the meanings of the set's name and of its members' parts."""
        return self._bind(self.variables(names, self.symbol.name), self.symbol.name)

    def _bind(self, variables: tuple[Var, ...], name: str) -> dict[str, Bound]:
        first, *rest = variables
        found = {name: Bound(first, self.symbol.kinds, self.symbol.model)}
        for (role, kinds), variable in zip(self.roles, rest, strict=True):
            found[f"{name}.{role}"] = Bound(variable, kinds)
        return found

    def test(self, writer: "MeasureWriter") -> Term:
        """Return the test that the member is one."""
        return self._test(self.variables(writer.names, self.symbol.name), writer)

    def _test(self, variables: tuple[Var, ...], writer: "MeasureWriter") -> Term:
        tests: list[Term] = []
        if self.symbol.model:
            tests.append(Struct("is_a", (variables[0], Atom(self.symbol.model))))
        if self.where is not None:
            tests.append(self.said_of(variables, writer))
        return tests[0] if len(tests) == 1 else Struct("all", (tuple(tests),))

    def said_of(self, variables: tuple[Var, ...], writer: "MeasureWriter") -> Struct:
        """Return the word that says who is a member, of such variables."""
        needed = [writer.bound(name).term for name in self.needs]
        if self.needs_thing:
            needed.append(Var("Thing"))
        return Struct(self.word, (*variables, *needed))

    def implied(self, writer: "MeasureWriter", body: Term) -> Term:
        """Return the condition that `body` holds if the element belongs to the set."""
        test = self.test(writer)
        return body if test == Struct("all", ((),)) else Struct("implies", (test, body))

    def copy(self, writer: "MeasureWriter", name: str) -> tuple[Term, dict[str, Bound], Term]:
        """Return pattern, names and test of a member that is called otherwise."""
        stems = (name, *(f"{name}_{role}" for role, _ in self.roles))
        variables = tuple(writer.names.fresh(stem) for stem in stems)
        return (
            _join_variables(variables),
            self._bind(variables, name),
            self._test(variables, writer),
        )


def _join_variables(variables: tuple[Var, ...]) -> Term:
    term: Term = variables[0]
    for variable in variables[1:]:
        term = Struct("-", (term, variable))
    return term


def set_shapes(scope: Scope) -> dict[str, SetShape]:
    """Return the sets of a model by name."""
    model = scope.model
    statements: list[Node] = [owned.node for _, owned in model.lines]
    statements += [owned.node for owned in model.parts]
    statements += [owned.node for owned in model.sizes]
    asked = _find_members_asked(statements)
    shapes = {}
    for symbol in scope.sets:
        own = scope.roles.get(symbol.model, {})
        roles = tuple(
            (role, own[role]) for role in sorted(asked.get(symbol.name, ())) if role in own
        )
        where = scope.where(symbol)
        named = names_in(where, scope)
        searches = _is_search(where, scope) or "count" in named
        needs = tuple(p.name for p in scope.singular if searches or p.name in named)
        word = f"{model.name}.{symbol.name}"
        shapes[symbol.name] = SetShape(
            symbol,
            roles,
            needs,
            searches or THIS in named,
            word,
            where,
        )
    return shapes


def _is_search(node: s.Expression | None, scope: Scope) -> bool:
    """Return whether a condition goes through the thing: then it needs the thing and all parts."""
    return any(
        isinstance(inner, s.There | s.Each | s.EachOf | s.Aggregate)
        for one in iter_conditions(node, scope)
        for inner in walk(one)
    )


def _find_members_asked(nodes: Iterable[Node]) -> dict[str, set[str]]:
    found: dict[str, set[str]] = {}
    for node in nodes:
        for inner in walk(node):
            if isinstance(inner, s.Member):
                found.setdefault(inner.owner.text, set()).add(inner.part.text)
    return found


UNSEEN = Atom("unseen")
NOTHING = Struct("all", ((),))
"""The test that always holds."""

_FINDERS = {
    frozenset({Kind.FACE}): "face_of",
    frozenset({Kind.EDGE}): "edge_of",
    frozenset({Kind.VERTEX}): "vertex_of",
    frozenset({Kind.FACE, Kind.EDGE}): "element_of",
    PIECE: "piece_in",
    OPENING: "opening_through",
    HOLLOW: "hollow_in",
}


def write_elements_goal(kinds: Kinds, term: Term) -> Struct:
    """Return the goal that finds elements of some kinds in the thing; things for objects."""
    if kinds == THING:
        return Struct("thing", (term,))
    return Struct(_FINDERS[kinds], (Var("Thing"), term))


def join_goals(tests: list[Term]) -> Term:
    """Return one test of several."""
    flat: list[Term] = []
    for test in tests:
        match test:
            case Struct("all", (tuple() as inner,)):
                flat.extend(inner)
            case _:
                flat.append(test)
    return flat[0] if len(flat) == 1 else Struct("all", (tuple(flat),))


def state_only(test: Term) -> Term:
    """Return a test without what changes its degree alone: who asks whether it holds needs no
    more."""
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
    """Return several goals in the place of one."""
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
        """Return the term that a name stands for."""
        if name in self.locals:
            return self.locals[name]
        if name == THIS:
            return Bound(Var("Thing"), THING)
        symbol = self.scope.symbols[name]
        return Bound(self.names[name], symbol.kinds, symbol.model)

    def parts(self) -> tuple[Term, ...]:
        """Return the singular parts, as the head of a clause names them."""
        return tuple(self.names[part.name] for part in self.scope.singular)

    def with_locals(self, **bound: Bound) -> Self:
        """Return the writer with more names; the goals it finds come before this clause's test."""
        return replace(self, locals={**self.locals, **bound}, outer=self.outer | frozenset(bound))

    def once(self, key: str, stem: str, goal_of: Callable[[Var], list[Term]]) -> Var:
        """Return a variable that a goal binds, the same goal once for a clause."""
        if key not in self.found:
            found = self.names.fresh(stem)
            self.found[key] = found
            self.goals.extend(goal_of(found))
        return self.found[key]

    def argument(self, node: s.Expression) -> Bound:
        """Return the argument that a word is applied to."""
        match node:
            case s.Reference(name):
                return self.bound(name.text)
            case s.Member(owner, part):
                return self._write_member(owner.text, part.text)
        raise TypeError(node)

    def _write_member(self, owner: str, part: str) -> Bound:
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
        """Return the writer in which a definition's parameters stand for its arguments."""
        parameters = self.scope.defines[name].node.parameters
        bound = [self.argument(argument) for argument in arguments]
        given = {p.text: b for p, b in zip(parameters, bound, strict=True)}
        return replace(self, locals={**self.locals, **given}, outer=self.outer | frozenset(given))

    def members(self, shape: SetShape) -> Var:
        """Return the variable of all that may be members of a set."""
        name = shape.symbol.name
        model = Atom(self.scope.model.name)
        return self.once(
            f"members {name}",
            f"{name}_members",
            lambda var: [Struct("members", (model, Atom(name), Var("Thing"), self.parts(), var))],
        )

    def held(self, shape: SetShape) -> Var:
        """Return the members of a set of which it is known that they are."""
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
        """Return the term that a measure is."""
        value = constant(node, self.scope.lets)
        if value is not None:
            return amount(value)
        match node:
            case s.Call(name, arguments):
                return self._write_measured(name.text, arguments)
            case s.Arithmetic(sign, left, right):
                return Struct(sign, (self.measure(left), self.measure(right)))
            case s.Negative(operand):
                return Struct("-", (self.measure(operand),))
            case s.Share(share, whole):
                part = quantity(share)
                assert part is not None  # noqa: S101  the checker has seen to it
                return scaled(part.value, self.measure(whole))
            case s.Aggregate():
                return self._write_aggregate(node)
        raise TypeError(node)

    def _write_measured(self, name: str, arguments: tuple[s.Expression, ...]) -> Term:
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
        return write_word(name, tuple(map(self.argument, arguments)))

    def _write_aggregate(self, node: s.Aggregate) -> Term:
        shape = next(
            self.shapes[inner.text]
            for inner in walk(node.operand)
            if isinstance(inner, s.Name) and inner.text in self.shapes
        )
        held = self.held(shape)
        pattern, bound, _ = shape.copy(self, shape.symbol.name)
        inner = self.with_locals(**bound)
        of = (
            inner.argument(node.operand).term
            if node.how.endswith(("gap", "spacing"))
            else inner.measure(node.operand)
        )
        values = self.names.fresh(f"{shape.symbol.name}_values")
        self.goals.append(Struct("findall", (of, Struct("member", (pattern, held)), values)))
        return Struct(node.how.replace(" ", "_"), (values,))


_NO_MORE: Mapping[Kinds, Struct] = {
    PIECE: Struct("pieces_known", (Var("Thing"),)),
    OPENING: Struct("openings_known", (Var("Thing"),)),
    HOLLOW: Struct("hollows_known", (Var("Thing"),)),
}
"""Kinds of parts of which all may be known, with the test that says so. Faces are not among them: a
round leg has none, but is a piece."""


def write_some_test(found: Struct, among: Kinds, *, some: bool) -> Term:
    """Return the test that one was found `among` all of such kinds that a thing has, or that none
    was.

    As long as a thing may have more openings or hollows than were seen nobody knows that there is
    none; what there is besides of other kinds is not asked.
    """
    if among not in EACH_HOLE:
        return found if some else Struct("not", (found,))
    known = _NO_MORE[among]
    if some:
        return Struct("any", ((found, Struct("not", (known,))),))
    return join_goals([Struct("not", (found,)), known])


def write_amount_test(
    pattern: Term, groups: Term, test: Term, low: float, high: float, among: Kinds
) -> Term:
    """Return the test of so many groups, `among` all of such kinds that a thing has."""
    tests: list[Term] = []
    known = _NO_MORE.get(among)
    if low > 0 and math.isfinite(low):
        least = math.ceil(low)
        if known is not None:
            counted = Struct("at_least_in", (least, known, pattern, groups, test))
        else:
            counted = Struct("at_least_of", (least, pattern, groups, test))
        tests.append(counted)
    if math.isfinite(high):
        tests.append(Struct("at_most_of", (math.floor(high), pattern, groups, test)))
        if among in EACH_HOLE:
            tests.append(_NO_MORE[among])
    return join_goals(tests) if tests else NOTHING
