"""Symbols: what a word of a file stands for, and where it was given its name."""

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import Analysis
from facetlog.grammar.faults import MOST_FAULTS
from facetlog.grammar.reading.layout import STATEMENT_WORDS, Layout, laid_out, pieces
from facetlog.grammar.reading.parse import Readable
from facetlog.grammar.scope import get_part_kind
from facetlog.grammar.source import NOWHERE, Span
from facetlog.grammar.traversal import Node, children
from facetlog.grammar.vocabulary import PIECE


class SymbolKind(StrEnum):
    """The kinds of symbols."""

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
    """A named thing; `home` is None if the language or facetlog itself defines it.

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
        """Return the symbol at a place or right before it; of two that touch, the later."""
        i = bisect_right(self.every, offset, key=lambda one: one.span.start) - 1
        if i < 0:
            return None
        found = self.every[i]
        return found if offset <= found.span.end + len(found.plural) else None

    def of(self, symbol: Symbol) -> tuple[Occurrence, ...]:
        """Return where a symbol surely stands."""
        return tuple(one for one in self.every if one.sure and one.symbol == symbol)


Names = Mapping[tuple[SymbolKind, str], Home]
"""Where names are given, by what they stand for."""


class Homes:
    """The homes of all names that are known of a file."""

    def __init__(self, analysis: Analysis) -> None:
        self.analysis = analysis
        self._names: dict[str, Names] = {}

    def find_file_names(self, file: s.File) -> Names:
        """Return the constants and definitions that stand before the first model of a file."""
        found: dict[tuple[SymbolKind, str], Home] = {}
        _add_names(file.statements, Path(file.source.name), found)
        return found

    def find_model_names(self, name: str) -> Names:
        """Return the names of a model; what an ancestor named first is at home there."""
        descent: list[str] = []
        at = name
        while at in self.analysis.all_models and at not in descent and at not in self._names:
            descent.append(at)
            parent = self.analysis.all_models[at].written.parent
            at = "" if parent is None else parent.text
        for one in reversed(descent):
            self._names[one] = self._collect_names(one)
        return self._names.get(name, {})

    def of_model(self, name: str) -> Home | None:
        """Return where a model begins."""
        flat = self.analysis.all_models.get(name)
        if flat is not None:
            return Home(Path(flat.source.name), flat.written.name.span)
        for path, own in self.analysis.library.words.items():
            if name in own.models:
                start = max(own.source.text.find(f"model({name}"), 0)
                return Home(path, Span(start, start + len("model(") + len(name)))
        return None

    def find_word_home(self, name: str) -> Home | None:
        """Return where a word of the user's own is declared."""
        word = self.analysis.words.get(name)
        if word is None or word.source is None or word.span is None:
            return None
        return Home(Path(word.source.name), word.span)

    def _collect_names(self, name: str) -> Names:
        flat = self.analysis.all_models[name]
        parent = flat.written.parent
        above = {} if parent is None else self._names.get(parent.text, {})
        found = {**self.find_file_names(flat.file), **above}
        _add_names(flat.written.statements, Path(flat.source.name), found)
        return found


def _add_names(
    statements: Iterable[s.Statement], path: Path, found: dict[tuple[SymbolKind, str], Home]
) -> None:
    """Add the names that statements give, but for those that are given already."""
    for statement in statements:
        match statement:
            case s.Part(names=names):
                kind, given = SymbolKind.PART, names
            case s.Let(name=name):
                kind, given = SymbolKind.CONSTANT, (name,)
            case s.Define(name=name):
                kind, given = SymbolKind.DEFINITION, (name,)
            case s.Line(label=s.Name() as label):
                kind, given = SymbolKind.LINE, (label,)
            case _:
                continue
        for name in given:
            found.setdefault((kind, name.text), Home(path, name.span))


# Local names (of `each`, `there` and parameters): the symbol, and the model if it is an object.
Locals = Mapping[str, tuple[Symbol, str]]


def occurrences(analysis: Analysis) -> Occurrences:
    """Return the symbols of the file that was analysed; those in statements that cannot be read
    unsure.
    """
    finder = _Finder(analysis)
    finder.file(analysis.file)
    finder.unreadable(analysis.file)
    return Occurrences(tuple(sorted(set(finder.found), key=lambda one: one.span.start)))


