"""A goal asked and its answers shown: as a table, or as a line of JSON."""

import json
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import IntEnum
from itertools import islice
from typing import Any

from facetlog.errors import EngineError, FacetlogError, QueryError, RuleSyntaxError
from facetlog.kb.engine.answers import Answers
from facetlog.kb.engine.terms import Term
from facetlog.query_shell.meanings import Meaning, find_counting_unit, make_height_notes, meanings
from facetlog.query_shell.screen import Screen, find_fault_place
from facetlog.query_shell.session import Session
from facetlog.query_shell.shown_terms import convert_term
from facetlog.query_shell.table import Table

SCHEMA = "facetlog-answers/1"

BLOCK = 1000
"""Rows laid out and written at a time: memory stays flat however many there are."""

WAITING_SECONDS = 0.3
"""Time for which slow answers are kept back, so that columns are laid out together."""

COUNTING_SECONDS = 0.2
"""Time for which answers beyond the limit are counted: so short that nobody notices."""

LOOKING_SECONDS = 0.5
"""Time for which a further answer is searched, where it only matters whether there is one."""


class Outcome(IntEnum):
    """Outcome of a goal, as an exit code."""

    YES = 0
    NO = 1
    FAULT = 2
    ENGINE = 3


@dataclass(frozen=True, slots=True)
class _Rest:
    """How many answers were not shown, and whether there are more than that."""

    count: int
    more: bool

    def __str__(self) -> str:
        if self.more and not self.count:
            return "… perhaps more"
        return f"… {'more than ' if self.more else ''}{self.count:,} more"


@dataclass(frozen=True, slots=True)
class WaysToAll:
    """Ways to see the rows and the parts of cells that were left out."""

    rows: str
    cells: str


def get_outcome(error: FacetlogError) -> Outcome:
    """Return the outcome of a goal that ended with this error."""
    return Outcome.ENGINE if isinstance(error, EngineError) else Outcome.FAULT


def show_answers(
    session: Session, screen: Screen, goal: str, *, limit: int | None, ways: WaysToAll
) -> Outcome:
    """Write at most `limit` answers as a table, with `ways` to see what is left out.

    Errors are raised, after the answers that were found before them.
    """
    began = time.monotonic()
    with session.base.query(goal, scenes=session.scenes, most=limit) as answers:
        if not answers.names:
            return _show_yes_or_no(screen, answers)
        table = _Rows(session, screen, goal, answers)
        shown = table.show(answers, limit)
        if shown == 0:
            screen.begin_answer(table=False)
            screen.say("no")
            if unit := find_counting_unit(goal, session.length):
                screen.remark(f"goals count lengths in {unit}")
            return Outcome.NO
    rest = _count_rest(session, goal, shown) if shown == limit else _Rest(0, more=False)
    known = meanings(goal)
    for note in (*make_height_notes(known), *table.iter_unit_notes(goal)):
        screen.remark(note)
    if rest.count or rest.more:
        screen.say(f"{rest} ({ways.rows})")
    elif table.is_cut:
        screen.remark(f"… stands where a cell was cut ({ways.cells})")
    seconds = time.monotonic() - began
    total = shown + rest.count
    number = f"{'more than ' if rest.more else ''}{total:,} answer{'s' * (total != 1)}"
    screen.report(f"{number} in {_format_duration(seconds)}")
    return Outcome.YES


def show_every_answer(session: Session, screen: Screen, goal: str) -> Outcome:
    """Show all answers page by page; errors as for `show_answers`."""
    with session.base.query(goal, scenes=session.scenes) as answers:
        if not answers.names:
            return _show_yes_or_no(screen, answers)
        found = _UntilFault(answers)
        first = found.take(BLOCK)
        if not first and found.fault is not None:
            raise found.fault
        screen.begin_answer(table=bool(first))
        if not first:
            screen.say("no")
            return Outcome.NO
        # Nothing is cut here: a pager breaks or moves lines that are wider than the terminal.
        table = Table(answers.names, meanings(goal), session.length, scenes=session.base.scenes)
        screen.page(_iter_lines(table, first, found))
    if found.fault is not None:
        raise found.fault
    return Outcome.YES


def _show_yes_or_no(screen: Screen, answers: Answers) -> Outcome:
    found = next(answers, None) is not None
    screen.begin_answer(table=False)
    screen.say("yes" if found else "no")
    return Outcome.YES if found else Outcome.NO


class _UntilFault:
    """Answers that end where an error does, which is kept in `fault`."""

    def __init__(self, answers: Answers) -> None:
        self._answers = answers
        self.fault: FacetlogError | None = None

    def __iter__(self) -> Iterator[tuple[Term, ...]]:
        try:
            yield from self._answers
        except FacetlogError as exc:
            self.fault = exc

    def take(self, most: int) -> list[tuple[Term, ...]]:
        """Return at most so many of the next answers."""
        return list(islice(self, most))


def _iter_lines(table: Table, first: list[tuple[Term, ...]], rest: _UntilFault) -> Iterator[str]:
    block = table.block(first)
    yield from table.head(first)
    yield from block
    while rows := rest.take(BLOCK):
        yield from table.block(rows)


