"""The outline of a model file: its models, and the names that each gives."""

from collections.abc import Iterable, Iterator

from lsprotocol import types as lsp

from facetlog.grammar import syntax as s
from facetlog.grammar.language_server.positions import EditorText
from facetlog.grammar.source import Span

__all__ = ["outline"]

_KINDS = lsp.SymbolKind

LONGEST_NAME = 60
"""Letters of a line that has no label, as an outline shows it."""


def outline(file: s.File, text: EditorText) -> list[lsp.DocumentSymbol]:
    """The constants and definitions before the first model, and the models with what they hold."""
    found = list(_symbols(file.statements, text))
    for i, model in enumerate(file.models):
        following = file.models[i + 1].span.start if i + 1 < len(file.models) else len(text.text)
        end = max([model.span.end, *(x.span.end for x in model.statements)])
        if model.doc is not None:
            end = max(end, model.doc.span.end)
        span = Span(_line_start(text, model.span.start), min(end, following))
        found.append(
            lsp.DocumentSymbol(
                model.name.text,
                _KINDS.Class,
                text.range(span),
                text.range(model.name.span),
                detail="" if model.parent is None else f"{model.ancestry} {model.parent}",
                children=list(_symbols(model.statements, text)),
            )
        )
    return found


def _line_start(text: EditorText, offset: int) -> int:
    return text.text.rfind("\n", 0, offset) + 1


def _symbols(statements: Iterable[s.Statement], text: EditorText) -> Iterator[lsp.DocumentSymbol]:
    for statement in statements:
        for name, kind, span in _named(statement, text):
            whole = text.range(Span(min(statement.span.start, span.start), statement.span.end))
            yield lsp.DocumentSymbol(name, kind, whole, text.range(span))


def _named(statement: s.Statement, text: EditorText) -> Iterator[tuple[str, lsp.SymbolKind, Span]]:
    match statement:
        case s.Part(names=names):
            for name in names:
                yield name.text, _KINDS.Field, name.span
        case s.Let(name=name):
            yield name.text, _KINDS.Constant, name.span
        case s.Define(name=name):
            yield name.text, _KINDS.Function, name.span
        case s.Line(label=label) if label is not None:
            yield label.text, _KINDS.Property, label.span
        case s.Line(span=span):
            words = " ".join(text.text[span.start : span.end].split())
            short = words if len(words) <= LONGEST_NAME else words[: LONGEST_NAME - 1] + "…"
            yield short, _KINDS.Property, span
        case s.Example(title=title):
            yield title.value.strip() or "example", _KINDS.Event, title.span
        case _:
            pass
