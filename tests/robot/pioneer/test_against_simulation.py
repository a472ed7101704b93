"""The driver's mind against the simulated robot, joined in simulated time."""

import math

import numpy as np
import pytest
from scipy.stats import chi2

from facetlog.errors import DeviceError
from facetlog.robot.pioneer.connecting import Connected, connect_over
from facetlog.robot.pioneer.control import Control
from facetlog.robot.pioneer.guard import Cause
from facetlog.robot.pioneer.parameters import MODELS
from facetlog.robot.pioneer.state import OdometryErrors, RobotState
from facetlog.robot.pose2 import Pose2, wrapped
from facetlog.robot.simulator.faults import Fault, FaultKind
from facetlog.robot.simulator.simulation import Simulation
from facetlog.robot.simulator.world_file import (
    ErrorSetup,
    HeadSetup,
    RobotSetup,
    SceneSetup,
    WorldSetup,
)
from tests.robot.pioneer.lines import TimedPort

TICK = 0.02
TRACK = 2 / 5.6  # metres, of the p3dx


class Run:
    """A connected robot whose motors are on."""

    def __init__(self, setup: WorldSetup, model: str | None = None) -> None:
        self.simulation = Simulation(setup)
        self.port = TimedPort(self.simulation, 0.0)
        self.connected: Connected = connect_over(self.port, self.port.clock, model=model)
        self.control = Control(
            self.port.now, self.connected.parameters, self.connected.configuration
        )
        for received in self.connected.received:
            self.control.take(received)
        self.start = self.ask_true_pose()
        while self.state.motors_on is False:
            for packet in self.control.list_switching_packets(on=True):
                self.control.note_outgoing(packet)
                self.port.write(packet.to_bytes())
                self.run(0.05)
            self.run(0.2)

    @property
    def state(self) -> RobotState:
        assert self.control.state is not None
        return self.control.state

    def ask_true_pose(self) -> Pose2:
        truth = self.simulation.state(self.port.now).truth
        return Pose2(truth.x, truth.y, truth.heading)

    def run(self, seconds: float, speed: float = 0.0, turning: float = 0.0) -> None:
        end = self.port.now + seconds
        while self.port.now < end:
            if (speed or turning) and self.control.lost is None:
                self.control.drive(speed, turning, 0.3, self.port.now)
            for packet in self.control.advance(self.port.now):
                self.port.write(packet.to_bytes())
            data, receiver = self.port.read(TICK), self.connected.receiver
            now, strange = self.port.now, receiver.strange
            for received in receiver.feed(data, now) if data else receiver.idle(now) or ():
                self.control.take(received)
            self.control.looked(now, damaged=receiver.strange > strange)


def world(errors: ErrorSetup, seed: int = 0, model: str = "p3dx") -> WorldSetup:
    return WorldSetup(
        scene=SceneSetup(world="empty"),
        robot=RobotSetup(model=model, odometry="perfect", errors=errors),
        head=HeadSetup(kind="none"),
        seed=seed,
    )


def errors_drawn(rng: np.random.Generator) -> ErrorSetup:
    """Of a robot whose constants are as far off as the driver's figures say."""
    e = OdometryErrors()
    way, turning, drift = rng.normal(0, [e.way, e.turning, e.drift])
    return ErrorSetup(
        left=float(way - drift * TRACK / 2),
        right=float(way + drift * TRACK / 2),
        track=float(turning),
        slip=0.002,
        encoder=0.001,
    )


@pytest.mark.slow
def test_the_covariance_is_honest_of_simulated_robots() -> None:
    """Mean NEES of 40 robots after five legs, within chi-square's 99 %."""
    rng, runs, total = np.random.default_rng(5), 40, 0.0
    for seed in range(runs):
        run = Run(world(errors_drawn(rng), seed))
        for _ in range(5):
            run.run(3.0, 0.3, 0.0)
            run.run(2.0, 0.0, 0.4)
        run.run(1.5)
        state, true = run.state, run.start.between(run.ask_true_pose())
        assert state.standing
        off = np.array(
            [
                true.x - state.pose.x,
                true.y - state.pose.y,
                wrapped(true.heading - state.pose.heading),
            ]
        )
        total += float(off @ np.linalg.solve(state.covariance, off))
    low, high = chi2.ppf([0.005, 0.995], 3 * runs) / runs
    assert low < total / runs < high


