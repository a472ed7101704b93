"""Work on many items by several processes."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import TypeVar

Item = TypeVar("Item")
Found = TypeVar("Found")

WORKERS = 2


def spread(
    function: Callable[[Item], Found], items: Sequence[Item], *, at_once: int = 1
) -> list[Found]:
    """Return the results of a module's function for each item, in their order, by spawned processes
    that take so many items `at_once`, with one thread each.
    """
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    with ProcessPoolExecutor(WORKERS, get_context("spawn")) as pool:
        return list(pool.map(function, items, chunksize=at_once))
