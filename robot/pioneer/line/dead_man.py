"""Stop the robot when its driver, or the process that owns its line, has ended or hangs.

The driver holds a lease: until a time that it renews, what it writes goes to the robot. Once that
has passed, bytes that stop the robot are written instead, again and again, for any of them may be
lost; what the driver writes is dropped, since it may be seconds old, until it renews the lease with
a time that has not passed. All times are of one clock that both processes have (monotonic).
"""

import math
import time
from collections.abc import Callable, Sequence

from facetlog.errors import DeviceError, FacetlogError
from facetlog.robot.pioneer.line.port import SerialPort, TcpPort, open_port

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
        """Let the driver drive until a time; `stop` is written then."""
        self._until, self._stop = until, stop
        if now < until:
            self._next, self._ends = until, math.inf

    def release(self) -> None:
        """Write nothing when the driver falls silent: the robot does not move."""
        self._until = self._next = self._ends = math.inf
        self._stop = b""

    def expire(self, now: float) -> None:
        """End the lease now, if there is one: the driver is gone."""
        if self._stop and now < self._until:
            self._until = self._next = now

    def has_expired(self, now: float) -> bool:
        """Return whether the lease has run out: what the driver writes is not to reach the
        robot.
        """
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
        """Return the bytes to write at `now`."""
        if now < self._next:
            return b""
        if math.isinf(self._ends):
            self._ends = now + STOPPING
        self._next = now + REPEAT
        if self._next > self._ends:
            self._next = math.inf
        return self._stop


OPEN_AGAIN_TIMEOUT = 0.5
"""Seconds for each attempt to open a broken line again."""
SAID_AFTER = 1.0
"""Seconds of failed attempts after which it is said that the robot was not stopped; tried on."""
PARTING_PAUSE = 0.05
"""Seconds between the commands that end a session: P2OS takes one in each half cycle."""


class NotStoppedError(DeviceError):
    """The line to a robot that may move is broken, and nothing that stops it could be written."""


class LastWill:
    """Writes to the line at an address, through a `port` if one is open."""

    def __init__(
        self, address: str, baud: int | None, port: SerialPort | TcpPort | None = None
    ) -> None:
        self._address, self._baud = address, baud
        self.port = port
        """The line as it then is, None where it could not be opened."""

    def stop_and_close(
        self,
        dead_man: DeadMan,
        parting: Sequence[bytes],
        report: Callable[[bool], None] | None = None,
    ) -> bool:
        """Stop the robot, if it is not known to stand, and end its session; return whether the line
        took a stop.

        `report` is called once: as soon as it took one, or when it took none for `SAID_AFTER`.
        """
        began = time.monotonic()
        dead_man.expire(began)
        took = False
        while not math.isinf(due := dead_man.due):
            time.sleep(max(0.0, due - time.monotonic()))
            took |= self._write(dead_man.advance(time.monotonic()))
            if report is not None and (took or time.monotonic() - began >= SAID_AFTER):
                report(took)
                report = None
        if report is not None:
            report(took)
        for command in parting:
            self._write(command)
            time.sleep(PARTING_PAUSE)
        return took

    def _write(self, data: bytes) -> bool:
        """Write to the line, opened first if it is not open; the next attempt may succeed."""
        try:
            if self.port is None:
                self.port = open_port(self._address, self._baud, OPEN_AGAIN_TIMEOUT)
            while self.port.read(0.0):
                pass  # nobody wants it, and a full buffer would hold up what is written
            self.port.write(data)
        except FacetlogError:
            if self.port is not None:
                self.port.close()
                self.port = None
            return False
        return bool(data)