@pytest.mark.parametrize("model", ["p2dx", "p3dx", "p2at", "pion1m"])
def test_every_model_is_driven_along_a_curve_and_knows_its_pose(model: str) -> None:
    run = Run(world(ErrorSetup(), model=model))
    run.run(8.0, 0.2, 0.25)
    run.control.stop()
    run.run(1.5)
    pose, true = run.state.pose, run.start.between(run.ask_true_pose())
    unit = run.connected.parameters.distance
    assert math.hypot(true.x, true.y) > 0.8
    assert math.hypot(pose.x - true.x, pose.y - true.y) < 2 * unit + 0.002
    assert abs(wrapped(pose.heading - true.heading)) < 2 * run.connected.parameters.angle
    assert run.control.problems == ()


@pytest.mark.parametrize("rate", [0.005, 0.05])
def test_damaged_bytes_and_frozen_lines_cost_the_pose_nothing(rate: float) -> None:
    """Bytes damaged both ways, and half a second of frozen line at times.

    Of one byte in twenty damaged one report in 75 comes through whole: the robot stands most of
    the time, and is known to be where it is.
    """
    run = Run(world(ErrorSetup(), seed=2))
    simulation = run.simulation
    simulation.inject(Fault(FaultKind.CORRUPT, rate=rate), run.port.now)
    for _ in range(6):
        run.run(2.5, 0.25, 0.2)
        simulation.inject(Fault(FaultKind.FROZEN, seconds=0.5), run.port.now)
        run.run(0.5, 0.25, 0.2)
    simulation.inject(Fault(FaultKind.CORRUPT, on=False), run.port.now)
    run.run(2.0)
    pose, true = run.state.pose, run.start.between(run.ask_true_pose())
    assert run.state.standing
    assert math.hypot(pose.x - true.x, pose.y - true.y) < 2e-3
    assert abs(wrapped(pose.heading - true.heading)) < 0.004
    causes = {p.cause for p in run.control.problems}
    assert causes <= {Cause.QUIET, Cause.REPORTS_AGAIN, Cause.LEASE}


def test_a_watchdog_of_half_a_second_is_kept_awake_while_the_robot_drives_and_stands() -> None:
    setup = WorldSetup(
        scene=SceneSetup(world="empty"),
        robot=RobotSetup(model="p3dx", odometry="perfect", config={"watchdog_ms": 500}),
        head=HeadSetup(kind="none"),
    )
    run = Run(setup)
    for speed in (0.2, 0.0, 0.2):
        for _ in range(30):
            run.run(0.1, speed)
            assert not run.simulation.state(run.port.now).unattended
    assert {p.cause for p in run.control.problems} <= {Cause.LEASE}
    assert run.state.pose.x > 1.0


def test_a_power_cycle_ends_the_session() -> None:
    run = Run(world(ErrorSetup()))
    run.run(2.0, 0.2, 0.0)
    run.simulation.inject(Fault(FaultKind.POWER_CYCLE), run.port.now)
    run.run(3.0)
    assert run.control.lost is not None
    assert run.simulation.state(run.port.now).speed == 0
    assert run.state.pose.x > 0.2


def test_the_stop_button_is_named_not_the_stall_that_comes_with_it() -> None:
    run = Run(world(ErrorSetup()))
    run.simulation.inject(Fault(FaultKind.STOP_BUTTON), run.port.now)
    run.run(1.0)
    with pytest.raises(DeviceError, match="STOP button"):
        run.control.drive(0.2, 0.0, 0.3, run.port.now)
    assert [p.cause for p in run.control.problems] == [Cause.STOP_BUTTON]


def test_a_robot_that_counts_in_other_units_is_stopped_before_it_is_far() -> None:
    run = Run(world(ErrorSetup(), model="p3dx-sh"), model="p3dx")
    run.run(1.0)
    with pytest.raises(DeviceError, match=r"its positions change by 0\.49 times .* p3dx-sh"):
        run.run(10.0, 0.3, 0.0)
    run.run(2.0)
    assert [p.cause for p in run.control.problems] == [Cause.SCALE]
    assert run.state.standing
    assert run.start.between(run.ask_true_pose()).x < 2.0


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.slow
def test_no_model_is_suspected_of_another_scale_than_its_own(model: str) -> None:
    run = Run(world(ErrorSetup(slip=0.02, encoder=0.001), model=model))
    for speed, turning in ((0.3, 0.0), (0.0, 0.5), (0.2, 0.3), (-0.1, -0.3), (0.05, 0.1)):
        run.run(5.0, speed, turning)
        run.run(1.0)
    assert Cause.SCALE not in [problem.cause for problem in run.control.problems]
