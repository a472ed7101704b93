"""The colours of names: what each word stands for, which no pattern can find."""

from collections.abc import Mapping
from itertools import count
from pathlib import Path

from lsprotocol import types as lsp

from facetlog.grammar.language_server.positions import EditorText
from facetlog.grammar.language_server.symbols import Occurrence, Occurrences, SymbolKind
from facetlog.grammar.source import Span, differing

__all__ = ["LEGEND", "GivenColours", "semantic_tokens"]

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

_NUMBERS = {kind: number for number, kind in enumerate(_COLOURS)}

LEGEND = lsp.SemanticTokensLegend(
    [colour.value for colour in _COLOURS.values()], [mark.value for mark in _MARKS]
)


def semantic_tokens(
    known: Occurrences, text: EditorText, path: object, piece: Span | None = None
) -> tuple[int, ...]:
    """Each name of a text, or of a piece of it: five numbers, as the protocol writes them.

    They are line and column from the one before, length, colour, marks.
    """
    data: list[int] = []
    line = column = 0
    for one in known.every if piece is None else known.within(piece):
        colour = _NUMBERS.get(one.symbol.kind)
        if colour is None:
            continue
        at, start = text.line_and_units(one.span.start)
        last, end = text.line_and_units(one.span.end)
        if at != last:
            continue  # `smallest gap` on two lines; the protocol's tokens stand on one
        down = at - line
        data += (down, start if down else start - column, end - start, colour, _marks(one, path))
        line, column = at, start
    return tuple(data)


class GivenColours:
    """The semantic tokens that an editor was given last, so that it needs only what is new."""

    def __init__(self) -> None:
        self._last: dict[Path, tuple[str, tuple[int, ...]]] = {}
        self._names = map(str, count(1))

    def full(self, path: Path, numbers: tuple[int, ...]) -> lsp.SemanticTokens:
        """All tokens of a file, with a name by which the editor asks for what is new."""
        name = self._give(path, numbers)
        return lsp.SemanticTokens(list(numbers), result_id=name)

    def delta(
        self, path: Path, numbers: tuple[int, ...], known: str
    ) -> lsp.SemanticTokens | lsp.SemanticTokensDelta:
        """What is new since the tokens that the editor knows by name; all if none is known so."""
        name, before = self._last.get(path, ("", ()))
        if name != known:
            return self.full(path, numbers)
        old, new = differing(before, numbers)
        data = list(numbers[new.start : new.end])
        edits = [lsp.SemanticTokensEdit(old.start, old.end - old.start, data)]
        given = self._give(path, numbers)
        return lsp.SemanticTokensDelta(edits if before != numbers else [], result_id=given)

    def _give(self, path: Path, numbers: tuple[int, ...]) -> str:
        name = next(self._names)
        self._last[path] = name, numbers
        return name


def _marks(one: Occurrence, path: object) -> int:
    home = one.symbol.home
    declared = home is not None and (home.path, home.span) == (path, one.span)
    return declared | (home is None) << 1
