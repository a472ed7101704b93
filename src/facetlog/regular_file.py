"""The one door for files: what is read is a regular file, and no more of it than may be.

Pipes, sockets and devices called like a file would block for ever, or never end. This module is
one of the lowest of the house, as errors.py is: every room may import it.
"""

import errno
import os
import stat
from pathlib import Path

from facetlog.errors import InputError

__all__ = ["MOST_BYTES", "MOST_SCENE_BYTES", "check_regular", "read_regular", "read_regular_text"]

MOST_BYTES = 256_000_000
"""Of a file of poses, labels or settings: some hundred thousand frames. A larger file is none."""

MOST_SCENE_BYTES = 1_000_000_000
"""Of a scene file: some million vertices."""

IRREGULAR = "it is a pipe, a socket or a device; give a file"


def check_regular(path: Path) -> None:
    """Nothing; raises InputError for a pipe, socket or device. For libraries that open paths.

    What is not there, or is a folder, is left to whoever opens it; links are followed.
    """
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):  # ValueError: a NUL in the name
        return
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
        raise InputError(f"{path}: {IRREGULAR}")


def read_regular(path: Path, most: int = MOST_BYTES) -> bytes:
    """The whole of a regular file of at most `most` bytes; OSError that says why where there is
    none, also for what is too long or no regular file.
    """
    try:
        with open(path, "rb", opener=_without_waiting) as file:
            about = os.fstat(file.fileno())
            if not stat.S_ISREG(about.st_mode):
                raise OSError(errno.EINVAL, IRREGULAR, str(path))
            # Memory is taken for all that is asked for: not for the longest file there may be.
            data = file.read(min(about.st_size, most) + 1)
            if len(data) > about.st_size:  # it grows, or says nothing of its size
                data += file.read(most + 1 - len(data))
    except ValueError as exc:  # a NUL in the name
        raise OSError(errno.EINVAL, str(exc), str(path)) from exc
    except OSError as exc:
        if exc.errno == errno.ENXIO:  # a socket, which cannot be opened
            raise OSError(errno.EINVAL, IRREGULAR, str(path)) from exc
        raise
    if len(data) > most:
        raise OSError(errno.EFBIG, f"it is too long: at most {most:,} bytes", str(path))
    return data


def read_regular_text(path: Path, most: int = MOST_BYTES) -> str:
    """`read_regular` as UTF-8 text, a byte order mark left out and line ends as they are.

    UnicodeDecodeError, which is a ValueError, for what is no such text.
    """
    return read_regular(path, most).decode("utf-8-sig")


def _without_waiting(path: str, flags: int) -> int:
    # To open a pipe waits for its other end, but for this flag.
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
