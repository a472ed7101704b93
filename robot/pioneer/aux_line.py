"""Bytes to a device on one of the robot's own serial ports and back, through the robot's packets.

The robot buffers the device's bytes, and sends n of them, once, when n are requested and there. So
an answer is read by requesting exactly its length (Pioneer 2 manual; drivers in use get two packets
for an answer at most: its shortest possible form, then the rest).
"""

import time
from dataclasses import dataclass

from facetlog.errors import DeviceTimeout
from facetlog.robot.pioneer.link import Link
from facetlog.robot.pioneer.opening import BAUD_CODES
from facetlog.robot.pioneer.packets.commands import (
    LARGEST_TEXT,
    Command,
    integer_command,
    text_command,
)
from facetlog.robot.pioneer.packets.reports import Report

__all__ = ["AuxLine"]

LARGEST_REQUEST = 200
"""Bytes that GETAUX may ask for, on P2OS (Pioneer 2 manual, page 48)."""
ASK_AGAIN = 0.4
"""Seconds after which a request may have been lost: 200 bytes take 0.2 s at 9600 baud."""


@dataclass(frozen=True, slots=True)
class _Numbers:
    send: Command
    get: Command
    report: Report
    baud: Command | None


PORTS = {
    1: _Numbers(Command.TTY2, Command.GETAUX, Report.SERAUX, Command.AUX1BAUD),
    2: _Numbers(Command.TTY3, Command.GETAUX2, Report.SERAUX2, Command.AUX2BAUD),
    3: _Numbers(Command.TTY4, Command.GETAUX3, Report.SERAUX3, None),
}


class AuxLine:
    """A line of bytes to whatever hangs on an AUX port.

    `baud` sets the port's speed first; None leaves it as the robot has it (9600 mostly). ValueError
    if there is no such port or speed.
    """

    def __init__(self, link: Link, number: int = 1, *, baud: int | None = None) -> None:
        if number not in PORTS:
            raise ValueError(f"there is no AUX port {number}: 1, 2 and 3 there are")
        self._link, self._numbers = link, PORTS[number]
        self.name = f"AUX{number}"
        self._inbox = link.inbox(self._numbers.report)
        self._waiting = bytearray()
        if baud is not None:
            if self._numbers.baud is None or baud not in BAUD_CODES:
                raise ValueError(f"{self.name} cannot be set to {baud} baud")
            link.send(integer_command(self._numbers.baud, BAUD_CODES[baud]))

    def flush(self) -> None:
        """Discards what the device has sent so far."""
        self._link.send(integer_command(self._numbers.get, 0))
        self._inbox.clear()
        self._waiting.clear()

    def send(self, data: bytes) -> None:
        """Sends bytes to the device."""
        for start in range(0, len(data), LARGEST_TEXT):
            chunk = data[start : start + LARGEST_TEXT]
            self._link.send(text_command(self._numbers.send, chunk))

    def receive(self, count: int, timeout: float) -> bytes:
        """Exactly `count` bytes from the device; DeviceTimeout if they do not come."""
        deadline = time.monotonic() + timeout
        asked_at = None
        while len(self._waiting) < count:
            now = time.monotonic()
            if asked_at is None or now - asked_at >= ASK_AGAIN:
                wanted = min(count - len(self._waiting), LARGEST_REQUEST)
                self._link.send(integer_command(self._numbers.get, wanted))
                asked_at = now
            left = min(deadline, asked_at + ASK_AGAIN) - time.monotonic()
            packet = self._inbox.take(max(0.0, left))
            if packet is not None:
                self._waiting += packet.payload
                asked_at = None
            elif time.monotonic() >= deadline:
                raise DeviceTimeout(
                    f"{self.name} of the robot: {len(self._waiting)} of {count} bytes came within"
                    f" {timeout:.1f} s; check the device's power, cable and speed, and the port"
                )
        data = bytes(self._waiting[:count])
        del self._waiting[:count]
        return data

    def close(self) -> None:
        """Nothing: the line belongs to the robot's connection."""
