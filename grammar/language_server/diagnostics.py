"""The faults of a file as an editor shows them."""

from collections.abc import Iterator
from pathlib import Path

from lsprotocol import types as lsp

from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import Analysis
from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.language_server.positions import EditorText
from facetlog.grammar.language_server.project import Project
from facetlog.grammar.source import Span

__all__ = ["SOURCE", "diagnostic", "diagnostics"]

SOURCE = "facetlog"

_SEVERITIES = {
    Severity.ERROR: lsp.DiagnosticSeverity.Error,
    Severity.WARNING: lsp.DiagnosticSeverity.Warning,
}


def diagnostics(project: Project, path: Path) -> list[lsp.Diagnostic]:
    """The faults of a file; those of the files that it uses stand where it says `use`."""
    analysis = project.analysis(path)
    text = project.text(path)
    own = [fault for fault in project.faults(path) if fault.source.name == str(path)]
    return [diagnostic(fault, text) for fault in own] + list(_of_others(project, analysis, text))


def diagnostic(fault: Fault, text: EditorText) -> lsp.Diagnostic:
    """A fault of the text."""
    message = f"{fault.message}; {fault.hint}" if fault.hint else fault.message
    return lsp.Diagnostic(
        text.range(fault.span),
        message,
        severity=_SEVERITIES[fault.severity],
        code=fault.code,
        source=SOURCE,
    )


def _of_others(project: Project, analysis: Analysis, text: EditorText) -> Iterator[lsp.Diagnostic]:
    others: dict[str, list[Fault]] = {}
    for fault in analysis.errors:
        if fault.source.name != analysis.file.source.name:
            others.setdefault(fault.source.name, []).append(fault)
    for name, faults in others.items():
        first = faults[0]
        many = "1 fault" if len(faults) == 1 else f"{len(faults)} faults"
        there = project.text(Path(name)).range(first.span)
        place = lsp.Location(project.uri(Path(name)), there)
        yield lsp.Diagnostic(
            text.range(_use_of(analysis, name)),
            f"{Path(name).name} has {many}: {first.message}",
            severity=lsp.DiagnosticSeverity.Error,
            code=first.code,
            source=SOURCE,
            related_information=[lsp.DiagnosticRelatedInformation(place, first.message)],
        )


def _use_of(analysis: Analysis, name: str) -> Span:
    """Where a file is used; if only by another, the first `use` that there is."""
    uses = analysis.file.uses
    base = Path(analysis.file.source.name).parent
    named: list[s.Use] = [u for u in uses if str(base / u.path.value) == name]
    return (named or list(uses))[0].path.span if uses else Span(0, 0)
