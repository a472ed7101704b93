"""A robot of the tests' own on a port: kinematic, with a watchdog that resumes, in given time."""

import math
import random
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from facetlog.robot.pioneer.packets.commands import Command, read_argument
from facetlog.robot.pioneer.packets.packet import Packet, Receiver
from facetlog.robot.pioneer.packets.reports import (
    Configuration,
    Names,
    Report,
    ServerInformation,
    SonarReading,
    TruePose,
)
from facetlog.robot.pioneer.parameters import MODELS
from facetlog.robot.pose2 import Pose2

STEP = 0.01
CONFIGURATION = Configuration(
    "Pioneer", "p3dx", "SCRIPT", 0, 300, 1000, 300, 2000, 400, "scripted", 100, 0, 0, 0, 1, 0,
    0, 0, 2000, 0, 0, 0, 0, 0, 100, 750, 100, 100, 0, 0, 0, 300, 300, 0, 0, 0, 5, 5, 0, 0, 0,
)  # fmt: skip


@dataclass
class ScriptedRobot:
    """What is on the robot's side of the line; `receive` and `pending` take the time."""

    model: str = "p3dx"
    subclass: str | None = None
    """The model that it reports, where that is another."""
    configuration: Configuration | None = CONFIGURATION
    reports_motors: bool = True
    watchdog: float = 2.0
    enable_works: bool = True
    session: str = "waiting"
    motors: bool = False
    stop_button: bool = False
    battery: int = 125
    stall: tuple[bool, bool] = (False, False)
    front_bumpers: int = 0
    speed: float = 0.0
    turning: float = 0.0
    wanted: tuple[float, float] = (0.0, 0.0)
    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0
    deceleration: float = 0.3
    acceleration: float = 0.6
    cycle: float = 0.1
    """Seconds between reports."""
    origin: tuple[int, int] = (32000, 4000)
    commands: list[tuple[float, str, int | bytes | None]] = field(default_factory=list)
    aux_out: list[bytes] = field(default_factory=list)
    aux_answers: dict[bytes, bytes] = field(default_factory=dict)
    aux_buffer: bytes = b""
    aux_wanted: int = 0
    frozen: bool = False
    now: float | None = None

    def __post_init__(self) -> None:
        self._receiver = Receiver()
        self._out = b""
        self._last_heard = -math.inf
        self._next_report = math.inf
        self._watched = False
        self.stopped_at: float | None = None

    def say(self, packet: Packet) -> None:
        self._out += packet.to_bytes()

    def open_session(self, now: float, speed: float = 0.0) -> None:
        """As a client leaves it that has died."""
        self.advance(now)
        self.session, self.motors = "open", True
        self.wanted, self.speed = (speed, 0.0), speed
        self._last_heard, self._next_report = now, now

    def receive(self, data: bytes, now: float) -> None:
        self.advance(now)
        for received in [*(self._receiver.idle(now) or ()), *self._receiver.feed(data, now)]:
            self._take(received.packet, now)

    def pending(self, now: float) -> bytes:
        self.advance(now)
        out, self._out = self._out, b""
        return b"" if self.frozen else out

    def advance(self, now: float) -> None:
        if self.now is None:
            self.now = now
        while self.now + STEP <= now:
            self.now += STEP
            self._step(self.now)

    def names(self) -> list[str]:
        return [name for _, name, _ in self.commands]

    def _take(self, packet: Packet, now: float) -> None:
        name = Command(packet.kind).name
        argument = read_argument(packet)
        self.commands.append((now, name, argument))
        if self.session == "waiting":
            self._synchronise(packet, now)
            return
        self._last_heard, self._watched = now, False
        value = argument if isinstance(argument, int) else 0
        match Command(packet.kind):
            case Command.OPEN:
                self.session, self._next_report = "open", now + self.cycle
            case Command.CLOSE:
                self.session, self.motors, self._sync = "waiting", False, 0
                self.wanted = (0.0, 0.0)
                self._next_report = math.inf
            case Command.ENABLE if self.enable_works:
                self.motors = bool(value)
                if value:
                    self.wanted = (0.0, 0.0)
            case Command.VEL:
                self.wanted = (value / 1e3, self.wanted[1])
            case Command.RVEL:
                self.wanted = (self.wanted[0], math.radians(value))
            case Command.STOP:
                self.wanted = (0.0, 0.0)
            case Command.ESTOP:
                self.wanted, self.speed, self.turning = (0.0, 0.0), 0.0, 0.0
            case Command.SETV:
                self._set(speed_max=value)
            case Command.SETRV:
                self._set(turning_max=value)
            case Command.SETA if value < 0:
                self.deceleration = -value / 1e3
                self._set(deceleration=-value)
            case Command.SETRA if value < 0:
                self._set(turning_deceleration=-value)
            case Command.CONFIG if self.configuration is not None:
                self.say(replace(self.configuration, subclass=self.model).to_packet())
            case Command.SIM_STAT:
                self.say(TruePose(Pose2(self.x, self.y, self.heading)).to_packet())
            case Command.TTY2 if isinstance(argument, bytes):
                self.aux_out.append(argument)
                self.aux_buffer += self.aux_answers.get(argument, b"")
                self._answer_aux()
            case Command.GETAUX:
                if value == 0:
                    self.aux_buffer, self.aux_wanted = b"", 0
                else:
                    self.aux_wanted = value
                    self._answer_aux()
            case _:
                pass

    _sync = 0

    def _synchronise(self, packet: Packet, now: float) -> None:
        if packet.kind > 2:
            return
        if packet.kind != self._sync and packet.kind != 0:
            self.say(Packet(Report.RESET_2))
            self._sync = 0
            return
        if packet.kind < 2:
            self._sync = packet.kind + 1
            self.say(Packet(packet.kind))
            return
        self.say(Names("scripted", "Pioneer", self.subclass or self.model).to_packet())
        self.session, self.motors, self._last_heard = "synchronised", False, now

    def _set(self, **settings: int) -> None:
        if self.configuration is not None:
            self.configuration = replace(self.configuration, **settings)  # type: ignore[arg-type]

    def _answer_aux(self) -> None:
        if self.aux_wanted and len(self.aux_buffer) >= self.aux_wanted:
            self.say(Packet(Report.SERAUX, self.aux_buffer[: self.aux_wanted]))
            self.aux_buffer, self.aux_wanted = self.aux_buffer[self.aux_wanted :], 0

    def _step(self, now: float) -> None:
        if now - self._last_heard > self.watchdog:
            self._watched = True
        wanted = (0.0, 0.0) if self._watched or not self.motors or self.stop_button else self.wanted
        faster = abs(wanted[0]) > abs(self.speed)
        self.speed = _towards(
            self.speed, wanted[0], (self.acceleration if faster else self.deceleration) * STEP
        )
        self.turning = _towards(self.turning, wanted[1], 2.1 * STEP)
        moving = self.speed != 0 or self.turning != 0
        if moving:
            self.stopped_at = None
        elif self.stopped_at is None:
            self.stopped_at = now
        if not self.motors:
            self.speed = self.turning = 0.0
        middle = self.heading + self.turning * STEP / 2
        self.x += self.speed * STEP * math.cos(middle)
        self.y += self.speed * STEP * math.sin(middle)
        self.heading += self.turning * STEP
        if self.session == "open" and now >= self._next_report:
            self._next_report += self.cycle
            self.say(self.report().to_packet())

    def report(self) -> ServerInformation:
        p = MODELS[self.model]
        mask = (1 << p.position_bits) - 1
        difference = self.turning / p.turning_per_speed
        return ServerInformation(
            x=round(self.x / p.distance) + self.origin[0] & mask,
            y=round(self.y / p.distance) + self.origin[1] & mask,
            heading=_signed(round(self.heading / p.angle)),
            left=round((self.speed - difference) / p.speed),
            right=round((self.speed + difference) / p.speed),
            battery=self.battery,
            stall_left=self.stall[0],
            stall_right=self.stall[1],
            rear_bumpers=0,
            front_bumpers=self.front_bumpers,
            control=0,
            flags=(self.motors | self.stop_button << 5) if self.reports_motors else 1500,
            compass=0,
            sonar=(SonarReading(0, 1000), SonarReading(7, 2000)),
        )


