"""Packets of a Pioneer's serial line to bytes and back; no port, no clock, no thread.

A packet is ``FA FB count kind payload checksum``: the count is of all bytes after it, the checksum
of kind and payload stands with its high byte first, integers in the payload with their low byte
first. The same form goes both ways (Pioneer 2 Operation Manual, 1999, page 26).
"""

from dataclasses import dataclass

HEADER = b"\xfa\xfb"
LARGEST_COUNT = 255
SMALLEST_COUNT = 3  # kind and checksum
CHECKSUM_BYTES = 2


class PacketError(ValueError):
    """A packet with a valid checksum whose contents do not fit its kind."""


def checksum(body: bytes) -> int:
    """Add the big-endian words of kind and payload modulo 65536, and xor an odd last byte.

    >>> hex(checksum(bytes.fromhex("0B 3B C8 00")))
    '0xd33b'
    """
    total = sum(int.from_bytes(body[i : i + 2]) for i in range(0, len(body) - 1, 2)) & 0xFFFF
    return total ^ body[-1] if len(body) % 2 else total


@dataclass(frozen=True, slots=True)
class Packet:
    """A command to the robot or a report from it, by the number of its kind.

    >>> Packet(11, bytes.fromhex("3B C8 00")).to_bytes().hex(" ")
    'fa fb 06 0b 3b c8 00 d3 3b'
    """

    kind: int
    payload: bytes = b""

    def __post_init__(self) -> None:
        if not 0 <= self.kind <= 255:
            raise ValueError(f"{self.kind} is no kind of packet: it is a byte")
        if len(self.payload) > LARGEST_COUNT - SMALLEST_COUNT:
            raise ValueError(f"{len(self.payload)} bytes do not go into one packet")

    def to_bytes(self) -> bytes:
        body = bytes([self.kind]) + self.payload
        count = len(body) + CHECKSUM_BYTES
        return HEADER + bytes([count]) + body + checksum(body).to_bytes(2)


@dataclass(frozen=True, slots=True)
class Received:
    """A packet that came, and when its first byte did (seconds of the caller's clock)."""

    packet: Packet
    at: float


class Decoder:
    """Finds the packets in a stream of bytes, however it is cut up and whatever else is in it.

    After a wrong checksum the search resumes at the byte after the header's first, so that a packet
    behind or inside it is not lost.
    """

    def __init__(self) -> None:
        self._bytes = bytearray()
        self._arrivals: list[tuple[int, float]] = []  # (bytes up to the end of a chunk, its time)
        self.skipped = 0
        """Bytes that belonged to no packet."""
        self.refused = 0
        """Headers after which the checksum was wrong."""

    @property
    def waiting(self) -> int:
        """Bytes of a packet that is not whole yet."""
        return len(self._bytes)

    def feed(self, data: bytes, at: float = 0.0) -> list[Received]:
        """Return the packets that are whole now; `at` is when `data` came."""
        if data:
            self._bytes += data
            self._arrivals.append((len(self._bytes), at))
        found: list[Received] = []
        while (received := self._next()) is not None:
            found.append(received)
        return found

    def expire(self) -> list[Received]:
        """Discard an incomplete packet; return the packets that were taken for part of it.

        To be called once its bytes have stopped coming (100 ms): the rest will not come.
        """
        found: list[Received] = []
        while self._bytes:
            self._skip(1)
            found.extend(self.feed(b""))
        return found

    def _next(self) -> Received | None:
        while True:
            self._skip_to_header()
            if len(self._bytes) < 3:
                return None
            count = self._bytes[2]
            if count < SMALLEST_COUNT:
                self._refuse()
                continue
            end = 3 + count
            if len(self._bytes) < end:
                return None
            body = bytes(self._bytes[3 : end - CHECKSUM_BYTES])
            if int.from_bytes(self._bytes[end - CHECKSUM_BYTES : end]) == checksum(body):
                received = Received(Packet(body[0], body[1:]), self._arrivals[0][1])
                self._drop(end)
                return received
            self._refuse()

    def _skip_to_header(self) -> None:
        start = self._bytes.find(HEADER)
        if start < 0:
            # The last byte may be the first of a header that is still to come.
            start = len(self._bytes) - self._bytes.endswith(HEADER[:1])
        if start:
            self._skip(start)

    def _refuse(self) -> None:
        self.refused += 1
        self._skip(1)

    def _skip(self, count: int) -> None:
        self.skipped += count
        self._drop(count)

    def _drop(self, count: int) -> None:
        del self._bytes[:count]
        self._arrivals = [(end - count, at) for end, at in self._arrivals if end > count]


BODY_TIMEOUT = 0.1
"""Seconds without a byte after which the rest of a packet does not come (drivers in use agree)."""


class Receiver:
    """A decoder with a time-out: it knows how long its line has been silent."""

    def __init__(self) -> None:
        self._decoder = Decoder()
        self._last_byte = 0.0
        self.given_up = 0
        """Number of incomplete packets that were discarded."""

    @property
    def strange(self) -> int:
        """Bytes so far that belonged to no packet."""
        return self._decoder.skipped

    @property
    def refused(self) -> int:
        """Packets so far whose checksum was wrong."""
        return self._decoder.refused

    def feed(self, data: bytes, now: float) -> list[Received]:
        """Return the packets that are whole now that `data` has come."""
        if data:
            self._last_byte = now
        return self._decoder.feed(data, now)

    def idle(self, now: float) -> list[Received] | None:
        """Give up waiting: return None, or the packets inside a discarded one."""
        if not self._decoder.waiting or now - self._last_byte < BODY_TIMEOUT:
            return None
        self.given_up += 1
        return self._decoder.expire()
