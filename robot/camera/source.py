"""Cameras by address: a device, a stream, a still over HTTP, or a file of frames.

A video source returns buffered frames first, so a frame requested after a move may show the scene
before it. So a thread reads devices and streams and puts each frame as it arrives, and the consumer
gives the time after which its exposure must have begun. A still is requested when needed. A file
has no times: each shot is its next frame.
"""

import os
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol
from urllib.parse import urlsplit

import cv2
import numpy as np

from facetlog.errors import DeviceError, DeviceTimeout, InputError
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
        """Take a frame that arrived, after so many `silent` seconds: see `Frame`."""
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
        """Take the reason why no frame comes; the next frame takes it back."""
        with self._changed:
            self._failure = reason
            self._changed.notify_all()

    def close(self) -> None:
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def shot(self, after: float, timeout: float) -> Frame:
        """Return a frame whose exposure began after the time `after` (monotonic, s).

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
        """Return the newest frame if its exposure began after `after`, else None; does not wait."""
        with self._changed:
            return self._taken(after)

    def complaint(self, since: int, timeout: float) -> DeviceTimeout:
        """Return the error of a frame that was not taken; `since` was the `count` before."""
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


# Default latency: the largest number of seconds between the beginning of an exposure and the
# arrival of its frame. A device: an exposure of 1/15 s, two frames in transit at 15 a second,
# decoding. A stream: also the buffers of encoders and of FFmpeg's reader. A still: exposed on
# request, or the frame that the camera took last.
DEVICE_LATENCY, STREAM_LATENCY, STILL_LATENCY = 0.3, 0.8, 0.3
# Of FFmpeg: how long opening a stream, or the next frame, may take. A camera that gives no picture
# for longer than a frame may take is silent.
OPEN_TIMEOUT_MS, READ_TIMEOUT_MS = 5_000, 3_000
# Between two attempts to open a camera that went away, or one over the network that is not there
# yet; for that it is tried so many seconds.
REOPEN_PAUSE = 0.5
OPENING = 10.0
# Between two requests for a still while the camera keeps returning the same one.
STILL_PAUSE = 0.1
STILL_SUFFIXES = (".jpg", ".jpeg", ".png")
STILL_WORDS = ("snapshot", "still")
LARGEST_STILL = 64 * 1024 * 1024
JPEG_START, JPEG_END = b"\xff\xd8\xff", b"\xff\xd9"


class FrameSource(Protocol):
    """A camera."""

    def shot(self, after: float, timeout: float) -> Frame:
        """Return a frame whose exposure began after the time `after` (monotonic, s).

        DeviceTimeout if none comes in `timeout` seconds, DeviceError if the camera is gone.
        """

    def close(self) -> None:
        """Give the camera back."""


def open_camera(
    address: str, *, latency: float | None = None, noisy: bool | None = None
) -> FrameSource:
    """Return the camera at an address, opened; DeviceError if there is none, InputError for no
    address.

    `address` is a number or path of a video device, an rtsp:// or http:// stream, an http:// still
    (its path ends in .jpg, .jpeg or .png, or it asks for a snapshot), or a file: a video, or
    numbered pictures as in `shots/%03d.png`. `latency` is how long after the beginning of its
    exposure a frame may arrive, in seconds. `noisy` says whether two exposures always differ in
    some pixel, as those of a real sensor do; then a camera that repeats itself is known as frozen.
    """
    _silence_opencv()
    live = True if noisy is None else noisy
    if address.isdecimal():
        return _open_device(
            int(address), address, DEVICE_LATENCY if latency is None else latency, live
        )
    parts = urlsplit(address)
    scheme = parts.scheme.lower()
    if scheme in ("http", "https") and _is_still(parts.path, parts.query):
        wait = STILL_LATENCY if latency is None else latency
        return StillSource(address, latency=wait, noisy=live)
    if scheme in ("http", "https", "rtsp", "rtsps", "udp", "tcp", "rtp"):
        wait = STREAM_LATENCY if latency is None else latency
        return VideoSource(
            lambda: _stream(address), address, latency=wait, noisy=live, patience=OPENING
        )
    path = Path(address)
    if path.is_char_device():
        return _open_device(address, address, DEVICE_LATENCY if latency is None else latency, live)
    if path.is_file() or ("%" in path.name and path.parent.is_dir()):
        return FileSource(address)
    raise InputError(
        f"camera {address!r:.120} is neither a device (0, /dev/video0), an address (rtsp://…, "
        "http://…) nor a file that exists"
    )


def _silence_opencv() -> None:
    """Silence OpenCV and FFmpeg on the terminal: this program reports errors itself."""
    # FFmpeg's part reads the variable when it opens its first file; -8 is its "quiet".
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)


def _is_still(path: str, query: str) -> bool:
    wanted = f"{path.rsplit('/', 1)[-1]}?{query}".lower()
    return path.lower().endswith(STILL_SUFFIXES) or any(word in wanted for word in STILL_WORDS)


def _open_device(number: int | str, name: str, latency: float, noisy: bool) -> "VideoSource":
    return VideoSource(
        lambda: cv2.VideoCapture(number, cv2.CAP_V4L2),
        name,
        latency=latency,
        noisy=noisy,
    )


def _stream(address: str) -> cv2.VideoCapture:
    limits = [
        *(cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, OPEN_TIMEOUT_MS),
        *(cv2.CAP_PROP_READ_TIMEOUT_MSEC, READ_TIMEOUT_MS),
    ]
    return cv2.VideoCapture(address, cv2.CAP_FFMPEG, limits)


def _silence(since: float, arrived: float) -> float:
    """Return seconds without a picture until one arrived, 0 where that is as long as one may
    take."""
    seconds = arrived - since
    return seconds if seconds > READ_TIMEOUT_MS / 1000 else 0.0


class VideoSource:
    """A device or a stream, read by a thread of its own; the newest frame is kept.

    `opening` gives an opened capture; it is called again if the camera goes away, and at first for
    so many seconds of `patience`. DeviceError if the camera cannot be opened until then.
    """

    def __init__(
        self,
        opening: Callable[[], cv2.VideoCapture],
        name: str,
        *,
        latency: float,
        noisy: bool = True,
        patience: float = 0.0,
    ) -> None:
        deadline = time.monotonic() + patience
        self._opening, self._name = opening, name
        self._newest = LatestFrame(name, latency=latency, noisy=noisy)
        self._ending = threading.Event()
        capture = opening()
        while not capture.isOpened() and time.monotonic() < deadline:
            capture.release()
            time.sleep(REOPEN_PAUSE)
            capture = opening()
        if not capture.isOpened():
            capture.release()
            raise DeviceError(
                f"camera {name} cannot be opened: check its address, that it is on, and that "
                "nothing else uses it"
            )
        self._thread = threading.Thread(
            target=self._read, args=(capture,), name=f"camera {name}", daemon=True
        )
        self._thread.start()

    def shot(self, after: float, timeout: float) -> Frame:
        """Return a frame whose exposure began after `after`; see `LatestFrame.shot`."""
        return self._newest.shot(after, timeout)

    def close(self) -> None:
        """End the thread, which may take as long as a frame may take, and free the camera."""
        self._ending.set()
        self._newest.close()
        self._thread.join((OPEN_TIMEOUT_MS + READ_TIMEOUT_MS) / 1000)

    def _read(self, capture: cv2.VideoCapture) -> None:
        last = time.monotonic()
        try:
            while not self._ending.is_set():
                # The time is taken before decoding, which is not part of the camera's latency.
                got = capture.grab()
                arrived = time.monotonic()
                done, image = capture.retrieve() if got else (False, None)
                if done and image is not None:
                    silent = _silence(last, arrived)
                    self._newest.put(np.asarray(image, dtype=np.uint8), arrived, silent)
                    last = arrived
                    continue
                self._newest.fail("the connection to it is lost")
                capture.release()
                if self._ending.wait(REOPEN_PAUSE):
                    return
                capture = self._opening()
        finally:
            capture.release()


class StillSource:
    """A camera that gives one picture for each request over HTTP."""

    def __init__(self, address: str, *, latency: float, noisy: bool = True) -> None:
        self._address = address
        self._newest = LatestFrame(address, latency=latency, noisy=noisy)
        self._last_fault = ""
        deadline = time.monotonic() + OPENING
        first = self._fetch(OPENING)
        while first is None and time.monotonic() < deadline:
            time.sleep(REOPEN_PAUSE)
            first = self._fetch(max(deadline - time.monotonic(), STILL_PAUSE))
        if first is None:
            raise DeviceError(
                f"camera {address} gives no picture ({self._last_fault}): check its address and "
                "that it is on"
            )
        self._newest.put(first, time.monotonic())

    def shot(self, after: float, timeout: float) -> Frame:
        """Return a picture requested after `after`; see `LatestFrame.shot`."""
        began = time.monotonic()
        deadline = began + timeout
        before = self._newest.count
        while True:
            image = self._fetch(max(deadline - time.monotonic(), STILL_PAUSE))
            if image is None:
                self._newest.fail(self._last_fault)
            else:
                arrived = time.monotonic()
                self._newest.put(image, arrived, _silence(began, arrived))
                began = arrived
            if (frame := self._newest.taken(after)) is not None:
                return frame
            if time.monotonic() + STILL_PAUSE >= deadline:
                raise self._newest.complaint(before, timeout)
            time.sleep(STILL_PAUSE)

    def close(self) -> None:
        """Close the camera; no connection is open between two requests."""
        self._newest.close()

    def _fetch(self, timeout: float) -> Image | None:
        """Return the picture; None if there is none, and `_last_fault` says why."""
        try:
            # The scheme is http or https: open_camera looks at it.
            with urllib.request.urlopen(self._address, timeout=timeout) as answer:  # noqa: S310
                data = answer.read(LARGEST_STILL)
        except (OSError, ValueError) as exc:
            reason = exc.reason if isinstance(exc, urllib.error.URLError) else exc
            self._last_fault = str(reason) or type(exc).__name__
            return None
        if data.startswith(JPEG_START) and not data.rstrip(b"\0").endswith(JPEG_END):
            self._last_fault = "its picture is cut off"
            return None
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR) if data else None
        if image is None:
            self._last_fault = "what it sends is no picture"
            return None
        return np.asarray(image, dtype=np.uint8)


class FileSource:
    """A video or numbered pictures, one frame for each shot, in their order."""

    def __init__(self, address: str) -> None:
        self._address = address
        self._capture = cv2.VideoCapture(address)
        if not self._capture.isOpened():
            raise InputError(f"camera file {address} cannot be read: give a video or pictures")

    def shot(self, after: float, timeout: float) -> Frame:  # noqa: ARG002 - a file does not wait
        """Return the next frame; `after` is its time. DeviceError at the end of the file."""
        done, image = self._capture.read()
        if not done or image is None:
            raise DeviceError(f"camera file {self._address} has no more frames: give a longer one")
        return Frame(np.asarray(image, dtype=np.uint8), after)

    def close(self) -> None:
        self._capture.release()
