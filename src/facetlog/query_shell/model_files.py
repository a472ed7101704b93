"""Model files that are loaded, and whether they have changed since."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

from facetlog.safe_read import read_regular


@dataclass(frozen=True, slots=True)
class Stamp:
    """State of a file: equal times and size mean that nothing changed, else the content decides."""

    times: tuple[int, int, int]
    digest: bytes

    def has_same_content(self, other: "Stamp") -> bool:
        """Return whether both files have the same content."""
        return self.digest == other.digest


def read_stamp(path: Path, before: Stamp | None = None) -> Stamp | None:
    """Return the stamp of a file, `before` if it is untouched; None if it cannot be read."""
    try:
        status = path.stat()
        times = (status.st_mtime_ns, status.st_size, status.st_ino)
        if before is not None and before.times == times:
            return before
        return Stamp(times, hashlib.sha256(read_regular(path)).digest())
    except OSError:
        return None
