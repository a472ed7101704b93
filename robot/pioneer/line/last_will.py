"""Stops a robot, and ends its session, where whoever drove it or owned its line is gone.

Over the line that there is, or over one that is opened again: a broken one, or that of a process
that ended.
"""

import math
import time
from collections.abc import Callable, Sequence

from facetlog.errors import DeviceError, FacetlogError
from facetlog.robot.pioneer.line.dead_man import DeadMan
from facetlog.robot.pioneer.line.port import SerialPort, TcpPort, open_port

__all__ = ["LastWill", "NotStoppedError"]

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

    def carry_out(
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
        """Writes to the line, opened first if it is not open; the next attempt may succeed."""
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
