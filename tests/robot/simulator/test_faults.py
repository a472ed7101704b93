"""Faults: of the line, of the robot, on demand and by schedule."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.errors import InputError
from facetlog.robot.pioneer.packets.commands import (
    Command,
    make_integer_command,
    make_plain_command,
)
from facetlog.robot.pioneer.packets.packet import Decoder, Packet
from facetlog.robot.pioneer.packets.reports import ServerInformation
from facetlog.robot.simulator.faults import Fault, FaultKind, FaultyLine
from facetlog.robot.simulator.simulation import Simulation
from facetlog.robot.simulator.world_file import (
    HeadSetup,
    RobotSetup,
    SceneSetup,
    StartSetup,
    TimedFault,
    WorldSetup,
)
from tests.robot.simulator.firmware.test_aux_ports import Parrot


def line() -> FaultyLine:
    return FaultyLine(np.random.default_rng(0))


class Driver:
    """A client of a whole simulation that repeats what it wants every 100 ms, as drivers do."""

    def __init__(self, *faults: TimedFault, model: str = "p3dx", seed: int = 0) -> None:
        self.simulation = Simulation(
            WorldSetup(
                scene=SceneSetup(world="empty"),
                robot=RobotSetup(model=model, odometry="perfect"),
                head=HeadSetup(kind="none"),
                faults=faults,
                seed=seed,
            )
        )
        self.now = 0.0
        self.decoder = Decoder()
        self.reports: list[ServerInformation] = []
        self.others: list[Packet] = []
        for kind in (0, 1, 2, Command.OPEN):
            self.command(make_plain_command(Command(kind)), 0.02)
        self.command(make_integer_command(Command.ENABLE, 1), 0.0)

    def command(self, packet: Packet, seconds: float) -> int:
        """How many packets came in the seconds after it was sent."""
        self.simulation.receive(packet.to_bytes(), self.now)
        return self.listen(seconds)

    def listen(self, seconds: float) -> int:
        self.now += seconds
        found = self.decoder.feed(self.simulation.pending(self.now), self.now)
        for received in found:
            if received.packet.kind in (0x32, 0x33):
                self.reports.append(ServerInformation.from_packet(received.packet))
            else:
                self.others.append(received.packet)
        return len(found)

    def hold(self, speed: int, seconds: float) -> None:
        end = self.now + seconds
        while self.now < end - 1e-9:
            self.command(make_integer_command(Command.VEL, speed), 0.1)

    def inject(self, kind: FaultKind, **values: float | bool) -> None:
        self.simulation.inject(Fault(kind, **values), self.now)  # type: ignore[arg-type]

    @property
    def x(self) -> float:
        return self.simulation.firmware.drive.body.truth.x

    @property
    def speed(self) -> float:
        return self.simulation.firmware.drive.body.speed


def test_bytes_are_corrupted_and_lost_at_their_rates() -> None:
    data = bytes(range(250)) * 400
    bad = line()
    bad.corrupt = 0.05
    bad.push(data, 0.0)
    came = bad.pull(0.0)
    assert len(came) == len(data)
    wrong = sum(a != b for a, b in zip(data, came, strict=True)) / len(data)
    assert wrong == pytest.approx(0.05, abs=0.005)
    bad.corrupt, bad.lost = 0.0, 0.1
    bad.push(data, 0.0)
    assert len(bad.pull(0.0)) / len(data) == pytest.approx(0.9, abs=0.005)


@given(st.floats(0.0, 1.0), st.floats(0.0, 0.5), st.integers(1, 30))
def test_late_bytes_keep_their_order(rate: float, delay: float, count: int) -> None:
    slow = line()
    slow.late, slow.delay = rate, delay
    came = b""
    for index in range(count):
        slow.push(bytes([index]), 0.1 * index)
        came += slow.pull(0.1 * index)
    assert bytes(range(count)).startswith(came)
    assert came + slow.pull(math.inf) == bytes(range(count))


def test_a_link_frozen_for_longer_than_the_watchdog_stops_it_and_then_lets_it_go_on() -> None:
    driver = Driver()
    driver.hold(300, 2.0)
    driver.inject(FaultKind.FROZEN, seconds=4.0)
    driver.listen(3.9)
    assert driver.speed == 0.0
    driver.command(make_plain_command(Command.PULSE), 1.5)
    assert driver.speed == pytest.approx(0.3)


def test_low_battery_stall_and_buttons_are_seen_in_the_reports() -> None:
    driver = Driver()
    driver.inject(FaultKind.LOW_BATTERY, volts=10.5)
    driver.hold(200, 1.0)
    assert driver.reports[-1].battery == 105
    driver.inject(FaultKind.STALL, seconds=1.0)
    driver.hold(200, 0.5)
    assert driver.reports[-1].stall_left
    assert driver.reports[-1].stall_right
    assert driver.speed == 0.0
    driver.hold(200, 1.5)
    assert not driver.reports[-1].stall_left
    assert driver.speed == pytest.approx(0.2)
    driver.inject(FaultKind.STALL, seconds=60.0)
    driver.hold(200, 0.2)
    driver.inject(FaultKind.STALL, on=False)
    driver.hold(200, 0.2)
    assert not driver.reports[-1].stall_left
    driver.inject(FaultKind.MOTORS_OFF)
    driver.hold(200, 1.0)
    assert driver.reports[-1].flags & 1 == 0
    assert driver.speed == 0.0
    driver.command(make_integer_command(Command.ENABLE, 1), 0.0)
    driver.inject(FaultKind.STOP_BUTTON)
    driver.command(make_integer_command(Command.ENABLE, 1), 0.2)
    assert driver.reports[-1].flags & 0b100001 == 0b100000
    driver.inject(FaultKind.STOP_BUTTON, on=False)
    driver.command(make_integer_command(Command.ENABLE, 1), 0.2)
    assert driver.reports[-1].flags & 0b100001 == 1


def test_faults_of_the_world_file_come_at_their_times() -> None:
    driver = Driver(
        TimedFault(3.0, Fault(FaultKind.LOW_BATTERY, volts=9.9)),
        TimedFault(5.0, Fault(FaultKind.LOW_BATTERY, on=False)),
    )
    volts = []
    for _ in range(65):
        driver.hold(0, 0.1)
        volts.append((driver.now, driver.reports[-1].battery))
    assert {battery for now, battery in volts if now < 2.9} == {128}
    assert {battery for now, battery in volts if 3.2 < now < 4.9} == {99}
    assert {battery for now, battery in volts if now > 5.2} == {128}


def test_a_silent_head_neither_hears_nor_answers_at_either_port() -> None:
    for port in ("aux1", "own"):
        setup = WorldSetup(head=HeadSetup(port=port))  # type: ignore[arg-type]
        parrot = Parrot()
        simulation = Simulation(setup, head=parrot)

        def said(simulation: Simulation, port: str, now: float) -> bytes:
            if port == "own":
                simulation.receive_at_head(b"abc", now)
                return simulation.pending_at_head(now + 0.1)
            aux = simulation.firmware.ports[0]
            aux.send(b"abc", now)
            aux.request(3)
            packet = aux.poll(now + 0.1)
            return b"" if packet is None else packet.payload

        assert said(simulation, port, 1.0) == b"abc"
        simulation.inject(Fault(FaultKind.HEAD_SILENT, seconds=5.0), 2.0)
        assert said(simulation, port, 3.0) == b""
        assert parrot.heard == b"abc"
        simulation.advance(8.0)
        assert said(simulation, port, 9.0) == b"abc"


def test_a_robot_that_would_stand_in_a_solid_is_refused() -> None:
    start = StartSetup(x=0.59, y=1.3)
    with pytest.raises(InputError, match=r"robot.start \(0.59, 1.3\): something of the scene"):
        Simulation(WorldSetup(robot=RobotSetup(start=start)))
