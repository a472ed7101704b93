"""Rule files and model files as the Prolog that is loaded."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.errors import RuleSyntaxError
from facetlog.safe_read import read_regular

if TYPE_CHECKING:
    from facetlog.grammar.compile import Program

# The language takes a tenth of a second to load: who has no models of his own does without.

__all__ = [
    "MODEL_SUFFIX",
    "RULE_SUFFIXES",
    "RuleSource",
    "has_only_words",
    "lacks_models",
    "read_rule_sources",
    "read_rule_text",
]

MODEL_SUFFIX = ".model"
"""Suffix of files in the model language; all others are Prolog."""

RULE_SUFFIXES = (MODEL_SUFFIX, ".pl")


_MODEL_LINE = re.compile(r"^[\s\ufeff]*model\b", re.MULTILINE)

# What compiled clauses and the words beside them are headed by.
_MADE_FROM = re.compile(r"% (\S+\.model:\d+|(\S+\.pl)$)")


@dataclass(frozen=True, slots=True)
class RuleSource:
    """The Prolog of a file, and all files that it was made from, itself first."""

    path: Path
    text: str
    files: tuple[Path, ...]

    def place(self, line: int) -> str:
        """Return the file and line that a line of the text, from 1, was made from."""
        made, name, since = str(self.path), "", 0
        for number, written in enumerate(self.text.splitlines()[:line], 1):
            found = _MADE_FROM.match(written)
            if found is not None:
                made, name, since = found[1], found[2] or "", number
        return f"{name}:{line - since}" if name else made

    @property
    def prolog_file(self) -> Path | None:
        """A file that it was made from and that is in Prolog: itself, or one with words for it."""
        return next((path for path in self.files if path.suffix != MODEL_SUFFIX), None)


LONGEST_BYTES = 1_000_000
"""No larger file is read; reading.pl, which counts characters, has the tighter limit."""


def read_rule_text(path: Path) -> str:
    """Return the text of the file, line ends as they are.

    Raise RuleSyntaxError if it is not there, may not be read, is too large, or is not UTF-8; then
    the message names the line.
    """
    try:
        data = read_regular(path, LONGEST_BYTES)
    except FileNotFoundError:
        raise RuleSyntaxError(f"{path}: there is no such file") from None
    except PermissionError:
        raise RuleSyntaxError(f"{path}: it may not be read") from None
    except OSError as exc:
        raise RuleSyntaxError(f"{path}: it cannot be read: {exc.strerror}") from exc
    try:
        return data.decode()
    except UnicodeDecodeError as exc:
        line = data.count(b"\n", 0, exc.start) + 1
        raise RuleSyntaxError(
            f"{path}:{line}: this is no UTF-8 text: save the file as UTF-8"
        ) from exc


def has_only_words(path: Path) -> bool:
    """Return whether a Prolog file declares words for the models of other files, and no model
    itself."""
    if path.suffix == MODEL_SUFFIX:
        return False
    from facetlog.grammar.own_words import own_words
    from facetlog.grammar.source import Source

    try:
        own = own_words(Source(str(path), read_rule_text(path)))
    except RuleSyntaxError:
        return False  # loading it says why
    return bool(own.words) and not own.models


def lacks_models(path: Path) -> bool:
    """Return whether a file in the model language is empty, or has nothing but comments and
    constants."""
    if path.suffix != MODEL_SUFFIX:
        return False
    try:
        return _MODEL_LINE.search(read_rule_text(path)) is None
    except RuleSyntaxError:
        return False  # loading it says why


def read_rule_sources(path: Path, *, present: Iterable[Path] = ()) -> tuple[RuleSource, ...]:
    """Return the file, last, after the model files whose models it asks about, and those that they
    ask.

    Of these others, files that are `present` are left out with what they need.
    Raise RuleSyntaxError, with all its faults, for a file that cannot be read or has any.
    """
    if path.suffix != MODEL_SUFFIX:
        return (RuleSource(path, read_rule_text(path), (path,)),)
    source, program = _compile_source(path)
    seen = {path.resolve(), *(known.resolve() for known in present)}
    found = [source]
    waiting = list(program.needs)
    while waiting:
        needed = waiting.pop()
        if needed.resolve() not in seen:
            seen.add(needed.resolve())
            source, program = _compile_source(needed)
            found.append(source)
            waiting.extend(program.needs)
    return tuple(reversed(found))


def _compile_source(path: Path) -> tuple[RuleSource, "Program"]:
    from facetlog.grammar.analysis import analyse
    from facetlog.grammar.compile import compiled

    analysis = analyse(path)
    program = compiled(analysis)
    if not program.models:
        raise RuleSyntaxError(f"{path}: there is no model in it; begin one with `model NAME`")
    library = analysis.library
    files = tuple(dict.fromkeys((path, *library.files, *library.words)))
    return RuleSource(path, program.prolog, files), program
