"""Symbols: what a word of a file stands for, and where it was given its name."""

from bisect import bisect_right
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

from facetlog.grammar.source import Span

__all__ = ["Home", "Occurrence", "Occurrences", "Symbol", "SymbolKind"]


class SymbolKind(StrEnum):
    """What a word can stand for."""

    MODEL = "model"
    PART = "part"
    CONSTANT = "constant"
    DEFINITION = "definition"
    LINE = "line"
    LOCAL = "local name"
    WORD = "word"
    UNIT = "unit"
    FILE = "file"
    BUILDER = "builder"


@dataclass(frozen=True, slots=True)
class Home:
    """Where a symbol is given its name."""

    path: Path
    span: Span


@dataclass(frozen=True, slots=True)
class Symbol:
    """What a word stands for; `home` is None if the language or facetlog itself brings it.

    A part, constant, definition or line that a model inherits or changes is one with that of its
    ancestor. `model` is the one that it was met in, for its description.
    """

    kind: SymbolKind
    name: str
    home: Home | None
    model: str = field(default="", compare=False)


@dataclass(frozen=True, slots=True)
class Occurrence:
    """A symbol at a place; `plural` are the letters that follow a model's name there.

    Not `sure` if its statement cannot be read, so that only the word itself says what it is.
    """

    symbol: Symbol
    span: Span
    plural: str = ""
    sure: bool = True


@dataclass(frozen=True, slots=True)
class Occurrences:
    """All symbols of a file, in the order of the text; no two of them overlap."""

    every: tuple[Occurrence, ...]

    def at(self, offset: int) -> Occurrence | None:
        """The symbol at a place or right before it; of two that touch, the later."""
        i = bisect_right(self.every, offset, key=lambda one: one.span.start) - 1
        if i < 0:
            return None
        found = self.every[i]
        return found if offset <= found.span.end + len(found.plural) else None

    def of(self, symbol: Symbol) -> tuple[Occurrence, ...]:
        """Where a symbol surely stands."""
        return tuple(one for one in self.every if one.sure and one.symbol == symbol)
