"""Where the commands on scenes write: checked before the work."""

from collections.abc import Collection
from pathlib import Path
from typing import Annotated

import typer

from facetlog.errors import InputError

__all__ = ["Overwrite", "check_output"]

Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Replace the file if it is there already.")
]


def check_output(path: Path, suffixes: Collection[str], *, overwrite: bool) -> None:
    """Raises InputError if a file of one of these suffixes cannot or must not be written there."""
    if path.suffix.lower() not in suffixes:
        raise InputError(
            f"{path}: {path.suffix or 'no suffix'}: what can be written is {', '.join(suffixes)}"
        )
    if path.is_dir() or not path.absolute().parent.is_dir():
        raise InputError(f"{path} cannot be written: give a file in a folder that exists")
    if path.is_file() and not overwrite:
        raise InputError(f"{path} exists: give --overwrite, or another name")
