"""Which files a command may write: never one that it reads, and another's only on request."""

import os
from collections.abc import Collection, Iterable
from pathlib import Path
from typing import Annotated

import typer

from facetlog.errors import InputError
from facetlog.regular_file import open_regular

__all__ = [
    "OWN_PAGE",
    "OWN_SCENE",
    "Overwrite",
    "check_distinct",
    "check_no_input",
    "check_output_file",
]

Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Replace files that are there already.")
]

OWN_PAGE = b'<meta name="generator" content="facetlog'
"""By which a page of facetlog is known as its own."""

OWN_SCENE = b'"facetlog-scene/'
"""The same of a scene."""

HEAD_BYTES = 4096
"""Of a file, within which that stands."""


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
        is_own = own is not None and target.is_file() and own in _head(target)
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
    within = () if folder or is_own else tuple(map(_identity, target.parents))
    for given in inputs:
        if (identity := _identity(given)) is None:
            continue
        if identity == _identity(target):
            why = f"is what is read ({given})"
        elif identity in within:
            why = f"exists in {given}, which is read"
        elif folder and target in given.resolve().parents:
            why = f"holds {given}, which is read"
        else:
            continue
        raise InputError(f"{path} {why}: give another name with {option}")


def _identity(path: Path) -> tuple[int, int] | None:
    """Return what all names of a file or folder share, None where there is none."""
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


def _head(path: Path) -> bytes:
    with open_regular(path) as file:
        return file.read(HEAD_BYTES)
