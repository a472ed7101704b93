"""A simulation in real time, for several threads at once."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from facetlog.robot.simulator.simulation import Simulation

__all__ = ["LiveSimulation"]

LONGEST_GAP = 2.0
"""Seconds that the simulation catches up at once; after a longer sleep the rest is skipped."""


class LiveSimulation:
    """A simulation in real time behind a lock: one thread at a time sees it as it is now."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._lock = threading.Lock()
        self._started = time.monotonic()
        self._last = 0.0

    @contextmanager
    def now(self) -> Iterator[tuple[Simulation, float]]:
        """The simulation and its time in seconds; nobody else has it meanwhile."""
        with self._lock:
            passed = time.monotonic() - self._started
            if passed - self._last > LONGEST_GAP:
                self._started += passed - self._last - LONGEST_GAP
                passed = self._last + LONGEST_GAP
            self._last = passed
            yield self._simulation, passed
