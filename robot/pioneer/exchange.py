"""What the handshake and the opening of a session have in common: bytes and times in, actions out.

Neither has I/O, a clock or a thread of its own: who drives them sends what `actions` returns, hands
in what comes back with the time, and calls `advance` when the time `due` has come.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

from facetlog.errors import DeviceError
from facetlog.robot.pioneer.packets.packet import Received
from facetlog.robot.pioneer.packets.receiver import Receiver

__all__ = ["Action", "Exchange", "SetBaud", "Write"]


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
        """What is to be done now, in order; each once."""
        done, self._actions = self._actions, []
        return done

    def receive(self, data: bytes, now: float) -> None:
        """Takes what came in; b"" if nothing did."""
        self.advance(now)
        received = self.receiver.feed(data, now) if data else self.receiver.idle(now) or []
        for each in received:
            self._take(each, now)

    def advance(self, now: float) -> None:
        """Does what is due at `now` or was before."""
        while not self.over and now >= self.due:
            self._late(self.due)

    @abstractmethod
    def _take(self, received: Received, now: float) -> None:
        """A packet has come."""

    @abstractmethod
    def _late(self, now: float) -> None:
        """No answer has come in time."""
