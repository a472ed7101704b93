"""Frames exposed after a given time: the latest frame of a camera, and whether it is frozen.

A video source returns buffered frames first, so a frame requested after a move may show the scene
before it. Here a thread of the source puts every frame as it arrives, and the consumer gives the
time after which its exposure must have begun. The clock is read only for time-outs: arrival times
are those that the source gives.
"""

import threading
import time
from dataclasses import dataclass, replace

import numpy as np

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.perception.types import Image


@dataclass(frozen=True, eq=False, slots=True)
class Frame:
    """A picture, grey (H, W) or blue-green-red (H, W, 3), and when it arrived (monotonic, s).

    `silent` is for how long the camera had given none before, if that was longer than it should be,
    since the frame that was taken before this one (s, 0 if not).
    """

    image: Image
    arrived: float
    silent: float = 0.0


class LatestFrame:
    """The newest frame of a camera, put by one thread and waited for by others.

    `latency` bounds the seconds between the beginning of a frame's exposure and its arrival.
    `noisy` says that two exposures never give the same pixels: then a frame that is like the one
    before it is no new exposure.
    """

    def __init__(self, name: str, *, latency: float, noisy: bool) -> None:
        self._name, self._latency, self._noisy = name, latency, noisy
        self._changed = threading.Condition()
        self._frame: Frame | None = None
        self._fresh = False
        self._repeats = 0
        self._count = 0
        self._silent = 0.0
        self._failure = ""
        self._closed = False

    def put(self, image: Image, arrived: float, silent: float = 0.0) -> None:
        """Takes a frame that arrived, after so many `silent` seconds: see `Frame`."""
        with self._changed:
            before = self._frame
            same = before is not None and np.array_equal(before.image, image)
            self._repeats = self._repeats + 1 if same else 0
            self._fresh = not (same and self._noisy)
            self._frame = Frame(image, arrived)
            self._count += 1
            self._silent = max(self._silent, silent)
            self._failure = ""
            self._changed.notify_all()

    def fail(self, reason: str) -> None:
        """Takes the reason why no frame comes; the next frame takes it back."""
        with self._changed:
            self._failure = reason
            self._changed.notify_all()

    def close(self) -> None:
        """Wakes all waiting threads."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def shot(self, after: float, timeout: float) -> Frame:
        """A frame whose exposure began after the time `after` (monotonic, s).

        DeviceTimeout if none comes within `timeout` seconds: the camera has stopped, or shows the
        same pixels again and again. DeviceError if it was closed.
        """
        deadline = time.monotonic() + timeout
        with self._changed:
            first = self._count
            while (frame := self._taken(after)) is None:
                left = deadline - time.monotonic()
                if left <= 0:
                    raise self._complaint(self._count - first, timeout)
                self._changed.wait(left)
            return frame

    @property
    def count(self) -> int:
        """Frames that arrived so far."""
        with self._changed:
            return self._count

    def taken(self, after: float) -> Frame | None:
        """The newest frame if its exposure began after `after`, else None; does not wait."""
        with self._changed:
            return self._taken(after)

    def complaint(self, since: int, timeout: float) -> DeviceTimeout:
        """What to say where no frame could be taken; `since` was `count` before, s."""
        with self._changed:
            return self._complaint(self._count - since, timeout)

    def _taken(self, after: float) -> Frame | None:
        if self._closed:
            raise DeviceError(f"camera {self._name} was closed")
        frame = self._frame
        if frame is not None and self._fresh and frame.arrived - self._latency >= after:
            silent, self._silent = self._silent, 0.0
            return replace(frame, silent=silent)
        return None

    def _complaint(self, came: int, timeout: float) -> DeviceTimeout:
        if came == 0:
            why = f" ({self._failure})" if self._failure else ""
            return DeviceTimeout(
                f"camera {self._name} sent no picture for {timeout:.1f} s{why}: "
                "check that it is on and that nothing else uses it"
            )
        if not self._fresh:
            return DeviceTimeout(
                f"camera {self._name} is frozen: its last {self._repeats + 1} pictures are the "
                "same to the pixel: switch it off and on"
            )
        return DeviceTimeout(
            f"camera {self._name} sent {came} pictures in {timeout:.1f} s, none of them surely "
            f"taken after the robot stood (its latency may be {self._latency:g} s): wait longer"
        )
