"""What an editor offers to do about faults: their fixes, and to allow a warning where it stands."""

from collections.abc import Iterable, Iterator

from lsprotocol import types as lsp

from facetlog.grammar.analysis import Analysis
from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.fixing.fix import Edit, Fix
from facetlog.grammar.fixing.fix_all import apart
from facetlog.grammar.language_server.diagnostics import diagnostic
from facetlog.grammar.language_server.positions import EditorText
from facetlog.grammar.lint.allowed import allowance
from facetlog.grammar.source import Span

__all__ = ["KINDS", "code_actions"]

KINDS = (lsp.CodeActionKind.QuickFix, lsp.CodeActionKind.SourceFixAll)


def code_actions(
    analysis: Analysis, text: EditorText, uri: str, span: Span
) -> list[lsp.CodeAction]:
    """Fixes of the faults that touch a span, the likeliest first; last, all that is sure."""
    source = analysis.file.source
    own = [fault for fault in analysis.faults if fault.source is source]
    here = [f for f in own if f.span.start <= span.end and span.start <= f.span.end]
    found = [_action(fault, fix, text, uri) for fault in here for fix in _fixes(fault, analysis)]
    found.sort(key=lambda action: not action.is_preferred)
    sure = [fault.sure_fix for fault in apart(own)]
    edits = [edit for fix in sure if fix is not None for edit in fix.edits]
    if edits:
        kind = lsp.CodeActionKind.SourceFixAll
        title = "put right all that is sure"
        found.append(lsp.CodeAction(title, kind=kind, edit=_edit(edits, text, uri)))
    return found


def _fixes(fault: Fault, analysis: Analysis) -> Iterator[Fix]:
    yield from fault.fixes
    if fault.severity is Severity.WARNING:
        yield allowance(fault, analysis.file.comments)


def _action(fault: Fault, fix: Fix, text: EditorText, uri: str) -> lsp.CodeAction:
    return lsp.CodeAction(
        fix.title,
        kind=lsp.CodeActionKind.QuickFix,
        diagnostics=[diagnostic(fault, text)],
        is_preferred=fix.sure,
        edit=_edit(fix.edits, text, uri),
    )


def _edit(edits: Iterable[Edit], text: EditorText, uri: str) -> lsp.WorkspaceEdit:
    changes = [lsp.TextEdit(text.range(edit.span), edit.text) for edit in edits]
    return lsp.WorkspaceEdit(changes={uri: changes})
