"""A text with all that is sure put right: one fix after the other, each looked at again."""

from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass

from facetlog.grammar.faults import MOST_FAULTS, Fault, Severity, applied

MOST_TRIED = 1000
"""Fixes that are tried on one text; who needs more can ask again."""

UNREAD = frozenset(
    {
        "bracket",
        "decimal-comma",
        "misspelt",
        "no-model",
        "open-text",
        "quote",
        "stray-text",
        "syntax",
    }
)
"""Faults of statements that cannot be read; what else is wrong with these shows afterwards."""

UNCHECKED = "unknown-word"
"""A fault by which nothing else is known of a measure or relation; that shows afterwards."""

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
    """A text after all fixes that are sure, what they were, and the faults that are left."""

    text: str
    done: tuple[Done, ...]
    faults: tuple[Fault, ...]


def fixed(text: str, check: Check) -> Fixed:
    """Return the text without the faults that have a sure fix; fixing it again changes nothing.

    Each fix is made in the text that those before have left, and kept only if its fault is gone
    after it and nothing new is wrong: what makes another error was not meant. Where an error is
    gone warnings may show, for lint looks only at models without errors. Of a word that was unknown
    errors may show that have sure fixes, and of a statement that could not be read others, if their
    own fixes leave no more of them than before.
    """
    return _run(Fixed(text, (), _select_own(text, check(text))), check, frozenset())


def _run(state: Fixed, check: Check, passed_over: frozenset[Hashable]) -> Fixed:
    """Return the text after all sure fixes, but for those of faults that are passed over."""
    refused: set[Hashable] = set()
    for _ in range(MOST_TRIED):
        left = [
            f
            for f in state.faults
            if _identify(f) not in refused and _identify(f) not in passed_over
        ]
        fault = min((f for f in left if f.sure_fix is not None), key=_place, default=None)
        if fault is None:
            break
        after = _apply_fix(state, fault, check, passed_over)
        if after is None:
            refused.add(_identify(fault))
        else:
            state = after
            refused.clear()  # What was refused may do now.
    return state


def _apply_fix(
    state: Fixed, fault: Fault, check: Check, passed_over: frozenset[Hashable]
) -> Fixed | None:
    """Return the text after the fix of a fault, and those of the errors that show by it; None if
    that would be no better.
    """
    fix = fault.sure_fix
    text = applied(state.text, fix.edits if fix is not None else ())
    after = Fixed(text, (*state.done, _describe(fault)), _select_own(text, check(text)))
    if _identify(fault) in map(_identify, after.faults):
        return None
    known = passed_over | frozenset(map(_identify, state.faults))
    if fault.code not in UNREAD:
        if fault.code == UNCHECKED and not _is_better(state.faults, after.faults, fault.severity):
            after = _run(after, check, known)
        return after if _is_better(state.faults, after.faults, fault.severity) else None
    if _count_unread(after.faults) > _count_unread(state.faults):
        return None
    most = len(_select_errors(state.faults))
    if len(_select_errors(after.faults)) > most:
        after = _run(after, check, known)
    return after if len(_select_errors(after.faults)) <= most or _is_crowded(state.faults) else None


def _select_own(text: str, faults: Iterable[Fault]) -> tuple[Fault, ...]:
    """Return the faults of the text itself, not of files that it uses."""
    return tuple(fault for fault in faults if fault.source.text == text)


def _is_better(before: Sequence[Fault], after: Sequence[Fault], mended: Severity) -> bool:
    """Return whether one error less is left and none is new, and no warning either if it was a
    warning that was mended.
    """
    if mended is Severity.ERROR:
        before, after = _select_errors(before), _select_errors(after)
    if _is_crowded(before):
        return len(after) <= len(before) and _count_unread(after) <= _count_unread(before)
    return Counter(f.code for f in after) < Counter(f.code for f in before)


def _select_errors(faults: Iterable[Fault]) -> tuple[Fault, ...]:
    return tuple(fault for fault in faults if fault.severity is Severity.ERROR)


def _is_crowded(faults: Sequence[Fault]) -> bool:
    """Return whether there may be more faults than are listed, which show as others go."""
    return len(faults) >= MOST_FAULTS


def _count_unread(faults: Iterable[Fault]) -> int:
    return sum(fault.code in UNREAD for fault in faults)


def _place(fault: Fault) -> tuple[int, int]:
    span = fault.sure_fix.span if fault.sure_fix is not None else fault.span
    return span.start, span.end


def _identify(fault: Fault) -> Hashable:
    """Return what identifies a fault: its code, message and place."""
    line, column = fault.source.get_line_and_column(fault.span.start)
    return fault.code, fault.message, line, column


def _describe(fault: Fault) -> Done:
    line, column = fault.source.get_line_and_column(fault.span.start)
    return Done(line, column, fault.code, fault.sure_fix.title if fault.sure_fix else "")
