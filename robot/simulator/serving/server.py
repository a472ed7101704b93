"""The loop that joins clients to the simulated robot in real time."""

import logging
import math
import select
import threading
from collections.abc import Sequence

from facetlog.robot.simulator.firmware.aux_port import BAUD_RATES
from facetlog.robot.simulator.serving.endpoints import Endpoint
from facetlog.robot.simulator.serving.live import LiveSimulation

__all__ = ["ActiveClient", "serve"]

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
        """Whether bytes from an end are passed to the robot at `now`.

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
    """Passes bytes until `stop` is set."""
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
                head.write(simulation.pending_at_head(now), now, HEAD_BAUD)
        for end in robot:
            end.write(said if end is turn.end else b"", now, baud)
            if hung_up:
                end.hang_up()
