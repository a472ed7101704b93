"""A model file, read and checked: the one door for the compiler, the commands and the editor."""

import gc
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from facetlog.grammar import syntax as s
from facetlog.grammar.checking.model import check_file, check_model
from facetlog.grammar.faults import Fault, Severity
from facetlog.grammar.library import Library, Read, read_library, read_text
from facetlog.grammar.lint.allowed import drop_allowed
from facetlog.grammar.lint.lint import lint
from facetlog.grammar.passes.memo import Fingerprints, Memo
from facetlog.grammar.resolve import FlatModel, flat_models
from facetlog.grammar.scope import Scope, file_scope, model_roles, model_scope
from facetlog.grammar.vocabulary import VOCABULARY, Kinds, Word

__all__ = ["PASSES", "Analysis", "Memory", "analyse"]


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


References = tuple[tuple[str, s.Name], ...]
"""The models that one refers to, with where it does."""


@dataclass(slots=True)
class Memory:
    """What analyses of one file as it is edited have found out, for the next of them."""

    checked: Memo[References] = field(default_factory=Memo)


def analyse(
    path: Path,
    text: str | None = None,
    *,
    read: Read = read_text,
    memory: Memory | None = None,
) -> Analysis:
    """Reads and checks a model file; `text` takes the place of the file's own.

    Never raises for anything that the file holds: what is wrong is in `faults`. With the `memory`
    of analyses of the same file, only what has changed since the last is looked at.
    """
    with _collector_paused():
        draft = _Draft(path, text, read, memory)
        for step in PASSES:
            step(draft)
        return draft.analysis()


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
            if gc.get_freeze_count() == 0:
                # All that is new counts as old, without a walk through it on the way out.
                gc.freeze()
                gc.unfreeze()
            gc.enable()


# ----------------------------------------------------------------------- passes


@dataclass(slots=True)
class _Draft:
    """An analysis as its passes make it, each from what those before it have found."""

    path: Path
    text: str | None
    read: Read
    memory: Memory | None
    faults: list[Fault] = field(default_factory=list)
    library: Library = field(init=False)
    words: Mapping[str, Word] = field(init=False)
    models: Mapping[str, FlatModel] = field(init=False)
    scopes: Mapping[str, Scope] = field(init=False)
    roles: Mapping[str, Mapping[str, Kinds]] = field(init=False)
    prints: Fingerprints | None = None
    references: dict[str, References] = field(default_factory=dict)

    def analysis(self) -> Analysis:
        main = self.library.main
        names = (model.name.text for model in main.models)
        own = {name: self.models[name] for name in names if name in self.models}
        faults = _sorted(self.faults, main)
        return Analysis(self.library, own, self.models, self.scopes, self.words, faults)


def _read(draft: _Draft) -> None:
    """The file, and the files that it uses."""
    draft.library = read_library(draft.path, draft.text, draft.read)
    draft.faults.extend(draft.library.faults)
    own = draft.library.words.values()
    draft.words = {**VOCABULARY, **{word.name: word for one in own for word in one.words}}


def _resolve(draft: _Draft) -> None:
    """What models inherit, and what their names stand for."""
    draft.models = flat_models(draft.library.files.values(), draft.faults)
    draft.roles = roles = model_roles(draft.models, draft.library)
    draft.words = {n: word for n, word in draft.words.items() if not (word.yields and n in roles)}
    models = draft.models.items()
    draft.scopes = {name: model_scope(model, draft.words, roles) for name, model in models}
    if draft.memory is not None:
        draft.prints = Fingerprints(draft.library, draft.models, roles)
        draft.memory.checked.begin()


def _check_files(draft: _Draft) -> None:
    """What stands before the first model of each file."""
    for file in draft.library.files.values():
        draft.faults.extend(check_file(file_scope(file, draft.words, draft.roles)))


def _check_models(draft: _Draft) -> None:
    """Names, kinds and dimensions in each model."""
    # What could not be read may be what a model seems to lack.
    unread = {fault.source for fault in draft.library.faults}
    for name, scope in draft.scopes.items():
        draft.references[name], faults = _checked(scope, draft)
        draft.faults.extend(f for f in faults if f.code not in _LACKING or f.source not in unread)


def _checked(scope: Scope, draft: _Draft) -> tuple[References, tuple[Fault, ...]]:
    model, memory, prints = scope.model, draft.memory, draft.prints
    start = model.written.span.start
    kept = memory.checked.take(model, prints) if memory is not None and prints else None
    if kept is None:
        checked = check_model(scope)
        references = tuple((name, s.moved(where, -start)) for name, where in checked.references)
        if memory is not None and prints is not None:
            memory.checked.keep(model, prints, references, checked.faults)
        return tuple(checked.references), checked.faults
    # Places are kept from the model's own beginning.
    return tuple((name, s.moved(where, start)) for name, where in kept[0]), kept[1]


def _find_circles(draft: _Draft) -> None:
    """Models that must be judged to judge themselves."""
    draft.faults.extend(_circles(draft.models, draft.references))


def _lint(draft: _Draft) -> None:
    """What is odd about models without errors."""
    draft.faults.extend(lint(draft.scopes, draft.library.main, draft.faults))


def _allow(draft: _Draft) -> None:
    """Warnings that the author allows are no faults."""
    draft.faults = drop_allowed(draft.library.main, draft.faults)


PASSES: tuple[Callable[[_Draft], None], ...] = (
    _read,
    _resolve,
    _check_files,
    _check_models,
    _find_circles,
    _lint,
    _allow,
)
"""The passes of an analysis, in their order."""


def _sorted(faults: Iterable[Fault], main: s.File) -> tuple[Fault, ...]:
    def order(fault: Fault) -> tuple[bool, str, int, int]:
        other = fault.source is not main.source
        return other, fault.source.name, fault.span.start, fault.span.end

    return tuple(dict.fromkeys(sorted(faults, key=order)))


def _circles(
    models: Mapping[str, FlatModel], references: Mapping[str, References]
) -> Iterator[Fault]:
    """Models that must be judged to judge themselves, directly or not."""
    needs: dict[str, tuple[str, ...]] = {}
    for name, model in models.items():
        parent = model.written.parent
        own = tuple(other for other, _ in references[name])
        needs[name] = (*own, parent.text) if parent is not None else own
    for name, model in models.items():
        for other, where in references[name]:
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
