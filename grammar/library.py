"""A model file and the files that it uses."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from facetlog.grammar import syntax as s
from facetlog.grammar.faults import Fault
from facetlog.grammar.own_words import OwnWords, own_words
from facetlog.grammar.reading.parse import LARGEST, parse
from facetlog.grammar.source import NOWHERE, Source
from facetlog.grammar.traversal import walk
from facetlog.safe_read import read_regular

BUILTIN = Path(__file__).resolve().parent.parent / "rules"
"""Models that every file may name without `use`."""

MOST_FILES = 500
"""Files that one may use, directly or not."""

Read = Callable[[Path], str]
"""Gives the text of a file; raises OSError or ValueError (not a text) if it cannot."""


@dataclass(frozen=True, slots=True)
class Library:
    """A file, the model files in its reach (itself first), and the words that Prolog files add.

    Every file may name what is in any file of the library: `use` joins, it does not hide.
    """

    main: s.File
    files: Mapping[Path, s.File]
    words: Mapping[Path, OwnWords]
    faults: tuple[Fault, ...]


def read_text(path: Path) -> str:
    """Return the text of a file as UTF-8; ValueError if it is none, OSError if it cannot be
    read."""
    raw = read_regular(path, 4 * LARGEST)
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw[: error.start].count(b"\n") + 1
        raise ValueError(f"line {line} is no UTF-8 text: save the file as UTF-8") from None


@dataclass(slots=True)
class _Reader:
    read: Read
    files: dict[Path, s.File] = field(default_factory=dict)
    words: dict[Path, OwnWords] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)

    def add(self, path: Path, text: str) -> s.File:
        parsed = parse(Source(str(path), text))
        self.files[path] = parsed.file
        self.faults.extend(parsed.faults)
        return parsed.file

    def follow(self, path: Path) -> None:
        """Read what a file uses, and what that uses."""
        waiting = [path]
        while waiting:
            base = waiting.pop()
            for use in self.files[base].uses:
                used = self._read_used(base, use)
                if used is not None:
                    waiting.append(used)

    def _read_used(self, base: Path, use: s.Use) -> Path | None:
        """Return the path of a model file that is used here for the first time."""
        path = _resolve_path(base, use.path.value)
        if path in self.files or path in self.words:
            return None
        source = self.files[base].source
        if path.suffix not in (".model", ".pl"):
            hint = "models are in files named .model, words of your own in files named .pl"
            self.faults.append(
                Fault("use", f"`{use.path.value}` is no model file", source, use.path.span, hint)
            )
            return None
        if len(self.files) + len(self.words) >= MOST_FILES:
            message = f"more than {MOST_FILES} files are used"
            self.faults.append(Fault("use", message, source, use.path.span))
            return None
        try:
            text = self.read(path)
        except (OSError, ValueError) as error:
            why = (
                "there is no such file"
                if isinstance(error, FileNotFoundError)
                else _get_reason(error)
            )
            self.faults.append(
                Fault("use", f"`{use.path.value}` cannot be read: {why}", source, use.path.span)
            )
            return None
        if path.suffix == ".pl":
            self.words[path] = own_words(Source(str(path), text))
            self.faults.extend(self.words[path].faults)
            return None
        self.add(path, text)
        return path

    def add_builtin(self) -> None:
        """Read the models that come with facetlog, as far as they are named and not defined."""
        while True:
            defined = {m.name.text for f in self.files.values() for m in f.models}
            defined |= {m for own in self.words.values() for m in own.models}
            free = list_builtin_names() - defined
            named = {n for f in self.files.values() for n in _iter_models_named(f, free)}
            missing = sorted(named & free)
            if not missing:
                return
            for name in missing:
                path = BUILTIN / f"{name}.model"
                self.add(path, read_text(path))
                self.follow(path)


def _iter_models_named(file: s.File, models: frozenset[str]) -> Iterator[str]:
    """Iterate over the names of these models, and others: parents, kinds of parts, properties."""
    if not models:
        return
    for model in file.models:
        if model.parent is not None:
            yield model.parent.text
        yield from (other.text for other in model.rather_than)
        named = (x for x in model.statements if isinstance(x, _ASKING))
        for node in (inner for one in named for inner in walk(one)):
            if isinstance(node, s.Part | s.There):
                yield node.kind.text
                yield node.kind.text.removesuffix("s")
            elif isinstance(node, s.Property):
                yield node.name.text


_ASKING = (s.Part, s.Line, s.Define)
"""Statements that can ask about a model; examples name what they build."""


def _get_reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)


def _resolve_path(base: Path, name: str) -> Path:
    """Return a path as `use` writes it: beside the file that says so. `..` is resolved without
    links.
    """
    parts: list[str] = []
    for part in (base.parent / name).parts:
        if part == ".." and parts and parts[-1] not in ("..", "/"):
            parts.pop()
        elif part != ".":
            parts.append(part)
    return Path(*parts) if parts else Path()


def read_library(path: Path, text: str | None = None, read: Read = read_text) -> Library:
    """Return a model file with what it uses; `text` in the place of the file's.

    Whatever cannot be read is a fault, also the file itself.
    """
    path = Path(path)
    reader = _Reader(read)
    if text is None:
        try:
            text = read(path)
        except (OSError, ValueError) as error:
            source = Source(str(path), "")
            message = f"the file cannot be read: {_get_reason(error)}"
            fault = Fault("unreadable", message, source, NOWHERE)
            empty = s.File(source, (), (), ())
            return Library(empty, {path: empty}, {}, (fault,))
    main = reader.add(path, text)
    reader.follow(path)
    reader.add_builtin()
    return Library(main, reader.files, reader.words, tuple(reader.faults))


@cache
def list_builtin_names() -> frozenset[str]:
    """Return the names of the models that come with facetlog, one a file."""
    return frozenset(path.stem for path in BUILTIN.glob("*.model"))
