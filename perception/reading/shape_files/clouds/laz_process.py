"""The process that reads a LAZ: `python -m …laz_process FILE` writes rows of 64-bit x, y, z, mark.

The decompressor (lazrs) panics, aborts, and makes room for whatever a damaged chunk table claims.
Here that ends nothing else, and memory and time are limited.
"""

import os
import sys
from pathlib import Path

__all__ = ["main"]

# Python, laspy and the chunks of points in work take .6 GB of addresses.
MOST_BYTES = 2 << 30
# A second is enough for 5 MB of compressed points; starting takes one.
SECONDS, BYTES_PER_SECOND = 30, 1 << 20


def main(path: Path) -> None:
    """Write the points of a file to the standard output, or end with the reason on the error."""
    _set_limits(path.stat().st_size)
    from facetlog.perception.reading.shape_files.clouds.las_points import (
        describe_fault,
        read_las_chunks,
    )

    try:
        for rows in read_las_chunks(path):
            sys.stdout.buffer.write(rows.tobytes())
        sys.stdout.flush()
    except BaseException as exc:  # a panic is no Exception
        sys.stderr.write("\n" + describe_fault(exc))
        sys.stderr.flush()
        os._exit(1)


def _set_limits(size: int) -> None:
    """Limit memory, and processor time by the size of the file, where the system can."""
    try:
        import resource
    except ImportError:  # not on Windows
        return
    for kind, most in (
        (resource.RLIMIT_AS, MOST_BYTES),
        (resource.RLIMIT_CPU, SECONDS + size // BYTES_PER_SECOND),
        (resource.RLIMIT_CORE, 0),
    ):
        hard = resource.getrlimit(kind)[1]
        kept = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(kind, (kept, hard))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
