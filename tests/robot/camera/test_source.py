"""Cameras of each kind: a capture that is scripted, servers on this machine, and files."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from facetlog.errors import DeviceError, DeviceTimeout, InputError
from facetlog.perception.types import Image
from facetlog.robot.camera import source as source_module
from facetlog.robot.camera.source import FileSource, VideoSource, open_camera
from tests.patience import allowed

PATIENCE = 30.0


def _picture(number: int) -> Image:
    """Noise, with its number as the grey of its upper left quarter (20 greys a step)."""
    image = np.random.default_rng(number).integers(0, 30, (48, 64)).astype(np.uint8)
    image[:24, :32] = 20 * (number % 12) + 10
    return image


def _number(image: Image) -> int:
    grey = image if image.ndim == 2 else image[:, :, 0]
    return round((float(grey[:22, :30].mean()) - 10) / 20)


def _jpeg(number: int) -> bytes:
    _, data = cv2.imencode(".jpg", _picture(number))
    return data.tobytes()


class ScriptedCapture:
    """A capture with a buffer of old frames: each grab takes 5 ms and the next frame."""

    def __init__(self, frames: Iterator[Image | None]) -> None:
        self.frames, self.next, self.released = frames, None, False

    def isOpened(self) -> bool:
        return not self.released

    def grab(self) -> bool:
        time.sleep(0.005)
        self.next = next(self.frames, None)  # type: ignore[assignment]
        return self.next is not None

    def retrieve(self) -> tuple[bool, Image | None]:
        return True, self.next

    def release(self) -> None:
        self.released = True


def _endless(start: int = 0) -> Iterator[Image]:
    number = start
    while True:
        yield _picture(number)
        number += 1


def _source(capture: ScriptedCapture, latency: float = 0.0) -> VideoSource:
    opening: Callable[[], Any] = lambda: capture  # noqa: E731
    return VideoSource(opening, "scripted", latency=latency)


def test_a_video_source_gives_what_came_after_not_what_was_buffered() -> None:
    source = _source(ScriptedCapture(_endless()))
    try:
        after = time.monotonic() + 0.1
        frame = source.shot(after, PATIENCE)
        assert frame.arrived >= after
    finally:
        source.close()


def test_a_camera_that_was_away_says_for_how_long_no_picture_came(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pause = source_module.REOPEN_PAUSE
    monkeypatch.setattr(source_module, "READ_TIMEOUT_MS", 1000 * pause)
    lost = ScriptedCapture(iter([_picture(1), None]))
    opened = iter([lost, ScriptedCapture(_endless(2))])
    opening: Callable[[], Any] = lambda: next(opened)  # noqa: E731
    source = VideoSource(opening, "scripted", latency=0.0)
    try:
        deadline = time.monotonic() + PATIENCE
        while not lost.released and time.monotonic() < deadline:
            time.sleep(0.01)
        assert source.shot(time.monotonic(), PATIENCE).silent > pause
    finally:
        source.close()


class Camera:
    """An HTTP camera: / is MJPEG, /frame.jpg a still; `held` keeps its picture as it is, and while
    it `starts` it has none, nor for so many `refusals`.
    """

    def __init__(self) -> None:
        self.held = False
        self.cut = False
        self.starts = False
        self.refusals = 0
        self.count = 0
        self.url = ""

    def picture(self) -> bytes:
        self.count += not self.held
        data = _jpeg(self.count)
        return data[:-40] if self.cut else data


@contextmanager
def _serving() -> Iterator[Camera]:
    camera = Camera()
    ending = threading.Event()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            if camera.starts or camera.refusals:
                camera.refusals = max(camera.refusals - 1, 0)
                self.send_error(503)
                return
            if self.path != "/":
                data = camera.picture()
                self.send_response(200)
                self.send_header("Content-Type", "image/jpeg")
                self.send_header("Content-Length", str(len(data)))
                self.end_headers()
                self.wfile.write(data)
                return
            self.send_response(200)
            self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
            self.end_headers()
            try:
                while not ending.wait(0.05):
                    data = camera.picture()
                    head = f"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(data)}\r\n"
                    self.wfile.write(head.encode() + b"\r\n" + data + b"\r\n")
            except OSError:
                return

        def log_message(self, *_: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, args=(0.02,))
    thread.start()
    camera.url = f"http://127.0.0.1:{server.server_port}"
    try:
        yield camera
    finally:
        ending.set()
        server.shutdown()
        thread.join()
        server.server_close()


@pytest.mark.slow
def test_an_mjpeg_stream_is_read_and_its_new_frames_distinguished_from_old_ones() -> None:
    with _serving() as camera:
        source = open_camera(camera.url + "/", latency=0.2)
        try:
            frame = source.shot(time.monotonic(), PATIENCE)
            assert frame.image.shape[:2] == (48, 64)
            camera.held = True
            with pytest.raises(DeviceTimeout, match="frozen"):
                source.shot(time.monotonic() + 0.5, 1.5)
            camera.held = False
            after = time.monotonic()
            frame = source.shot(after, PATIENCE)
            assert frame.arrived - 0.2 >= after
        finally:
            source.close()


def test_a_still_that_comes_late_says_how_late(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(source_module, "READ_TIMEOUT_MS", 1000 * source_module.STILL_PAUSE)
    with _serving() as camera:
        source = open_camera(camera.url + "/frame.jpg", latency=0.0)
        camera.refusals = 2
        assert source.shot(time.monotonic(), PATIENCE).silent > 2 * source_module.STILL_PAUSE


def test_a_still_that_never_changes_is_frozen() -> None:
    with _serving() as camera:
        source = open_camera(camera.url + "/snapshot", latency=0.0)
        camera.held = True
        started = time.monotonic()
        with pytest.raises(DeviceTimeout, match="frozen"):
            source.shot(time.monotonic(), 0.5)
        assert time.monotonic() - started < allowed(0.5)


def test_a_still_that_is_cut_off_is_not_taken() -> None:
    with _serving() as camera:
        source = open_camera(camera.url + "/frame.jpg", latency=0.0)
        camera.cut = True
        with pytest.raises(DeviceTimeout, match="its picture is cut off"):
            source.shot(time.monotonic(), 0.3)


@pytest.fixture
def short_opening(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(source_module, "OPENING", 0.2)
    monkeypatch.setattr(source_module, "REOPEN_PAUSE", 0.1)


@pytest.mark.parametrize("address", ["/frame.jpg", "/"])
def test_a_camera_over_the_network_may_come_a_little_later(
    address: str,
) -> None:
    with _serving() as camera:
        camera.starts = True
        threading.Timer(0.5, setattr, (camera, "starts", False)).start()
        source = open_camera(camera.url + address, latency=0.0)
        assert source.shot(time.monotonic(), PATIENCE).image.size
        source.close()


@pytest.mark.usefixtures("short_opening")
def test_a_still_camera_that_is_not_there_is_reported() -> None:
    with _serving() as camera:
        url = camera.url
    with pytest.raises(DeviceError, match=r"gives no picture \(.*refused.*\): check"):
        open_camera(url + "/frame.jpg")


def test_numbered_pictures_are_taken_one_for_each_shot(tmp_path: Path) -> None:
    for number in (1, 2):
        cv2.imwrite(str(tmp_path / f"shot{number:02d}.png"), _picture(number))
    source = open_camera(str(tmp_path / "shot%02d.png"))
    assert isinstance(source, FileSource)
    assert [_number(source.shot(at, 1.0).image) for at in (5.0, 6.0)] == [1, 2]
    with pytest.raises(DeviceError, match="has no more frames"):
        source.shot(7.0, 1.0)
    source.close()


def test_what_is_no_camera_is_reported() -> None:
    with pytest.raises(InputError, match="'nothing' is neither a device"):
        open_camera("nothing")


def test_a_missing_device_is_reported_without_chatter(
    capfd: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(DeviceError, match="camera 97 cannot be opened"):
        open_camera("97")
    assert capfd.readouterr().err == ""
