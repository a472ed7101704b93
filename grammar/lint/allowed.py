"""Warnings that an author allows: `# lint: allow CODE` on the line of the warning, or above it.

A comment behind a statement speaks of its own line, one that stands alone of the next line that
holds anything but comments. Errors cannot be allowed.
"""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from facetlog.grammar import syntax as s
from facetlog.grammar.fault_codes import FAULT_KINDS
from facetlog.grammar.faults import MOST_FAULTS, Fault, Severity, said
from facetlog.grammar.fixing.fix import Edit, Fix, insertion
from facetlog.grammar.fixing.respelling import respelling
from facetlog.grammar.source import Source, Span

__all__ = ["allowance", "not_allowed"]

_ALLOW = re.compile(r"#[ \t]*lint:[ \t]*allow\b[ \t]*(?P<codes>.*)$")
_CODE = re.compile(r"[^\s,]+")


@dataclass(frozen=True, slots=True)
class _Allowed:
    """A code in a comment; `line` is the one that it speaks of.

    `only` if its comment names no other code.
    """

    name: s.Name
    line: int
    comment: s.Comment
    only: bool


def not_allowed(file: s.File, faults: Iterable[Fault]) -> tuple[Fault, ...]:
    """The faults less the warnings that the file allows, with what is wrong with its allowances.

    An allowance that allows nothing is a warning where all others are known: not beside errors,
    which keep lint from looking, nor where there are too many faults to list all.
    """
    faults = tuple(faults)
    allowed = tuple(_allowances(file))
    if not allowed:
        return faults
    used: set[_Allowed] = set()
    left: list[Fault] = []
    for fault in faults:
        found = [one for one in allowed if _speaks_of(one, fault, file.source)]
        used.update(found)
        if not found:
            left.append(fault)
    all_known = len(faults) < MOST_FAULTS and not any(
        fault.severity is Severity.ERROR for fault in faults
    )
    for one in allowed:
        if one.name.text not in FAULT_KINDS:
            left.append(_unknown(one, file.source))
        elif one not in used and all_known:
            left.append(_idle(one, file.source))
    return tuple(left)


def allowance(fault: Fault, comments: Iterable[s.Comment]) -> Fix:
    """The fix that allows a warning on its line."""
    source = fault.source
    number, column = source.line_and_column(fault.span.start)
    start = fault.span.start - column + 1
    end = start + len(source.line(number))
    title = f"allow `{fault.code}` here"
    comment = next((c for c in comments if start <= c.span.start < end), None)
    if comment is None:
        return insertion(title, end, f"  # lint: allow {fault.code}", sure=False)
    if _ALLOW.match(comment.text):
        at = comment.span.start + len(comment.text)
        return insertion(title, at, f", {fault.code}", sure=False)
    indent = re.match(r"[ \t]*", source.line(number))
    lead = indent[0] if indent is not None else ""
    return insertion(title, start, f"{lead}# lint: allow {fault.code}\n", sure=False)


def _allowances(file: s.File) -> Iterator[_Allowed]:
    for comment in file.comments:
        match = _ALLOW.match(comment.text)
        if match is None:
            continue
        line = file.source.line_and_column(comment.span.start)[0]
        if comment.alone:
            line = _next_line(file.source, line)
        start = comment.span.start + match.start("codes")
        for code in _CODE.finditer(match["codes"]):
            span = Span(start + code.start(), start + code.end())
            yield _Allowed(s.Name(code[0], span), line, comment, len(match["codes"].split()) == 1)


def _next_line(source: Source, line: int) -> int:
    """The next line that holds anything but a comment; beyond the last if there is none."""
    last = source.line_and_column(len(source.text))[0]
    line += 1
    while line <= last and source.line(line).strip()[:1] in ("", "#"):
        line += 1
    return line


def _speaks_of(one: _Allowed, fault: Fault, source: Source) -> bool:
    return (
        fault.severity is Severity.WARNING
        and fault.code == one.name.text
        and fault.source is source
        and source.line_and_column(fault.span.start)[0] == one.line
    )


def _unknown(one: _Allowed, source: Source) -> Fault:
    message = f"no warning has the code `{one.name}`"
    hint, fixes = said(one.name.text, FAULT_KINDS), respelling(one.name, FAULT_KINDS)
    span = one.name.span
    return Fault("unknown-allowance", message, source, span, hint, Severity.WARNING, fixes)


def _idle(one: _Allowed, source: Source) -> Fault:
    if FAULT_KINDS[one.name.text].severity is Severity.ERROR:
        message = f"nothing is allowed here: there is no warning `{one.name}` on that line"
    else:
        message = f"there is no `{one.name}` on that line to be allowed"
    fixes = (_without(one, source),) if one.only else ()
    span = one.name.span
    return Fault("idle-allowance", message, source, span, "leave it out", Severity.WARNING, fixes)


def _without(one: _Allowed, source: Source) -> Fix:
    """Takes the comment out, with its line if it stands alone there."""
    start, end = one.comment.span.start, one.comment.span.start + len(one.comment.text)
    while start > 0 and source.text[start - 1] in " \t":
        start -= 1
    if one.comment.alone and source.text[end : end + 1] == "\n":
        end += 1
    return Fix("leave the allowance out", (Edit(Span(start, end), ""),), True)
