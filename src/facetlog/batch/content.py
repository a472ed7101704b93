"""Hash of a file's content."""

import hashlib
from pathlib import Path

from facetlog.errors import InputError
from facetlog.safe_read import open_regular

HASHED_AT_ONCE = 1 << 20  # bytes


def hash_content(path: Path) -> str:
    """Return the SHA-256 of a file, as hexadecimal digits; InputError if it cannot be read."""
    digest = hashlib.sha256()
    try:
        with open_regular(path) as file:
            while piece := file.read(HASHED_AT_ONCE):
                digest.update(piece)
    except OSError as exc:
        raise InputError(f"{path}: cannot be read: {exc.strerror or exc}") from exc
    return digest.hexdigest()
