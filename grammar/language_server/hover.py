"""What is shown of the word under the pointer."""

from collections.abc import Iterator

from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import Analysis
from facetlog.grammar.language_server import Builders
from facetlog.grammar.language_server.documentation import (
    code,
    constant_value,
    model_documentation,
    statement_text,
    unit_documentation,
    word_documentation,
)
from facetlog.grammar.language_server.symbols import Symbol, SymbolKind
from facetlog.grammar.limits import Limit
from facetlog.grammar.resolve import Owned
from facetlog.grammar.source import Source

__all__ = ["hover_text", "limit_text"]


def hover_text(analysis: Analysis, symbol: Symbol, builders: Builders) -> str:
    """What is known of a symbol, in Markdown; empty if nothing is."""
    return "\n\n".join(part for part in _parts(analysis, symbol, builders) if part)


def limit_text(limit: Limit) -> str:
    """From where to where a comparison fades, in Markdown."""
    return f"`{limit.text}` {limit.fades}"


def _parts(analysis: Analysis, symbol: Symbol, builders: Builders) -> Iterator[str]:
    name = symbol.name
    match symbol.kind:
        case SymbolKind.WORD:
            word = analysis.words[name]
            yield code(word.signature)
            yield word_documentation(word)
        case SymbolKind.UNIT:
            yield unit_documentation(name)
        case SymbolKind.BUILDER:
            if name in builders:
                yield code(f"{name}({', '.join(builders[name])})")
        case SymbolKind.CONSTANT:
            yield code(_statement(analysis, symbol))
            yield from _constant(analysis, symbol)
        case SymbolKind.MODEL:
            model = analysis.all_models.get(name)
            if model is None:
                yield code(f"model {name}")
                return
            yield code(statement_text(model.source, model.written.name.span.start))
            yield model_documentation(model)
        case SymbolKind.LOCAL:
            yield f"named in this {'definition' if _in_definition(analysis, symbol) else 'line'}"
        case SymbolKind.FILE:
            return
        case _:
            yield code(_statement(analysis, symbol))
            yield _in_model(analysis, symbol)


def _source(analysis: Analysis, symbol: Symbol) -> Source | None:
    if symbol.home is None or symbol.home.path not in analysis.library.files:
        return None
    return analysis.library.files[symbol.home.path].source


def _statement(analysis: Analysis, symbol: Symbol) -> str:
    """The statement that a symbol is named by."""
    source = _source(analysis, symbol)
    if source is None or symbol.home is None:
        return symbol.name
    return statement_text(source, symbol.home.span.start)


def _constant(analysis: Analysis, symbol: Symbol) -> Iterator[str]:
    model = analysis.all_models.get(symbol.model)
    if model is not None:
        lets = model.lets
    else:
        file = analysis.file
        lets = {x.name.text: Owned(x, file, "") for x in file.statements if isinstance(x, s.Let)}
    if symbol.name in lets:
        let = lets[symbol.name].node
        value = constant_value(let, lets)
        yield f"is {value}" if value else ""
        if let.doc is not None:
            yield let.doc.value


def _in_model(analysis: Analysis, symbol: Symbol) -> str:
    """The model that names a symbol, if another inherits it."""
    for name, model in analysis.all_models.items():
        here = symbol.home is not None and model.source.name == str(symbol.home.path)
        if here and symbol.home is not None and name != symbol.model:
            spans = [statement.span for statement in model.written.statements]
            if any(symbol.home.span.start in span for span in spans):
                return f"of `{name}`"
    return ""


def _in_definition(analysis: Analysis, symbol: Symbol) -> bool:
    return _statement(analysis, symbol).startswith("define ")
