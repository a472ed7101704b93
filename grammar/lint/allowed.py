"""Warnings that an author allows: `# lint: allow CODE` on the line of the warning, or above it.

A comment behind a statement speaks of its own line, one that stands alone of the next line that
holds anything but comments. Errors cannot be allowed.
"""

import re
from collections.abc import Iterable

from facetlog.grammar import syntax as s
from facetlog.grammar.faults import Fault, Fix, Severity, make_insertion
from facetlog.grammar.source import Source

_ALLOW = re.compile(r"#[ \t]*lint:[ \t]*allow\b[ \t]*(?P<codes>.*)$")
_CODE = re.compile(r"[^\s,]+")


def drop_allowed(file: s.File, faults: Iterable[Fault]) -> list[Fault]:
    """Return the faults less the warnings that the file allows."""
    source = file.source
    allowed: set[tuple[str, int]] = set()
    for comment in file.comments:
        match = _ALLOW.match(comment.text)
        if match is not None:
            line = source.get_line_and_column(comment.span.start)[0]
            if comment.alone:
                line = _next_line(source, line)
            allowed |= {(code, line) for code in _CODE.findall(match["codes"])}
    return [
        fault
        for fault in faults
        if fault.severity is Severity.ERROR
        or fault.source is not source
        or (fault.code, source.get_line_and_column(fault.span.start)[0]) not in allowed
    ]


def allow_fix(fault: Fault, comments: Iterable[s.Comment]) -> Fix:
    """Return the fix that allows a warning on its line."""
    source = fault.source
    number, column = source.get_line_and_column(fault.span.start)
    start = fault.span.start - column + 1
    end = start + len(source.line(number))
    title = f"allow `{fault.code}` here"
    comment = next((c for c in comments if start <= c.span.start < end), None)
    if comment is None:
        return make_insertion(title, end, f"  # lint: allow {fault.code}", sure=False)
    if _ALLOW.match(comment.text):
        at = comment.span.start + len(comment.text)
        return make_insertion(title, at, f", {fault.code}", sure=False)
    indent = re.match(r"[ \t]*", source.line(number))
    lead = indent[0] if indent is not None else ""
    return make_insertion(title, start, f"{lead}# lint: allow {fault.code}\n", sure=False)


def _next_line(source: Source, line: int) -> int:
    """Return the next line that holds anything but a comment; beyond the last if there is none."""
    last = source.get_line_and_column(len(source.text))[0]
    line += 1
    while line <= last and source.line(line).strip()[:1] in ("", "#"):
        line += 1
    return line
