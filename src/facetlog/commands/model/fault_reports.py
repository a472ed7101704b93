"""Faults of model files for other programs: SARIF for code hosts, JUnit's XML for build servers.

Sources: OASIS Standard "Static Analysis Results Interchange Format (SARIF) Version 2.1.0", 2020;
the schema of Apache Ant's JUnit task, as build servers read it.
"""

import json
import os
from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from urllib.parse import quote
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from facetlog import __version__
from facetlog.commands.model.fault_text import plain
from facetlog.grammar.fault_codes import FAULT_KINDS
from facetlog.grammar.faults import Fault, Fix, Severity
from facetlog.grammar.source import Source, Span
from facetlog.grammar.syntax import File
from facetlog.plurals import many

__all__ = ["format_faults_junit", "format_faults_sarif"]


SCHEMA_ADDRESS = "https://json.schemastore.org/sarif-2.1.0.json"


def format_faults_sarif(files: Sequence[Path], faults: Sequence[Fault]) -> str:
    """Format the faults as a SARIF log: the files, a rule per kind of fault, a result per fault."""
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
    kind = FAULT_KINDS[code]
    return {"id": code, "shortDescription": {"text": kind.meaning}, "helpUri": kind.address}


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


def format_faults_junit(
    files: Sequence[Path],
    faults: Sequence[Fault],
    *,
    read: Mapping[str, File],
    warnings_as_errors: bool = False,
) -> str:
    """Format the faults as JUnit's XML: a suite for each file, a case for each model.

    What stands before the first model is a case, too, named by the file. Names do not change with
    the lines that faults stand in, so that build servers can follow a model from run to run.
    Warnings fail only if they count as errors, and else go to `system-out`. `read` are the files by
    name, for their models.
    """
    root = Element("testsuites", name="facetlog model check")
    names = dict.fromkeys([*map(str, files), *(fault.source.name for fault in faults)])
    for name in names:
        own = [fault for fault in faults if fault.source.name == name]
        _add_suite(root, name, read.get(name), own, warnings_as_errors)
    suites = list(root)
    for count in ("tests", "failures"):
        root.set(count, str(sum(int(suite.get(count, "0")) for suite in suites)))
    indent(root)
    head = '<?xml version="1.0" encoding="utf-8"?>'
    return f"{head}\n{tostring(root, encoding='unicode')}"


def _add_suite(
    root: Element, name: str, file: File | None, faults: Iterable[Fault], warnings_fail: bool
) -> None:
    models = file.models if file is not None else ()
    starts = [model.span.start for model in models]
    cases: list[list[Fault]] = [[] for _ in range(len(models) + 1)]
    for fault in faults:
        cases[bisect_right(starts, max(fault.span.start, fault.span.end - 1))].append(fault)
    suite = SubElement(root, "testsuite", name=_escape(name))
    titles = [Path(name).name, *(model.name.text for model in models)]
    failed = [
        _add_case(suite, name, title, own, warnings_fail)
        for title, own in zip(titles, cases, strict=True)
    ]
    suite.set("tests", str(len(failed)))
    suite.set("failures", str(sum(failed)))


def _add_case(
    suite: Element, file: str, title: str, faults: Sequence[Fault], warnings_fail: bool
) -> bool:
    """Add a case with its faults; return whether it fails."""
    case = SubElement(suite, "testcase", classname=_escape(file), name=_escape(title))
    fatal = [f for f in faults if warnings_fail or f.severity is Severity.ERROR]
    if fatal:
        others = f" (+ {many(len(fatal) - 1, 'fault')})" if len(fatal) > 1 else ""
        message = _escape(f"{fatal[0].message}{others}")
        failure = SubElement(case, "failure", type=fatal[0].code, message=message)
        failure.text = _format_faults(fatal)
    rest = [fault for fault in faults if fault not in fatal]
    if rest:
        SubElement(case, "system-out").text = _format_faults(rest)
    return bool(fatal)


def _format_faults(faults: Iterable[Fault]) -> str:
    return _escape("\n".join(line for fault in faults for line in fault.lines()))


def _escape(text: str) -> str:
    """Replace the characters that XML 1.0 cannot hold."""
    return "\n".join(map(plain, text.split("\n")))
