"""Pictures out of a video: frames of a file by their numbers, or what a camera shows now."""

import os
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from facetlog.errors import InputError
from facetlog.perception.types import Image
from facetlog.safe_read import check_regular

COUNTED = (".avi", ".mp4", ".m4v", ".mov")
"""Kinds of files that state their number of frames: of others the last frame is never used."""


@dataclass(frozen=True, slots=True)
class VideoFrame:
    """Frame `number` (from 0) of the video file `source`; without a number the picture that the
    camera `source` (a device or the address of a stream) takes next.
    """

    source: str
    number: int | None

    def __str__(self) -> str:
        return self.source if self.number is None else f"frame {self.number} of {self.source}"

    def name(self, index: int) -> str:
        """Return its name in messages: by its number, for a camera by the place of its pose."""
        return f"{Path(self.source).name}#{index if self.number is None else self.number}"


class VideoFrames:
    """Reads frames; in rising order each is decoded once."""

    def __init__(self) -> None:
        # This program reports errors itself. FFmpeg's part reads the variable when it opens its
        # first file; -8 is its "quiet".
        os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
        cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
        self._source = ""
        self._capture: cv2.VideoCapture | None = None
        # The frame that comes next, and whether it is there.
        self._next, self._there = 0, False
        # Of files that ended: after how many frames, and how large they were then.
        self._ended: dict[str, tuple[int, int]] = {}

    def read(self, frame: VideoFrame) -> Image:
        """Return the frame as stored, grey, (H, W) uint8; InputError if there is none (yet)."""
        image = self._taken(frame) if frame.number is None else self._numbered(frame)
        grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        found = np.ascontiguousarray(grey, dtype=np.uint8)
        found.setflags(write=False)
        return found

    def _taken(self, frame: VideoFrame) -> cv2.typing.MatLike:
        # Opened for each picture: one that waits in a queue shows where the camera was before.
        camera = int(frame.source) if frame.source.isdecimal() else frame.source
        capture = cv2.VideoCapture(camera)
        try:
            taken, image = capture.read()
        finally:
            capture.release()
        if not taken:
            raise InputError(f"camera {frame.source} gives no picture: is it connected and free?")
        return image

    def _numbered(self, frame: VideoFrame) -> cv2.typing.MatLike:
        number, size = frame.number or 0, _size(frame.source)
        count, size_then = self._ended.get(frame.source, (0, -1))
        if size == size_then and number >= count:
            raise _make_missing_frame_error(frame, count)
        if self._capture is None or self._source != frame.source or self._next > number:
            self.close()
            self._capture, self._source, self._next = _opened(frame.source), frame.source, 0
            self._there = self._capture.grab()
        image: cv2.typing.MatLike = np.zeros(0)
        while self._next <= number:
            _, image = self._capture.retrieve() if self._there else (False, image)
            whole, self._there = self._there, self._capture.grab()
            stated = self._next + 1 == _read_stated_count(frame.source, self._capture)
            # In a truncated file the decoder invents the rest of the last frame.
            if not whole or not (self._there or stated):
                self._ended[frame.source] = (self._next, size)
                self.close()  # it would not find what is written afterwards
                raise _make_missing_frame_error(frame, self._next)
            self._next += 1
        return image

    def close(self) -> None:
        """Close the file."""
        if self._capture is not None:
            self._capture.release()
        self._capture = None


def read_frame_count(source: str) -> int:
    """Return how many frames a video file states, 0 if it does not; InputError if it is none."""
    _size(source)
    VideoFrames()  # which makes FFmpeg quiet
    capture = _opened(source)
    try:
        return _read_stated_count(source, capture)
    finally:
        capture.release()


def _size(source: str) -> int:
    check_regular(Path(source))
    try:
        return Path(source).stat().st_size
    except FileNotFoundError as exc:
        raise InputError(f"video {source} is missing: put it there") from exc
    except (OSError, ValueError) as exc:
        raise InputError(f"video {source!r} cannot be read: {exc}") from exc


def _opened(source: str) -> cv2.VideoCapture:
    capture = cv2.VideoCapture(source, cv2.CAP_FFMPEG)
    if not capture.isOpened():
        raise InputError(f"{source} is no video that can be read, or its end was never written")
    # Not turned by what the file says of it: poses and intrinsics belong to frames as stored.
    capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
    return capture


def _read_stated_count(source: str, capture: cv2.VideoCapture) -> int:
    """Return how many frames the file states; of other kinds OpenCV only guesses it."""
    if Path(source).suffix.lower() not in COUNTED:
        return 0
    return round(capture.get(cv2.CAP_PROP_FRAME_COUNT))


def _make_missing_frame_error(frame: VideoFrame, count: int) -> InputError:
    return InputError(
        f"{frame.source} has no whole frame {frame.number}: it ends, or is cut off, after {count}"
    )
