"""All that `facetlog simulate` runs: the robot in real time, its clients and its camera."""

import json
import logging
import math
import select
import signal
import sys
import threading
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from types import FrameType
from typing import Self

import numpy as np

from facetlog.robot.simulator.camera.camera import Camera
from facetlog.robot.simulator.firmware.firmware import BAUD_RATES
from facetlog.robot.simulator.serving.endpoints import Endpoint, PtyEndpoint, TcpEndpoint
from facetlog.robot.simulator.serving.web import Web
from facetlog.robot.simulator.simulation import OWN_PORT, LiveSimulation, Simulation
from facetlog.robot.simulator.world_file import WorldSetup

TICK_MS = 5
"""Between two looks at the simulation; it goes on in steps of the same length."""
HEAD_BAUD = BAUD_RATES[0]

_LOG = logging.getLogger(__name__)


class ActiveClient:
    """Which end of the robot's line is the active client, where there are several.

    A robot has one client: while that one sends, packets from other ends are ignored, so that they
    cannot stop or close its session.
    """

    def __init__(self, ends: Sequence[Endpoint]) -> None:
        self.end = ends[0] if ends else None
        self._spoke = -math.inf
        self._warned = False

    def takes(self, end: Endpoint, now: float, watchdog: float) -> bool:
        """Return whether bytes from an end are passed to the robot at `now`.

        Another end becomes the active client once this one has been silent for the watchdog's time.
        """
        if end is not self.end:
            if now - self._spoke < watchdog:
                if not self._warned:
                    _LOG.warning("%s: a second client was not heard", end.address)
                self._warned = True
                return False
            self.end, self._warned = end, False
        self._spoke = now
        return True


def serve(
    live: LiveSimulation,
    robot: Sequence[Endpoint],
    head: Endpoint | None,
    stop: threading.Event,
) -> None:
    """Pass bytes until `stop` is set."""
    turn = ActiveClient(robot)
    ends = [*robot, *([head] if head is not None else [])]
    while not stop.is_set():
        poll = select.poll()
        for end in ends:
            for descriptor in end.descriptors():
                poll.register(descriptor, select.POLLIN)
        poll.poll(TICK_MS)
        with live.now() as (simulation, now):
            watchdog = (simulation.firmware.drive.configuration.watchdog_ms or 0) / 1e3
            for end in robot:
                data = end.read(simulation.firmware.baud)
                if data and turn.takes(end, now, watchdog):
                    simulation.receive(data, now)
            said = simulation.pending(now)
            hung_up, simulation.hung_up = simulation.hung_up, False
            baud = simulation.firmware.baud
            if head is not None:
                simulation.receive_at_head(head.read(HEAD_BAUD), now)
                head.write(simulation.take_pending_at_head(now), now, HEAD_BAUD)
        for end in robot:
            end.write(said if end is turn.end else b"", now, baud)
            if hung_up:
                end.hang_up()


SCHEMA = 1
PTY = "pty"
FIRST_PICTURE_S = 60.0  # of a machine that has much else to do
GARBLING_STREAM = 4  # apart from what else is drawn with the same seed


@dataclass(frozen=True, slots=True)
class Addresses:
    """The addresses of the simulated devices."""

    robot: str
    pty: str | None
    head: str
    camera: str
    still: str
    state: str
    faults: str

    @property
    def text(self) -> str:
        parts = asdict(self).items()
        return "  ".join(f"{name} {value}" for name, value in parts if value is not None)

    @property
    def json(self) -> str:
        return json.dumps({"schema": SCHEMA, **asdict(self)})


class Station:
    """Sockets, threads and the camera's process, from its making to its closing.

    DeviceError if an address is in use or cannot be.
    """

    def __init__(self, setup: WorldSetup, *, listen: str, pty: bool, camera: str) -> None:
        self._stop = threading.Event()
        self._setup = setup
        rng = np.random.default_rng([setup.seed, GARBLING_STREAM])
        with ExitStack() as made:
            tcp = TcpEndpoint(listen, "--listen")
            made.callback(tcp.close)
            self._robot: list[Endpoint] = [tcp]
            line = PtyEndpoint(rng) if pty else None
            if line is not None:
                made.callback(line.close)
                self._robot.append(line)
            self._head = _open_head_endpoint(setup, rng)
            if self._head is not None:
                made.callback(self._head.close)
            self._live = LiveSimulation(Simulation(setup))
            pictures = self._camera = Camera(self._live, setup)
            made.callback(pictures.close)
            web = Web(camera, "--camera", self._live, pictures)
            # Streams end when the camera does, and the server waits for them.
            made.callback(web.close)
            made.callback(pictures.close)
            self._made = made.pop_all()
        with self._live.now() as (simulation, _):
            simulation.firmware.drive.name_camera(f"{web.address}/")
        self.addresses = Addresses(
            robot=tcp.address,
            pty=None if line is None else line.address,
            head=_name_head_address(setup) if self._head is None else self._head.address,
            camera=f"{web.address}/",
            still=f"{web.address}/frame.jpg",
            state=f"{web.address}/state",
            faults=f"{web.address}/faults",
        )

    @property
    def camera_process(self) -> int | None:
        """Number of the process that renders, while it runs."""
        return self._camera.process

    def draw_first(self) -> None:
        """Wait until the camera has taken a picture, or for some seconds if it takes none."""
        self._camera.draw_first(FIRST_PICTURE_S)

    def run(self) -> None:
        """Serve until Ctrl-C or SIGTERM; to be called in the main thread."""
        before = {number: signal.signal(number, self._asked) for number in _ENDING}
        sys.stdout.flush()
        try:
            self.serve()
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    def serve(self) -> None:
        """Serve until `stop`."""
        serve(self._live, self._robot, self._head, self._stop)

    def stop(self) -> None:
        """End `serve`."""
        self._stop.set()

    def close(self) -> None:
        self.stop()
        self._made.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _asked(self, _number: int, _frame: FrameType | None) -> None:
        self.stop()


_ENDING = (signal.SIGINT, signal.SIGTERM)


def _name_head_address(setup: WorldSetup) -> str:
    return "none" if setup.head.kind == "none" else setup.head.port


def _open_head_endpoint(setup: WorldSetup, rng: np.random.Generator) -> Endpoint | None:
    if setup.head.kind == "none" or setup.head.port != OWN_PORT:
        return None
    if setup.head.own == PTY:
        return PtyEndpoint(rng)
    return TcpEndpoint(setup.head.own, "head.own in the world file")