class _Finder:
    def __init__(self, analysis: Analysis) -> None:
        self.analysis = analysis
        self.path = Path(analysis.file.source.name)
        self.homes = Homes(analysis)
        self.found: list[Occurrence] = []
        self.names = self.homes.find_file_names(analysis.file)
        self.models = dict.fromkeys(analysis.all_models)
        self.models |= dict.fromkeys(m for w in analysis.library.words.values() for m in w.models)
        self.model = ""
        self.sure = True

    def file(self, file: s.File) -> None:
        for statement in file.statements:
            self._find_in_statement(statement)
        for model in file.models:
            self.model = model.name.text
            flat = self.analysis.all_models.get(self.model)
            if flat is None or flat.written is not model:
                # A second model of one name is a fault; it has no names of its own.
                continue
            self.names = self.homes.find_model_names(self.model)
            self._add(SymbolKind.MODEL, model.name, Home(self.path, model.name.span))
            if model.parent is not None:
                self._add_model(model.parent)
            for other in model.rather_than:
                self._add_model(other)
            for statement in model.statements:
                self._find_in_statement(statement)

    def unreadable(self, file: s.File) -> None:
        """Find the known words of statements that cannot be read."""
        readable = Readable(file)
        self.sure = False
        self.model = ""
        self.names = self.homes.find_file_names(file)
        for statement in (x for piece in self._iter_unread() for x in piece.statements):
            first, *rest = statement.tokens
            if first.text == "model" and rest:
                self.model = rest[0].text
                self.names = self.homes.find_model_names(self.model)
            if readable.has(statement.span):
                continue
            for token in statement.tokens:
                if token.kind == "word" and token.text not in STATEMENT_WORDS:
                    name = s.Name(token.text, Span(token.start, token.end))
                    before = len(self.found)
                    self._add_value(name, {})
                    if len(self.found) == before:
                        self._add_word(name)

    def _iter_unread(self) -> Iterator[Layout]:
        """Iterate over the pieces of the text in which something could not be read."""
        source = self.analysis.file.source
        places = [f.span.start for f in self.analysis.library.faults if f.source is source]
        # After so many faults no more are listed.
        every = len(places) >= MOST_FAULTS
        for piece in pieces(source.text) if places else ():
            if every or any(place in piece for place in places):
                yield laid_out(source, piece)

    # -------------------------------------------------------- statements

    def _find_in_statement(self, node: s.Statement) -> None:
        match node:
            case s.Use(path=path):
                inside = Span(path.span.start + 1, path.span.end - 1)
                file = Home(self.path.parent / path.value, NOWHERE)
                self._add(SymbolKind.FILE, s.Name(path.value, inside), file)
            case s.Let():
                self._add_known(node.name, SymbolKind.CONSTANT)
                self._find_in_expression(node.value, {})
            case s.Define():
                self._add_known(node.name, SymbolKind.DEFINITION)
                brought = {p.text: (self._add_local(p), "") for p in node.parameters}
                self._find_in_expression(node.body, brought)
            case s.Part():
                self._find_in_part(node)
            case s.Line():
                if node.label is not None:
                    self._add_known(node.label, SymbolKind.LINE)
                self._find_in_expression(node.condition, {})
            case s.Drop():
                self._find_lines(node.labels)
            case s.Size():
                for measure in node.measures:
                    self._find_in_expression(measure, {})
            case s.Example():
                self._find_lines(node.because)
                self._find_in_scene(node.scene)

    def _find_in_part(self, node: s.Part) -> None:
        self._add_kind(node.kind)
        for name in node.names:
            self._add_known(name, SymbolKind.PART)
        if node.where is not None:
            self._find_in_expression(node.where, {})

    def _find_lines(self, labels: Iterable[s.Name]) -> None:
        """Label after `drop` and `because`; the latter may also name sets by their counts."""
        for label in labels:
            self._add_known(label, SymbolKind.LINE, SymbolKind.PART)

    def _find_in_scene(self, scene: s.SceneFile | s.SceneBuilt) -> None:
        if isinstance(scene, s.SceneBuilt):
            for solid in scene.solids:
                self._add(SymbolKind.BUILDER, solid.builder, None)
                for setting in solid.settings:
                    self._find_in_expression(setting.quantity, {})

    # ------------------------------------------------------- expressions

    def _find_in_expression(self, node: s.Expression, brought: Locals) -> None:
        match node:
            case s.Quantity(unit=unit):
                if unit is not None:
                    self._add(SymbolKind.UNIT, unit, None)
            case s.Reference(name=name):
                self._add_value(name, brought)
            case s.Member():
                self._add_member(node, brought)
            case s.Call(name=name):
                self._add_word(name)
                self._find_inside(node, brought)
            case s.Property(name=name):
                self._find_inside(node, brought)
                self._add_word(name)
            case s.Relation(name=name):
                self._find_inside(node, brought)
                self._add_word(name)
            case s.Each(kind=None):
                self._add_value(node.name, brought)
                self._find_in_expression(node.body, brought)
            case s.Each(kind=s.Name() as kind):
                self._add_kind(kind)
                inside = {**brought, node.name.text: (self._add_local(node.name), "")}
                if node.where is not None:
                    self._find_in_expression(node.where, inside)
                self._find_in_expression(node.body, inside)
            case s.EachOf():
                model = self._find_range(node.of, brought)
                new = {name.text: (self._add_local(name), model) for name in node.names}
                self._find_in_expression(node.body, {**brought, **new})
            case s.There():
                self._add_kind(node.kind)
                model = self._find_range(node.of, brought)
                local = self._add_local(node.name)
                if node.where is not None:
                    self._find_in_expression(
                        node.where, {**brought, node.name.text: (local, model)}
                    )
            case _:
                self._find_inside(node, brought)

    def _find_inside(self, node: Node, brought: Locals) -> None:
        for child in children(node):
            if not isinstance(child, s.Name):
                self._find_in_expression(child, brought)  # type: ignore[arg-type]

    def _find_range(self, of: Iterable[s.Name], brought: Locals) -> str:
        """Note the names that a local name ranges over; return the model of its objects."""
        model = ""
        for name in of:
            self._add_value(name, brought)
            model = self._get_model_of(name.text, brought)
        return model

    def _get_model_of(self, name: str, brought: Locals) -> str:
        """Return the model of an object, or of a set of them; empty if it is none."""
        if name in brought:
            return brought[name][1]
        scope = self.analysis.scopes.get(self.model)
        symbol = None if scope is None else scope.symbols.get(name)
        return "" if symbol is None else symbol.model

    # -------------------------------------------------------------- names

    def _add(self, kind: SymbolKind, name: s.Name, home: Home | None, plural: str = "") -> None:
        text = name.text.removesuffix(plural)
        span = Span(name.span.start, name.span.end - len(plural))
        symbol = Symbol(kind, text, home, self.model)
        self.found.append(Occurrence(symbol, span, plural, self.sure))

    def _add_known(self, name: s.Name, *kinds: SymbolKind) -> bool:
        """Add a name as the first of some kinds that it is known as."""
        for kind in kinds:
            home = self.names.get((kind, name.text))
            if home is not None:
                self._add(kind, name, home)
                return True
        return False

    def _add_local(self, name: s.Name) -> Symbol:
        self._add(SymbolKind.LOCAL, name, Home(self.path, name.span))
        return self.found[-1].symbol

    def _add_value(self, name: s.Name, brought: Locals) -> None:
        """Add a part, a set, a constant, or a name of `each`, `there` or a definition."""
        if name.text in brought:
            self._add(SymbolKind.LOCAL, name, brought[name.text][0].home)
        else:
            self._add_known(name, SymbolKind.PART, SymbolKind.CONSTANT)

    def _add_member(self, node: s.Member, brought: Locals) -> None:
        self._add_value(node.owner, brought)
        model = self._get_model_of(node.owner.text, brought)
        home = self.homes.find_model_names(model).get((SymbolKind.PART, node.part.text))
        if home is not None:
            symbol = Symbol(SymbolKind.PART, node.part.text, home, model)
            self.found.append(Occurrence(symbol, node.part.span))

    def _add_word(self, name: s.Name) -> None:
        """Add a definition, a word of the vocabulary, or a model."""
        if self._add_known(name, SymbolKind.DEFINITION):
            return
        if name.text in self.analysis.words:
            self._add(SymbolKind.WORD, name, self.homes.find_word_home(name.text))
        else:
            self._add_model(name)

    def _add_model(self, name: s.Name) -> None:
        home = self.homes.of_model(name.text)
        if home is not None:
            self._add(SymbolKind.MODEL, name, home)

    def _add_kind(self, name: s.Name) -> None:
        """Add the kind of a part, singular or plural, if it is a model or a shape of pieces."""
        found = get_part_kind(name.text, self.models)
        if found is not None and found[1]:
            home = self.homes.of_model(found[1])
            self._add(SymbolKind.MODEL, name, home, name.text[len(found[1]) :])
        elif found == (PIECE, "") and name.text.removesuffix("s") in self.analysis.words:
            shape = name.text.removesuffix("s")
            self._add(
                SymbolKind.WORD, name, self.homes.find_word_home(shape), name.text[len(shape) :]
            )
