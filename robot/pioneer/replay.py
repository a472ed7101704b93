"""A traffic log played back, so that a session can be decoded again without its robot."""

import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from facetlog.errors import DeviceError, InputError
from facetlog.robot.pioneer.connecting import Connected, connect_over
from facetlog.robot.pioneer.control import Control
from facetlog.robot.pioneer.limits import Limits
from facetlog.robot.pioneer.packets.packet import Decoder, Received
from facetlog.robot.pioneer.state import OdometryErrors, RobotState
from facetlog.robot.pioneer.traffic import SCHEMA


@dataclass(frozen=True, slots=True)
class _Chunk:
    at: float
    incoming: bool
    data: bytes


@dataclass(frozen=True, slots=True)
class _Session:
    start: float
    serial: bool
    model: str | None
    baud: int | None
    chunks: list[_Chunk]


class ReplayPort:
    """A port that returns the robot's logged bytes at once; writes are ignored.

    `model` and `baud` are what the user gave when the log was made. `clock` is the time of the log
    at which the last bytes came. At the end of the log the line is gone: DeviceError.
    """

    def __init__(self, address: str, session: _Session) -> None:
        self.address = address
        self.has_baud = session.serial
        self.model = session.model
        self.baud = session.baud
        self._chunks: Iterator[_Chunk] = iter(session.chunks)
        self._now = session.start

    def clock(self) -> float:
        """Return seconds, on the clock of the log."""
        return self._now

    def read(self, timeout: float) -> bytes:  # noqa: ARG002 - what was said does not wait
        """Return the next bytes that came; b"" where half a packet was given up."""
        for chunk in self._chunks:
            self._now = max(self._now, chunk.at)
            if chunk.incoming:
                return chunk.data
        raise DeviceError(f"{self.address}: the log ends here")

    def rest(self) -> Iterator[tuple[float, bool, bytes]]:
        """Yield the rest of the log: times, whether the bytes came in, and the bytes."""
        for chunk in self._chunks:
            self._now = max(self._now, chunk.at)
            yield chunk.at, chunk.incoming, chunk.data

    def write(self, data: bytes) -> None:
        """Ignore what is written."""

    def set_baud(self, baud: int) -> None:
        """Forget it."""

    def close(self) -> None:
        """End the log."""
        self._chunks = iter(())


def replay(path: Path | str, session: int = -1) -> ReplayPort:
    """Return the port of a session in a log: the last one unless another is named (0 is the first).

    InputError if the file cannot be read, holds no such session, or has a line that is none; but
    the last line may be cut off, as a kill leaves it.
    """
    path = Path(path)
    try:
        lines = path.read_bytes().split(b"\n")
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    sessions: list[_Session] = []
    for number, line in enumerate(lines[:-1], 1):
        try:
            entry = json.loads(line)
            at = float(entry["at"])
            if "start" in entry:
                if entry["schema"] != SCHEMA:
                    raise InputError(
                        f"{path}:{number}: a log of schema {entry['schema']}; {SCHEMA} can be read"
                    )
                given = entry["serial"], entry["model"], entry["baud"]
                sessions.append(_Session(at, *given, chunks=[]))
            elif "direction" in entry:
                incoming = {"in": True, "out": False}[entry["direction"]]
                sessions[-1].chunks.append(_Chunk(at, incoming, bytes.fromhex(entry["hex"])))
        except (ValueError, KeyError, TypeError, IndexError) as error:
            raise InputError(f"{path}:{number}: is no line of a traffic log") from error
    try:
        found = sessions[session]
    except IndexError:
        raise InputError(f"{path}: holds {len(sessions)} sessions, none is {session}") from None
    return ReplayPort(f"replay:{path}", found)


def iter_replayed_states(
    port: ReplayPort,
    *,
    errors: OdometryErrors | None = None,
    connected: Callable[[Connected], None] | None = None,
) -> Iterator[RobotState]:
    """Yield the states that the driver computed in a session, one after the other.

    `connected` is called with the opened session. DeviceError if it never came to a report.
    """
    found = connect_over(port, port.clock, model=port.model, baud=port.baud)
    if connected is not None:
        connected(found)
    control = Control(port.clock(), found.parameters, found.configuration, Limits(), errors)
    sent = Decoder()
    yield from _iter_states(control, found.received)
    for at, incoming, data in port.rest():
        if incoming:
            receiver = found.receiver
            received = receiver.feed(data, at) if data else receiver.idle(at) or ()
            yield from _iter_states(control, received)
        else:
            for each in sent.feed(data, at):
                control.replay_outgoing(each.packet)


def _iter_states(control: Control, received: Iterable[Received]) -> Iterator[RobotState]:
    for each in received:
        before = control.state
        control.take(each)
        if control.state is not None and control.state is not before:
            yield control.state