class _Rows:
    """A table that is written while its answers come in."""

    def __init__(self, session: Session, screen: Screen, goal: str, answers: Answers) -> None:
        self._screen, self._length = screen, session.length
        self._table = Table(
            answers.names,
            meanings(goal),
            session.length,
            width=screen.width,
            scenes=session.base.scenes,
        )
        self._headed = False

    @property
    def is_cut(self) -> bool:
        """Whether a cell did not fit the terminal."""
        return self._table.is_cut

    def iter_unit_notes(self, goal: str) -> Iterator[str]:
        """Say in which unit the goal counts, where it has numbers and the table another unit."""
        if find_counting_unit(goal, self._length):
            yield from self._table.iter_unit_notes()

    def show(self, answers: Answers, limit: int | None) -> int:
        """Write at most `limit` answers and return their number; raise an error after them."""
        shown = 0
        rows: list[tuple[Term, ...]] = []
        written = time.monotonic()
        try:
            for row in islice(answers, limit):
                rows.append(row)
                shown += 1
                if len(rows) == BLOCK or time.monotonic() - written > WAITING_SECONDS:
                    self._write(rows)
                    rows.clear()
                    written = time.monotonic()
        finally:
            self._write(rows)
        return shown

    def _write(self, rows: list[tuple[Term, ...]]) -> None:
        if not rows:
            return
        block = self._table.block(rows)
        if not self._headed:
            self._screen.begin_answer(table=True)
            head, rule = self._table.head(rows)
            self._screen.say(head, style="bold")
            self._screen.say(rule, style="dim")
            self._headed = True
        self._screen.say(*block)


def _count_rest(session: Session, goal: str, shown: int, most: int | None = None) -> _Rest:
    """Return how many answers there are beyond those shown, `most` in all or as there is time for.

    The goal is asked once more: one that has no further answer may not say so for ever, and what
    was shown must not wait for it.
    """
    count = 0
    began = time.monotonic()
    seconds = COUNTING_SECONDS if most is None else LOOKING_SECONDS
    limits = replace(session.base.limits, seconds=seconds)
    try:
        with session.base.query(goal, scenes=session.scenes, limits=limits, most=most) as answers:
            for chunk in answers.chunks():
                count += chunk.length
                # The limit is of processor time; the reader waits by the clock.
                if count > shown and time.monotonic() - began > seconds:
                    return _Rest(count - shown, more=True)
    except (FacetlogError, KeyboardInterrupt):
        # What was shown stands; only the number of the others is not known.
        return _Rest(max(0, count - shown), more=True)
    return _Rest(max(0, count - shown), more=False)


def _format_duration(seconds: float) -> str:
    """Format a time.

    >>> _format_duration(0.0123), _format_duration(2.34)
    ('12 ms', '2.3 s')
    """
    return f"{seconds * 1000:.0f} ms" if seconds < 1 else f"{seconds:.1f} s"


def write_answers(
    session: Session, screen: Screen, goal: str, *, limit: int | None, line: int | None = None
) -> Outcome:
    """Write the answers as one line of JSON, row by row as they come.

    `complete` is false if there are more than `limit`, or if an error, then in `error`, ended them.
    A goal that cannot be asked gives a line with `error` and no rows. Errors are raised as well.
    `line` is the goal's line in a file.
    """
    began = time.monotonic()
    try:
        answers = session.base.query(goal, scenes=session.scenes, most=limit)
    except FacetlogError as exc:
        screen.say(error_json(goal, exc, line=line))
        raise
    count = 0
    end: dict[str, Any] = {"complete": True}
    known = meanings(goal)
    with answers:
        head = {
            **_make_head(goal, line),
            "names": list(answers.names),
            "units": {
                name: _name_unit(known[name], session.length)
                for name in answers.names
                if name in known
            },
        }
        screen.raw(json.dumps(head)[:-1] + ', "rows": [')
        try:
            for row in answers:
                screen.raw(f"{', ' if count else ''}{json.dumps(list(map(convert_term, row)))}")
                count += 1
            if count == limit:
                rest = _count_rest(session, goal, count, count + 1)
                end["complete"] = not (rest.count or rest.more)
        except FacetlogError as exc:
            end = {"complete": False, "error": _convert_error(goal, exc)}
            raise
        except KeyboardInterrupt:
            end = {"complete": False, "error": {"kind": "interrupted", "message": "interrupted"}}
            raise
        finally:
            end = {"count": count, **end, "seconds": round(time.monotonic() - began, 6)}
            screen.raw(f"], {json.dumps(end)[1:]}\n")
            screen.flush()
    return Outcome.YES if count else Outcome.NO


def _name_unit(meaning: Meaning, length: str) -> str:
    """Return the unit for machines: deg, m, m², px, units; for all else the kind."""
    kind = meaning.kind.value
    return {"length": length, "length²": f"{length}²"}.get(kind, kind)


def error_json(goal: str, error: FacetlogError, *, line: int | None = None) -> str:
    """Format a question that failed, with the error, as a line of JSON."""
    return json.dumps({**_make_head(goal, line), "error": _convert_error(goal, error)})


def _make_head(goal: str, line: int | None) -> dict[str, Any]:
    return {"schema": SCHEMA, "goal": goal, **({} if line is None else {"line": line})}


def _convert_error(goal: str, error: FacetlogError) -> dict[str, Any]:
    """Convert an error to plain data, with its place in the goal (all of it, if unknown)."""
    if isinstance(error, EngineError):
        return {"kind": "engine", "message": str(error)}
    start, end = 0, len(goal)
    if isinstance(error, QueryError) and error.text:
        start, end = find_fault_place(error)
    kind = "models" if isinstance(error, RuleSyntaxError) else "question"
    return {"kind": kind, "message": str(error), "start": start, "end": end}
