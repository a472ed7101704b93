"""Singular parts into the clauses that propose who plays them.

`likely` joins: for each part in turn what adjoins a part that is there, or else any face of the
thing; then at once whatever can be asked of the parts that are there, what needs one face before
what needs two. It proposes all that may hold, so no assignment that holds is overlooked. Where
there is none, `distant` proposes near misses: what adjoins as it should, and, part by part, the
largest faces that lie as they should and the largest pieces and openings, `unseen` where there is
none.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

from facetlog.grammar import syntax as s
from facetlog.grammar.compiling.symmetry import interchangeable
from facetlog.grammar.compiling.tests import Writer, WriterOf
from facetlog.grammar.compiling.writer import (
    NOTHING,
    UNSEEN,
    join_goals,
    state_only,
    write_elements_goal,
)
from facetlog.grammar.scope import THIS, PartSymbol, Scope
from facetlog.grammar.terms import ANYTHING, Atom, Clause, Struct, Term, Var
from facetlog.grammar.traversal import Node, walk
from facetlog.grammar.vocabulary import FACE, HOLLOW, OPENING, PIECE, THING, Gives


@dataclass(frozen=True, slots=True)
class Requirement:
    """One condition on singular parts; `substitutes` says what its names stand for.

    `identifies`: it says how a part lies (level, at right angles to another), or the author
    chose it by `where`, so that what does not satisfy it is not the part, rather than a bad one.
    """

    condition: s.Expression
    substitutes: tuple[tuple[str, str], ...]
    parts: frozenset[str]
    if_known: bool
    identifies: bool
    adjoins: tuple[str, str] | None = None


def requirements(scope: Scope) -> tuple[Requirement, ...]:
    """Return the requirements of a model on its singular parts, in the order of the file."""
    singular = {p.name: p for p in scope.singular if not p.owned.node.optional}
    found: list[Requirement] = []
    for part in singular.values():
        where = scope.where(part)
        if where is not None:
            found += _iter_requirements(where, scope, singular, {}, False, True)
    for _, owned in scope.model.lines:
        if owned.node.expect is None:
            found += _iter_requirements(
                owned.node.condition, scope, singular, {}, owned.node.if_known, False
            )
    return tuple(found)


def _iter_requirements(
    node: s.Expression,
    scope: Scope,
    singular: dict[str, PartSymbol],
    given: dict[str, str],
    if_known: bool,
    chosen: bool,
) -> Iterator[Requirement]:
    """Iterate over the single requirements that a condition is made of."""
    match node:
        case s.And(conditions):
            for condition in conditions:
                yield from _iter_requirements(condition, scope, singular, given, if_known, chosen)
            return
        case s.EachOf(names, of, body) if all(n.text in singular for n in of):
            for some in combinations([n.text for n in of], len(names)):
                inner = {**given, **dict(zip((n.text for n in names), some, strict=True))}
                yield from _iter_requirements(body, scope, singular, inner, if_known, chosen)
            return
    parts = _find_parts(node, scope, singular, given)
    if parts is None or not parts:
        return
    adjoins = _find_adjoining_pair(node, given)
    identifies = chosen or _is_orientation(node, scope)
    yield Requirement(node, tuple(given.items()), parts, if_known, identifies, adjoins)


def _find_parts(
    node: s.Expression, scope: Scope, singular: dict[str, PartSymbol], given: dict[str, str]
) -> frozenset[str] | None:
    """Return the singular parts that a condition is about; None if it is about more than these."""
    found: set[str] = set()
    waiting: list[tuple[Node, frozenset[str]]] = [(node, frozenset())]
    seen: set[str] = set()
    while waiting:
        one, parameters = waiting.pop()
        for inner in walk(one):
            match inner:
                case s.There() | s.Each() | s.EachOf() | s.Aggregate() | s.Member():
                    return None
                case s.Reference(name):
                    text = given.get(name.text, name.text)
                    if text in singular:
                        found.add(text)
                    elif text in parameters or text == THIS or text in scope.lets:
                        continue
                    else:
                        return None
                case s.Call(name) | s.Property(_, name) | s.Relation(_, name):
                    if name.text == "count":
                        return None
                    if name.text in scope.defines and name.text not in seen:
                        seen.add(name.text)
                        define = scope.defines[name.text].node
                        waiting.append((define.body, frozenset(p.text for p in define.parameters)))
    return frozenset(found)


def _find_adjoining_pair(node: s.Expression, given: dict[str, str]) -> tuple[str, str] | None:
    match node:
        case s.Relation(s.Reference(left), s.Name("adjoins"), s.Reference(right)):
            pass
        case s.Call(s.Name("adjoins"), (s.Reference(left), s.Reference(right))):
            pass
        case _:
            return None
    return given.get(left.text, left.text), given.get(right.text, right.text)


def _is_orientation(node: s.Expression, scope: Scope) -> bool:
    """Return whether it says how faces lie: a property of one, or an angle."""
    match node:
        case s.Property(_, name, False):
            word = scope.words.get(name.text)
            return word is not None and word.is_condition and len(word.arguments) == 1
        case s.Comparison(_, s.Call(name)):
            word = scope.words.get(name.text)
            return word is not None and word.gives is Gives.ANGLE
    return False


# How many of the largest faces are tried for the first part, the second, ... where no assignment
# may hold: near misses for a reader, and at most 60 in all.
_TRIED = {1: (20,), 2: (10, 4), 3: (6, 3, 3)}
_TRIED_MORE = (6, 3)
MOST_ADJOINING = 40
"""Assignments that adjoin as they should, the largest faces first, among the near misses."""


@dataclass(frozen=True, slots=True)
class _Join:
    scope: Scope
    needs: tuple[Requirement, ...]
    groups: tuple[tuple[str, ...], ...]

    def before(self, a: str, b: str) -> bool:
        """Return whether a comes before b in one group of interchangeable parts, next to it."""
        return any((a, b) in pairwise(g) for g in self.groups)

    def together(self, a: str, b: str) -> bool:
        """Return whether two parts are interchangeable, so that their order says that they
        differ.
        """
        return any(a in g and b in g for g in self.groups)


def write_candidate_clauses(
    scope: Scope, writer_of: WriterOf, place: str, says: str
) -> list[Clause]:
    """Return the clauses of candidate/3 and of what it calls, for a model."""
    model = Atom(scope.model.name)
    join = _Join(scope, requirements(scope), interchangeable(scope))
    thing, parts = Var("Thing"), Var("Parts")
    found = Var("Found")
    head = Struct("candidate", (model, thing, parts))
    choice = Struct(
        "->;",
        (
            Struct("==", (found, ())),
            Struct("distant", (model, thing, parts)),
            Struct("member", (parts, found)),
        ),
    )
    likely = Struct("likely", (model, thing, parts))
    body = (Struct("findall", (parts, likely, found)), choice)
    likely_ones = replace(
        _write_likely(join, writer_of), place=place, says="all that may satisfy its lines"
    )
    distant = [_write_adjoining(join, writer_of)] if _is_linked(join) else []
    distant.append(_write_as_far_as_seen(join, writer_of))
    distant = [replace(clause, place=place, says="near misses") for clause in distant]
    return [Clause(head, body, place, says), likely_ones, *distant]


def _make_head(join: _Join, writer: Writer, functor: str) -> Struct:
    return Struct(functor, (Atom(join.scope.model.name), Var("Thing"), writer.parts()))


def _test(need: Requirement, writer: Writer) -> Term:
    given = {name: writer.bound(part) for name, part in need.substitutes}
    inner = writer.with_locals(**given) if given else writer
    test = state_only(inner.test(need.condition))
    return Struct("if_known", (test,)) if need.if_known else test


def _wrap_possible(tests: list[Term]) -> list[Term]:
    return [Struct("possible", (join_goals(tests),))] if tests else []


def _order_parts(join: _Join) -> list[PartSymbol]:
    """Return the singular parts in the order of the join: what adjoins a part that is there comes
    next.
    """
    waiting = [p for p in join.scope.singular if not p.owned.node.optional]
    optional = [p for p in join.scope.singular if p.owned.node.optional]
    order: list[PartSymbol] = []
    while waiting:
        there = {p.name for p in order}
        linked = [p for p in waiting if _find_neighbours(join, p.name, there)]
        order.append((linked or waiting)[0])
        waiting.remove(order[-1])
    return order + optional


def _find_neighbours(join: _Join, name: str, there: set[str]) -> list[str]:
    found = []
    for need in join.needs:
        if need.adjoins is not None and name in need.adjoins and not need.if_known:
            (other,) = set(need.adjoins) - {name} or {name}
            if other in there and other not in found:
                found.append(other)
    return found


def _write_likely(join: _Join, writer_of: WriterOf) -> Clause:
    writer: Writer = writer_of()
    goals: list[Term] = []
    there: list[PartSymbol] = []
    for part in _order_parts(join):
        if part.owned.node.optional:
            goals.append(_write_optional(join, part, there, writer))
        elif part.kinds == THING:
            goals += _write_object(join, part, there, writer)
        else:
            goals += _place_part(join, part, there, writer, ordered=there)
            goals += _write_asked(join, part, there, writer)
        there.append(part)
    head = _make_head(join, writer, "likely")
    return Clause(head, (*writer.goals, *goals))


def _place_part(
    join: _Join,
    part: PartSymbol,
    there: list[PartSymbol],
    writer: Writer,
    ordered: list[PartSymbol],
) -> list[Term]:
    """Return the goals that bind a part and see that it is another than those that are there.

    Of interchangeable parts among those `ordered` one order is enough.
    """
    variable = writer.names[part.name]
    names = {p.name for p in there}
    neighbours = _find_neighbours(join, part.name, names) if part.kinds == FACE else []
    goals: list[Term] = []
    if neighbours:
        first, *others = neighbours
        goals.append(Struct("shared_edge", (writer.names[first], variable, ANYTHING)))
    else:
        others = []
        goals.append(write_elements_goal(part.kinds, variable))
    for other in there:
        if other in ordered and join.before(other.name, part.name):
            goals.append(Struct("@<", (writer.names[other.name], variable)))
        elif (
            other.kinds & part.kinds
            and other.name not in neighbours
            and not (other in ordered and join.together(other.name, part.name))
        ):
            goals.append(Struct("\\==", (variable, writer.names[other.name])))
    goals += [Struct("shared_edge", (writer.names[o], variable, ANYTHING)) for o in others]
    return goals


def _write_asked(
    join: _Join, part: PartSymbol, there: list[PartSymbol], writer: Writer
) -> list[Term]:
    """Write the tests that can be made once a part is bound: of it alone, then of it and others."""
    names = {p.name for p in there} | {part.name}
    alone: list[Term] = []
    more: list[Term] = []
    for need in join.needs:
        if part.name not in need.parts or not need.parts <= names:
            continue
        if need.adjoins is not None and not need.if_known:
            continue
        (alone if len(need.parts) == 1 else more).append(_test(need, writer))
    return _wrap_possible(_drop_repeats(alone)) + _wrap_possible(_drop_repeats(more))


def _drop_repeats(tests: list[Term]) -> list[Term]:
    return list(dict.fromkeys(tests))


def _write_object(
    join: _Join, part: PartSymbol, there: list[PartSymbol], writer: Writer
) -> list[Term]:
    variable = writer.names[part.name]
    goals: list[Term]
    if there:
        goals = [write_elements_goal(THING, variable)]
        goals += [Struct("\\==", (variable, writer.names[p.name])) for p in there]
    else:
        goals = [Struct("=", (variable, Var("Thing")))]
    goals.append(Struct("possible", (Struct("is_a", (variable, Atom(part.model))),)))
    return goals + _write_asked(join, part, there, writer)


def _write_optional(join: _Join, part: PartSymbol, there: list[PartSymbol], writer: Writer) -> Term:
    """Return a part that may be absent: whatever may be it, and nothing."""
    variable = writer.names[part.name]
    goals: list[Term] = [write_elements_goal(part.kinds, variable)]
    goals += [
        Struct("\\==", (variable, writer.names[p.name])) for p in there if p.kinds & part.kinds
    ]
    if part.model:
        goals.append(Struct("possible", (Struct("is_a", (variable, Atom(part.model))),)))
    where = join.scope.where(part)
    if where is not None:
        # What its condition goes through is found for each that may be it.
        alone = replace(writer, goals=[], found={})
        test = alone.test(where)
        goals += [*alone.goals, Struct("possible", (state_only(test),))]
    found = writer.names.fresh(f"{part.name}s")
    every = Struct(",", tuple(goals)) if len(goals) > 1 else goals[0]
    choices = Struct("findall", (variable, every, found))
    return Struct(",", (choices, Struct("member", (variable, Struct("[|]", (UNSEEN, found))))))


def _is_linked(join: _Join) -> bool:
    """Return whether every part adjoins one that is there before it."""
    order = _order_parts(join)
    return (
        len(order) > 1
        and all(p.kinds == FACE and not p.owned.node.optional for p in order)
        and all(
            _find_neighbours(join, part.name, {p.name for p in order[:number]})
            for number, part in enumerate(order)
            if number
        )
    )


def _write_adjoining(join: _Join, writer_of: WriterOf) -> Clause:
    """Return near misses that adjoin as they should, those of the largest faces first."""
    writer = writer_of()
    faces = writer.names.fresh("faces")
    first, *others = _order_parts(join)
    goals: list[Term] = [Struct("member", (writer.names[first.name], faces))]
    there = [first]
    for part in others:
        # The first is tried in the order of size; only the order of the others is free to choose.
        goals += _place_part(join, part, there, writer, ordered=there[1:])
        there.append(part)
    limited = Struct("limit", (MOST_ADJOINING, Struct(",", tuple(goals))))
    body = (Struct("largest_faces", (Var("Thing"), faces)), limited)
    head, ordered = _sort_interchangeable(join, writer, "distant")
    return Clause(head, (*body, *ordered))


def _write_fitting(join: _Join, writer: Writer) -> Term:
    """Return the goal that parts adjoin as they should and lie as they should."""
    goals: list[Term] = []
    there: list[PartSymbol] = []
    for part in _order_parts(join):
        goals += _place_part(join, part, there, writer, ordered=there)
        there.append(part)
        goals += _wrap_possible(_find_identifying(join, part, {p.name for p in there}, writer))
    return Struct(",", tuple(goals))


def _find_identifying(join: _Join, part: PartSymbol, there: set[str], writer: Writer) -> list[Term]:
    """Return how a part lies, as far as it can be asked of those that are there."""
    return _drop_repeats(
        [
            _test(need, writer)
            for need in join.needs
            if need.identifies and part.name in need.parts and need.parts <= there
        ]
    )


def _sort_interchangeable(join: _Join, writer: Writer, functor: str) -> tuple[Struct, list[Term]]:
    """Return the head with interchangeable parts sorted, and the goals that sort them."""
    goals: list[Term] = []
    shown = {p.name: writer.names[p.name] for p in join.scope.singular}
    for group in join.groups:
        given = tuple(shown[name] for name in group)
        for name in group:
            shown[name] = writer.names.fresh(name)
        goals.append(Struct("msort", (given, tuple(shown[name] for name in group))))
    head = Struct(functor, (Atom(join.scope.model.name), Var("Thing"), tuple(shown.values())))
    return head, goals


def _write_as_far_as_seen(join: _Join, writer_of: WriterOf) -> Clause:
    writer: Writer = writer_of()
    order = _order_parts(join)
    if join.scope.of_things:
        head = _make_head(join, writer, "distant")
        first, *rest = writer.parts()
        goals: list[Term] = [Struct("=", (first, Var("Thing")))]
        goals += [Struct("=", (other, UNSEEN)) for other in rest]
        return Clause(head, tuple(goals))
    counts = _TRIED.get(len(order), (*_TRIED_MORE, *(1 for _ in order[2:])))
    tried = dict(zip((part.name for part in order), counts, strict=True))
    required = [part for part in order if not part.owned.node.optional]
    there: set[str] = set()
    steps: list[Struct] = []
    for part in (part for part in required if part.kinds == FACE):
        there.add(part.name)
        tests = _find_identifying(join, part, there, writer)
        test = join_goals(tests) if tests else NOTHING
        steps.append(Struct("step", (writer.names[part.name], tried[part.name], test)))
    searches: list[Term] = []
    for kind, largest in _LARGEST.items():
        choices = _Choices(largest)
        for part in (part for part in required if part.kinds == kind):
            there.add(part.name)
            # Where one sees through is counted by the space that was seen, not by what was found.
            tests = _find_identifying(join, part, there, writer) if kind == PIECE else []
            choices.add(writer.names[part.name], tried[part.name], tests, writer)
        searches += choices.goals
    if steps or not searches:
        stepped = tuple(step.args[0] for step in steps)
        searches.insert(0, Struct("as_far_as_seen", (Var("Thing"), tuple(steps), stepped)))
    free = [Struct("=", (writer.names[p.name], UNSEEN)) for p in order if p.name not in there]
    head, ordered = _sort_interchangeable(join, writer, "distant")
    # Where faces adjoin and lie as they should, others that do not adjoin are no nearer.
    unless = [Struct("\\+", (_write_fitting(join, writer_of()),))] if _is_linked(join) else []
    return Clause(head, (*unless, *searches, *free, *ordered))


# What lists the pieces or openings of a thing, the largest first.
_LARGEST = {PIECE: "largest_pieces", OPENING: "largest_openings", HOLLOW: "largest_hollows"}


class _Choices:
    """The goals that propose pieces, or openings, one part after the other, none twice.

    Of a thing whose pieces are all known those that lie most as the part should are its nearest
    misses, the largest first. Of another only what may lie as the part does is proposed: any other
    is no bad one, for the part may be where nobody looked.
    """

    def __init__(self, largest: str) -> None:
        self._largest = largest
        self._all = Var(largest.removeprefix("largest_").capitalize())
        self._taken: list[Term] = []
        self.goals: list[Term] = []

    def add(self, variable: Var, count: int, tests: list[Term], writer: Writer) -> None:
        """Add a part, of which so many are tried; `tests` say how it lies."""
        if not self.goals:
            self.goals.append(Struct(self._largest, (Var("Thing"), self._all)))
        fitting = [writer.names.fresh(f"{variable.name}_fitting") for _ in tests]
        for test, found in zip(tests, fitting, strict=True):
            fits = Struct(
                ",",
                (Struct("member", (variable, self._all)), Struct("possible", (test,))),
            )
            self.goals.append(Struct("findall", (variable, fits, found)))
        free = writer.names.fresh(f"{variable.name}_nearest") if tests else self._all
        if tests:
            given = (Var("Thing"), self._all, tuple(fitting), free)
            self.goals.append(Struct("nearest_pieces", given))
        self.goals.append(Struct("piece_choice", (free, count, tuple(self._taken), variable)))
        self._taken.append(variable)
