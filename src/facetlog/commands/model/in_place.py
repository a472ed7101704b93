"""Files whose text is replaced as a whole."""

import os
import stat
from pathlib import Path

from facetlog.errors import InputError

__all__ = ["replace_text", "write_text"]


def replace_text(path: Path, text: str) -> None:
    """Puts a text in the place of a file's; nobody reads half of it, and its mode stays.

    A link stays a link. Raises InputError if it cannot be; the file is then as it was.
    """
    try:
        _put(path.resolve(strict=True), text, stat.S_IMODE(path.stat().st_mode))
    except OSError as exc:
        raise InputError(f"{path} cannot be written: {exc.strerror or exc}") from exc


def write_text(path: Path, text: str) -> None:
    """Writes a file, which may be there already, as a whole; InputError if it cannot be."""
    if path.is_file():
        replace_text(path, text)
        return
    try:
        if path.exists():  # a pipe or a device; of a folder the attempt says what is wrong
            path.write_text(text, encoding="utf-8", newline="")
        else:
            _put(path, text, None)
    except OSError as exc:
        raise InputError(f"{path} cannot be written: {exc.strerror or exc}") from exc


def _put(path: Path, text: str, mode: int | None) -> None:
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("xb") as file:
            file.write(text.encode())
            if mode is not None:
                os.fchmod(file.fileno(), mode)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
