"""Cameras by address: a device, a stream, a still over HTTP, or a file of frames.

Devices and streams are read by a thread that takes every frame as soon as it is there, so that
none grows old in a buffer. A still is requested when needed. A file has no times: each shot is its
next frame.
"""

import os
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Protocol
from urllib.parse import urlsplit

import cv2
import numpy as np

from facetlog.errors import DeviceError, InputError
from facetlog.perception.types import Image
from facetlog.robot.camera.freshness import Frame, LatestFrame

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
    """What takes pictures."""

    def shot(self, after: float, timeout: float) -> Frame:
        """A frame whose exposure began after the time `after` (monotonic, s).

        DeviceTimeout if none comes in `timeout` seconds, DeviceError if the camera is gone.
        """

    def close(self) -> None:
        """Gives the camera back."""


def open_camera(
    address: str, *, latency: float | None = None, noisy: bool | None = None
) -> FrameSource:
    """The camera at an address, opened; DeviceError if there is none, InputError for no address.

    `address` is a number or path of a video device, an rtsp:// or http:// stream, an http:// still
    (its path ends in .jpg, .jpeg or .png, or it asks for a snapshot), or a file: a video, or
    numbered pictures as in `shots/%03d.png`. `latency` is how long after the beginning of its
    exposure a frame may arrive, in seconds. `noisy` says whether two exposures always differ in
    some pixel, as those of a real sensor do; then a camera that repeats itself is known as frozen.
    """
    _quieten()
    live = True if noisy is None else noisy
    if address.isdecimal():
        return _device(int(address), address, DEVICE_LATENCY if latency is None else latency, live)
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
        return _device(address, address, DEVICE_LATENCY if latency is None else latency, live)
    if path.is_file() or ("%" in path.name and path.parent.is_dir()):
        return FileSource(address)
    raise InputError(
        f"camera {address!r:.120} is neither a device (0, /dev/video0), an address (rtsp://…, "
        "http://…) nor a file that exists"
    )


def _quieten() -> None:
    """Silences OpenCV and FFmpeg on the terminal: this program reports errors itself."""
    # FFmpeg's part reads the variable when it opens its first file; -8 is its "quiet".
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)


def _is_still(path: str, query: str) -> bool:
    wanted = f"{path.rsplit('/', 1)[-1]}?{query}".lower()
    return path.lower().endswith(STILL_SUFFIXES) or any(word in wanted for word in STILL_WORDS)


def _device(number: int | str, name: str, latency: float, noisy: bool) -> "VideoSource":
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
    """Seconds without a picture until one arrived, 0 where that is as long as one may take."""
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
        """A frame whose exposure began after `after`; see `LatestFrame.shot`."""
        return self._newest.shot(after, timeout)

    def close(self) -> None:
        """Ends the thread, which may take as long as a frame may take, and frees the camera."""
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
        """A picture requested after `after`; see `LatestFrame.shot`."""
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
        """Nothing is held between two requests."""
        self._newest.close()

    def _fetch(self, timeout: float) -> Image | None:
        """The picture; None if there is none, and `_last_fault` says why."""
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
        """The next frame; `after` is its time. DeviceError at the end of the file."""
        done, image = self._capture.read()
        if not done or image is None:
            raise DeviceError(f"camera file {self._address} has no more frames: give a longer one")
        return Frame(np.asarray(image, dtype=np.uint8), after)

    def close(self) -> None:
        """Closes the file."""
        self._capture.release()
