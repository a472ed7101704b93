"""What an editor offers to do about faults: their fixes, and to allow a warning where it stands."""

from collections.abc import Iterable, Iterator

from lsprotocol import types as lsp

from facetlog.grammar.analysis import Analysis
from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.fixing.fix import Edit, Fix
from facetlog.grammar.fixing.fix_all import Check, fixed
from facetlog.grammar.language_server.diagnostics import diagnostic
from facetlog.grammar.language_server.positions import EditorText
from facetlog.grammar.lint.allowed import allow_fix
from facetlog.grammar.source import Span, differing

__all__ = ["KINDS", "code_actions", "fix_all"]

KINDS = (lsp.CodeActionKind.QuickFix, lsp.CodeActionKind.SourceFixAll)


def code_actions(
    analysis: Analysis, faults: Iterable[Fault], text: EditorText, uri: str, span: Span
) -> list[lsp.CodeAction]:
    """Fixes of the faults that touch a span, the likeliest first."""
    source = analysis.file.source
    own = [fault for fault in faults if fault.source is source]
    here = [f for f in own if f.span.start <= span.end and span.start <= f.span.end]
    found = [_action(fault, fix, text, uri) for fault in here for fix in _fixes(fault, analysis)]
    return sorted(found, key=lambda action: not action.is_preferred)


def fix_all(text: EditorText, uri: str, check: Check) -> list[lsp.CodeAction]:
    """All that is sure at once, as `model check --fix` does it; nothing if that is nothing."""
    after = fixed(text.text, check).text
    if after == text.text:
        return []
    kind = lsp.CodeActionKind.SourceFixAll
    old, new = differing(text.text, after)
    edit = _edit([Edit(old, after[new.start : new.end])], text, uri)
    return [lsp.CodeAction("put right all that is sure", kind=kind, edit=edit)]


def _fixes(fault: Fault, analysis: Analysis) -> Iterator[Fix]:
    yield from fault.fixes
    if fault.severity is Severity.WARNING:
        yield allow_fix(fault, analysis.file.comments)


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
