"""The simulated camera in real time: takes pictures while clients watch, and keeps the newest."""

import logging
import math
import socket
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection

from facetlog.one_thread import ONE_THREAD
from facetlog.python_process import make_importing_environment, make_module_command
from facetlog.robot.simulator.camera.process import (
    encode_setup,
    encode_viewpoints,
    measure_smear_px,
)
from facetlog.robot.simulator.camera.viewpoint import Viewpoint, make_camera
from facetlog.robot.simulator.simulation import LiveSimulation
from facetlog.robot.simulator.world_file import WorldSetup

LATEST = 0.5
"""Seconds after its exposure that a picture is still sent if the camera has moved since."""
OUTDATED_PX = 0.5
"""By so much the picture must have moved meanwhile for that."""
IDLE = 0.05  # seconds between two looks whether somebody looks
RESTART_PAUSE = 1.0
ENDING = 2.0
DARKROOM = "facetlog.robot.simulator.camera.process"

_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Shot:
    """A JPEG, its number, and when its exposure began: in the simulation, and monotonic."""

    jpeg: bytes
    number: int
    at: float
    exposed: float


class Camera:
    """Takes pictures in a thread of its own; they are rendered in a process of its own."""

    def __init__(self, live: LiveSimulation, setup: WorldSetup) -> None:
        self._live, self._setup = live, setup
        self._changed = threading.Condition()
        self._newest: Shot | None = None
        self._watchers = 0
        self._stop = threading.Event()
        self._process: subprocess.Popen[bytes] | None = None
        self._line: Connection | None = None
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End thread and process."""
        self._stop.set()
        with self._changed:
            self._changed.notify_all()
        self._end_process()  # or its answer would be waited for
        self._thread.join()

    @property
    def process(self) -> int | None:
        """Number of the process that renders, while it runs."""
        process = self._process
        return None if process is None else process.pid

    @property
    def closed(self) -> bool:
        """Whether there will be no more pictures."""
        return self._stop.is_set()

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Keep pictures coming while at least one client looks."""
        with self._changed:
            self._watchers += 1
        try:
            yield
        finally:
            with self._changed:
                self._watchers -= 1

    def draw_first(self, timeout: float) -> bool:
        """Take a picture that nobody looks at, so that the first client waits for no process to
        start; whether it came in so many seconds."""
        with self.watching():
            return self.wait_for_shot(0, 0.0, timeout) is not None

    def wait_for_shot(self, number: int, exposed: float, timeout: float) -> Shot | None:
        """Return the newest after `number` whose exposure began after `exposed`; None if none
        comes.
        """
        deadline = time.monotonic() + timeout
        with self._changed:
            while not self._stop.is_set():
                shot = self._newest
                if shot is not None and shot.number > number and shot.exposed >= exposed:
                    return shot
                left = deadline - time.monotonic()
                if left <= 0:
                    return None
                self._changed.wait(left)
        return None

    def _run(self) -> None:
        try:
            self._take_shots()
        finally:
            self._end_process()

    def _take_shots(self) -> None:
        due = time.monotonic()
        while not self._stop.is_set():
            with self._changed:
                watched = self._watchers > 0
            wait = due - time.monotonic() if watched else IDLE
            if wait > 0 and self._stop.wait(wait):
                return
            if watched:
                due = max(due + 1 / self._setup.camera.rate, time.monotonic())
                self._take()

    def _take(self) -> None:
        exposed = time.monotonic()
        with self._live.now() as (simulation, at):
            start = simulation.viewpoint(at)
            frozen, silent = simulation.camera_frozen, simulation.camera_silent
        if silent:
            return
        if frozen and self._newest is not None:
            self._publish(self._newest.jpeg, at, exposed)
            return
        self._stop.wait(self._setup.camera.exposure)
        jpeg = self._request_jpeg(start, self._viewpoint())
        if jpeg is not None and not self._is_outdated(start, exposed):
            self._publish(jpeg, at, exposed)

    def _viewpoint(self) -> Viewpoint:
        with self._live.now() as (simulation, at):
            return simulation.viewpoint(at)

    def _is_outdated(self, start: Viewpoint, exposed: float) -> bool:
        """Return whether the picture is late and the camera has moved on since."""
        if time.monotonic() - exposed < LATEST:
            return False
        camera, mount = make_camera(self._setup.camera), self._setup.mount.mount
        then, now = start.camera_pose(mount), self._viewpoint().camera_pose(mount)
        moved = measure_smear_px(camera, then, now)
        return not math.isfinite(moved) or moved > OUTDATED_PX

    def _publish(self, jpeg: bytes, at: float, exposed: float) -> None:
        with self._changed:
            number = self._newest.number + 1 if self._newest is not None else 1
            self._newest = Shot(jpeg, number, at, exposed)
            self._changed.notify_all()

    def _request_jpeg(self, start: Viewpoint, end: Viewpoint) -> bytes | None:
        try:
            line = self._line or self._start_process()
            line.send_bytes(encode_viewpoints(start, end))
            return line.recv_bytes()
        except (EOFError, OSError):
            if not self._stop.is_set():
                _LOG.warning("the camera's process ended: it is started again")
            self._end_process()
            self._stop.wait(RESTART_PAUSE)
            return None

    def _start_process(self) -> Connection:
        ours, theirs = socket.socketpair()
        with theirs:
            environment = {**make_importing_environment(), **dict.fromkeys(ONE_THREAD, "1")}
            descriptor = theirs.fileno()
            self._process = subprocess.Popen(
                make_module_command(DARKROOM, str(descriptor)),
                pass_fds=[descriptor],
                env=environment,
                process_group=0,  # Ctrl-C is the server's matter
            )
        self._line = Connection(ours.detach())
        self._line.send_bytes(encode_setup(self._setup))
        return self._line

    def _end_process(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait(ENDING)
        line, self._line = self._line, None
        if line is not None:
            line.close()
