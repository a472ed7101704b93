"""A byte line to a device, read in blocks of known length, whatever carries it.

The serial ports of the robot's microcontroller (AUX) pass on received bytes only when a number of
bytes is requested, and then only once all of them are there. Drivers that keep to that work through
them and on a port of their own alike.
"""

import time
from typing import Protocol

from facetlog.errors import DeviceTimeout

MOST_READS_OF_A_FLUSH = 256
"""A device that never stops sending must not block `flush` for ever."""


class ByteLine(Protocol):
    """A line that sends bytes to a device and receives a known number of bytes."""

    def flush(self) -> None:
        """Discard bytes that came in and were not received."""

    def send(self, data: bytes) -> None:
        """Send all of `data`."""

    def receive(self, count: int, timeout: float) -> bytes:
        """Return the next `count` bytes, waiting `timeout` seconds at most.

        DeviceTimeout if they are not all there by then; what did come stays for the next call.
        """

    def close(self) -> None:
        """Give the line back; it cannot be used afterwards."""


class BytePort(Protocol):
    """A port with no more than bytes: a serial port or a socket (`robot/pioneer/line/port.py`)."""

    def read(self, timeout: float, /) -> bytes:
        """Return the bytes that came, at least one; b"" after `timeout` seconds without any."""

    def write(self, data: bytes, /) -> None:
        """Send all of it."""

    def close(self) -> None:
        """Close the port."""


class PortLine:
    """The line of a device that has a port of its own."""

    def __init__(self, port: BytePort) -> None:
        self._port = port
        self._came_in = bytearray()

    def flush(self) -> None:
        self._came_in.clear()
        for _ in range(MOST_READS_OF_A_FLUSH):
            if not self._port.read(0.0):
                return

    def send(self, data: bytes) -> None:
        self._port.write(data)

    def receive(self, count: int, timeout: float) -> bytes:
        """Return the next `count` bytes; DeviceTimeout if they are not there in `timeout`
        seconds.
        """
        deadline = time.monotonic() + timeout
        while len(self._came_in) < count:
            left = deadline - time.monotonic()
            if not (came := self._port.read(max(left, 0.0))) and left <= 0:
                raise DeviceTimeout(
                    f"{len(self._came_in)} of {count} bytes came on the device's port in"
                    f" {timeout:.1f} s: check its cable, its power and the baud rate"
                )
            self._came_in += came
        taken = bytes(self._came_in[:count])
        del self._came_in[:count]
        return taken

    def close(self) -> None:
        self._port.close()
