"""A model file, read and checked: for the compiler, the commands and the editor."""

import gc
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from facetlog.grammar import syntax as s
from facetlog.grammar.checking.model import check_file, check_model
from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.library import Library, Read, read_library, read_text
from facetlog.grammar.lint.allowed import drop_allowed
from facetlog.grammar.lint.lint import lint
from facetlog.grammar.reading.layout import laid_out, pieces
from facetlog.grammar.reading.mistakes import list_declared_names
from facetlog.grammar.reading.parse import Readable
from facetlog.grammar.resolve import FlatModel, find_reachable, flatten_models
from facetlog.grammar.scope import Scope, build_file_scope, build_model_scope, get_model_roles
from facetlog.grammar.source import Source
from facetlog.grammar.vocabulary import VOCABULARY, Word

_LACKING = frozenset({"no-parts", "no-lines"})

_FOLLOWING = frozenset({"unknown-name", "unknown-line", "set"})
"""Faults of names that a part's line, which could not be read, may have declared."""


@dataclass(frozen=True, slots=True)
class Analysis:
    """The result of reading and checking a model file.

    `models` are those of the file itself, with what they inherit; `all_models` also those that it
    may name, and `scopes` what each may name. `words` is the vocabulary with the user's own words.
    `faults` come file by file, this one's first, in the order of the text.
    """

    library: Library
    models: Mapping[str, FlatModel]
    all_models: Mapping[str, FlatModel]
    scopes: Mapping[str, Scope]
    words: Mapping[str, Word]
    faults: tuple[Fault, ...]

    @property
    def file(self) -> s.File:
        """The file as written."""
        return self.library.main

    @property
    def errors(self) -> tuple[Fault, ...]:
        """The faults that keep the file from being used."""
        return tuple(f for f in self.faults if f.severity is Severity.ERROR)


References = Mapping[str, tuple[tuple[str, s.Name], ...]]
"""The models that each model refers to, with where it does."""


def analyse(path: Path, text: str | None = None, *, read: Read = read_text) -> Analysis:
    """Read and check a model file; `text` takes the place of the file's own.

    Never raises for anything that the file holds: what is wrong is in `faults`.
    """
    with _hold_collector():
        return _analyse(path, text, read)


@contextmanager
def _hold_collector() -> Iterator[None]:
    """Hold the collector of circular garbage: a tree is no circle, and to look at all its nodes
    again and again takes a fifth of the time of a large file."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.enable()


def _analyse(path: Path, text: str | None, read: Read) -> Analysis:
    library = read_library(path, text, read)
    main = library.main
    faults = list(library.faults)
    words = {**VOCABULARY, **{w.name: w for own in library.words.values() for w in own.words}}
    models = flatten_models(library.files.values(), faults)
    roles = get_model_roles(models, library)
    words = {n: word for n, word in words.items() if not (word.yields and n in roles)}
    scopes = {name: build_model_scope(model, words, roles) for name, model in models.items()}
    for file in library.files.values():
        faults += check_file(build_file_scope(file, words, roles))
    checks = {name: check_model(scope) for name, scope in scopes.items()}
    references = {name: tuple(check.references) for name, check in checks.items()}
    faults += (fault for check in checks.values() for fault in check.faults)
    faults += _find_circles(models, references)
    faults += lint(scopes, main, faults)
    faults = list(_drop_following(library, faults))

    def order(fault: Fault) -> tuple[bool, str, int, int]:
        other = fault.source is not main.source
        return other, fault.source.name, fault.span.start, fault.span.end

    shown = tuple(dict.fromkeys(sorted(drop_allowed(main, faults), key=order)))
    own = {m.name.text: models[m.name.text] for m in main.models if m.name.text in models}
    return Analysis(library, own, models, scopes, words, shown)


def _drop_following(library: Library, faults: Sequence[Fault]) -> Iterator[Fault]:
    """Yield the faults, without those of what a file lacks since it could not be read."""
    wrong_parts = {(f.source, f.span.start) for f in faults if f.code == "part"}
    sources = {f.source for f in library.faults} | {source for source, _ in wrong_parts}
    names: dict[Source, frozenset[str]] = {}
    for file in library.files.values():
        if file.source in sources:
            readable = Readable(file)
            names[file.source] = frozenset(
                name
                for piece in pieces(file.source.text)
                for statement in laid_out(file.source, piece).statements
                if not readable.has(statement.span)
                or (file.source, statement.span.start) in wrong_parts
                for name in list_declared_names(statement)
            )
    for fault in faults:
        text = fault.source.text[fault.span.start : fault.span.end]
        text = text.removeprefix("count(").removesuffix(")")
        if fault.code in _LACKING and fault.source in sources:
            continue
        if fault.code in _FOLLOWING and text in names.get(fault.source, ()):
            continue
        yield fault


def _find_circles(models: Mapping[str, FlatModel], references: References) -> Iterator[Fault]:
    """Find models that must be judged to judge themselves, directly or not."""
    needs: dict[str, tuple[str, ...]] = {}
    for name, model in models.items():
        parent = model.written.parent
        own = tuple(other for other, _ in references[name])
        needs[name] = (*own, parent.text) if parent is not None else own
    for name, model in models.items():
        for other, where in references[name]:
            if other == name or name in find_reachable(other, lambda one: needs.get(one, ())):
                by = "itself" if other == name else f"`{other}`, and that on `{name}`"
                message = f"whether something is a `{name}` depends on {by}"
                hint = "no answer can be given: ask about parts instead"
                yield Fault("cycle", message, model.source, where.span, hint)
                break
