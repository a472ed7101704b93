"""Read regular files only, and not more of them than a limit allows.

Pipes, sockets and devices named like a file would block for ever, or never end. This module
imports errors.py only, so that every package may import it.
"""

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import BinaryIO, TypeAlias

from facetlog.errors import InputError

__all__ = [
    "MOST_BYTES",
    "MOST_SCENE_BYTES",
    "MOST_SHAPE_BYTES",
    "Signature",
    "check_current_folder",
    "check_regular",
    "open_regular",
    "read_regular",
    "read_regular_text",
    "record_reads",
    "sign_file",
]

MOST_BYTES = 256_000_000
"""Largest file of poses, labels or settings: some hundred thousand frames."""

MOST_SCENE_BYTES = 1_000_000_000
"""Largest scene file: some million vertices."""

MOST_SHAPE_BYTES = 4 << 30
"""Largest mesh or cloud: several times what a laser scan of a building takes."""

Signature: TypeAlias = tuple[int, ...]
"""Of a file's state: it changes with any change of the file."""

_READS: ContextVar[dict[Path, Signature] | None] = ContextVar("reads", default=None)

IRREGULAR = "it is a pipe, a socket or a device; give a file"


def check_regular(path: Path) -> None:
    """Raise InputError for a pipe, socket or device. For libraries that open paths.

    What is not there, or is a folder, is left to whoever opens it; links are followed.
    """
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):  # ValueError: a NUL in the name
        return
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
        raise InputError(f"{path}: {IRREGULAR}")


def check_current_folder() -> None:
    """Raise InputError if the current folder was removed: no relative path means anything there."""
    try:
        Path.cwd()
    except OSError as exc:
        raise InputError("the current folder was removed: change to one that exists") from exc


def sign_file(about: os.stat_result) -> Signature:
    """Return the signature of a file's state."""
    return (about.st_dev, about.st_ino, about.st_size, about.st_mtime_ns, about.st_ctime_ns)


@contextmanager
def record_reads() -> Iterator[dict[Path, Signature]]:
    """Return the files that `open_regular` and `read_regular` open from now on, as they were."""
    reads: dict[Path, Signature] = {}
    token = _READS.set(reads)
    try:
        yield reads
    finally:
        _READS.reset(token)


@contextmanager
def open_regular(path: Path, most: int | None = None) -> Iterator[BinaryIO]:
    """Open a regular file to read it from its start; raise OSError for what is no regular file, or
    is longer than `most` bytes.
    """
    try:
        file = open(path, "rb", opener=_open_without_waiting)  # noqa: SIM115 - closed below
    except ValueError as exc:  # a NUL in the name
        raise OSError(errno.EINVAL, str(exc), str(path)) from exc
    except OSError as exc:
        if exc.errno == errno.ENXIO:  # a socket, which cannot be opened
            raise OSError(errno.EINVAL, IRREGULAR, str(path)) from exc
        raise
    with file:
        about = os.fstat(file.fileno())
        if not stat.S_ISREG(about.st_mode):
            raise OSError(errno.EINVAL, IRREGULAR, str(path))
        if most is not None and about.st_size > most:
            raise _make_too_long_error(path, most)
        if (reads := _READS.get()) is not None:
            reads.setdefault(path, sign_file(about))
        yield file


def read_regular(path: Path, most: int = MOST_BYTES) -> bytes:
    """Read a whole regular file of at most `most` bytes; OSError as `open_regular` raises it."""
    with open_regular(path, most) as file:
        # Memory is taken for all that is asked for: not for the longest file there may be.
        size = os.fstat(file.fileno()).st_size
        data = file.read(min(size, most) + 1)
        if len(data) > size:  # it grows, or says nothing of its size
            data += file.read(most + 1 - len(data))
    if len(data) > most:
        raise _make_too_long_error(path, most)
    return data


def read_regular_text(path: Path, most: int = MOST_BYTES) -> str:
    """Read a regular file as UTF-8 text, without a byte order mark, with line ends as they are.

    UnicodeDecodeError, which is a ValueError, for what is no such text.
    """
    return read_regular(path, most).decode("utf-8-sig")


def _make_too_long_error(path: Path, most: int) -> OSError:
    return OSError(errno.EFBIG, f"it is too long: at most {most:,} bytes", str(path))


def _open_without_waiting(path: str, flags: int) -> int:
    # To open a pipe waits for its other end, but for this flag.
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
