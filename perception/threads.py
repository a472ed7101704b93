"""Work on one item after another, on two threads where there are two cores.

OpenCV lets go of the interpreter's lock while it works on a picture; processes of their own would
have to load it first.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

# What is not OpenCV's holds the lock: more threads wait for one another.
THREADS = 2

Item = TypeVar("Item")
Result = TypeVar("Result")


def map_on_threads(function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
    """Yield the function's result of each item, in their order.

    >>> list(map_on_threads(abs, (-2, 1)))
    [2, 1]
    """
    with ThreadPoolExecutor(min(THREADS, len(os.sched_getaffinity(0)))) as pool:
        try:
            yield from pool.map(function, items)
        finally:
            pool.shutdown(cancel_futures=True)
