"""Which model files the arguments of a command name."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from facetlog.errors import InputError

__all__ = ["STDIN", "Files", "is_stdin", "model_files", "read_stdin"]

SUFFIX = ".model"

STDIN = Path("<stdin>")
"""Name of the text on standard input; files that it uses are relative to the current folder."""

Files = Annotated[
    list[str],
    typer.Argument(
        metavar="FILE...",
        help="Model files, folders of them, or patterns in quotes; - reads standard input.",
        show_default=False,
    ),
]

_MAGIC = frozenset("*?[")


def is_stdin(path: Path) -> bool:
    """Return whether the path stands for standard input."""
    return path == STDIN


def model_files(arguments: Sequence[str]) -> tuple[Path, ...]:
    """Return the model files that these files, folders, patterns and "-" name, each once.

    Folders and patterns in alphabetical order, without hidden folders. A file that is not there is
    among them: reading it will say so. Raise InputError for a folder or pattern without models.
    """
    found: list[Path] = []
    for argument in arguments:
        found.extend(_resolve_argument(argument))
    return tuple(dict.fromkeys(found))


def _resolve_argument(argument: str) -> tuple[Path, ...]:
    if argument == "-":
        return (STDIN,)
    path = Path(argument)
    try:
        if path.is_dir():
            return _match_inside(path, f"**/*{SUFFIX}", f"{path}: the folder has no {SUFFIX} files")
        exists = path.exists()
    except (OSError, ValueError) as exc:  # too long for a file's name, or with a NUL
        raise InputError(f"{argument!r} is no file: {exc}") from exc
    if not exists and _MAGIC & set(argument):
        base = Path(path.anchor) if path.is_absolute() else Path()
        pattern = str(path.relative_to(path.anchor))
        return _match_inside(base, pattern, f"{argument}: no {SUFFIX} file is called so")
    if path.suffix == ".pl":
        raise InputError(f"{path} is Prolog, no {SUFFIX} file: it is checked when it is loaded")
    return (path,)


def _match_inside(folder: Path, pattern: str, nothing: str) -> tuple[Path, ...]:
    """Return the model files in a folder that match a pattern; InputError (`nothing`) if none."""
    try:
        paths = sorted(folder.glob(pattern))
    except (OSError, ValueError, NotImplementedError) as exc:
        raise InputError(f"{pattern!r} is no pattern for files: {exc}") from exc
    found = tuple(
        path
        for path in paths
        if path.suffix == SUFFIX
        and path.is_file()
        and not any(part.startswith(".") for part in path.relative_to(folder).parts if part != "..")
    )
    if not found:
        raise InputError(nothing)
    return found


def read_stdin() -> str:
    """Read standard input; raise InputError if it is not UTF-8 or far too long for a model."""
    from facetlog.grammar.reading.parse import LARGEST

    # Four bytes a character at most; one more shows that it is too long, and parse says so.
    data = typer.get_binary_stream("stdin").read(4 * LARGEST + 1)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as exc:
        line = data.count(b"\n", 0, exc.start) + 1
        raise InputError(
            f"standard input: line {line} is no UTF-8 text: save it as UTF-8"
        ) from None
