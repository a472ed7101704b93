"""A line in simulated time between a machine of the driver and whatever answers."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from facetlog.robot.pioneer.opening import Handshake, Opening, SetBaud
from facetlog.robot.pioneer.packets.commands import Command
from facetlog.robot.pioneer.packets.packet import Decoder
from tests.robot.pioneer.scripted import ScriptedRobot

TICK = 0.01
Answer = Callable[[bytes, float, int | None], bytes]
"""What comes back at once for bytes at a time and a baud rate; b"" in, for time that goes."""


@dataclass
class Line:
    """Carries out what a handshake wants, in steps of simulated time."""

    answer: Answer
    bauds: tuple[int, ...] = ()
    now: float = 100.0
    writes: list[tuple[float, int | None, bytes]] = field(default_factory=list)

    def run(self, machine: Handshake | Opening, longest: float = 60.0) -> None:
        baud = machine.baud
        end = self.now + longest
        while not machine.over and self.now < end:
            said = b""
            for action in machine.actions():
                if isinstance(action, SetBaud):
                    baud = action.baud
                else:
                    self.writes.append((self.now, baud, action.data))
                    said += self.answer(action.data, self.now, baud)
            self.now += TICK
            said += self.answer(b"", self.now, baud)
            machine.receive(said, self.now)
        for action in machine.actions():
            assert isinstance(action, SetBaud), "it writes after its end"
        assert machine.over, "it goes on for ever"

    def commands(self) -> list[str]:
        """Names of all that was written, in order (0, 1, 2 as SYNC)."""
        decoder = Decoder()
        return [
            f"SYNC{each.packet.kind}" if each.packet.kind < 3 else Command(each.packet.kind).name
            for _, _, data in self.writes
            for each in decoder.feed(data)
        ]


class Timed(Protocol):
    """A robot in time that its caller counts."""

    def receive(self, data: bytes, now: float) -> None: ...

    def pending(self, now: float) -> bytes: ...


class TimedPort:
    """A robot on a port in its own time, which goes on while somebody reads."""

    address, has_baud = "timed", False

    def __init__(self, robot: Timed, now: float = 100.0) -> None:
        self.robot, self.now = robot, now

    def clock(self) -> float:
        return self.now

    def read(self, timeout: float) -> bytes:
        self.now += min(max(timeout, 1e-3), 0.02)
        return self.robot.pending(self.now)

    def write(self, data: bytes) -> None:
        self.robot.receive(data, self.now)

    def set_baud(self, baud: int) -> None:
        raise AssertionError(f"there is no rate to make {baud}")

    def close(self) -> None:
        raise AssertionError("nobody closes it")


def answering(robot: ScriptedRobot, at_baud: int | None = None) -> Answer:
    """A robot that hears and is heard at one rate; at others, what it says is noise."""

    def answer(data: bytes, now: float, baud: int | None) -> bytes:
        right = at_baud is None or baud == at_baud
        if data and right:
            robot.receive(data, now)
        said = robot.pending(now)
        return said if right else bytes(b ^ 0x5A for b in said)

    return answer
