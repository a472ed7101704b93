"""The drivers by the clock, over a socket to a simulated head."""

import math
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import pytest

from facetlog.robot.byte_line import PortLine
from facetlog.robot.head.canon import VC_C4
from facetlog.robot.head.open_head import open_head
from facetlog.robot.simulator.device import Device
from facetlog.robot.simulator.heads.canon import CanonHead
from facetlog.robot.simulator.heads.sony import SonyHead

PATIENCE_S = 60.0


class SocketPort:
    """A port over a socket."""

    def __init__(self, end: socket.socket) -> None:
        self.end = end

    def read(self, timeout: float, /) -> bytes:
        self.end.settimeout(max(timeout, 0.001))
        try:
            return self.end.recv(100)
        except TimeoutError:
            return b""

    def write(self, data: bytes, /) -> None:
        self.end.sendall(data)

    def close(self) -> None:
        self.end.close()


@contextmanager
def served(device: Device) -> Iterator[PortLine]:
    """A line to the device, which runs by the clock meanwhile."""
    ours, theirs = socket.socketpair()
    ended = threading.Event()

    def serve() -> None:
        theirs.settimeout(0.002)
        while not ended.is_set():
            with suppress(TimeoutError):
                device.receive(theirs.recv(100), time.monotonic())
            if said := device.pending(time.monotonic()):
                theirs.sendall(said)

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield PortLine(SocketPort(ours))
    finally:
        ended.set()
        thread.join()
        theirs.close()
        ours.close()


@pytest.mark.parametrize(
    ("kind", "device"),
    [("sony-evi-d30", SonyHead()), ("canon-vc-c4", CanonHead(VC_C4, powered=True))],
)
@pytest.mark.slow
def test_a_head_is_started_and_turned_by_the_clock(kind: str, device: Device) -> None:
    with served(device) as line:
        head = open_head(kind, line)
        head.start()
        state = head.look(math.radians(20), math.radians(-10), timeout=PATIENCE_S)
        now = time.monotonic()
        assert device.angles(now)[:2] == pytest.approx((state.pan, state.tilt), abs=1e-9)
        assert state.pan == pytest.approx(math.radians(20), abs=math.radians(0.06))
        assert state.reported
        assert state.at <= now
        head.close()
