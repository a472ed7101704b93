"""Faults of model files as JUnit's XML, which build servers show: a suite for each file.

A file without faults is one case that passes; else each fault is a case. Source: the schema of
Apache Ant's JUnit task, as build servers read it.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from facetlog.commands.model.fault_text import plain
from facetlog.grammar.faults import Fault, Severity

__all__ = ["faults_junit"]


def faults_junit(
    files: Sequence[Path], faults: Sequence[Fault], *, warnings_as_errors: bool = False
) -> str:
    """The document; warnings fail only if they count as errors, and else stand in `system-out`."""
    root = Element("testsuites", name="facetlog model check")
    names = dict.fromkeys([*map(str, files), *(fault.source.name for fault in faults)])
    for name in names:
        own = [fault for fault in faults if fault.source.name == name]
        _suite(root, name, own, warnings_as_errors)
    suites = list(root)
    for count in ("tests", "failures"):
        root.set(count, str(sum(int(suite.get(count, "0")) for suite in suites)))
    indent(root)
    head = '<?xml version="1.0" encoding="utf-8"?>'
    return f"{head}\n{tostring(root, encoding='unicode')}"


def _suite(root: Element, name: str, faults: Iterable[Fault], warnings_fail: bool) -> None:
    suite = SubElement(root, "testsuite", name=_shown(name))
    failures = 0
    for fault in faults:
        line, column = fault.source.line_and_column(fault.span.start)
        case = SubElement(
            suite, "testcase", classname=_shown(name), name=f"{fault.code} at {line}:{column}"
        )
        text = _shown("\n".join(fault.lines()))
        if fault.severity is Severity.ERROR or warnings_fail:
            failures += 1
            failure = SubElement(case, "failure", type=fault.code, message=_shown(fault.message))
            failure.text = text
        else:
            SubElement(case, "system-out").text = text
    if not len(suite):
        SubElement(suite, "testcase", classname=_shown(name), name="no faults")
    suite.set("tests", str(len(suite)))
    suite.set("failures", str(failures))


def _shown(text: str) -> str:
    """A text without the letters that XML 1.0 cannot hold."""
    return "\n".join(map(plain, text.split("\n")))
