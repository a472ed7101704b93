"""Where the names that a model may use were given: in it, in its ancestors, before the models."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import Analysis
from facetlog.grammar.language_server.symbols import Home
from facetlog.grammar.source import Span

__all__ = ["Homes", "Names"]


@dataclass(frozen=True, slots=True)
class Names:
    """The homes of names, by what they stand for."""

    parts: Mapping[str, Home]
    constants: Mapping[str, Home]
    definitions: Mapping[str, Home]
    lines: Mapping[str, Home]


_NONE = Names({}, {}, {}, {})


class Homes:
    """The homes of all names that are known of a file."""

    def __init__(self, analysis: Analysis) -> None:
        self.analysis = analysis
        self._names: dict[str, Names] = {}

    def before_models(self, file: s.File) -> Names:
        """The constants and definitions that stand before the first model of a file."""
        path = Path(file.source.name)
        constants: dict[str, Home] = {}
        definitions: dict[str, Home] = {}
        for statement in file.statements:
            if isinstance(statement, s.Let):
                constants.setdefault(statement.name.text, Home(path, statement.name.span))
            elif isinstance(statement, s.Define):
                definitions.setdefault(statement.name.text, Home(path, statement.name.span))
        return Names({}, constants, definitions, {})

    def in_model(self, name: str) -> Names:
        """The names of a model; what an ancestor named first is at home there."""
        descent: list[str] = []
        at = name
        while at in self.analysis.all_models and at not in descent and at not in self._names:
            descent.append(at)
            parent = self.analysis.all_models[at].written.parent
            at = "" if parent is None else parent.text
        for one in reversed(descent):
            self._names[one] = self._of(one)
        return self._names.get(name, _NONE)

    def of_model(self, name: str) -> Home | None:
        """Where a model begins."""
        flat = self.analysis.all_models.get(name)
        if flat is not None:
            return Home(Path(flat.source.name), flat.written.name.span)
        for path, own in self.analysis.library.words.items():
            if name in own.models:
                start = max(own.source.text.find(f"model({name}"), 0)
                return Home(path, Span(start, start + len("model(") + len(name)))
        return None

    def of_word(self, name: str) -> Home | None:
        """Where a word of the user's own is declared."""
        word = self.analysis.words.get(name)
        if word is None or word.source is None or word.span is None:
            return None
        return Home(Path(word.source.name), word.span)

    def _of(self, name: str) -> Names:
        flat = self.analysis.all_models[name]
        path = Path(flat.source.name)
        parent = flat.written.parent
        above = _NONE if parent is None else self._names.get(parent.text, _NONE)
        before = self.before_models(flat.file)
        parts, lines = dict(above.parts), dict(above.lines)
        constants = {**before.constants, **above.constants}
        definitions = {**before.definitions, **above.definitions}
        for statement in flat.written.statements:
            match statement:
                case s.Part(names=names):
                    for part in names:
                        parts.setdefault(part.text, Home(path, part.span))
                case s.Let(name=given):
                    constants.setdefault(given.text, Home(path, given.span))
                case s.Define(name=given):
                    definitions.setdefault(given.text, Home(path, given.span))
                case s.Line(label=label) if label is not None:
                    lines.setdefault(label.text, Home(path, label.span))
                case _:
                    pass
        return Names(parts, constants, definitions, lines)
