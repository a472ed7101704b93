"""Faults of model files as SARIF 2.1.0, which code hosts and editors show at their lines.

Source: OASIS Standard "Static Analysis Results Interchange Format (SARIF) Version 2.1.0", 2020.
"""

import json
import os
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import quote

from facetlog import __version__
from facetlog.grammar.fault_codes import FAULT_KINDS
from facetlog.grammar.faults import Fault, Fix
from facetlog.grammar.source import Source, Span

__all__ = ["format_faults_sarif"]

SCHEMA_ADDRESS = "https://json.schemastore.org/sarif-2.1.0.json"


def format_faults_sarif(files: Sequence[Path], faults: Sequence[Fault]) -> str:
    """Format a log with one run: the files, a rule per kind of fault, and a result per fault."""
    codes = sorted({fault.code for fault in faults})
    run = {
        "tool": {
            "driver": {
                "name": "facetlog",
                "version": __version__,
                "rules": [_make_rule(code) for code in codes],
            }
        },
        # Section 3.14.17: how columns are counted; the way of editors.
        "columnKind": "utf16CodeUnits",
        "artifacts": [{"location": {"uri": _make_uri(str(path))}} for path in files],
        "results": [_make_result(fault, codes.index(fault.code)) for fault in faults],
    }
    return json.dumps({"$schema": SCHEMA_ADDRESS, "version": "2.1.0", "runs": [run]}, indent=1)


def _make_rule(code: str) -> dict[str, object]:
    return {"id": code, "shortDescription": {"text": FAULT_KINDS[code].meaning}}


def _make_result(fault: Fault, rule: int) -> dict[str, object]:
    hint = f"; {fault.hint}" if fault.hint else ""
    region = _make_region(fault.source, fault.span)
    location = {"artifactLocation": {"uri": _make_uri(fault.source.name)}, "region": region}
    return {
        "ruleId": fault.code,
        "ruleIndex": rule,
        "level": fault.severity.value,
        "message": {"text": f"{fault.message}{hint}"},
        "locations": [{"physicalLocation": location}],
        **({"fixes": [_make_fix(fault.source, fix) for fix in fault.fixes]} if fault.fixes else {}),
    }


def _make_fix(source: Source, fix: Fix) -> dict[str, object]:
    """Convert a fix, as section 3.55 of the standard has it."""
    changes = [
        {"deletedRegion": _make_region(source, edit.span), "insertedContent": {"text": edit.text}}
        for edit in fix.edits
    ]
    artifact = {"artifactLocation": {"uri": _make_uri(source.name)}, "replacements": changes}
    return {"description": {"text": fix.title}, "artifactChanges": [artifact]}


def _make_region(source: Source, span: Span) -> dict[str, int]:
    start_line, start_column = _find_place(source, span.start)
    end_line, end_column = _find_place(source, span.end)
    return {
        "startLine": start_line,
        "startColumn": start_column,
        "endLine": end_line,
        "endColumn": end_column,
    }


def _find_place(source: Source, offset: int) -> tuple[int, int]:
    """Return line and column from 1, the column in UTF-16 code units."""
    line, column = source.get_line_and_column(offset)
    before = source.text[offset - column + 1 : offset]
    return line, len(before.encode("utf-16-le", "surrogatepass")) // 2 + 1


def _make_uri(name: str) -> str:
    """Convert a path to a URI: absolute ones with their scheme, others relative."""
    path = Path(name)
    return path.as_uri() if path.is_absolute() else quote(os.fsencode(path.as_posix()))