def _signed(value: int) -> int:
    return (value + 2048) % 4096 - 2048


def _towards(value: float, wanted: float, step: float) -> float:
    return wanted if abs(wanted - value) <= step else value + math.copysign(step, wanted - value)


class ScriptedPort:
    """The robot on a port, for threads: in the machine's time, and so a lively robot.

    `damage` is the share of bytes, both ways, that is changed.
    """

    def __init__(
        self,
        robot: ScriptedRobot,
        *,
        damage: float = 0.0,
        seed: int = 1,
        has_baud: bool = False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        robot.cycle, robot.acceleration = 0.05, 3.0
        self.robot, self.damage, self.has_baud = robot, damage, has_baud
        self.address = "scripted"
        self.closed = False
        self.broken: Exception | None = None
        self.bauds: list[int] = []
        self.clock = clock
        self.lock = threading.Lock()
        self._random = random.Random(seed)
        self.written: list[tuple[float, bytes]] = []

    def read(self, timeout: float) -> bytes:
        deadline = time.monotonic() + timeout
        while True:
            if self.broken is not None:
                raise self.broken
            with self.lock:
                data = self.robot.pending(self.clock())
            if data or time.monotonic() >= deadline:
                return self._damage_bytes(data)
            time.sleep(0.002)

    def write(self, data: bytes) -> None:
        if self.broken is not None:
            raise self.broken
        with self.lock:
            self.written.append((self.clock(), data))
            if not self.robot.frozen:
                self.robot.receive(self._damage_bytes(data), self.clock())

    def set_baud(self, baud: int) -> None:
        self.bauds.append(baud)

    def close(self) -> None:
        self.closed = True

    def _damage_bytes(self, data: bytes) -> bytes:
        if not self.damage:
            return data
        return bytes(
            self._random.randrange(256) if self._random.random() < self.damage else byte
            for byte in data
        )
