"""The driver's mind and a robot in simulated time, with a line between them that can fail."""

import math
import random
from collections.abc import Callable
from dataclasses import replace

from facetlog.robot.pioneer.control import Control
from facetlog.robot.pioneer.limits import Limits
from facetlog.robot.pioneer.packets.commands import Command, name_command
from facetlog.robot.pioneer.packets.packet import Packet, Receiver
from facetlog.robot.pioneer.parameters import MODELS
from facetlog.robot.pioneer.state import RobotState
from tests.robot.pioneer.scripted import CONFIGURATION, ScriptedRobot

TICK = 0.01


class Drive:
    """A connected robot, its motors on, that runs in steps of 10 ms."""

    def __init__(
        self,
        robot: ScriptedRobot | None = None,
        *,
        limits: Limits | None = None,
        damage: float = 0.0,
        enabled: bool = True,
    ) -> None:
        self.now = 50.0
        self.robot = robot or ScriptedRobot()
        self.robot.open_session(self.now)
        self.robot.motors = False
        configuration = self.robot.configuration
        if configuration is not None:
            configuration = replace(configuration, subclass=self.robot.model)
        self.control = Control(self.now, MODELS[self.robot.model], configuration, limits)
        self.sent: list[tuple[float, Packet]] = []
        self.silent = False
        """Nothing reaches the driver."""
        self.cut = False
        """Nothing passes either way."""
        self._receiver = Receiver()
        self.damage, self._random = damage, random.Random(3)
        self.run(0.3)
        if enabled:
            for _ in range(10):
                self.send(*self.control.list_switching_packets(on=True))
                self.run(0.5)
                if self.robot.motors and self.state.motors_on is not False:
                    break

    @property
    def state(self) -> RobotState:
        assert self.control.state is not None
        return self.control.state

    def names(self, since: float = 0.0) -> list[str]:
        return [name_command(packet) for at, packet in self.sent if at >= since]

    def send(self, *packets: Packet) -> None:
        for packet in packets:
            for first in self.control.motion.list_packets_before(self.now):
                self._put(first)
            self.control.note_outgoing(packet)
            self._put(packet)

    def run(
        self,
        seconds: float,
        speeds: tuple[float, float] | None = None,
        *,
        every: float = 0.1,
        until: Callable[[], bool] = lambda: False,
    ) -> None:
        """Lets time go; with `speeds`, a program drives ten times a second."""
        end = self.now + seconds
        again = self.now
        while self.now < end - 1e-9 and not until():
            if speeds is not None and self.now >= again - 1e-9:
                self.control.drive(*speeds, 0.3, self.now)
                again += every
            self.tick()

    def tick(self) -> None:
        for packet in self.control.advance(self.now):
            self._put(packet)
        self.now += TICK
        said = self._damage_bytes(self.robot.pending(self.now))
        if self.silent or self.cut:
            said = b""
        strange = self._receiver.strange
        for received in (
            self._receiver.feed(said, self.now) if said else self._receiver.idle(self.now) or ()
        ):
            self.control.take(received)
        self.control.looked(self.now, damaged=self._receiver.strange > strange)

    def hang(self, seconds: float) -> None:
        """The program gets no time to run in; the robot does, and its reports wait."""
        self.now += seconds
        self.robot.advance(self.now)

    def _put(self, packet: Packet) -> None:
        self.sent.append((self.now, packet))
        if not self.cut:
            self.robot.receive(self._damage_bytes(packet.to_bytes()), self.now)

    def _damage_bytes(self, data: bytes) -> bytes:
        if not self.damage:
            return data
        return bytes(
            self._random.randrange(256) if self._random.random() < self.damage else byte
            for byte in data
        )


def list_speeds_sent(drive: Drive, since: float) -> list[tuple[str, int]]:
    """VEL and RVEL that were sent, with their values."""
    told = []
    for name in drive.names(since):
        word, _, value = name.partition(" ")
        if word in (Command.VEL.name, Command.RVEL.name):
            told.append((word, int(value)))
    return told


def way(robot: ScriptedRobot) -> float:
    return math.hypot(robot.x, robot.y)


__all__ = ["CONFIGURATION", "TICK", "Drive", "list_speeds_sent", "way"]
