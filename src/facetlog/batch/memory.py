"""Memory limit of worker processes.

The limit is on what a process writes into (RLIMIT_DATA), not on its address space: libraries that
are mapped, and stacks that threads reserve, are no cost of a scene. Linux counts all private memory
against it; where a system does not, a scene that needs too much ends its worker.
"""

import math
import os
import resource
from contextlib import suppress
from pathlib import Path

LEAST_MB = 400
"""A worker with the engine and all models takes 200; a scene needs some, too."""

SHARE_OF_MEMORY = 0.8
"""Of the machine's memory, for all workers together: the rest is for the run itself, other
programs and files."""

NEAR_LIMIT = 0.8
"""A process that died with so much of its limit resident is taken to have died of it: of a limit on
what was asked for not all has been written into."""

MEGABYTE = 1 << 20

# Of a container; "max" or a number of bytes (cgroups(7), version 2 and 1).
CONTAINER_LIMITS = (
    Path("/sys/fs/cgroup/memory.max"),
    Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"),
)


def memory_mb() -> int:
    """Return memory of the machine or of the container that this runs in."""
    found = [os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")]
    for path in CONTAINER_LIMITS:
        with suppress(OSError, ValueError):  # there is none, or it is "max"
            found.append(int(path.read_text(encoding="ascii")))
    return min(found) // MEGABYTE


def compute_share_mb(workers: int, of_mb: float | None = None) -> int:
    """Return the memory limit of each of so many workers, of `of_mb` or of this machine's memory.

    >>> compute_share_mb(4, of_mb=16000), compute_share_mb(64, of_mb=16000)
    (3200, 400)
    """
    whole = memory_mb() if of_mb is None else of_mb
    return max(LEAST_MB, int(SHARE_OF_MEMORY * whole / workers))


def limit_memory(most_mb: int) -> None:
    """Limit the memory of this process from now on.

    So do those that it starts, unless they lift it.
    """
    most = most_mb * MEGABYTE
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    if hard != resource.RLIM_INFINITY:
        most = min(most, hard)
    with suppress(OSError, ValueError):  # a system that has no such limit
        resource.setrlimit(resource.RLIMIT_DATA, (most, hard))


def get_left_mb() -> float:
    """Return the memory left to this process, MB; infinite without a limit."""
    most, _ = resource.getrlimit(resource.RLIMIT_DATA)
    if most == resource.RLIM_INFINITY:
        return math.inf
    try:
        # proc_pid_statm(5): the sixth field is data and stack, in pages.
        taken = int(Path("/proc/self/statm").read_bytes().split()[5])
    except OSError:
        return math.inf
    return (most - taken * os.sysconf("SC_PAGE_SIZE")) / MEGABYTE


def format_memory_error(most_mb: int) -> str:
    """Return the error of a scene that needs too much memory; rows.py knows it by its first words.

    >>> format_memory_error(800)
    'needs more memory than 800 MB: give more by --memory, or fewer --workers'
    """
    return f"needs more memory than {most_mb} MB: give more by --memory, or fewer --workers"


def is_memory_exhausted(resident_mb: float, most_mb: int) -> bool:
    """Return whether a process that died, and had so much resident at most, died of its limit."""
    return resident_mb >= NEAR_LIMIT * most_mb
