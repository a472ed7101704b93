"""The faults of a file as an editor shows them."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from lsprotocol import types as lsp

from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import Analysis
from facetlog.grammar.faults import Edit, Fault, Fix, Severity
from facetlog.grammar.fix_all import Check, fixed
from facetlog.grammar.language_server.project import EditorText, Project
from facetlog.grammar.lint.allowed import allow_fix
from facetlog.grammar.source import Span, find_changed_spans

SOURCE = "facetlog"

_SEVERITIES = {
    Severity.ERROR: lsp.DiagnosticSeverity.Error,
    Severity.WARNING: lsp.DiagnosticSeverity.Warning,
}


def diagnostics(project: Project, path: Path) -> list[lsp.Diagnostic]:
    """Return the faults of a file; those of the files that it uses stand where it says `use`."""
    analysis = project.analysis(path)
    text = project.text(path)
    own = [fault for fault in project.faults(path) if fault.source.name == str(path)]
    return [diagnostic(fault, text) for fault in own] + list(
        _iter_of_others(project, analysis, text)
    )


def diagnostic(fault: Fault, text: EditorText) -> lsp.Diagnostic:
    """Return a fault of the text."""
    message = f"{fault.message}; {fault.hint}" if fault.hint else fault.message
    return lsp.Diagnostic(
        text.range(fault.span),
        message,
        severity=_SEVERITIES[fault.severity],
        code=fault.code,
        source=SOURCE,
    )


def _iter_of_others(
    project: Project, analysis: Analysis, text: EditorText
) -> Iterator[lsp.Diagnostic]:
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
    """Return where a file is used; if only by another, the first `use` that there is."""
    uses = analysis.file.uses
    base = Path(analysis.file.source.name).parent
    named: list[s.Use] = [u for u in uses if str(base / u.path.value) == name]
    return (named or list(uses))[0].path.span if uses else Span(0, 0)


KINDS = (lsp.CodeActionKind.QuickFix, lsp.CodeActionKind.SourceFixAll)


def list_code_actions(
    analysis: Analysis, faults: Iterable[Fault], text: EditorText, uri: str, span: Span
) -> list[lsp.CodeAction]:
    """Return fixes of the faults that touch a span, the likeliest first."""
    source = analysis.file.source
    own = [fault for fault in faults if fault.source is source]
    here = [f for f in own if f.span.start <= span.end and span.start <= f.span.end]
    found = [
        _make_action(fault, fix, text, uri)
        for fault in here
        for fix in _iter_fixes(fault, analysis)
    ]
    return sorted(found, key=lambda action: not action.is_preferred)


def fix_all(text: EditorText, uri: str, check: Check) -> list[lsp.CodeAction]:
    """Return all that is sure at once, as `model check --fix` does it; nothing if that is
    nothing."""
    after = fixed(text.text, check).text
    if after == text.text:
        return []
    kind = lsp.CodeActionKind.SourceFixAll
    old, new = find_changed_spans(text.text, after)
    edit = _make_edit([Edit(old, after[new.start : new.end])], text, uri)
    return [lsp.CodeAction("put right all that is sure", kind=kind, edit=edit)]


def _iter_fixes(fault: Fault, analysis: Analysis) -> Iterator[Fix]:
    yield from fault.fixes
    if fault.severity is Severity.WARNING:
        yield allow_fix(fault, analysis.file.comments)


def _make_action(fault: Fault, fix: Fix, text: EditorText, uri: str) -> lsp.CodeAction:
    return lsp.CodeAction(
        fix.title,
        kind=lsp.CodeActionKind.QuickFix,
        diagnostics=[diagnostic(fault, text)],
        is_preferred=fix.sure,
        edit=_make_edit(fix.edits, text, uri),
    )


def _make_edit(edits: Iterable[Edit], text: EditorText, uri: str) -> lsp.WorkspaceEdit:
    changes = [lsp.TextEdit(text.range(edit.span), edit.text) for edit in edits]
    return lsp.WorkspaceEdit(changes={uri: changes})
