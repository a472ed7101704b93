"""A model file, read and checked: the one door for the compiler, the commands and the editor."""

import gc
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from facetlog.grammar import syntax as s
from facetlog.grammar.checking.model import Checked, check_file, check_model
from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.library import Library, Read, read_library, read_text
from facetlog.grammar.lint.allowed import not_allowed
from facetlog.grammar.lint.lint import lint
from facetlog.grammar.resolve import FlatModel, flat_models
from facetlog.grammar.scope import Scope, file_scope, model_roles, model_scope
from facetlog.grammar.vocabulary import VOCABULARY, Word

__all__ = ["Analysis", "analyse"]


_LACKING = frozenset({"no-parts", "no-lines"})


@dataclass(frozen=True, slots=True)
class Analysis:
    """What is known of a model file.

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


def analyse(path: Path, text: str | None = None, *, read: Read = read_text) -> Analysis:
    """Reads and checks a model file; `text` takes the place of the file's own.

    Never raises for anything that the file holds: what is wrong is in `faults`.
    """
    with _collector_paused():
        return _analysed(path, text, read)


@contextmanager
def _collector_paused() -> Iterator[None]:
    """Keeps Python's collector of cycles from walking the growing tree again and again.

    A tree has no cycles; for a thousand models the walks took as long as all the rest.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


def _analysed(path: Path, text: str | None, read: Read) -> Analysis:
    library = read_library(path, text, read)
    faults = list(library.faults)
    words = {**VOCABULARY, **{w.name: w for own in library.words.values() for w in own.words}}
    every = flat_models(library.files.values(), faults)
    own = {m.name.text: every[m.name.text] for m in library.main.models if m.name.text in every}
    roles = model_roles(every, library)
    scopes = {name: model_scope(model, words, roles) for name, model in every.items()}
    for file in library.files.values():
        faults.extend(check_file(file_scope(file, words, roles)))
    checked = {name: check_model(scope) for name, scope in scopes.items()}
    # What could not be read may be what a model seems to lack.
    unread = {fault.source for fault in library.faults}
    for one in checked.values():
        faults.extend(f for f in one.faults if f.code not in _LACKING or f.source not in unread)
    faults.extend(_circles(every, checked))
    faults.extend(lint(scopes, library.main, faults))
    left = not_allowed(library.main, faults)
    return Analysis(library, own, every, scopes, words, _sorted(left, library.main))


def _sorted(faults: Iterable[Fault], main: s.File) -> tuple[Fault, ...]:
    def order(fault: Fault) -> tuple[bool, str, int, int]:
        other = fault.source is not main.source
        return other, fault.source.name, fault.span.start, fault.span.end

    return tuple(dict.fromkeys(sorted(faults, key=order)))


def _circles(models: Mapping[str, FlatModel], checked: Mapping[str, Checked]) -> Iterator[Fault]:
    """Models that are asked about in order to judge themselves, directly or not."""
    needs: dict[str, tuple[str, ...]] = {}
    for name, model in models.items():
        parent = model.written.parent
        own = tuple(other for other, _ in checked[name].asked)
        needs[name] = (*own, parent.text) if parent is not None else own
    for name, model in models.items():
        for other, where in checked[name].asked:
            if other == name or _reaches(other, name, needs):
                by = "itself" if other == name else f"`{other}`, and that on `{name}`"
                message = f"whether something is a `{name}` depends on {by}"
                hint = "no answer can be given: ask about parts instead"
                yield Fault("cycle", message, model.source, where.span, hint)
                break


def _reaches(start: str, goal: str, needs: Mapping[str, tuple[str, ...]]) -> bool:
    seen, waiting = {start}, [start]
    while waiting:
        for other in needs.get(waiting.pop(), ()):
            if other == goal:
                return True
            if other not in seen:
                seen.add(other)
                waiting.append(other)
    return False
