"""The colours of names: what each word stands for, which no pattern can tell."""

from collections.abc import Mapping

from lsprotocol import types as lsp

from facetlog.grammar.language_server.positions import EditorText
from facetlog.grammar.language_server.symbols import Occurrence, Occurrences, SymbolKind

__all__ = ["LEGEND", "semantic_tokens"]

_TYPES = lsp.SemanticTokenTypes
_MODIFIERS = lsp.SemanticTokenModifiers

_COLOURS: Mapping[SymbolKind, _TYPES] = {
    SymbolKind.MODEL: _TYPES.Class,
    SymbolKind.PART: _TYPES.Variable,
    SymbolKind.CONSTANT: _TYPES.EnumMember,
    SymbolKind.DEFINITION: _TYPES.Function,
    SymbolKind.LINE: _TYPES.Property,
    SymbolKind.LOCAL: _TYPES.Parameter,
    SymbolKind.WORD: _TYPES.Method,
    SymbolKind.UNIT: _TYPES.Keyword,
    SymbolKind.BUILDER: _TYPES.Type,
}
"""Files are texts in quotes, which have a colour."""

_MARKS = (_MODIFIERS.Declaration, _MODIFIERS.DefaultLibrary)

LEGEND = lsp.SemanticTokensLegend(
    [colour.value for colour in _COLOURS.values()], [mark.value for mark in _MARKS]
)


def semantic_tokens(known: Occurrences, text: EditorText, path: object) -> lsp.SemanticTokens:
    """Each name of a file: line and column from the one before, length, colour, marks."""
    colours = list(_COLOURS)
    data: list[int] = []
    line = column = 0
    for one in known.every:
        if one.symbol.kind not in _COLOURS:
            continue
        start, end = text.position(one.span.start), text.position(one.span.end)
        if start.line != end.line:
            continue  # `smallest gap` on two lines; the protocol's tokens stand on one
        down = start.line - line
        right = start.character if down else start.character - column
        length = end.character - start.character
        data += [down, right, length, colours.index(one.symbol.kind), _marks(one, path)]
        line, column = start.line, start.character
    return lsp.SemanticTokens(data)


def _marks(one: Occurrence, path: object) -> int:
    home = one.symbol.home
    declared = home is not None and (home.path, home.span) == (path, one.span)
    return declared | (home is None) << 1
