"""A client of the simulated firmware in simulated time, and robots for it."""

from dataclasses import dataclass, field, replace

import numpy as np

from facetlog.robot.pioneer.packets.commands import (
    Command,
    make_integer_command,
    make_plain_command,
)
from facetlog.robot.pioneer.packets.packet import Decoder, Packet
from facetlog.robot.pioneer.packets.reports import SIP_KINDS, ServerInformation
from facetlog.robot.pioneer.parameters import find_parameters
from facetlog.robot.pose2 import Pose2
from facetlog.robot.rendering.world import Solid
from facetlog.robot.simulator.body import Body, MotionErrors, Obstacles, Sonars
from facetlog.robot.simulator.firmware.drive import Drive
from facetlog.robot.simulator.firmware.factory_settings import make_default_configuration
from facetlog.robot.simulator.firmware.firmware import Firmware
from facetlog.robot.simulator.simulation import Simulation

ROBOT_HEIGHT = 0.24
ORIGIN, EXACT = Pose2(0.0, 0.0, 0.0), MotionErrors()


def make_firmware(
    model: str = "p3dx",
    *solids: Solid,
    start: Pose2 = ORIGIN,
    errors: MotionErrors = EXACT,
    seed: int = 0,
    position_bits: int = 15,
    **config: int,
) -> Firmware:
    """A robot among solids, in metres; `config` is what it says differently to CONFIG."""
    parameters = find_parameters(model)
    configuration = replace(make_default_configuration(parameters, "Test"), **config)  # type: ignore[arg-type]
    obstacles = Obstacles.of(solids, radius=parameters.radius, height=ROBOT_HEIGHT)
    rng = np.random.default_rng(seed)
    track = 2 / parameters.turning_per_speed
    body = Body(track, start, errors=errors, surroundings=obstacles, rng=rng)
    return Firmware(
        Drive(parameters, configuration, body),
        Sonars(parameters, obstacles, period=0.04),
        position_bits=position_bits,
    )


@dataclass
class Client:
    """Sends packets to a robot, bare or on a faulty line, and reads reports; `now` is its clock."""

    firmware: Firmware | Simulation
    now: float = 0.0
    decoder: Decoder = field(default_factory=Decoder)
    packets: list[Packet] = field(default_factory=list)
    """All that came and was not taken yet."""

    def say(self, *packets: Packet) -> None:
        for packet in packets:
            self.firmware.receive(packet.to_bytes(), self.now)

    def command(self, command: Command, value: int | None = None) -> None:
        packet = (
            make_plain_command(command) if value is None else make_integer_command(command, value)
        )
        self.say(packet)

    def wait(self, seconds: float) -> list[Packet]:
        """What came in that time; nothing is said meanwhile."""
        self.now += seconds
        data = self.firmware.pending(self.now)
        found = [received.packet for received in self.decoder.feed(data, self.now)]
        self.packets += found
        return found

    def wait_pulsing(self, seconds: float) -> list[Packet]:
        """The same, with a PULSE every half second as clients send it."""
        found: list[Packet] = []
        while seconds > 1e-9:
            self.command(Command.PULSE)
            found += self.wait(min(seconds, 0.5))
            seconds -= 0.5
        return found

    def open(self, *, motors: bool = True) -> "Client":
        for number in range(3):
            self.say(Packet(number))
            assert [packet.kind for packet in self.wait(0.01)] == [number]
        self.command(Command.OPEN)
        if motors:
            self.command(Command.ENABLE, 1)
        return self

    def report(self) -> ServerInformation:
        """The next SIP."""
        sips = [packet for packet in self.wait(0.1) if packet.kind in SIP_KINDS]
        assert sips, "no SIP within a cycle"
        return ServerInformation.from_packet(sips[-1])

    def hold(self, speed: int, seconds: float) -> None:
        """Repeat a speed every 100 ms, as drivers do."""
        for _ in range(round(10 * seconds)):
            self.command(Command.VEL, speed)
            self.wait(0.1)

    @property
    def last_report(self) -> ServerInformation:
        sips = [packet for packet in self.packets if packet.kind in SIP_KINDS]
        return ServerInformation.from_packet(sips[-1])

    @property
    def drive(self) -> Drive:
        robot = self.firmware
        return robot.drive if isinstance(robot, Firmware) else robot.firmware.drive

    @property
    def truth(self) -> Pose2:
        return self.drive.body.truth

    @property
    def speed(self) -> float:
        return self.drive.body.speed

    @property
    def turning(self) -> float:
        return self.drive.body.turning


def connected(firmware: Firmware | Simulation, *, motors: bool = True) -> Client:
    """A client whose session is open."""
    return Client(firmware).open(motors=motors)
