"""Checks of output files: no command replaces what it reads, nor files of others unless asked."""

import os
from collections.abc import Collection, Iterable
from pathlib import Path

from facetlog.errors import InputError
from facetlog.safe_read import open_regular

__all__ = [
    "OWN_PAGE",
    "OWN_SCENE",
    "check_distinct",
    "check_no_input",
    "check_output_file",
]

OWN_PAGE = b'<meta name="generator" content="facetlog'
"""Mark of a page that facetlog wrote."""

OWN_SCENE = b'"facetlog-scene/'
"""Mark of a scene that facetlog wrote."""

HEAD_BYTES = 4096
"""Number of bytes at the beginning of a file that hold the mark."""


def check_output_file(
    path: Path,
    option: str,
    inputs: Iterable[Path] = (),
    *,
    suffixes: Collection[str] = (),
    own: bytes | None = None,
    overwrite: bool | None = False,
) -> None:
    """Raise InputError unless a command may write a file here; to be called before the work.

    `option` is how the file was given, `inputs` are the files and folders that the command reads:
    none of them is replaced, nor a file in a folder of them, not even with `overwrite`. Without it
    no file is replaced but an empty one, and one that facetlog wrote, known by the mark `own` in
    its head; `overwrite` is None where nothing else is ever replaced. What is no file, as a pipe,
    is written to as it is.
    """
    if suffixes and path.suffix.lower() not in suffixes:
        raise InputError(
            f"{path}: {path.suffix or 'no suffix'}: what can be written is {', '.join(suffixes)}"
        )
    try:
        target = path.resolve()
        if target.is_dir() or not target.parent.is_dir():
            raise InputError(f"{path} cannot be written: give a file in a folder that exists")
        if path.exists() and not target.is_file():
            return
        if not os.access(target.parent, os.W_OK | os.X_OK):
            raise InputError(f"{path} cannot be written: {target.parent} is no folder to write in")
        is_own = own is not None and target.is_file() and own in _read_head(target)
        check_no_input(path, option, inputs, is_own=is_own)
        if target.is_file() and target.stat().st_size and not (overwrite or is_own):
            way = "not written by facetlog: give" if overwrite is None else "give --overwrite, or"
            raise InputError(f"{path} exists: {way} another name with {option}")
    except (OSError, ValueError, RuntimeError) as exc:  # RuntimeError: a link to itself
        raise InputError(f"{str(path)!r} cannot be written: {exc}") from exc


def check_no_input(
    path: Path, option: str, inputs: Iterable[Path], *, is_own: bool = False
) -> None:
    """Raise InputError if what is written at `path` would replace one of the inputs.

    That is an input under whatever name (by links, too), a folder that holds one, and a file that
    exists in a folder that is read, unless it is facetlog's own.
    """
    if not path.exists():
        return
    target = path.resolve()
    folder = target.is_dir()
    within = () if folder or is_own else tuple(map(_identify, target.parents))
    for given in inputs:
        if (identity := _identify(given)) is None:
            continue
        if identity == _identify(target):
            why = f"is what is read ({given})"
        elif identity in within:
            why = f"exists in {given}, which is read"
        elif folder and target in given.resolve().parents:
            why = f"holds {given}, which is read"
        else:
            continue
        raise InputError(f"{path} {why}: give another name with {option}")


def _identify(path: Path) -> tuple[int, int] | None:
    """Return device and inode, which all names of a file or folder share; None if it is missing."""
    try:
        found = path.stat()
    except (OSError, ValueError):
        return None
    return found.st_dev, found.st_ino


def check_distinct(outputs: Iterable[tuple[str, Path | None]]) -> None:
    """Raise InputError if two of the options name the same file or folder."""
    seen: dict[Path, str] = {}
    for option, path in outputs:
        if path is not None and (other := seen.setdefault(path.resolve(), option)) != option:
            raise InputError(f"{path} is given by both {other} and {option}: give another name")


def _read_head(path: Path) -> bytes:
    with open_regular(path) as file:
        return file.read(HEAD_BYTES)
