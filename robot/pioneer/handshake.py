"""The handshake with the robot, without I/O, clock or thread: bytes and times in, actions out.

SYNC0, SYNC1 and SYNC2 are echoed one by one, the last with the robot's names (Pioneer 2 manual).
The handshake listens before it sends: a session that another client left open sends reports ten
times a second. There SYNC0 would be a PULSE, and the first packet after a client's death makes the
robot resume its last commanded speed. So such a session gets STOP and CLOSE, and nothing before
them.
"""

from collections.abc import Sequence
from enum import Enum, auto

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.pioneer.exchange import Exchange, SetBaud, Write
from facetlog.robot.pioneer.packets.commands import Command, plain_command
from facetlog.robot.pioneer.packets.packet import Received
from facetlog.robot.pioneer.packets.receiver import Receiver
from facetlog.robot.pioneer.packets.reports import Names, Report

__all__ = ["BAUDS", "Handshake"]

BAUDS = (9600, 38400, 19200, 115200, 57600)
"""Baud rates that a robot's port may have, the likeliest first, as other drivers try them."""
LISTEN = 0.35
"""Seconds: three reports of an open session, so that one may be lost."""
ECHO_TIMEOUT = 1.0
"""Seconds for an echo; another driver's figure, long enough for a radio modem."""
FLUSH = 0.3
"""Seconds after CLOSE in which reports may still be under way."""
PAUSE = 0.1
"""Seconds to wait after a synchronisation packet out of order."""
SILENT_TRIES = 2
"""At one baud rate of several, where nothing is heard at all."""
TRIES = 6
"""Where it is the only rate; simulators hang up after ten."""
HEARD_TRIES = 12
"""Where a robot is heard: with one byte in fifty damaged, two thirds of all tries fail."""
ROUNDS = 2
"""Through all baud rates."""
CLOSINGS = 5
"""Of sessions that were found open."""
RESETS = 10
"""Restarts of the synchronisation before the handshake fails."""
NOISE_BYTES = 8
"""Bytes without a packet among them from which on the baud rate is taken to be wrong."""


class _Phase(Enum):
    LISTENING = auto()
    SYNCHRONISING = auto()
    FLUSHING = auto()


