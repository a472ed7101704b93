"""Files that are there whole or not at all."""

import os
from pathlib import Path

from facetlog.errors import InputError

__all__ = ["write_whole"]


def write_whole(path: Path, content: bytes) -> None:
    """Write a file beside its place and rename it there, so that nobody reads half of it.

    Raises InputError if the folder cannot be written to; an older file is then left as it was. A
    link is followed, and what is no file (a pipe, a device) is written to as it stands.
    """
    try:
        if path.exists() and not path.is_file():
            path.write_bytes(content)
            return
        path = path.resolve()
        part = path.with_name(f".{path.name}.{os.getpid()}.part")
        try:
            with part.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
    except OSError as exc:
        raise InputError(f"{path}: cannot be written: {exc.strerror}") from exc
