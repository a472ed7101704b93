"""How soon the simulated robot stands when a driver, its program or its line fails.

Judged by the simulation's own clock and its true state, sampled all along.
"""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from facetlog.errors import DeviceError
from facetlog.robot.pioneer.pioneer import Pioneer
from facetlog.robot.pose2 import Pose2
from facetlog.robot.simulator.faults import Fault, FaultKind
from facetlog.robot.simulator.simulation import SimulationState
from facetlog.robot.simulator.world_file import HeadSetup, RobotSetup, SceneSetup, WorldSetup
from tests.patience import allowed
from tests.robot.simulator.running import SMALL, Running, until

STANDING = 1e-3
LEASE_LIMIT = 0.6
WATCHDOG = 2.0
FULL_SPEED = 0.75
"""m/s: what the simulated p3dx allows."""


class Robot(Running):
    """A simulated robot that is served, and what it did."""

    def __init__(self, model: str = "p3dx") -> None:
        self.samples: list[SimulationState] = []
        self._done = threading.Event()
        self._sampler = threading.Thread(target=self._sample)
        setup = WorldSetup(
            scene=SceneSetup(world="empty"),
            robot=RobotSetup(model=model, odometry="perfect"),
            head=HeadSetup(kind="none"),
            camera=SMALL,
        )
        super().__init__(setup)
        self._sampler.start()

    @property
    def address(self) -> str:
        return self.station.addresses.robot

    @property
    def now(self) -> SimulationState:
        with self.station._live.now() as (simulation, at):
            return simulation.state(at)

    def inject(self, fault: Fault) -> float:
        with self.station._live.now() as (simulation, at):
            simulation.inject(fault, at)
            return at

    def _sample(self) -> None:
        while not self._done.wait(0.01):
            self.samples.append(self.now)

    def stood_after(self, since: float) -> float:
        """How long after `since` it stood for good; it must have moved then."""
        moving = [s.at for s in self.samples if s.at >= since and _moves(s)]
        return (max(moving) - since) if moving else 0.0

    def close(self) -> None:
        self._done.set()
        self._sampler.join()
        super().close()


def _moves(state: SimulationState) -> bool:
    return abs(state.speed) > STANDING or abs(state.turning) > STANDING


@contextmanager
def robot() -> Iterator[Robot]:
    made = Robot()
    try:
        yield made
    finally:
        made.close()


def drive_for(client: Pioneer, seconds: float, speed: float, turning: float) -> None:
    """Drives so long, with a lease that is renewed all the time, and goes on after a stop."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            client.drive(speed, turning)
        except DeviceError:
            client.clear_stop()
        time.sleep(0.05)


CLIENT = """
import sys, time
from facetlog.robot.pioneer.limits import Limits
from facetlog.robot.pioneer.pioneer import Pioneer
with Pioneer.connect(sys.argv[1], limits=Limits(speed=5.0, turning=5.0)) as robot:
    robot.enable_motors()
    told = False
    while True:
        robot.drive(5.0, 0.0)
        if not told and robot.state.speed > 0.9 * float(sys.argv[2]):
            print("at full speed", flush=True)
            told = True
        time.sleep(0.05)
"""


@contextmanager
def client_at_full_speed(
    simulated: Robot, program: str = CLIENT
) -> Iterator[subprocess.Popen[bytes]]:
    """A program of its own that drives as fast as the robot goes."""
    arguments = [sys.executable, "-c", program, simulated.address, str(FULL_SPEED)]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(
        arguments, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment
    ) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == b"at full speed\n"
            yield process
        finally:
            process.kill()


def stands_by_command(simulated: Robot, since: SimulationState) -> None:
    """It stands within a lease and braking, and not because its watchdog holds it."""
    until(lambda: not _moves(simulated.now), "a stand")
    time.sleep(0.2)
    assert simulated.stood_after(since.at) < allowed(LEASE_LIMIT)
    moving = [s for s in simulated.samples if s.at >= since.at and _moves(s)]
    assert not any(s.unattended for s in moving)


@pytest.mark.slow
def test_a_client_killed_at_full_speed_leaves_a_robot_that_brakes_and_closes_its_session() -> None:
    with robot() as simulated:
        with client_at_full_speed(simulated) as process:
            killed = simulated.now
            process.kill()
            stands_by_command(simulated, killed)
        until(lambda: not (simulated.now.session or simulated.now.motors), "the session's end")
        place, first = simulated.now.truth, simulated.now.at
        time.sleep(0.5)  # the line is given back
        with Pioneer.connect(simulated.address) as client:
            assert client.state.pose == Pose2(0.0, 0.0, 0.0)
            client.enable_motors()
            time.sleep(1.0)
            there = simulated.now.truth
            assert (there.x, there.y, there.heading) == (place.x, place.y, place.heading)
            assert not any(_moves(s) for s in simulated.samples if s.at > first)
            drive_for(client, 1.0, 0.2, 0.0)
            assert _moves(simulated.now)


@pytest.mark.slow
def test_a_client_suspended_at_full_speed_leaves_a_robot_that_brakes_and_does_not_go_on_later() -> (
    None
):
    with robot() as simulated, client_at_full_speed(simulated) as process:
        suspended = simulated.now
        process.send_signal(signal.SIGSTOP)
        stands_by_command(simulated, suspended)
        stood = simulated.now
        time.sleep(WATCHDOG)
        process.send_signal(signal.SIGCONT)
        # It is told that it was held up, and ends: what it had in hand did not reach the robot.
        assert process.wait(allowed(20.0)) == 1
        until(lambda: not simulated.now.session, "the session's end")
        assert not any(_moves(s) for s in simulated.samples if s.at > stood.at)


@pytest.mark.slow
def test_nothing_jumps_when_the_line_comes_back_after_the_watchdog() -> None:
    with robot() as simulated:
        with Pioneer.connect(simulated.address) as client:
            client.enable_motors()
            drive_for(client, 1.5, 0.3, 0.0)
            frozen = simulated.inject(Fault(FaultKind.FROZEN, seconds=WATCHDOG + 2.0))
            with pytest.raises(DeviceError):
                _driven_until_refused(client)
        until(lambda: simulated.now.at > frozen + WATCHDOG + 3.0, "the end of the gap")
        # The watchdog stops it; packets that waited in the line must not set it off again for
        # longer than it takes the zeros behind them to arrive.
        assert simulated.stood_after(frozen + WATCHDOG + 2.0) < allowed(0.3)


def _driven_until_refused(client: Pioneer) -> None:
    for _ in range(200):
        client.drive(0.3, 0.0)
        _ = client.state
        time.sleep(0.05)


@pytest.mark.slow
def test_an_interpreter_that_ends_without_closing_stops_the_robot() -> None:
    ending = CLIENT.replace("with Pioneer.connect", "for robot in [Pioneer.connect").replace(
        "turning=5.0)) as robot:", "turning=5.0))]:"
    )
    ending = ending.replace("told = True", "sys.exit(0)")
    with robot() as simulated:
        with client_at_full_speed(simulated, ending) as process:
            ended = simulated.now
            assert process.wait(allowed(20.0)) == 0
        stands_by_command(simulated, ended)
        until(lambda: not (simulated.now.session or simulated.now.motors), "the session's end")
