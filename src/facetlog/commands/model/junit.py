"""Model files as JUnit's XML, which build servers show: a suite for each file, a case a model.

What stands before the first model is a case, too, named by the file. Names do not change with the
lines that faults stand in, so that build servers can follow a model from run to run. Source: the
schema of Apache Ant's JUnit task, as build servers read it.
"""

from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from facetlog.commands.model.fault_text import plain
from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.syntax import File
from facetlog.plurals import many

__all__ = ["format_faults_junit"]


def format_faults_junit(
    files: Sequence[Path],
    faults: Sequence[Fault],
    *,
    read: Mapping[str, File],
    warnings_as_errors: bool = False,
) -> str:
    """Format the faults; warnings fail only if they count as errors, and else go to `system-out`.

    `read` are the files by name, for their models.
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
