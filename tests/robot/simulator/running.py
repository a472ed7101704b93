"""A whole simulated robot that runs by the clock, for tests that talk to it."""

import json
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import pytest

from facetlog.robot.simulator.station import Station
from facetlog.robot.simulator.world_file import CameraSetup, RobotSetup, WorldSetup
from tests.patience import allowed

ANYWHERE = "127.0.0.1:0"
SMALL = CameraSetup(width=160, height=120, rate=20.0, noise=1.0)
SETUP = WorldSetup(camera=SMALL, robot=RobotSetup(model="p3dx", odometry="perfect"))
LONG = 30.0


def until(found: Callable[[], Any], what: str) -> Any:
    deadline = time.monotonic() + allowed(LONG)
    while time.monotonic() < deadline:
        if value := found():
            return value
        time.sleep(0.01)
    pytest.fail(f"{what} did not come")


class Running:
    """A station that serves on a thread of its own."""

    def __init__(self, setup: WorldSetup = SETUP, *, pty: bool = False) -> None:
        self.station = Station(setup, listen=ANYWHERE, pty=pty, camera=ANYWHERE)
        self.thread = threading.Thread(target=self.station.serve)
        self.thread.start()

    def close(self) -> None:
        self.station.stop()
        self.thread.join()
        self.station.close()

    def get(self, url: str) -> bytes:
        with urllib.request.urlopen(url, timeout=allowed(LONG)) as answer:  # noqa: S310
            return bytes(answer.read())

    def state(self) -> dict[str, Any]:
        return dict(json.loads(self.get(self.station.addresses.state)))

    def fault(self, **fault: object) -> dict[str, Any]:
        request = urllib.request.Request(  # noqa: S310 - loopback
            self.station.addresses.faults, data=json.dumps(fault).encode()
        )
        with urllib.request.urlopen(request, timeout=allowed(LONG)) as answer:  # noqa: S310
            return dict(json.loads(answer.read()))

    def picture(self) -> np.ndarray[Any, np.dtype[np.uint8]]:
        data = np.frombuffer(self.get(self.station.addresses.still), np.uint8)
        return cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)

    def get_picture_or_none(self) -> "np.ndarray[Any, np.dtype[np.uint8]] | None":
        try:
            return self.picture()
        except urllib.error.HTTPError as refused:
            refused.close()
            return None
