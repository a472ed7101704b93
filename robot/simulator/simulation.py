"""The whole simulated robot: firmware, head and line faults; without I/O, and in real time."""

import math
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from facetlog.errors import InputError
from facetlog.robot.pioneer.parameters import find_parameters
from facetlog.robot.pose2 import Pose2
from facetlog.robot.simulator.body import Body, Obstacles, Sonars
from facetlog.robot.simulator.camera.viewpoint import Viewpoint
from facetlog.robot.simulator.device import Device
from facetlog.robot.simulator.faults import Fault, FaultKind, FaultyLine, Schedule
from facetlog.robot.simulator.firmware.drive import Drive
from facetlog.robot.simulator.firmware.factory_settings import make_default_configuration
from facetlog.robot.simulator.firmware.firmware import Firmware
from facetlog.robot.simulator.heads.canon import CanonHead
from facetlog.robot.simulator.heads.sony import SonyHead
from facetlog.robot.simulator.world_file import WorldSetup, make_scene


def make_head(kind: str) -> Device | None:
    """Return a head of this kind at rest; None for `none`."""
    match kind:
        case "sony-evi-d30":
            return SonyHead()
        case "canon-vc-c4":
            return CanonHead()
        case _:
            return None


# Separate random streams for motion and for the line, independent of that of the pictures.
MOTION_STREAM, LINE_STREAM = 1, 2
AUX_PORTS = ("aux1", "aux2", "aux3")
OWN_PORT = "own"


@dataclass(frozen=True, slots=True)
class SimulationState:
    """The true state at one moment; seconds, metres, radians."""

    at: float
    truth: Pose2
    odometry: Pose2
    speed: float
    turning: float
    motors: bool
    stop_button: bool
    session: bool
    unattended: bool
    stalled: bool
    touching: bool
    battery_v: float
    pan: float
    tilt: float
    zoom: float


class Simulation:
    """A robot in a world, with a head and faults; `now` are seconds from 0 on, never backwards."""

    def __init__(self, setup: WorldSetup, *, head: Device | None = None) -> None:
        self.setup = setup
        self.head = head or make_head(setup.head.kind)
        self.firmware = _make_firmware(setup)
        rng = np.random.default_rng([setup.seed, LINE_STREAM])
        self._to_robot, self._to_client = FaultyLine(rng), FaultyLine(rng)
        self._schedule = Schedule()
        self._head_silent = False
        self.camera_frozen = False
        """Whether the camera sends its last picture again."""
        self.camera_silent = False
        self.hung_up = False
        """Whether the client's connection is to be closed; whoever closes it resets this."""
        for timed in setup.faults:
            self._schedule.add(timed.at, timed.fault)
        if setup.head.port in AUX_PORTS:
            port = self.firmware.ports[AUX_PORTS.index(setup.head.port)]
            port.device = self.head

    def receive(self, data: bytes, now: float) -> None:
        self.advance(now)
        self._to_robot.push(data, now)
        self.advance(now)

    def pending(self, now: float) -> bytes:
        self.advance(now)
        return self._to_client.pull(now)

    def receive_at_head(self, data: bytes, now: float) -> None:
        """Take bytes that come to a head with a port of its own."""
        self.advance(now)
        if self._has_own_port and self.head is not None and not self._head_silent:
            self.head.receive(data, now)

    def take_pending_at_head(self, now: float) -> bytes:
        """Return bytes from a head with a port of its own."""
        self.advance(now)
        if not self._has_own_port or self.head is None:
            return b""
        said = self.head.pending(now)
        return b"" if self._head_silent else said

    @property
    def _has_own_port(self) -> bool:
        return self.setup.head.port == OWN_PORT

    def inject(self, fault: Fault, now: float) -> None:
        self.advance(now)
        self._schedule.add(now, fault)
        self.advance(now)

    def advance(self, now: float) -> None:
        """Advance everything to `now`, in the order of events."""
        while True:
            times = (self._schedule.next_at, self._to_robot.next_at)
            at = min((t for t in times if t is not None), default=math.inf)
            if at > now:
                break
            self.firmware.advance(at)
            for fault in self._schedule.due(at):
                self._apply(fault, at)
            self.firmware.receive(self._to_robot.pull(at), at)
            self._to_client.push(self.firmware.pending(at), at)
        self._to_client.push(self.firmware.pending(now), now)

    def viewpoint(self, now: float) -> Viewpoint:
        self.advance(now)
        truth = self.firmware.drive.body.truth
        pan, tilt, _ = self._angles(now)
        return Viewpoint(truth.x, truth.y, truth.heading, pan, tilt)

    def state(self, now: float) -> SimulationState:
        self.advance(now)
        drive = self.firmware.drive
        pan, tilt, zoom = self._angles(now)
        return SimulationState(
            at=now,
            truth=drive.body.truth,
            odometry=drive.odometry,
            speed=drive.body.speed,
            turning=drive.body.turning,
            motors=drive.motors,
            stop_button=drive.stop_button,
            session=self.firmware.opened,
            unattended=self.firmware.unattended(now),
            stalled=drive.contacts.stalled,
            touching=drive.body.contact is not None,
            battery_v=self.firmware.battery_v,
            pan=pan,
            tilt=tilt,
            zoom=zoom,
        )

    def _angles(self, now: float) -> tuple[float, float, float]:
        return (0.0, 0.0, 0.0) if self.head is None else self.head.angles(now)

    def _apply(self, fault: Fault, now: float) -> None:
        lines = (self._to_robot, self._to_client)
        rate = fault.rate if fault.on else 0.0
        drive = self.firmware.drive
        match fault.kind:
            case FaultKind.LOST:
                for line in lines:
                    line.lost = rate
            case FaultKind.CORRUPT:
                for line in lines:
                    line.corrupt = rate
            case FaultKind.LATE:
                for line in lines:
                    line.late, line.delay = rate, fault.delay
            case FaultKind.FROZEN:
                for line in lines:
                    line.frozen_until = now + (fault.lasts or 0.0) if fault.on else now
            case FaultKind.HUNG_UP:
                self.hung_up = fault.on
            case FaultKind.POWER_CYCLE:
                self.firmware.power_cycle(now, fault.lasts or 0.0)
            case FaultKind.LOW_BATTERY:
                volts = fault.volts if fault.on else self.setup.robot.battery_v
                self.firmware.battery_v = volts
            case FaultKind.STALL if fault.on:
                drive.contacts.stall(now, fault.lasts or 0.0)
            case FaultKind.STALL:
                drive.contacts.free()
            case FaultKind.MOTORS_OFF:
                drive.enable(not fault.on)
            case FaultKind.STOP_BUTTON:
                drive.press_stop_button(now, pressed=fault.on)
            case FaultKind.HEAD_SILENT:
                self._head_silent = fault.on
                for port in self.firmware.ports:
                    port.silent = fault.on
            case FaultKind.CAMERA_FROZEN:
                self.camera_frozen = fault.on
            case FaultKind.CAMERA_SILENT:
                self.camera_silent = fault.on


