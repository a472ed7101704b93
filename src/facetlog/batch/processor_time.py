"""What another process worked, and waited for a processor, where the system says it."""

import os
from contextlib import suppress
from pathlib import Path

__all__ = ["processor_seconds", "queued_seconds"]

# proc_pid_stat(5): fields 14 and 15 are utime and stime, in ticks. The name before them, in
# brackets, may hold blanks, so they are counted from its end; field 3 is the first after it.
USER, SYSTEM = 14 - 3, 15 - 3


# sched-stats.rst of Linux: time on a processor, time waiting for one (both nanoseconds), turns.
WAITING = 1
NANOSECONDS = 1e9


def processor_seconds(pid: int) -> float | None:
    """Seconds that a process has worked, all its threads together; None where nothing says it.

    >>> (processor_seconds(os.getpid()) or 1.0) > 0.0
    True
    """
    try:
        content = Path(f"/proc/{pid}/stat").read_bytes()
    except OSError:
        return None
    fields = content.rpartition(b")")[2].split()
    return (int(fields[USER]) + int(fields[SYSTEM])) / os.sysconf("SC_CLK_TCK")


def queued_seconds(pid: int) -> float:
    """Seconds that threads of a process could have worked, and no processor was free for them.

    0.0 where nothing says it.

    >>> queued_seconds(os.getpid()) >= 0.0
    True
    """
    total = 0
    for path in Path(f"/proc/{pid}/task").glob("*/schedstat"):
        with suppress(OSError, IndexError, ValueError):  # the thread has ended
            total += int(path.read_bytes().split()[WAITING])
    return total / NANOSECONDS
