"""The interface of a simulated serial device, its output at a baud rate, and its motors."""

import math
from collections import deque
from dataclasses import dataclass
from typing import Protocol


class Device(Protocol):
    """A simulated device on a serial line, in time that its caller counts (`now`, seconds).

    It has no clock and no thread: calls come with times that never run backwards.
    """

    def receive(self, data: bytes, now: float) -> None:
        """Take bytes that came in at `now`."""

    def pending(self, now: float) -> bytes:
        """Return the bytes that it has sent up to `now` at its baud rate; each once."""

    def angles(self, now: float) -> tuple[float, float, float]:
        """Return where it truly looks at `now`: pan (left positive), tilt (up positive), zoom.

        Radians; zero is straight ahead and level. The zoom is in the device's own counts, 0 the
        widest.
        """


BITS_OF_A_BYTE = 10
"""Start, eight of data, stop."""


class SerialOut:
    """Bytes on their way out, each with the time at which it has arrived."""

    def __init__(self, baud: int = 9600) -> None:
        self._byte_s = BITS_OF_A_BYTE / baud
        self._bytes: deque[tuple[float, int]] = deque()
        self._free = 0.0

    def say(self, data: bytes, now: float) -> None:
        """Begin to send at `now`, or when all that was said before is through."""
        for byte in data:
            self._free = max(self._free, now) + self._byte_s
            self._bytes.append((self._free, byte))

    def arrived(self, now: float) -> bytes:
        """Return the bytes that have arrived by `now`; each once."""
        taken = bytearray()
        while self._bytes and self._bytes[0][0] <= now:
            taken.append(self._bytes.popleft()[1])
        return bytes(taken)


@dataclass(frozen=True, slots=True)
class Slew:
    """Motion of one axis since `since`; acceleration is left out, it takes less than a picture."""

    origin: float
    target: float
    speed: float
    """Steps a second."""
    since: float
    """Seconds."""

    @classmethod
    def standing(cls, at: float) -> "Slew":
        """Return an axis at rest."""
        return cls(at, at, math.inf, 0.0)

    @property
    def end(self) -> float:
        """When it arrives, seconds."""
        return self.since + abs(self.target - self.origin) / self.speed

    def at(self, now: float) -> float:
        """Return where it is at `now`, exact at both ends and never beyond them."""
        if now >= self.end:
            return self.target
        gone = max(now - self.since, 0.0) * self.speed
        return self.origin + math.copysign(gone, self.target - self.origin)

    def to(self, target: float, speed: float, now: float) -> "Slew":
        """Return the motion to another target from where it is at `now`."""
        return Slew(self.at(now), target, speed, now)

    def stopped(self, now: float) -> "Slew":
        """Return the axis at rest where it is at `now`."""
        return Slew.standing(self.at(now))
