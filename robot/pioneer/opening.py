"""How a session is opened: handshake, OPEN, CONFIG and a faster serial line.

No I/O, clock or thread: bytes and times in, actions out.

SYNC0, SYNC1 and SYNC2 are echoed one by one, the last with the robot's names (Pioneer 2 manual).
The handshake listens before it sends, for a session that another client left open sends reports ten
times a second. There SYNC0 would be a PULSE, and the first packet after a client's death makes the
robot resume its last commanded speed. So such a session gets STOP and CLOSE first, and a new
session gets STOP as the first packet after OPEN.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, auto

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.pioneer.packets.commands import (
    Command,
    make_integer_command,
    make_plain_command,
    name_command,
)
from facetlog.robot.pioneer.packets.packet import Packet, PacketError, Received, Receiver
from facetlog.robot.pioneer.packets.reports import (
    AUTOBAUD,
    SIP_KINDS,
    Configuration,
    Names,
    Report,
)


@dataclass(frozen=True, slots=True)
class Write:
    """Bytes to send now, and their name: SYNC0 has the number of PULSE."""

    data: bytes
    name: str


@dataclass(frozen=True, slots=True)
class SetBaud:
    """A speed to change the line to, once all is sent."""

    baud: int


Action = Write | SetBaud


class Exchange(ABC):
    """Questions to a robot until it has answered or does not answer.

    `over` is whether it has succeeded or failed; then `failure` says why not. `due` is when
    `advance` is to be called at the latest (seconds, of the caller's clock), and `baud` the rate in
    use; None where the line has none.
    """

    due: float

    def __init__(self, receiver: Receiver, baud: int | None) -> None:
        self.receiver = receiver
        self.baud = baud
        self.failure: DeviceError | None = None
        self.over = False
        self._actions: list[Action] = []

    def actions(self) -> list[Action]:
        """Return what is to be done now, in order; each once."""
        done, self._actions = self._actions, []
        return done

    def receive(self, data: bytes, now: float) -> None:
        """Take what came in; b"" if nothing did."""
        self.advance(now)
        received = self.receiver.feed(data, now) if data else self.receiver.idle(now) or []
        for each in received:
            self._take(each, now)

    def advance(self, now: float) -> None:
        """Do what is due at `now` or was before."""
        while not self.over and now >= self.due:
            self._handle_timeout(self.due)

    @abstractmethod
    def _take(self, received: Received, now: float) -> None:
        """Take a packet that has come."""

    @abstractmethod
    def _handle_timeout(self, now: float) -> None:
        """Act where no answer has come in time."""


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


class _HandshakePhase(Enum):
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
        self._try_next_rate(now)

    def receive(self, data: bytes, now: float) -> None:
        """Take what came in, and go on to the next rate where that is noise alone."""
        super().receive(data, now)
        if not self.over and len(self._rates) > 0 and not self._heard:
            strange = self.receiver.strange - self._strange_before
            if strange >= NOISE_BYTES and self._phase is _HandshakePhase.LISTENING:
                self._noise = True
                self._try_next_rate(now)

    def _handle_timeout(self, now: float) -> None:
        if self._phase is _HandshakePhase.SYNCHRONISING:
            self._missed(now)
        else:
            self._synchronise(0, now)

    def _try_next_rate(self, now: float) -> None:
        self.baud = self._rates.pop(0) if self._rates else None
        if self.baud is not None:
            self._actions.append(SetBaud(self.baud))
        self._misses = 0
        self._heard = False
        self._strange_before = self.receiver.strange
        self._phase, self.due = _HandshakePhase.LISTENING, now + LISTEN

    def _synchronise(self, step: int, now: float) -> None:
        self._phase, self._step, self.due = _HandshakePhase.SYNCHRONISING, step, now + ECHO_TIMEOUT
        self._close_may_be_sync2 = False
        self._actions.append(Write(make_plain_command(Command(step)).to_bytes(), f"SYNC{step}"))

    def _flush(self, seconds: float, now: float) -> None:
        self._phase, self.due = _HandshakePhase.FLUSHING, now + seconds

    def _drop_pending_writes(self) -> None:
        """Drop pending writes: SYNC0 must not be sent into an open session."""
        self._actions = [each for each in self._actions if isinstance(each, SetBaud)]

    def _close(self, now: float, *, in_session: bool = False) -> None:
        self._drop_pending_writes()
        commands = (Command.STOP, Command.CLOSE)
        data = b"".join(make_plain_command(each).to_bytes() for each in commands)
        self._actions.append(Write(data, "STOP, CLOSE"))
        self._close_may_be_sync2 = not in_session
        self._flush(FLUSH, now)

    def _missed(self, now: float) -> None:
        self._misses += 1
        searching = len(self._bauds) > 1 and not self._heard
        tries = HEARD_TRIES if self._heard else SILENT_TRIES if searching else TRIES
        if self._misses >= tries:
            if searching and self._rates:
                self._try_next_rate(now)
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
        if self._phase is _HandshakePhase.FLUSHING:
            # CLOSE has the number of SYNC2: a robot that waits for that takes it so, and answers.
            if self._close_may_be_sync2 and packet.kind == Report.SYNC2 and packet.payload:
                self._step = 2
                self._take_echo(received, now)
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
        elif self._phase is _HandshakePhase.SYNCHRONISING and packet.kind == self._step:
            self._take_echo(received, now)

    def _take_echo(self, received: Received, now: float) -> None:
        if self._step < 2:
            self._synchronise(self._step + 1, now)
        elif received.packet.payload:
            self.names = Names.from_packet(received.packet)
            self.over = True
        else:
            self._nameless = True  # and wait: the names may follow what was an echo of the line

    def _fail(self) -> None:
        self._drop_pending_writes()
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


class _OpeningPhase(Enum):
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
        self._phase, self._tries = _OpeningPhase.OPENING, 1
        self._open(now)
        for each in left_over:
            self._take(each, now)

    def _write(self, *packets: Packet) -> None:
        data = b"".join(packet.to_bytes() for packet in packets)
        self._actions.append(Write(data, ", ".join(map(name_command, packets))))

    def _open(self, now: float) -> None:
        self._write(make_plain_command(Command.OPEN), make_plain_command(Command.STOP))
        self.due = now + RETRY

    def _ask(self, now: float) -> None:
        self._write(make_integer_command(Command.CONFIG, 1))
        self.due = now + RETRY

    def _handle_timeout(self, now: float) -> None:
        self._tries += 1
        match self._phase:
            case _OpeningPhase.OPENING if self._tries > OPENINGS:
                self._fail(
                    "it answered the handshake, but no reports come after OPEN; switch it off and"
                    " on again, check the cable and that no other program uses the line, then"
                    " connect again"
                )
            case _OpeningPhase.OPENING:
                self._open(now)
            case _OpeningPhase.ASKING if self._tries > QUESTIONS:
                self.over = True  # without CONFIG, as old firmware is
            case _OpeningPhase.ASKING:
                self._ask(now)
            case _OpeningPhase.SWITCHING:
                self._actions.append(SetBaud(self._switch[1]))
                self._deaf_until = now + DEAF
                self._enter(_OpeningPhase.FAST, FAST_RETRY, now)
            case _OpeningPhase.FAST if self._tries > FAST_TRIES:
                self._actions.append(SetBaud(self._switch[0]))
                self._enter(_OpeningPhase.BACK, BACK_RETRY, now)
            case _OpeningPhase.FAST:
                self._enter(_OpeningPhase.FAST, FAST_RETRY, now, again=True)
            case _OpeningPhase.BACK if self._tries > BACK_TRIES:
                self._fail(
                    f"its port was to change to {self._switch[1]} baud and is silent since; give"
                    f" baud={self._switch[0]} to leave the rate as it is"
                )
            case _:
                self._enter(_OpeningPhase.BACK, BACK_RETRY, now, again=True)

    def _enter(
        self, phase: _OpeningPhase, retry: float, now: float, *, again: bool = False
    ) -> None:
        if not again:
            self._tries = 1
        self._phase, self.due = phase, now + retry
        self._write(make_plain_command(Command.STOP))

    def _take(self, received: Received, now: float) -> None:
        packet = received.packet
        self.received.append(received)
        if self.over:
            return
        if packet.kind in (Report.RESET_1, Report.RESET_2):
            self._fail("it was reset while the session was opened; connect again")
        elif packet.kind == Report.CONFIG and self._phase is _OpeningPhase.ASKING:
            try:
                self.configuration = Configuration.from_packet(packet)
            except PacketError:
                return  # it is requested again
            self._take_configuration(now)
        elif packet.kind in SIP_KINDS:
            if self._phase is _OpeningPhase.OPENING:
                self._phase, self._tries = _OpeningPhase.ASKING, 1
                self._ask(now)
            elif self._phase is _OpeningPhase.FAST and now >= self._deaf_until:
                self.baud = self._switch[1]
                self.over = True
            elif self._phase is _OpeningPhase.BACK:
                self.over = True

    def _take_configuration(self, now: float) -> None:
        takes_it = self.configuration is not None and self.configuration.autobaud == AUTOBAUD
        if self._switch[0] == self._switch[1] or not takes_it:
            self.over = True
            return
        self._write(make_integer_command(Command.HOSTBAUD, BAUD_CODES[self._switch[1]]))
        self._phase, self._tries = _OpeningPhase.SWITCHING, 0
        self.due = now + SWITCH_TIME

    def _fail(self, text: str) -> None:
        self.failure = DeviceTimeout(text)
        self.over = True
