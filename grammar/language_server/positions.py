"""Places as editors count them: lines from 0, and code units of UTF-16 (or what was agreed on)."""

import re
from bisect import bisect_right
from dataclasses import dataclass, field

from lsprotocol import types as lsp

from facetlog.grammar.source import Span

__all__ = ["UTF_16", "EditorText"]

UTF_16 = "utf-16"

# Line ends of the protocol: section "Text Documents" of its specification 3.17.
_LINE_END = re.compile(r"\r\n|\n|\r")


@dataclass(frozen=True, slots=True, eq=False)
class EditorText:
    """A text with its lines; `encoding` says in which units columns are counted."""

    text: str
    encoding: str = UTF_16
    _starts: list[int] = field(init=False, repr=False)
    _ends: list[int] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        ends = list(_LINE_END.finditer(self.text))
        object.__setattr__(self, "_starts", [0, *(match.end() for match in ends)])
        object.__setattr__(self, "_ends", [*(m.start() for m in ends), len(self.text)])

    def offset(self, position: lsp.Position) -> int:
        """The character at a position; past the end of a line or the text, that end.

        >>> EditorText("a\\n😀b").offset(lsp.Position(1, 2))
        3
        """
        if position.line >= len(self._starts):
            return len(self.text)
        at, end = self._starts[position.line], self._ends[position.line]
        left = position.character
        while at < end and left > 0:
            left -= self._units(self.text[at])
            at += 1
        return at

    def position(self, offset: int) -> lsp.Position:
        """The position of a character.

        >>> EditorText("a\\n😀b").position(3)
        1:2
        """
        offset = min(max(offset, 0), len(self.text))
        line = bisect_right(self._starts, offset) - 1
        before = self.text[self._starts[line] : min(offset, self._ends[line])]
        units = len(before) if before.isascii() else sum(map(self._units, before))
        return lsp.Position(line, units)

    def range(self, span: Span) -> lsp.Range:
        """The range of a span."""
        return lsp.Range(self.position(span.start), self.position(span.end))

    def whole(self) -> lsp.Range:
        """The range of all of the text."""
        return self.range(Span(0, len(self.text)))

    def changed(self, change: lsp.TextDocumentContentChangeEvent) -> "EditorText":
        """The text after a change of a piece, or of all of it."""
        text = change.text
        if isinstance(change, lsp.TextDocumentContentChangePartial):
            start, end = self.offset(change.range.start), self.offset(change.range.end)
            text = self.text[:start] + change.text + self.text[max(start, end) :]
        return EditorText(text, self.encoding)

    def _units(self, letter: str) -> int:
        if self.encoding == UTF_16:
            return 2 if ord(letter) > 0xFFFF else 1
        # Half of a surrogate pair has no UTF-8; it counts as the three bytes it would take.
        return len(letter.encode("utf-8", "surrogatepass")) if self.encoding == "utf-8" else 1
