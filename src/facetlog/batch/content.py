"""What a file holds, in a few digits."""

import hashlib
from pathlib import Path

from facetlog.errors import InputError
from facetlog.regular_file import check_regular

__all__ = ["content_hash"]

HASHED_AT_ONCE = 1 << 20  # bytes


def content_hash(path: Path) -> str:
    """The SHA-256 of a file, as hexadecimal digits; InputError if it cannot be read."""
    check_regular(path)
    digest = hashlib.sha256()
    try:
        with path.open("rb") as file:
            while piece := file.read(HASHED_AT_ONCE):
                digest.update(piece)
    except (OSError, ValueError) as exc:  # ValueError: a NUL in the name
        reason = getattr(exc, "strerror", None) or exc
        raise InputError(f"{path}: cannot be read: {reason}") from exc
    return digest.hexdigest()
