"""Faults of model files as text and as JSON."""

import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from facetlog import __version__
from facetlog.grammar.faults import Fault, Fix, Severity
from facetlog.grammar.source import Source
from facetlog.plain_text import plain_text
from facetlog.terminal import shortened

__all__ = ["counted", "distinct", "errors_in", "faults_data", "faults_json", "faults_text", "plain"]

SCHEMA = "facetlog-model-check/1"


def plain(line: str) -> str:
    """A line without control characters, which would steer the terminal; tabs stay.

    >>> plain("a\\x1b[2Jb")
    'a\\ufffd[2Jb'
    """
    return "".join(c if c.isprintable() or c == "\t" else "\ufffd" for c in plain_text(line))


def distinct(faults: Iterable[Fault]) -> tuple[Fault, ...]:
    """The faults without those reported before: a file that several use has them once."""
    found = {(f.source.name, f.span, f.code, f.message): f for f in faults}
    return tuple(found.values())


def errors_in(faults: Sequence[Fault]) -> int:
    """How many of the faults keep a model from being used."""
    return sum(fault.severity is Severity.ERROR for fault in faults)


def counted(number: int, noun: str) -> str:
    """A number and its noun.

    >>> counted(1, "error"), counted(2, "error")
    ('1 error', '2 errors')
    """
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _summary(files: Sequence[Path], faults: Sequence[Fault]) -> str:
    errors = errors_in(faults)
    warnings = len(faults) - errors
    if not faults:
        return f"{counted(len(files), 'file')}, no faults"
    said = [counted(errors, "error")] if errors else []
    said += [counted(warnings, "warning")] if warnings else []
    return f"{counted(len(files), 'file')}, {' and '.join(said)}"


def faults_text(files: Sequence[Path], faults: Sequence[Fault]) -> str:
    """Each fault with its place, line and carets, then one line that counts them."""
    return "\n".join([*_lines(faults), _summary(files, faults)])


def _lines(faults: Iterable[Fault]) -> Iterator[str]:
    for fault in faults:
        yield from (plain(shortened(line)) for line in fault.lines())


def faults_json(files: Sequence[Path], faults: Sequence[Fault]) -> str:
    """The same as one JSON object; lines and columns from 1, columns in characters."""
    errors = errors_in(faults)
    data = {
        "schema": SCHEMA,
        "facetlog": __version__,
        "files": [str(path) for path in files],
        "errors": errors,
        "warnings": len(faults) - errors,
        "faults": faults_data(faults),
    }
    return json.dumps(data, indent=1)


def faults_data(faults: Iterable[Fault]) -> list[dict[str, object]]:
    """Each fault as plain data."""
    return [_fault(fault) for fault in faults]


def _fault(fault: Fault) -> dict[str, object]:
    line, column = fault.source.line_and_column(fault.span.start)
    end_line, end_column = fault.source.line_and_column(fault.span.end)
    return {
        "code": fault.code,
        "severity": fault.severity.value,
        "message": fault.message,
        "hint": fault.hint,
        "file": fault.source.name,
        "line": line,
        "column": column,
        "end_line": end_line,
        "end_column": end_column,
        "fixes": [_fix(fault.source, fix) for fix in fault.fixes],
    }


def _fix(source: Source, fix: Fix) -> dict[str, object]:
    edits = []
    for edit in fix.edits:
        line, column = source.line_and_column(edit.span.start)
        end_line, end_column = source.line_and_column(edit.span.end)
        place = {"line": line, "column": column, "end_line": end_line, "end_column": end_column}
        edits.append({**place, "text": edit.text})
    return {"title": fix.title, "sure": fix.sure, "edits": edits}
