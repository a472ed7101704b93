"""Faults: of the line, of the robot, on demand and by schedule."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facetlog.errors import InputError
from facetlog.robot.pioneer.packets.commands import (
    Command,
)
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
from tests.robot.simulator.clients import Client, connected
from tests.robot.simulator.firmware.test_aux_ports import Parrot


def line() -> FaultyLine:
    return FaultyLine(np.random.default_rng(0))


def driver(*faults: TimedFault) -> tuple[Client, Simulation]:
    simulation = Simulation(
        WorldSetup(
            scene=SceneSetup(world="empty"),
            robot=RobotSetup(model="p3dx", odometry="perfect"),
            head=HeadSetup(kind="none"),
            faults=faults,
        )
    )
    return connected(simulation), simulation


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
    client, simulation = driver()
    client.hold(300, 2.0)
    simulation.inject(Fault(FaultKind.FROZEN, seconds=4.0), client.now)
    client.wait(3.9)
    assert client.speed == 0.0
    client.command(Command.PULSE)
    client.wait(1.5)
    assert client.speed == pytest.approx(0.3)


def test_low_battery_stall_and_buttons_are_seen_in_the_reports() -> None:
    client, simulation = driver()

    def inject(kind: FaultKind, **values: float | bool) -> None:
        simulation.inject(Fault(kind, **values), client.now)  # type: ignore[arg-type]

    inject(FaultKind.LOW_BATTERY, volts=10.5)
    client.hold(200, 1.0)
    assert client.last_report.battery == 105
    inject(FaultKind.STALL, seconds=1.0)
    client.hold(200, 0.5)
    assert client.last_report.stall_left
    assert client.speed == 0.0
    client.hold(200, 1.5)
    assert not client.last_report.stall_left
    assert client.speed == pytest.approx(0.2)
    inject(FaultKind.MOTORS_OFF)
    client.hold(200, 1.0)
    assert client.last_report.flags & 1 == 0
    assert client.speed == 0.0
    for pressed, flags in ((True, 0b100000), (False, 0b1)):
        inject(FaultKind.STOP_BUTTON, on=pressed)
        client.command(Command.ENABLE, 1)
        client.wait(0.2)
        assert client.last_report.flags & 0b100001 == flags


def test_faults_of_the_world_file_come_at_their_times() -> None:
    client, _ = driver(
        TimedFault(3.0, Fault(FaultKind.LOW_BATTERY, volts=9.9)),
        TimedFault(5.0, Fault(FaultKind.LOW_BATTERY, on=False)),
    )
    volts = []
    for _ in range(65):
        client.hold(0, 0.1)
        volts.append((client.now, client.last_report.battery))
    assert {battery for now, battery in volts if 0.2 < now < 2.9} == {128}
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
                return simulation.take_pending_at_head(now + 0.1)
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
