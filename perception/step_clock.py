"""The time each step of a run took: wall clock and CPU.

Each step is logged as well: that it begins (debug), and how long it took (info). A clock is handed
down the pipeline and every step is timed where it happens:

>>> clock = StepClock()
>>> with clock.step("edges"):
...     pass
>>> [time.name for time in clock.times]
['edges']
"""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter, process_time

_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class StepTime:
    """How long one step took, in seconds; CPU time counts all threads of the process."""

    name: str
    wall: float
    cpu: float
    calls: int = 1


class StepClock:
    """Adds up wall and CPU seconds by the name of the step.

    A step inside a step is counted under its own name only, so that the times of all steps add up
    to the time that was measured at all. The run begins when the clock is made.
    """

    def __init__(self) -> None:
        self._began = perf_counter(), process_time()
        self._times: dict[str, StepTime] = {}
        self._inner: list[tuple[float, float]] = []  # time spent in steps inside each open step

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        """Provide time the body of the `with` statement, also when it ends by an exception."""
        self._times.setdefault(name, StepTime(name, 0.0, 0.0, 0))  # in the order of their start
        self._inner.append((0.0, 0.0))
        _LOG.debug("%s begins", name)
        wall, cpu = perf_counter(), process_time()
        try:
            yield
        finally:
            wall, cpu = perf_counter() - wall, process_time() - cpu
            _LOG.info("%s took %.3f s", name, wall)
            inner_wall, inner_cpu = self._inner.pop()
            if self._inner:
                outer_wall, outer_cpu = self._inner[-1]
                self._inner[-1] = (outer_wall + wall, outer_cpu + cpu)
            known = self._times[name]
            self._times[name] = StepTime(
                name,
                known.wall + wall - inner_wall,
                known.cpu + cpu - inner_cpu,
                known.calls + 1,
            )

    @property
    def times(self) -> tuple[StepTime, ...]:
        """The steps in the order in which they first started."""
        return tuple(self._times.values())

    @property
    def run(self) -> StepTime:
        """The run so far, with what is in no step: what is loaded, opened, waited for and shown."""
        wall, cpu = self._began
        return StepTime("whole run", perf_counter() - wall, process_time() - cpu)

    @property
    def total(self) -> StepTime:
        """All steps together."""
        times = self.times
        return StepTime(
            "all steps",
            sum(t.wall for t in times),
            sum(t.cpu for t in times),
            sum(t.calls for t in times),
        )
