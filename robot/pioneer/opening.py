"""From the answer to SYNC2 to a session that reports: OPEN, CONFIG, and a faster serial line.

Without I/O, clock or thread, as the handshake. The first packet after OPEN is STOP: the client
before may have died at full speed, and any packet makes the robot resume it.
"""

from collections.abc import Sequence
from enum import Enum, auto

from facetlog.errors import DeviceTimeout
from facetlog.robot.pioneer.exchange import Exchange, SetBaud, Write
from facetlog.robot.pioneer.packets.commands import (
    Command,
    command_name,
    integer_command,
    plain_command,
)
from facetlog.robot.pioneer.packets.configuration import AUTOBAUD, CONFIGURATION_KIND, Configuration
from facetlog.robot.pioneer.packets.packet import Packet, PacketError, Received
from facetlog.robot.pioneer.packets.receiver import Receiver
from facetlog.robot.pioneer.packets.reports import Report
from facetlog.robot.pioneer.packets.server_information import SIP_KINDS

__all__ = ["BAUD_CODES", "Opening"]

BAUD_CODES = {9600: 0, 19200: 1, 38400: 2, 57600: 3, 115200: 4}
"""Arguments of HOSTBAUD."""
RETRY = 0.5
"""Seconds: five reports should have come."""
OPENINGS = 4
QUESTIONS = 3
"""For CONFIG, which old firmware does not know."""
SWITCH_TIME = 0.01
"""Seconds the robot takes to change its port's speed (another driver's figure)."""
FAST_TRIES, FAST_RETRY = 4, 0.2
"""The robot goes back to its own rate if no packet comes within 0.5 s (AROS manual, page 51)."""
DEAF = 0.05
"""Seconds after the change in which reports may still come out of a buffer of the old rate."""
BACK_TRIES, BACK_RETRY = 5, 0.4


class _Phase(Enum):
    OPENING = auto()
    ASKING = auto()
    SWITCHING = auto()
    FAST = auto()
    BACK = auto()


class Opening(Exchange):
    """Opens the session; then `failure` is set, or `received` holds what has come meanwhile.

    `baud` is the line's rate and `fast_baud` the one to change to; None where there is none. The
    rate is changed only if CONFIG says that the robot's port takes it.
    """

    def __init__(
        self,
        now: float,
        receiver: Receiver,
        left_over: Sequence[Received] = (),
        *,
        baud: int | None = None,
        fast_baud: int | None = None,
    ) -> None:
        super().__init__(receiver, baud)
        self.configuration: Configuration | None = None
        self.received: list[Received] = []
        self._switch = (baud or 0, (baud and fast_baud) or baud or 0)
        self._deaf_until = now
        self._phase, self._tries = _Phase.OPENING, 1
        self._open(now)
        for each in left_over:
            self._take(each, now)

    def _write(self, *packets: Packet) -> None:
        data = b"".join(packet.to_bytes() for packet in packets)
        self._actions.append(Write(data, ", ".join(map(command_name, packets))))

    def _open(self, now: float) -> None:
        self._write(plain_command(Command.OPEN), plain_command(Command.STOP))
        self.due = now + RETRY

    def _ask(self, now: float) -> None:
        self._write(integer_command(Command.CONFIG, 1))
        self.due = now + RETRY

    def _late(self, now: float) -> None:
        self._tries += 1
        match self._phase:
            case _Phase.OPENING if self._tries > OPENINGS:
                self._fail(
                    "it answered the handshake, but no reports come after OPEN; switch it off and"
                    " on again, check the cable and that no other program uses the line, then"
                    " connect again"
                )
            case _Phase.OPENING:
                self._open(now)
            case _Phase.ASKING if self._tries > QUESTIONS:
                self.over = True  # without CONFIG, as old firmware is
            case _Phase.ASKING:
                self._ask(now)
            case _Phase.SWITCHING:
                self._actions.append(SetBaud(self._switch[1]))
                self._deaf_until = now + DEAF
                self._enter(_Phase.FAST, FAST_RETRY, now)
            case _Phase.FAST if self._tries > FAST_TRIES:
                self._actions.append(SetBaud(self._switch[0]))
                self._enter(_Phase.BACK, BACK_RETRY, now)
            case _Phase.FAST:
                self._enter(_Phase.FAST, FAST_RETRY, now, again=True)
            case _Phase.BACK if self._tries > BACK_TRIES:
                self._fail(
                    f"its port was to change to {self._switch[1]} baud and is silent since; give"
                    f" baud={self._switch[0]} to leave the rate as it is"
                )
            case _:
                self._enter(_Phase.BACK, BACK_RETRY, now, again=True)

    def _enter(self, phase: _Phase, retry: float, now: float, *, again: bool = False) -> None:
        if not again:
            self._tries = 1
        self._phase, self.due = phase, now + retry
        self._write(plain_command(Command.STOP))

    def _take(self, received: Received, now: float) -> None:
        packet = received.packet
        self.received.append(received)
        if self.over:
            return
        if packet.kind in (Report.RESET_1, Report.RESET_2):
            self._fail("it was reset while the session was opened; connect again")
        elif packet.kind == CONFIGURATION_KIND and self._phase is _Phase.ASKING:
            try:
                self.configuration = Configuration.from_packet(packet)
            except PacketError:
                return  # it is requested again
            self._configured(now)
        elif packet.kind in SIP_KINDS:
            if self._phase is _Phase.OPENING:
                self._phase, self._tries = _Phase.ASKING, 1
                self._ask(now)
            elif self._phase is _Phase.FAST and now >= self._deaf_until:
                self.baud = self._switch[1]
                self.over = True
            elif self._phase is _Phase.BACK:
                self.over = True

    def _configured(self, now: float) -> None:
        takes_it = self.configuration is not None and self.configuration.autobaud == AUTOBAUD
        if self._switch[0] == self._switch[1] or not takes_it:
            self.over = True
            return
        self._write(integer_command(Command.HOSTBAUD, BAUD_CODES[self._switch[1]]))
        self._phase, self._tries = _Phase.SWITCHING, 0
        self.due = now + SWITCH_TIME

    def _fail(self, text: str) -> None:
        self.failure = DeviceTimeout(text)
        self.over = True
