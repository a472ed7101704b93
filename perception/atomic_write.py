"""Files that are there whole or not at all."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from facetlog.errors import InputError


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file beside its place and rename it there, so that nobody reads half of it.

    As `open_atomically`, of what is at hand as a whole.
    """
    with open_atomically(path) as file:
        file.write(content)


@contextmanager
def open_atomically(path: Path) -> Iterator[BinaryIO]:
    """Open a file beside its place, which is renamed there at the end if nothing was raised.

    Raise InputError if the folder cannot be written to; an older file is then left as it was, else
    its permissions are kept. A link stays one: its target is written, also where there is none yet.
    What is no file (a pipe, a device) is written to as it stands.
    """
    try:
        if path.exists() and not path.is_file():
            with path.open("wb") as file:
                yield file
            return
        path = path.resolve()
        part = path.with_name(f".{path.name}.{os.getpid()}.part")
        try:
            with part.open("wb") as file:
                yield file
                file.flush()
                if path.exists():
                    os.fchmod(file.fileno(), stat.S_IMODE(path.stat().st_mode))
                os.fsync(file.fileno())
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
    except (OSError, RuntimeError) as exc:  # RuntimeError: a link to itself
        raise InputError(
            f"{path}: cannot be written: {getattr(exc, 'strerror', None) or exc}"
        ) from exc