class Handshake(Exchange):
    """Brings a robot from any state to an answered SYNC2.

    `bauds` are the rates to try on a serial line; empty where the line has none. At the end
    `names` or `failure` is set.
    """

    def __init__(self, now: float, bauds: Sequence[int] = ()) -> None:
        super().__init__(Receiver(), None)
        self.names: Names | None = None
        self.left_over: list[Received] = []
        """Packets behind the answer to SYNC2."""
        self._bauds = tuple(bauds)
        self._rates = list(self._bauds[:1] if len(self._bauds) < 2 else self._bauds * ROUNDS)
        self._closings = self._resets = 0
        self._noise = False
        self._nameless = self._close_may_be_sync2 = False
        self._next_rate(now)

    def receive(self, data: bytes, now: float) -> None:
        """Takes what came in, and goes on to the next rate where that is noise alone."""
        super().receive(data, now)
        if not self.over and len(self._rates) > 0 and not self._heard:
            strange = self.receiver.strange - self._strange_before
            if strange >= NOISE_BYTES and self._phase is _Phase.LISTENING:
                self._noise = True
                self._next_rate(now)

    def _late(self, now: float) -> None:
        if self._phase is _Phase.SYNCHRONISING:
            self._missed(now)
        else:
            self._synchronise(0, now)

    def _next_rate(self, now: float) -> None:
        self.baud = self._rates.pop(0) if self._rates else None
        if self.baud is not None:
            self._actions.append(SetBaud(self.baud))
        self._misses = 0
        self._heard = False
        self._strange_before = self.receiver.strange
        self._phase, self.due = _Phase.LISTENING, now + LISTEN

    def _synchronise(self, step: int, now: float) -> None:
        self._phase, self._step, self.due = _Phase.SYNCHRONISING, step, now + ECHO_TIMEOUT
        self._close_may_be_sync2 = False
        self._actions.append(Write(plain_command(Command(step)).to_bytes(), f"SYNC{step}"))

    def _flush(self, seconds: float, now: float) -> None:
        self._phase, self.due = _Phase.FLUSHING, now + seconds

    def _withdraw(self) -> None:
        """Drops pending writes: SYNC0 must not be sent into an open session."""
        self._actions = [each for each in self._actions if isinstance(each, SetBaud)]

    def _close(self, now: float, *, in_session: bool = False) -> None:
        self._withdraw()
        commands = (Command.STOP, Command.CLOSE)
        data = b"".join(plain_command(each).to_bytes() for each in commands)
        self._actions.append(Write(data, "STOP, CLOSE"))
        self._close_may_be_sync2 = not in_session
        self._flush(FLUSH, now)

    def _missed(self, now: float) -> None:
        self._misses += 1
        searching = len(self._bauds) > 1 and not self._heard
        tries = HEARD_TRIES if self._heard else SILENT_TRIES if searching else TRIES
        if self._misses >= tries:
            if searching and self._rates:
                self._next_rate(now)
            else:
                self._fail()
        elif self._step == 2 or self._misses > 1 or searching:
            # The robot may have answered SYNC2, and the answer was lost: it waits for OPEN then.
            self._close(now)
        else:
            self._synchronise(0, now)

    def _take(self, received: Received, now: float) -> None:
        packet = received.packet
        if self.over:
            self.left_over.append(received)
            return
        self._heard = True
        if self._phase is _Phase.FLUSHING:
            # CLOSE has the number of SYNC2: a robot that waits for that takes it so, and answers.
            if self._close_may_be_sync2 and packet.kind == Report.SYNC2 and packet.payload:
                self._step = 2
                self._echoed(received, now)
            return
        if packet.kind in (Report.RESET_1, Report.RESET_2):
            self._resets += 1
            if self._resets > RESETS:
                self._fail()
            else:
                self._flush(PAUSE, now)
        elif packet.kind > Report.SYNC2:
            self._closings += 1
            if self._closings > CLOSINGS:
                self._fail()
            else:
                self._close(now, in_session=True)
        elif self._phase is _Phase.SYNCHRONISING and packet.kind == self._step:
            self._echoed(received, now)

    def _echoed(self, received: Received, now: float) -> None:
        if self._step < 2:
            self._synchronise(self._step + 1, now)
        elif received.packet.payload:
            self.names = Names.from_packet(received.packet)
            self.over = True
        else:
            self._nameless = True  # and wait: the names may follow what was an echo of the line

    def _fail(self) -> None:
        self._withdraw()
        self.over = True
        if self._closings > CLOSINGS:
            self.failure = DeviceError(
                "the robot goes on with a session that is open and does not take CLOSE; end the"
                " other program that drives it, and check the wire that carries bytes to it"
            )
        elif self._resets > RESETS:
            self.failure = DeviceError(
                "the robot loses count of the handshake again and again; check the cable, and"
                " that no other program writes to the line"
            )
        elif self._nameless:
            self.failure = DeviceError(
                "SYNC2 comes back without the robot's names; the line seems to echo what is sent"
                " instead of reaching a robot"
            )
        else:
            self.failure = DeviceTimeout(self._silence())

    def _silence(self) -> str:
        rates = "/".join(str(baud) for baud in self._bauds)
        tried = f" at {rates} baud" if rates else ""
        if self._noise or self.receiver.refused:
            seen = "what comes back is no packet of a robot"
        elif self._heard:
            seen = "answers stop half-way"
        else:
            seen = "nothing answers"
        check = "that the robot is switched on and no other program is connected to it"
        if self._bauds:
            check += ", the cable, and the baud rate"
        return f"handshake tried {self._misses} times{tried}, {seen}; check {check}"
