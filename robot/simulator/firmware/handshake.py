"""The firmware's handshake: from the first SYNC to the session, and answers to other packets."""

from dataclasses import dataclass, field

from facetlog.robot.pioneer.packets.commands import Command
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.packets.reports import Names, Report

__all__ = ["Handshake"]

SYNCHRONISED = 3
"""How many of SYNC0, SYNC1 and SYNC2 a client must have sent, in their order."""


@dataclass(slots=True)
class Handshake:
    """Answers packets while no session is open; OPEN after the three SYNCs opens one.

    OPEN has the number of SYNC1, CLOSE that of SYNC2 and PULSE that of SYNC0: the meaning depends
    on the packets before.
    """

    names: Names
    _next: int = field(default=0, init=False)

    def reset(self) -> None:
        """Back to the beginning, as after CLOSE."""
        self._next = 0

    def heard(self, packet: Packet) -> tuple[tuple[Packet, ...], bool]:
        """The answer to a packet, and whether it opened a session.

        A SYNC out of order is answered with 0xFF, and the client has to start again. The previous
        one may be repeated, for its echo may have been lost. Anything else is echoed (Pioneer 2
        manual, page 41).
        """
        if self._next == SYNCHRONISED and packet.kind == Command.OPEN:
            self.reset()
            return (), True
        if packet.kind > Report.SYNC2:
            return (packet,), False
        if packet.payload:  # a SYNC has none: it is an OPEN or CLOSE that came too early
            self.reset()
            return (), False
        if packet.kind == Report.SYNC0 or packet.kind in (self._next, self._next - 1):
            self._next = packet.kind + 1
            return (self._echo(packet.kind),), False
        self.reset()
        return (Packet(Report.RESET_2),), False

    def _echo(self, number: int) -> Packet:
        return self.names.to_packet() if number == Report.SYNC2 else Packet(number)
