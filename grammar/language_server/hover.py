"""Hover texts: documentation of the word under the pointer."""

from collections.abc import Iterator, Mapping

from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import Analysis
from facetlog.grammar.constants import constant
from facetlog.grammar.example_scenes import Builders
from facetlog.grammar.format import space_tokens
from facetlog.grammar.language_server.symbols import Symbol, SymbolKind
from facetlog.grammar.limits import Limit
from facetlog.grammar.reading.layout import laid_out
from facetlog.grammar.resolve import FlatModel, Owned
from facetlog.grammar.source import Source
from facetlog.grammar.units import UNITS, Dimension
from facetlog.grammar.vocabulary import Word

_BASE_UNITS = {
    Dimension.LENGTH: " m",
    Dimension.AREA: " m²",
    Dimension.ANGLE: "°",
    Dimension.NUMBER: "",
}


def code(text: str) -> str:
    """Return a piece of a model file, to be shown as such."""
    return f"```facetlog-model\n{text}\n```"


def describe_word(word: Word) -> str:
    """Explain a word: its meaning, when it is unknown, and which file defines it."""
    lines = [f"{word.meaning[:1].upper()}{word.meaning[1:]}."]
    if word.low is not None or word.high is not None:
        bounds = [f"at least {word.low:g}" if word.low is not None else ""]
        bounds.append(f"at most {word.high:g}" if word.high is not None else "")
        lines.append(f"Always {' and '.join(b for b in bounds if b)}.")
    if word.symmetric:
        lines.append("The order of its arguments means nothing.")
    if word.unknown_when:
        lines.append(f"Not known if {word.unknown_when}.")
    if word.source is not None:
        lines.append(f"A word of `{word.source.name.rpartition('/')[2]}`.")
    return "\n\n".join(lines)


def describe_unit(name: str) -> str:
    """Explain a unit; empty if there is none of the name."""
    unit = UNITS.get(name)
    if unit is None:
        return ""
    return f"{unit.dimension}: {unit.factor:g}{_BASE_UNITS[unit.dimension]}"


def show_constant_value(let: s.Let, lets: Mapping[str, Owned[s.Let]]) -> str:
    """Return the value of a constant in metres, degrees or ones; empty if it is none."""
    value = constant(let.value, lets)
    return "" if value is None else f"{value.value:.6g}{_BASE_UNITS[value.dimension]}"


def describe_model(model: FlatModel) -> str:
    """Return the description of a model."""
    doc = model.written.doc
    return "" if doc is None else doc.value


def show_statement(source: Source, offset: int) -> str:
    """Return the statement at a place, on one line; empty if there is none."""
    for statement in laid_out(source).statements:
        if offset in statement.span:
            return space_tokens(statement.tokens)
    return ""


def find_hover_text(analysis: Analysis, symbol: Symbol, builders: Builders) -> str:
    """Return the documentation of a symbol in Markdown; empty if there is none."""
    return "\n\n".join(part for part in _iter_parts(analysis, symbol, builders) if part)


def limit_text(limit: Limit) -> str:
    """Return the range over which a comparison fades, in Markdown."""
    return f"`{limit.text}` {limit.fades}"


def _iter_parts(analysis: Analysis, symbol: Symbol, builders: Builders) -> Iterator[str]:
    name = symbol.name
    match symbol.kind:
        case SymbolKind.WORD:
            word = analysis.words[name]
            yield code(word.signature)
            yield describe_word(word)
        case SymbolKind.UNIT:
            yield describe_unit(name)
        case SymbolKind.BUILDER:
            if name in builders:
                yield code(f"{name}({', '.join(builders[name])})")
        case SymbolKind.CONSTANT:
            yield code(_get_statement(analysis, symbol))
            yield from _describe_constant(analysis, symbol)
        case SymbolKind.MODEL:
            model = analysis.all_models.get(name)
            if model is None:
                yield code(f"model {name}")
                return
            yield code(show_statement(model.source, model.written.name.span.start))
            yield describe_model(model)
        case SymbolKind.LOCAL:
            in_definition = _get_statement(analysis, symbol).startswith("define ")
            yield f"named in this {'definition' if in_definition else 'line'}"
        case SymbolKind.FILE:
            return
        case _:
            yield code(_get_statement(analysis, symbol))
            yield _describe_owner(analysis, symbol)


def _get_statement(analysis: Analysis, symbol: Symbol) -> str:
    """Return the statement that a symbol is named by."""
    if symbol.home is None or symbol.home.path not in analysis.library.files:
        return symbol.name
    source = analysis.library.files[symbol.home.path].source
    return show_statement(source, symbol.home.span.start)


def _describe_constant(analysis: Analysis, symbol: Symbol) -> Iterator[str]:
    model = analysis.all_models.get(symbol.model)
    if model is not None:
        lets = model.lets
    else:
        file = analysis.file
        lets = {x.name.text: Owned(x, file, "") for x in file.statements if isinstance(x, s.Let)}
    if symbol.name in lets:
        let = lets[symbol.name].node
        value = show_constant_value(let, lets)
        yield f"is {value}" if value else ""
        if let.doc is not None:
            yield let.doc.value


def _describe_owner(analysis: Analysis, symbol: Symbol) -> str:
    """Return the model that names a symbol, if another inherits it."""
    for name, model in analysis.all_models.items():
        here = symbol.home is not None and model.source.name == str(symbol.home.path)
        if here and symbol.home is not None and name != symbol.model:
            spans = [statement.span for statement in model.written.statements]
            if any(symbol.home.span.start in span for span in spans):
                return f"of `{name}`"
    return ""
