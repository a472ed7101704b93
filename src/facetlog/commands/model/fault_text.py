"""Faults of model files as text and as JSON."""

import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog import __version__
from facetlog.plain_text import plain_text
from facetlog.plurals import many
from facetlog.terminal import shortened

if TYPE_CHECKING:
    from facetlog.grammar.faults import Fault, Fix
    from facetlog.grammar.source import Source

__all__ = [
    "count_errors",
    "distinct",
    "format_faults_json",
    "format_faults_text",
    "list_faults",
    "plain",
]

SCHEMA = "facetlog-model-check/1"


def plain(line: str) -> str:
    """Replace control characters, which would steer the terminal; tabs stay.

    >>> plain("a\\x1b[2Jb")
    'a\\ufffd[2Jb'
    """
    return "".join(c if c.isprintable() or c == "\t" else "\ufffd" for c in plain_text(line))


def distinct(faults: "Iterable[Fault]") -> "tuple[Fault, ...]":
    """Return the faults, each once: a file that several use has them only once."""
    found = {(f.source.name, f.span, f.code, f.message): f for f in faults}
    return tuple(found.values())


def count_errors(faults: "Sequence[Fault]") -> int:
    """Count the faults that keep a model from being used."""
    from facetlog.grammar.faults import Severity  # loaded on demand

    return sum(fault.severity is Severity.ERROR for fault in faults)


def _summarize(files: Sequence[Path], faults: "Sequence[Fault]") -> str:
    errors = count_errors(faults)
    warnings = len(faults) - errors
    if not faults:
        return f"{many(len(files), 'file')}, no faults"
    said = [many(errors, "error")] if errors else []
    said += [many(warnings, "warning")] if warnings else []
    return f"{many(len(files), 'file')}, {' and '.join(said)}"


def format_faults_text(files: Sequence[Path], faults: "Sequence[Fault]") -> str:
    """Format each fault with its place, line and carets, then where each code is explained, and one
    line that counts them.
    """
    codes = dict.fromkeys(fault.code for fault in faults)
    pages = (f"see {_find_address(code)}" for code in codes)
    return "\n".join([*_format_lines(faults), *pages, _summarize(files, faults)])


def _find_address(code: str) -> str:
    from facetlog.grammar.fault_codes import FAULT_KINDS  # loaded on demand

    return FAULT_KINDS[code].address


def _format_lines(faults: "Iterable[Fault]") -> Iterator[str]:
    for fault in faults:
        yield from (plain(shortened(line)) for line in fault.lines())


def format_faults_json(files: Sequence[Path], faults: "Sequence[Fault]") -> str:
    """Format the faults as one JSON object; lines and columns count from 1, in characters."""
    errors = count_errors(faults)
    data = {
        "schema": SCHEMA,
        "facetlog": __version__,
        "files": [str(path) for path in files],
        "errors": errors,
        "warnings": len(faults) - errors,
        "faults": list_faults(faults),
    }
    return json.dumps(data, indent=1)


def list_faults(faults: "Iterable[Fault]") -> list[dict[str, object]]:
    """Convert each fault to plain data."""
    return [_convert_fault(fault) for fault in faults]


def _convert_fault(fault: "Fault") -> dict[str, object]:
    line, column = fault.source.get_line_and_column(fault.span.start)
    end_line, end_column = fault.source.get_line_and_column(fault.span.end)
    return {
        "code": fault.code,
        "severity": fault.severity.value,
        "message": fault.message,
        "hint": fault.hint,
        "help": _find_address(fault.code),
        "file": fault.source.name,
        "line": line,
        "column": column,
        "end_line": end_line,
        "end_column": end_column,
        "fixes": [_convert_fix(fault.source, fix) for fix in fault.fixes],
    }


def _convert_fix(source: "Source", fix: "Fix") -> dict[str, object]:
    edits = []
    for edit in fix.edits:
        line, column = source.get_line_and_column(edit.span.start)
        end_line, end_column = source.get_line_and_column(edit.span.end)
        place = {"line": line, "column": column, "end_line": end_line, "end_column": end_column}
        edits.append({**place, "text": edit.text})
    return {"title": fix.title, "sure": fix.sure, "edits": edits}
