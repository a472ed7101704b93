"""Output of a device on a serial line: bytes arrive no faster than the baud rate allows."""

from collections import deque

__all__ = ["SerialOut"]

BITS_OF_A_BYTE = 10
"""Start, eight of data, stop."""


class SerialOut:
    """Bytes on their way out, each with the time at which it has arrived."""

    def __init__(self, baud: int = 9600) -> None:
        self._byte_s = BITS_OF_A_BYTE / baud
        self._bytes: deque[tuple[float, int]] = deque()
        self._free = 0.0

    def say(self, data: bytes, now: float) -> None:
        """Begins to send at `now`, or when all that was said before is through."""
        for byte in data:
            self._free = max(self._free, now) + self._byte_s
            self._bytes.append((self._free, byte))

    def arrived(self, now: float) -> bytes:
        """What has arrived by `now`; each byte once."""
        taken = bytearray()
        while self._bytes and self._bytes[0][0] <= now:
            taken.append(self._bytes.popleft()[1])
        return bytes(taken)
