"""What was found out of models, kept while they and all that they depend on stay as they are.

An edit changes one model; of the others all faults are known, and only move with their text.
"""

import re
from bisect import bisect_right
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Generic, TypeVar

from facetlog.grammar import syntax as s
from facetlog.grammar.faults import Fault
from facetlog.grammar.library import Library
from facetlog.grammar.resolve import FlatModel
from facetlog.grammar.source import Span
from facetlog.grammar.vocabulary import Kinds

__all__ = ["Fingerprints", "Kept", "Memo", "fault_moved"]

_WORD = re.compile(r"\w+")
_LINE = re.compile(r"\bline \d")

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Kept(Generic[T]):
    """What was found out of a model, and where it then began.

    `lines` are those where it and its ancestors began, if faults speak of lines by number; `names`
    those of all models, if there are faults, whose hints may name any that is spelt alike.
    """

    found: T
    faults: tuple[Fault, ...]
    start: int
    lines: tuple[int, ...] | None
    names: frozenset[str] | None


@dataclass(slots=True)
class Memo(Generic[T]):
    """What one pass found out of the models of a file, by their fingerprints.

    Only what the last text needed is kept.
    """

    _before: dict[Hashable, Kept[T]] = field(default_factory=dict)
    _now: dict[Hashable, Kept[T]] = field(default_factory=dict)

    def begin(self) -> None:
        """A new text is looked at."""
        self._before, self._now = self._now, {}

    def take(self, model: FlatModel, prints: "Fingerprints") -> tuple[T, tuple[Fault, ...]] | None:
        """What was found out of a model, its faults where they now are; None if it must be anew."""
        key = prints.of(model)
        kept = self._before.get(key)
        if kept is None or kept.lines not in (None, prints.lines(model)):
            return None
        if kept.names not in (None, prints.names):
            return None
        self._now[key] = kept
        by = model.written.span.start - kept.start
        return kept.found, tuple(fault_moved(f, model, kept.start, by) for f in kept.faults)

    def keep(
        self, model: FlatModel, prints: "Fingerprints", found: T, faults: Iterable[Fault]
    ) -> None:
        """Keeps what was found out of a model, if all its faults stand in it or before models."""
        faults = tuple(faults)
        if not all(prints.stands_in(fault, model) for fault in faults):
            return
        by_number = any(_LINE.search(fault.message + fault.hint) for fault in faults)
        lines = prints.lines(model) if by_number else None
        names = prints.names if faults else None
        self._now[prints.of(model)] = Kept(found, faults, model.written.span.start, lines, names)


@lru_cache(maxsize=2000)
def words_of(text: str) -> frozenset[str]:
    """The words of a text, and what they are in the singular."""
    words = set(_WORD.findall(text))
    words |= {word.removesuffix("s") for word in words}
    words |= {word.removesuffix("es") for word in words}
    return frozenset(words)


def fault_moved(fault: Fault, model: FlatModel, start: int, by: int) -> Fault:
    """A fault in the text as it is now; what stands before the models has not moved."""
    if fault.span.start < start:
        by = 0
    span = Span(fault.span.start + by, fault.span.end + by)
    fixes = tuple(fix.moved(by) for fix in fault.fixes)
    return replace(fault, source=model.source, span=span, fixes=fixes)


@dataclass(slots=True)
class Fingerprints:
    """All that what is found out of a model depends on, as a key for each model.

    `names` are those of all models. A model depends on those that its text may name.
    """

    library: Library
    models: Mapping[str, FlatModel]
    roles: Mapping[str, Mapping[str, Kinds]]
    _keys: dict[str, Hashable] = field(default_factory=dict)
    _starts: dict[int, tuple[int, ...]] = field(default_factory=dict)
    names: frozenset[str] = field(init=False)
    _words: Hashable = field(init=False)

    def __post_init__(self) -> None:
        self.names = frozenset(self.roles)
        self._words = tuple(
            (word.name, word.signature, word.meaning)
            for own in self.library.words.values()
            for word in own.words
        )

    def of(self, model: FlatModel) -> Hashable:
        """The key of a model: its text, those of its ancestors, and the parts of whom it names."""
        if model.name not in self._keys:
            blocks = tuple(
                (one.source.name, self._before_models(one.file), self._text(one), one.file is main)
                for main in (self.library.main,)
                for one in self._descent(model)
            )
            named = frozenset().union(*(words_of(text) for block in blocks for text in block[1:3]))
            roles = tuple(
                (name, tuple(self.roles[name].items())) for name in sorted(named & self.names)
            )
            self._keys[model.name] = blocks, roles, self._words
        return self._keys[model.name]

    def lines(self, model: FlatModel) -> tuple[int, ...]:
        """The lines where a model and its ancestors begin."""
        return tuple(
            one.source.line_and_column(one.written.span.start)[0] for one in self._descent(model)
        )

    def stands_in(self, fault: Fault, model: FlatModel) -> bool:
        """Whether a fault stands in a model's own text, or before the models of its file."""
        if fault.source is not model.source:
            return False
        start = model.file.models[0].span.start
        return fault.span.end <= start or self._span(model).start <= fault.span.start < (
            self._span(model).end
        )

    def _descent(self, model: FlatModel) -> tuple[FlatModel, ...]:
        found: dict[str, FlatModel] = {}
        at: FlatModel | None = model
        while at is not None and at.name not in found:
            found[at.name] = at
            parent = at.written.parent
            at = self.models.get(parent.text) if parent is not None else None
        return tuple(found.values())

    def _before_models(self, file: s.File) -> str:
        return file.source.text[: file.models[0].span.start] if file.statements else ""

    def _span(self, model: FlatModel) -> Span:
        """From a model's name to that of the next."""
        starts = self._starts.get(id(model.file))
        if starts is None:
            starts = tuple(one.span.start for one in model.file.models)
            self._starts[id(model.file)] = starts
        start = model.written.span.start
        after = bisect_right(starts, start)
        end = starts[after] if after < len(starts) else len(model.source.text)
        return Span(start, end)

    def _text(self, model: FlatModel) -> str:
        span = self._span(model)
        return model.source.text[span.start : span.end]
