"""Packets decoded from the bytes of a line, with a time-out for incomplete packets."""

from facetlog.robot.pioneer.packets.packet import Decoder, Received

__all__ = ["BODY_TIMEOUT", "Receiver"]

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
        """The packets that are whole now that `data` has come."""
        if data:
            self._last_byte = now
        return self._decoder.feed(data, now)

    def idle(self, now: float) -> list[Received] | None:
        """To be called when nothing came: None, or the packets inside one that is discarded."""
        if not self._decoder.waiting or now - self._last_byte < BODY_TIMEOUT:
            return None
        self.given_up += 1
        return self._decoder.expire()
