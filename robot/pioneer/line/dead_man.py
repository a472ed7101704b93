"""What is written to a robot's line when whoever drives it is heard no more; without I/O or clock.

The driver holds a lease: until a time that it renews, what it writes goes to the robot. Once that
has passed, bytes that stop the robot are written instead, again and again, for any of them may be
lost; and what the driver writes is dropped, since it may be seconds old, until it renews the lease
with a time that has not passed. All times are of one clock that both processes have (monotonic).
"""

import math

__all__ = ["REPEAT", "STOPPING", "DeadMan"]

REPEAT = 0.1
"""Seconds between two stops: two cycles of the slowest firmware."""
STOPPING = 2.0
"""Seconds for which stops are written: from 0.5 m/s at 0.3 m/s², the maker's deceleration, it takes
1.7 s; and a robot that hears nothing for so long stands by its own watchdog."""


class DeadMan:
    """The lease on a line, and what stops the robot when it has run out."""

    def __init__(self) -> None:
        self._until = math.inf
        self._stop = b""
        self._next = math.inf
        self._ends = math.inf

    def hold(self, until: float, stop: bytes, now: float) -> None:
        """The driver is heard: it may drive until a time, and `stop` is written then."""
        self._until, self._stop = until, stop
        if now < until:
            self._next, self._ends = until, math.inf

    def release(self) -> None:
        """The robot stands: nothing is to be written when the driver is heard no more."""
        self._until = self._next = self._ends = math.inf
        self._stop = b""

    def expire(self, now: float) -> None:
        """The lease, if there is one, ends now: the driver is gone."""
        if self._stop and now < self._until:
            self._until = self._next = now

    def expired(self, now: float) -> bool:
        """Whether the lease has run out: what the driver writes is not to reach the robot."""
        return now >= self._until

    @property
    def holds(self) -> bool:
        """Whether the robot may move: the driver has not said that it stands."""
        return bool(self._stop)

    @property
    def due(self) -> float:
        """When `advance` is to be called at the latest; infinite if nothing will be written."""
        return self._next

    def advance(self, now: float) -> bytes:
        """What is to be written at `now`."""
        if now < self._next:
            return b""
        if math.isinf(self._ends):
            self._ends = now + STOPPING
        self._next = now + REPEAT
        if self._next > self._ends:
            self._next = math.inf
        return self._stop
