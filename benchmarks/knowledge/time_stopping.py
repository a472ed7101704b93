"""How far does a robot at 0.5 m/s go on when what drives it dies, is suspended or is cut off?

A simulated p3dx and a client in a process of its own, both in real time. From the moment of the
fault on the simulation's own clock and true state are sampled every 2 ms: `unnoticed` is the way at
full speed until the robot begins to brake, `way` all of it until it stands, `seconds` the time that
takes. What is wanted: 0.2 m and the way of braking.
"""

import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.common import Report, Row, Settings, Table
from facetlog.robot.simulator.faults import Fault, FaultKind
from facetlog.robot.simulator.simulation import SimulationState
from facetlog.robot.simulator.station import Station
from facetlog.robot.simulator.world_file import (
    CameraSetup,
    HeadSetup,
    RobotSetup,
    SceneSetup,
    WorldSetup,
)

NAME = "time_stopping"
RUNS = 5
SPEED = 0.5
"""m/s: the most that `facetlog collect` drives at."""
BRAKES_BELOW = 0.99
"""Share of the speed below which the robot counts as braking."""
STANDS = 1e-3
SAMPLED_EVERY = 0.002
LONGEST = 6.0
"""Seconds to wait for it to stand: the watchdog's 2, and 0.5 m/s at 0.3 m/s²."""
ANYWHERE = "127.0.0.1:0"
CLIENT = """
import sys, time
from facetlog.robot.pioneer.limits import Limits
from facetlog.robot.pioneer.pioneer import Pioneer
robot = Pioneer.connect(sys.argv[1], limits=Limits(speed=float(sys.argv[2])))
robot.enable_motors()
told = False
while True:
    robot.drive(float(sys.argv[2]), 0.0)
    if not told and robot.state.speed > 0.99 * float(sys.argv[2]):
        print("at full speed", flush=True)
        told = True
        if sys.argv[3] == "hangs":
            time.sleep(1000.0)
    time.sleep(0.1)
"""


@dataclass(frozen=True, slots=True)
class _Stop:
    """What a robot did after a fault; metres and seconds."""

    unnoticed: float
    way: float
    seconds: float


class _Simulated:
    """A simulated robot that is served, with its true state sampled all along."""

    def __init__(self, seed: int) -> None:
        setup = WorldSetup(
            scene=SceneSetup(world="empty"),
            robot=RobotSetup(model="p3dx", odometry="perfect"),
            head=HeadSetup(kind="none"),
            camera=CameraSetup(width=160, height=120),
            seed=seed,
        )
        self.station = Station(setup, listen=ANYWHERE, pty=False, camera=ANYWHERE)
        self.samples: list[SimulationState] = []
        self._done = threading.Event()
        self._threads = [
            threading.Thread(target=self.station.serve),
            threading.Thread(target=self._sample),
        ]
        for thread in self._threads:
            thread.start()

    def now(self) -> SimulationState:
        with self.station._live.now() as (simulation, at):
            return simulation.state(at)

    def hang_up(self) -> None:
        with self.station._live.now() as (simulation, at):
            simulation.inject(Fault(FaultKind.HUNG_UP), at)

    def close(self) -> None:
        self._done.set()
        self.station.stop()
        for thread in self._threads:
            thread.join()
        self.station.close()

    def _sample(self) -> None:
        while not self._done.wait(SAMPLED_EVERY):
            self.samples.append(self.now())


def _signalled(number: signal.Signals) -> Callable[[_Simulated, subprocess.Popen[bytes]], None]:
    return lambda _simulated, client: client.send_signal(number)


FAULTS: dict[str, Callable[[_Simulated, subprocess.Popen[bytes]], None]] = {
    "the program is killed (SIGKILL)": _signalled(signal.SIGKILL),
    "the program is suspended (SIGSTOP)": _signalled(signal.SIGSTOP),
    "the thread that drives hangs": lambda _simulated, _client: None,
    "the TCP connection is closed": lambda simulated, _client: simulated.hang_up(),
}


def measure(settings: Settings) -> Report:
    """Measure every fault, at another phase of the client's cycle each time."""
    runs = settings.seeds(RUNS)
    rows: list[Row] = []
    for what, fault in FAULTS.items():
        stops = [_stopped(what, fault, seed, (seed % RUNS) / RUNS) for seed in runs]
        row: dict[str, str | float] = {"fault": what}
        for name in ("unnoticed", "way", "seconds"):
            values = sorted(getattr(stop, name) for stop in stops)
            row[f"{name}, median"] = round(values[len(values) // 2], 3)
            row[f"{name}, worst"] = round(values[-1], 3)
        rows.append(row)
    return Report(
        NAME,
        (Table("Metres and seconds from the fault on", tuple(rows)),),
        {"runs": len(runs), "first seed": runs.start, "m/s": SPEED},
    )


def _stopped(
    what: str,
    fault: Callable[[_Simulated, subprocess.Popen[bytes]], None],
    seed: int,
    phase: float,
) -> _Stop:
    """Return one run; the fault comes at a phase of the 0.1 s in which the client drives anew."""
    simulated = _Simulated(seed)
    how = "hangs" if "hangs" in what else "drives"
    arguments = [sys.executable, "-c", CLIENT, simulated.station.addresses.robot, str(SPEED), how]
    client = subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    try:
        assert client.stdout is not None
        assert client.stdout.readline() == b"at full speed\n"
        if how != "hangs":
            time.sleep(0.2 + 0.1 * phase)
        before = simulated.now()
        fault(simulated, client)
        end = time.monotonic() + LONGEST
        while time.monotonic() < end and abs(simulated.now().speed) > STANDS:
            time.sleep(SAMPLED_EVERY)
        time.sleep(0.3)
    finally:
        client.kill()
        client.wait()
        client.stdout and client.stdout.close()
        simulated.close()
    after = [s for s in simulated.samples if s.at >= before.at]
    full = [s for s in after if abs(s.speed) >= BRAKES_BELOW * before.speed]
    moving = [s for s in after if abs(s.speed) > STANDS]
    last_full, last = (full or [before])[-1], (moving or [before])[-1]
    return _Stop(
        last_full.truth.x - before.truth.x,
        last.truth.x - before.truth.x,
        last.at - before.at,
    )
