"""Another name for a symbol, in all files that use it, if that leaves everything as it is."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from facetlog.grammar.analysis import Analysis, analyse
from facetlog.grammar.language_server.project import Project, is_builtin
from facetlog.grammar.language_server.symbols import (
    Occurrence,
    Occurrences,
    Symbol,
    SymbolKind,
    occurrences,
)
from facetlog.grammar.reading.layout import STATEMENT_WORDS
from facetlog.grammar.scope import THIS
from facetlog.grammar.source import Span
from facetlog.grammar.units import UNITS


def references(project: Project, symbol: Symbol, origin: Path) -> Iterator[tuple[Path, Occurrence]]:
    """Iterate over all places of a symbol, file by file: first the one `origin`."""
    for path in _iter_files(project, symbol, origin):
        for one in project.symbols(path).of(symbol):
            yield path, one


def _iter_files(project: Project, symbol: Symbol, origin: Path) -> Iterator[Path]:
    yield origin
    if symbol.kind in (SymbolKind.LOCAL, SymbolKind.UNIT, SymbolKind.BUILDER):
        return
    others = list(project.find_files_with_word(symbol.name))
    if symbol.home is not None and symbol.home.path.suffix == ".model":
        # It may lie outside of the workspace.
        others.append(symbol.home.path)
    yield from (path for path in dict.fromkeys(others) if path != origin)


_NAME = re.compile(r"[^\W\d]\w*\Z")

_UNREADABLE = ("syntax", "misspelt")
"""Codes of faults that a name brings which the grammar takes for a word of its own."""

_FIXED = {
    SymbolKind.WORD: "is a word of the vocabulary",
    SymbolKind.UNIT: "is a unit",
    SymbolKind.FILE: "is a file",
    SymbolKind.BUILDER: "is built by facetlog",
}


class Refusal(Exception):  # noqa: N818 - nothing failed: the name is not given, and this says why
    """A name is not given; one sentence says why."""


@dataclass(frozen=True, slots=True)
class Replacement:
    """A piece of a file and the text that takes its place."""

    path: Path
    span: Span
    text: str


def explain_fixed_name(symbol: Symbol) -> str:
    """Return why a symbol keeps its name; empty if it may get another."""
    if symbol.kind in _FIXED:
        return f"`{symbol.name}` {_FIXED[symbol.kind]}"
    if symbol.home is None or symbol.home.path.suffix == ".pl":
        return f"`{symbol.name}` is not named by a model file"
    if is_builtin(symbol.home.path):
        return f"`{symbol.name}` is of a model that comes with facetlog"
    return ""


def renamed(project: Project, symbol: Symbol, name: str, origin: Path) -> tuple[Replacement, ...]:
    """Return the edits that rename a symbol; raise Refusal if it cannot be renamed.

    The files are read again as they would be: no new fault may arise, and every word must stand for
    what it stood for.
    """
    fixed = explain_fixed_name(symbol)
    if fixed:
        raise Refusal(f"{fixed} and keeps its name")
    _check_spelling(name)
    if symbol.kind is not SymbolKind.LINE and name in project.analysis(origin).words:
        raise Refusal(f"`{name}` is a word of the vocabulary: choose another name")
    if name == symbol.name:
        return ()
    places: dict[Path, list[Occurrence]] = {}
    for path, one in references(project, symbol, origin):
        places.setdefault(path, []).append(one)
    found = tuple(
        Replacement(
            path, Span(one.span.start, one.span.end + len(one.plural)), _add_plural(name, one)
        )
        for path, ones in places.items()
        for one in ones
    )
    _check_meaning(project, symbol, name, found)
    return found


def _check_spelling(name: str) -> None:
    if not _NAME.match(name):
        raise Refusal(f"`{name}` is no name: letters, digits and _ make one, a letter first")
    if name in STATEMENT_WORDS or name in UNITS or name == THIS:
        raise Refusal(f"`{name}` is a word of the language: choose another name")


def _add_plural(name: str, one: Occurrence) -> str:
    """Return the new name, in the plural where the old one was."""
    if not one.plural:
        return name
    return name + ("es" if name.endswith(("s", "x", "z", "ch", "sh")) else "s")


def _check_meaning(
    project: Project, symbol: Symbol, name: str, replacements: Iterable[Replacement]
) -> None:
    texts: dict[Path, str] = {}
    count: Counter[Path] = Counter()
    # From the end of each file, so that places before stay.
    for one in sorted(replacements, key=lambda r: r.span, reverse=True):
        text = texts.get(one.path)
        text = project.text(one.path).text if text is None else text
        texts[one.path] = text[: one.span.start] + one.text + text[one.span.end :]
        count[one.path] += 1

    def read(path: Path) -> str:
        return texts[path] if path in texts else project.read(path)

    for path in texts:
        after = analyse(path, texts[path], read=read)
        _check_faults(project.analysis(path), after, name)
        before = _count_named(project.symbols(path), symbol.kind, name)
        if _count_named(occurrences(after), symbol.kind, name) != before + count[path]:
            raise Refusal(f"`{name}` would be taken for something else: choose another name")


def _count_named(known: Occurrences, kind: SymbolKind, name: str) -> int:
    """Return how often something of a kind is called so in a file."""
    every = (one.symbol for one in known.every if one.sure)
    return sum(symbol.kind is kind and symbol.name == name for symbol in every)


def _check_faults(before: Analysis, after: Analysis, name: str) -> None:
    """Refuse a name that brings new faults, of any file that is read."""

    def kinds(analysis: Analysis) -> Mapping[tuple[str, str], int]:
        return Counter((fault.source.name, fault.code) for fault in analysis.errors)

    known = kinds(before)
    seen: Counter[tuple[str, str]] = Counter()
    for fault in after.errors:
        key = fault.source.name, fault.code
        seen[key] += 1
        if seen[key] <= known.get(key, 0):
            continue
        if fault.code in _UNREADABLE:
            raise Refusal(
                f"`{name}` is a word of the language where it would stand: choose another"
            )
        named = next((f for f in after.errors if name in f.message and f.code == fault.code), fault)
        raise Refusal(f"`{name}` cannot be given: {named.message}")
