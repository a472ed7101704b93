"""Texts and places in them."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple


class Span(NamedTuple):
    """From one character of a text to before another, counted from 0."""

    start: int
    end: int

    def to(self, other: "Span") -> "Span":
        """Return the span from the beginning of this one to the end of another."""
        return Span(self.start, max(self.end, other.end))

    def __contains__(self, offset: object) -> bool:
        return isinstance(offset, int) and self.start <= offset <= self.end


NOWHERE = Span(0, 0)


def find_changed_spans(before: Sequence[object], after: Sequence[object]) -> tuple[Span, Span]:
    """Return the pieces in which two sequences differ, between their ends that are alike.

    >>> find_changed_spans("top is levl", "top is level")
    (Span(start=10, end=10), Span(start=10, end=11))
    """
    shorter = min(len(before), len(after))
    start = next((i for i in range(shorter) if before[i] != after[i]), shorter)
    left = shorter - start
    same = next((i for i in range(left) if before[-1 - i] != after[-1 - i]), left)
    return Span(start, len(before) - same), Span(start, len(after) - same)


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """A text and the name that its faults give."""

    name: str
    text: str
    _starts: list[int] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        starts, at = [0], self.text.find("\n")
        while at >= 0:
            starts.append(at + 1)
            at = self.text.find("\n", at + 1)
        object.__setattr__(self, "_starts", starts)

    def get_line_and_column(self, offset: int) -> tuple[int, int]:
        """Return line and column of a character, both from 1.

        >>> Source("m", "model a\\n  face b").get_line_and_column(10)
        (2, 3)
        """
        line = bisect_right(self._starts, offset)
        return line, offset - self._starts[line - 1] + 1

    def line(self, number: int) -> str:
        """Return the text of a line, from 1, without its end."""
        start = self._starts[number - 1]
        end = self._starts[number] if number < len(self._starts) else len(self.text)
        return self.text[start:end].rstrip("\r\n")

    def offset(self, line: int, column: int) -> int:
        """Return the character at a line and column from 1, clipped to the text."""
        if line > len(self._starts):
            return len(self.text)
        return min(self._starts[max(line, 1) - 1] + max(column, 1) - 1, len(self.text))

    def place(self, offset: int) -> str:
        """Name, line and column, as compilers write them."""
        line, column = self.get_line_and_column(offset)
        return f"{self.name}:{line}:{column}"
