"""A text with all that is sure put right."""

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.fixing.fix import Edit, applied

__all__ = ["Done", "Fixed", "apart", "fixed"]

MOST_ROUNDS = 100
"""Rounds of fixing: at most fifty faults are told at a time, and some hide others."""

UNREAD = frozenset({"bracket", "misspelt", "no-model", "open-text", "stray-text", "syntax"})
"""Faults of statements that cannot be read; what else is wrong with these shows afterwards."""

Check = Callable[[str], tuple[Fault, ...]]
"""The faults of a text."""


@dataclass(frozen=True, slots=True)
class Done:
    """One fix: the place in the text as it then was (line and column), the fault, what was done."""

    line: int
    column: int
    code: str
    title: str


@dataclass(frozen=True, slots=True)
class Fixed:
    """A text after all fixes that are sure, and what they were."""

    text: str
    done: tuple[Done, ...]


def fixed(text: str, check: Check) -> Fixed:
    """The text without the faults that have a sure fix; fixing it again changes nothing.

    A fix is kept only if its fault is gone after it and no statement can be read less well.
    """
    done: list[Done] = []
    refused: set[tuple[str, str]] = set()
    faults = _own(text, check(text))
    for _ in range(MOST_ROUNDS):
        chosen = [f for f in apart(faults) if _what(f) not in refused]
        if not chosen:
            break
        after, left = _after(text, chosen, check)
        if not _better(faults, left, chosen) and len(chosen) > 1:
            chosen = chosen[:1]
            after, left = _after(text, chosen, check)
        if not _better(faults, left, chosen):
            refused.add(_what(chosen[0]))
            continue
        done += map(_done, chosen)
        text, faults = after, left
    return Fixed(text, tuple(done))


def _after(text: str, chosen: Iterable[Fault], check: Check) -> tuple[str, tuple[Fault, ...]]:
    after = applied(text, _edits(chosen))
    return after, _own(after, check(after))


def _own(text: str, faults: Iterable[Fault]) -> tuple[Fault, ...]:
    """The faults of the text itself, not of files that it uses."""
    return tuple(fault for fault in faults if fault.source.text == text)


def apart(faults: Iterable[Fault]) -> tuple[Fault, ...]:
    """The faults with sure fixes, as many as can be made at once: those that do not touch."""
    found: list[Fault] = []
    end = -1
    for fault in sorted(faults, key=_place):
        fix = fault.sure_fix
        if fix is not None and fix.span.start > end:
            found.append(fault)
            end = fix.span.end
    return tuple(found)


def _place(fault: Fault) -> tuple[int, int]:
    span = fault.sure_fix.span if fault.sure_fix is not None else fault.span
    return span.start, span.end


def _edits(faults: Iterable[Fault]) -> tuple[Edit, ...]:
    fixes = (fault.sure_fix for fault in faults)
    return tuple(edit for fix in fixes if fix is not None for edit in fix.edits)


def _better(before: Iterable[Fault], after: tuple[Fault, ...], chosen: Iterable[Fault]) -> bool:
    had, has = Counter(f.code for f in before), Counter(f.code for f in after)
    mended = Counter(fault.code for fault in chosen)
    unread = sum(had[code] for code in UNREAD), sum(has[code] for code in UNREAD)
    # Of a statement that could not be read the rest shows only now.
    shown = any(fault.code in UNREAD for fault in chosen)
    gone = all(has[code] < had[code] for code in mended)
    errors = sum(f.severity is Severity.ERROR for f in after)
    no_worse = shown or errors <= sum(f.severity is Severity.ERROR for f in before)
    return unread[1] <= unread[0] and gone and no_worse


def _what(fault: Fault) -> tuple[str, str]:
    fix = fault.sure_fix
    return fault.message, fix.title if fix is not None else ""


def _done(fault: Fault) -> Done:
    line, column = fault.source.line_and_column(fault.span.start)
    return Done(line, column, fault.code, fault.sure_fix.title if fault.sure_fix else "")