def _make_firmware(setup: WorldSetup) -> Firmware:
    robot = setup.robot
    parameters = find_parameters(robot.model)
    configuration = replace(make_default_configuration(parameters, robot.name), **robot.config)  # type: ignore[arg-type]
    start = Pose2(robot.start.x, robot.start.y, math.radians(robot.start.heading_deg))
    world = make_scene(setup.scene)
    obstacles = Obstacles.of(world.solids, radius=parameters.radius, height=robot.height)
    if (there := obstacles.nearest(start.x, start.y)) is not None and there.gap < 0.0:
        raise InputError(
            f"robot.start ({start.x:g}, {start.y:g}): something of the scene stands there: "
            f"give a place {-there.gap:.2f} m further off"
        )
    body = Body(
        track=2 / parameters.turning_per_speed,
        truth=start,
        errors=robot.motion_errors,
        surroundings=obstacles,
        rng=np.random.default_rng([setup.seed, MOTION_STREAM]),
    )
    return Firmware(
        Drive(parameters, configuration, body),
        Sonars(parameters, obstacles, (configuration.sonar_cycle or 0) / 1e3),
        position_bits=robot.position_bits,
        battery_v=robot.battery_v,
    )


LONGEST_GAP = 2.0
"""Seconds that the simulation catches up at once; after a longer sleep the rest is skipped."""


class LiveSimulation:
    """A simulation in real time behind a lock: one thread at a time sees it as it is now."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._lock = threading.Lock()
        self._started = time.monotonic()
        self._last = 0.0

    @contextmanager
    def now(self) -> Iterator[tuple[Simulation, float]]:
        """Provide the simulation and its time in seconds; nobody else has it meanwhile."""
        with self._lock:
            passed = time.monotonic() - self._started
            if passed - self._last > LONGEST_GAP:
                self._started += passed - self._last - LONGEST_GAP
                passed = self._last + LONGEST_GAP
            self._last = passed
            yield self._simulation, passed
