"""Lines, sets and sizes of a model into clauses."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from facetlog.grammar import syntax as s
from facetlog.grammar.compiling.tests import Writer, WriterOf
from facetlog.grammar.compiling.writer import (
    NOTHING,
    UNSEEN,
    SetShape,
    conjunction,
    join_goals,
    state_only,
    write_elements_goal,
)
from facetlog.grammar.resolve import Owned
from facetlog.grammar.scope import PartSymbol, Scope
from facetlog.grammar.terms import ANYTHING, Atom, Clause, Struct, Term, Text, Var
from facetlog.grammar.traversal import Node, walk
from facetlog.grammar.vocabulary import EACH_HOLE, FACE, PIECE, Kinds

WEIGHTS = {"weakly": 0.10, "": 0.25, "strongly": 0.50}
"""How far the degree falls where an expectation fails (the language's definition)."""

_BLANK = re.compile(r"\s+")


def write_line_clauses(
    scope: Scope, shapes: Mapping[str, SetShape], writer_of: WriterOf
) -> list[Clause]:
    """Return the clauses of sets, conditions, groups, sizes, and of the text that they were made
    from.
    """
    clauses: list[Clause] = []
    for shape in shapes.values():
        clauses += _compile_set(scope, shape, writer_of)
    for owned in scope.model.parts:
        clauses += _compile_part(scope, shapes, owned, writer_of)
    for label, line in scope.model.lines:
        clauses += _compile_line(scope, label, line, writer_of)
    for shape in shapes.values():
        clauses.append(_write_group(scope, shape, writer_of))
    for size in scope.model.sizes:
        clauses += _compile_sizes(scope, size, writer_of)
    return clauses


def _quote_source(owned: Owned[s.Part] | Owned[s.Line], node: Node) -> str:
    """Return the author's text in one line."""
    return _BLANK.sub(" ", owned.source.text[node.span.start : node.span.end])


def _place(owned: Owned[s.Part] | Owned[s.Line] | Owned[s.Size]) -> str:
    name, line = owned.place
    return f"{Path(name).name}:{line}"


def _compile_line(
    scope: Scope, label: str, owned: Owned[s.Line], writer_of: WriterOf
) -> Iterator[Clause]:
    line = owned.node
    writer = writer_of()
    test = writer.test(line.condition)
    if line.if_known:
        test = Struct("if_known", (test,))
    if line.expect is not None:
        weight = WEIGHTS.get(line.expect)
        if weight is None:
            weight = float(line.expect.split()[0]) / 100
        test = Struct("expect", (weight, test))
    says = _quote_source(owned, line.condition)
    reason = line.reason.value if line.reason else says
    named = {n.text for n in walk(line.condition) if isinstance(n, s.Name)}
    yield from _write_condition(scope, label, reason, test, writer, _place(owned), says, named)


def _write_condition(
    scope: Scope,
    label: str,
    reason: str,
    test: Term,
    writer: Writer,
    place: str,
    says: str,
    named: set[str],
) -> Iterator[Clause]:
    """Iterate over the condition, and the text it was made from. Of an absent part nothing is
    asked.
    """
    model = Atom(scope.model.name)
    absent: list[Term] = [
        Struct("\\==", (writer.names[part.name], UNSEEN))
        for part in scope.singular
        if part.owned.node.optional and part.name in named
    ]
    head = Struct(
        "condition",
        (model, Atom(label), Text(reason), Var("Thing"), writer.parts(), test),
    )
    yield Clause(head, (*absent, *writer.goals), place, says)
    written = Struct("written", (model, Atom(label), Atom(place), Text(says)))
    yield Clause(written)


def _compile_part(
    scope: Scope,
    shapes: Mapping[str, SetShape],
    owned: Owned[s.Part],
    writer_of: WriterOf,
) -> Iterator[Clause]:
    """Compile the demands of a part's statement: `where`, the model of an object, a set's count."""
    part = owned.node
    for name in part.names:
        writer = writer_of()
        test = _write_demanded(scope, shapes, part, name.text, writer)
        if test == NOTHING:
            continue
        says = _quote_source(owned, part)
        if part.reason is not None:
            says = says.removesuffix(f'"{part.reason.value}"').rstrip()
        where = () if part.where is None else walk(part.where)
        named = {n.text for n in where if isinstance(n, s.Name)} | {name.text}
        reason = part.reason.value if part.reason else says
        yield from _write_condition(
            scope, name.text, reason, test, writer, _place(owned), says, named
        )


def _write_demanded(
    scope: Scope, shapes: Mapping[str, SetShape], part: s.Part, name: str, writer: Writer
) -> Term:
    """Return the test that a part is what its statement says, or a set has so many members."""
    if part.count is not None:
        if part.optional:
            return NOTHING
        return writer.write_count_test(shapes[name], part.count.least, part.count.most)
    symbol = scope.symbols[name]
    assert isinstance(symbol, PartSymbol)  # noqa: S101  it has no count
    tests: list[Term] = []
    if symbol.model:
        tests.append(Struct("is_a", (writer.names[name], Atom(symbol.model))))
    if symbol.kinds in EACH_HOLE and not part.optional:
        # Of a thing that has fewer the part stays unseen: then this fails, if they are all known.
        tests.append(writer.has_elements(symbol.kinds, len(_list_needed(scope, symbol.kinds))))
    needed = _list_needed(scope, PIECE)
    if needed[1:]:  # once is enough, and of a single one there is always the largest
        said = [p for p in needed if scope.where(p) is not None] or needed
        if symbol is said[-1]:
            tests.append(writer.has_elements(PIECE, len(needed)))
    where = scope.where(symbol)
    if where is not None:
        tests.append(writer.test(where))
    return join_goals(tests)


def _list_needed(scope: Scope, kinds: Kinds) -> list[PartSymbol]:
    """Return the single parts of such kinds that are not optional."""
    return [p for p in scope.singular if p.kinds == kinds and not p.owned.node.optional]


def _compile_set(scope: Scope, shape: SetShape, writer_of: WriterOf) -> Iterator[Clause]:
    """Iterate over who may be a member, and the word that says how far one is."""
    owned = shape.symbol.owned
    where = shape.where
    place = _place(owned)
    if where is not None:
        writer = writer_of()
        bound = shape.bound(writer.names)
        inner = writer.with_locals(**bound)
        test = inner.test(where)
        variables = shape.variables(writer.names, shape.symbol.name)
        head = Struct("means", (shape.said_of(variables, writer), test))
        yield Clause(head, tuple(writer.goals), place, _quote_source(owned, where))
    writer = writer_of()
    members = Var("Members")
    member = writer.names[shape.symbol.name]
    goals = _write_finding(scope, shape, writer, member)
    for role, _ in shape.roles:
        asked = writer.names[f"{shape.symbol.name}_{role}"]
        goals.append(Struct("part_in", (member, Atom(shape.symbol.model), Atom(role), asked)))
    test = shape.test(writer)
    if test != NOTHING:
        goals.append(Struct("possible", (state_only(test),)))
    found = Var("Found")
    head = Struct(
        "members",
        (Atom(scope.model.name), Atom(shape.symbol.name), Var("Thing"), writer.parts(), members),
    )
    every = Struct("findall", (shape.pattern(writer.names), conjunction(goals), found))
    yield Clause(head, (every, Struct("sort", (found, members))), place)


def _write_finding(scope: Scope, shape: SetShape, writer: Writer, member: Var) -> list[Term]:
    """Return the goals that go through what may be a member; a face that adjoins a part is found
    there.
    """
    others = tuple(
        writer.names[part.name] for part in scope.singular if part.kinds & shape.symbol.kinds
    )
    neighbour = _find_neighbour(shape, scope)
    if neighbour is not None:
        goals: list[Term] = [Struct("shared_edge", (writer.names[neighbour], member, ANYTHING))]
        others = tuple(o for o in others if o != writer.names[neighbour])
    else:
        goals = [write_elements_goal(shape.symbol.kinds, member)]
    if others:
        goals.append(Struct("\\+", (Struct("memberchk", (member, others)),)))
    return goals


def _find_neighbour(shape: SetShape, scope: Scope) -> str | None:
    """Return the singular part that every member adjoins."""
    where = shape.symbol.owned.node.where
    if where is None or shape.symbol.kinds != FACE:
        return None
    singular = {part.name for part in scope.singular if part.kinds == FACE}
    for node in where.conditions if isinstance(where, s.And) else (where,):
        match node:
            case s.Relation(s.Reference(left), s.Name("adjoins"), s.Reference(right)):
                pair = {left.text, right.text}
                if shape.symbol.name in pair and pair & singular:
                    (found,) = pair & singular
                    return found
            case s.Relation(s.Reference(left), s.Name("closes"), s.Reference(right)):
                if left.text == shape.symbol.name and right.text in singular:
                    return right.text
    return None


def _write_group(scope: Scope, shape: SetShape, writer_of: WriterOf) -> Clause:
    """Return the members that a verdict shows: those of which it is known."""
    writer = writer_of()
    head = Struct(
        "group",
        (
            Atom(scope.model.name),
            Var("Thing"),
            writer.parts(),
            Atom(shape.symbol.name),
            Var("Members"),
        ),
    )
    found = writer.members(shape)
    goals: list[Term] = [Struct("member", (shape.pattern(writer.names), found))]
    test = shape.test(writer)
    if test != NOTHING:
        goals.append(Struct("holds", (state_only(test),)))
    member = writer.names[shape.symbol.name]
    every = Struct("findall", (member, conjunction(goals), Var("Members")))
    return Clause(head, (*writer.goals, every), _place(shape.symbol.owned))


def _compile_sizes(scope: Scope, owned: Owned[s.Size], writer_of: WriterOf) -> Iterator[Clause]:
    size = owned.node
    model, place = Atom(scope.model.name), _place(owned)
    if not size.longest_first:
        for name, node in zip(size.names, size.measures, strict=True):
            writer = writer_of()
            measure = writer.measure(node)
            head = Struct("size", (model, Var("Thing"), writer.parts(), Atom(name.text), measure))
            yield Clause(head, tuple(writer.goals), place)
        return
    writer = writer_of()
    measures = tuple(writer.measure(node) for node in size.measures)
    names = tuple(Atom(name.text) for name in size.names)
    ordered, number = writer.names.fresh("sorted"), writer.names.fresh("number")
    label, measure_of = writer.names.fresh("name"), writer.names.fresh("measure")
    head = Struct("size", (model, Var("Thing"), writer.parts(), label, measure_of))
    body = (
        *writer.goals,
        Struct("longest_first", (measures, ordered)),
        Struct("nth1", (number, ordered, measure_of)),
        Struct("nth1", (number, names, label)),
    )
    yield Clause(head, body, place)
