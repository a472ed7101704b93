"""The loop that joins clients to the simulated robot in real time."""

import select
import threading
from collections.abc import Sequence

from facetlog.robot.simulator.aux_port import BAUD_RATES
from facetlog.robot.simulator.endpoints import Endpoint
from facetlog.robot.simulator.live import LiveSimulation

__all__ = ["serve"]

TICK_MS = 5
"""Between two looks at the simulation; it goes on in steps of the same length."""
HEAD_BAUD = BAUD_RATES[0]


def serve(
    live: LiveSimulation,
    robot: Sequence[Endpoint],
    head: Endpoint | None,
    stop: threading.Event,
) -> None:
    """Passes bytes until `stop` is set.

    A robot has one line to its client: where it has several ends, the one that spoke last is
    answered.
    """
    active = robot[0] if robot else None
    ends = [*robot, *([head] if head is not None else [])]
    while not stop.is_set():
        poll = select.poll()
        for end in ends:
            for descriptor in end.descriptors():
                poll.register(descriptor, select.POLLIN)
        poll.poll(TICK_MS)
        with live.now() as (simulation, now):
            for end in robot:
                data = end.read(simulation.firmware.baud)
                if data:
                    active = end
                    simulation.receive(data, now)
            said = simulation.pending(now)
            baud = simulation.firmware.baud
            if head is not None:
                simulation.receive_at_head(head.read(HEAD_BAUD), now)
                head.write(simulation.pending_at_head(now), now, HEAD_BAUD)
        for end in robot:
            end.write(said if end is active else b"", now, baud)
