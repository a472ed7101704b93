"""All facts of a scene that mention a name, by kind of fact."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from facetlog.kb.engine.terms import Atom, Term
from facetlog.perception.facts.fact_schema import FACT_SCHEMA, ArgumentKind, FactKind
from facetlog.query_shell.meanings import length_unit, meanings
from facetlog.query_shell.scene_names import kind_of, names_of_kind, scene_names
from facetlog.query_shell.session import Session
from facetlog.query_shell.table import Table
from facetlog.query_shell.words import fact_signature, plain

MORE = "  … "
"""Begins the line that says how many facts of a kind were left out."""

LINE = 44
"""Cells for a fact that stands alone, before its meaning."""


@dataclass(frozen=True, slots=True)
class _Group:
    """The facts of one kind that mention the name."""

    kind: FactKind
    rows: tuple[tuple[Term, ...], ...]


def fact_lines(
    session: Session, scene: str, name: str, *, most: int | None, width: int | None
) -> Iterator[str]:
    """The facts that mention a name, grouped, with meaning and units; `most` of each kind.

    Nothing if the scene has no such name.
    """
    names = scene_names(session.base, (scene,))
    if kind_of(names, name) is None:
        return
    length = session.base.scenes[scene].length_unit or length_unit([None])
    for group in _groups(session, scene, name, names):
        table = _table(group, length, width)
        if len(group.rows) == 1:
            yield _line(group, table)
        else:
            yield f"{fact_signature(group.kind)}: {plain(group.kind.meaning)}"
            shown = group.rows[:most]
            block = table.block(shown)
            yield from (f"  {line}" for line in (*table.head(shown), *block))
            if len(shown) < len(group.rows):
                yield f"{MORE}{len(group.rows) - len(shown):,} more"


def _table(group: _Group, length: str, width: int | None) -> Table:
    columns = [argument.name for argument in group.kind.arguments]
    known = meanings(fact_signature(group.kind))
    return Table(columns, known, length, width=None if width is None else width - len("  "))


def _line(group: _Group, table: Table) -> str:
    """A fact that stands alone, its numbers with their units, and its meaning."""
    fact = f"{group.kind.functor}({', '.join(table.values(group.rows[0]))})"
    return f"{fact:<{LINE}}  {plain(group.kind.meaning)}"


def _groups(
    session: Session, scene: str, name: str, names: Mapping[ArgumentKind, tuple[str, ...]]
) -> Iterator[_Group]:
    for kind in FACT_SCHEMA:
        rows: dict[tuple[Term, ...], None] = {}
        for place, argument in enumerate(kind.arguments):
            if argument.kind.is_name and name in names_of_kind(names, argument.kind):
                rows.update(dict.fromkeys(_facts(session, scene, kind, place, name)))
        if rows:
            yield _Group(kind, tuple(rows))


def _facts(
    session: Session, scene: str, kind: FactKind, place: int, name: str
) -> Iterator[tuple[Term, ...]]:
    """The arguments of the facts with the name at a place."""
    variables = [f"A{i}" for i in range(kind.arity)]
    goal = f"{kind.functor}({', '.join(variables)})"
    given = {variables[place]: Atom(name)}
    with session.base.query(goal, scenes=(scene,), bindings=given) as answers:
        for row in answers:
            yield (*row[:place], Atom(name), *row[place:])
