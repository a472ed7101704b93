"""How much is worked out at one go, and for how long altogether."""

import time

from facetlog.errors import EngineError

__all__ = ["Pace"]

FIRST_ROWS = 64  # the first answers come soon
MOST_ROWS = 1 << 16  # beyond that nothing gets faster, and memory stays within some megabytes


class Pace:
    """Steps that grow from some answers to many, within `seconds` of work for all of them.

    Work is the processor time of the thread that asks for the steps.
    """

    def __init__(self, seconds: float) -> None:
        self._left, self._rows = seconds, FIRST_ROWS
        self._end = time.thread_time() + seconds
        self._stopped = False

    def step(self) -> int:
        """The rows of the next step; EngineError when time is over, or the question stopped."""
        if self._stopped:
            raise EngineError("the question was stopped")
        if time.thread_time() > self._end:
            raise EngineError("the time limit was reached")
        rows = self._rows
        self._rows = min(2 * rows, MOST_ROWS)
        return rows

    def rest(self) -> None:
        """From here on time does not count..."""
        self._left = self._end - time.thread_time()

    def go_on(self) -> None:
        """... and from here on it does again."""
        self._end = time.thread_time() + self._left

    def stop(self) -> None:
        """The next step is none."""
        self._stopped = True
