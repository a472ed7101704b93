"""Files that end: pipes, sockets and devices called like one are not opened."""

import stat
from pathlib import Path

from facetlog.errors import InputError

__all__ = ["check_regular"]


def check_regular(path: Path) -> None:
    """Nothing; raises InputError for a pipe, socket or device, which could block for ever.

    What is not there, or is a folder, is left to whoever opens it; links are followed.
    """
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):  # ValueError: a NUL in the name
        return
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
        raise InputError(f"{path}: is a pipe, a socket or a device; give a file")
