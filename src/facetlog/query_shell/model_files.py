"""Model files that are loaded, and whether they have changed since."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

from facetlog.regular_file import read_regular


@dataclass(frozen=True, slots=True)
class Stamp:
    """What a file was like: times and size tell quickly that nothing changed, else the content."""

    times: tuple[int, int, int]
    digest: bytes

    def same_content(self, other: "Stamp") -> bool:
        """Whether both files hold the same."""
        return self.digest == other.digest


def stamp_of(path: Path, before: Stamp | None = None) -> Stamp | None:
    """What the file is like now, `before` if it has not been touched; None if it cannot be read."""
    try:
        status = path.stat()
        times = (status.st_mtime_ns, status.st_size, status.st_ino)
        if before is not None and before.times == times:
            return before
        return Stamp(times, hashlib.sha256(read_regular(path)).digest())
    except OSError:
        return None
