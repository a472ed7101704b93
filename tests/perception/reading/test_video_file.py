"""Frames out of videos: by number, of files that grow or are cut off, and from a camera."""

import threading
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import cv2
import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.video_file import COUNTED, VideoFrame, VideoFrames
from tests.perception.reading.videos import write_video

COUNT = 12
KINDS = (("a.avi", "MJPG"), ("a.mkv", "FFV1"), ("a.mkv", "mp4v"), ("a.mp4", "mp4v"))


def pictures():
    rng = np.random.default_rng(5)
    small = rng.integers(0, 255, (COUNT, 12, 16), dtype=np.uint8)
    return [cv2.resize(picture, (160, 120)) for picture in small]


def written(folder, name="a.avi", code="MJPG"):
    return write_video(folder / name, pictures(), code)


def frames_of(path, videos):
    found = []
    with suppress(InputError):
        found.extend(videos.read(VideoFrame(str(path), number)) for number in range(COUNT))
    return found


@pytest.mark.parametrize(("name", "code"), KINDS)
def test_frames_come_by_their_numbers_in_any_order(tmp_path, name, code):
    path, videos = written(tmp_path, name, code), VideoFrames()
    for number in (0, 1, 5, 11 if path.suffix in COUNTED else 10, 3):
        frame = videos.read(VideoFrame(str(path), number))
        assert frame.shape == (120, 160)
        apart = [np.abs(frame.astype(int) - picture).mean() for picture in pictures()]
        assert int(np.argmin(apart)) == number


@pytest.mark.parametrize(("name", "code"), [*KINDS[:3], ("a.ts", "mp4v")])
@pytest.mark.parametrize("share", [0.4, 0.7])
def test_of_a_video_that_ends_in_mid_frame_no_frame_is_made_up(tmp_path, name, code, share):
    path = written(tmp_path, name, code)
    videos, right = VideoFrames(), frames_of(path, VideoFrames())
    data = path.read_bytes()
    cut = tmp_path / f"cut{path.suffix}"
    cut.write_bytes(data[: int(share * len(data))])
    found = frames_of(cut, videos)
    np.testing.assert_array_equal(found, right[: len(found)])
    assert share * COUNT / 2 < len(found) < COUNT - 1
    with pytest.raises(InputError, match=f"cut off, after {len(found)}$"):
        videos.read(VideoFrame(str(cut), len(found)))


def test_a_file_that_grows_gives_its_new_frames(tmp_path):
    data, grows = written(tmp_path).read_bytes(), tmp_path / "grows.avi"
    grows.write_bytes(data[: len(data) // 2])
    videos, last = VideoFrames(), VideoFrame(str(grows), 9)
    for _ in range(2):  # the second time without decoding it all again
        with pytest.raises(InputError, match="no whole frame 9"):
            videos.read(last)
    grows.write_bytes(data)
    assert np.abs(videos.read(last).astype(int) - pictures()[9]).mean() < 10


def test_what_is_no_video_is_one_line(tmp_path, capfd):
    (tmp_path / "a.avi").write_bytes(b"no video")
    with pytest.raises(InputError, match="is no video"):
        VideoFrames().read(VideoFrame(str(tmp_path / "a.avi"), 0))
    with pytest.raises(InputError, match="is missing"):
        VideoFrames().read(VideoFrame(str(tmp_path / "b.avi"), 0))
    with pytest.raises(InputError, match="gives no picture"):
        VideoFrames().read(VideoFrame("/dev/no-camera", None))
    assert capfd.readouterr().err == ""


def test_a_camera_takes_a_new_picture_each_time():
    shown = iter(pictures())

    class Camera(BaseHTTPRequestHandler):
        def do_GET(self):
            picture = cv2.imencode(".jpg", next(shown))[1].tobytes()
            self.send_response(200)
            self.send_header("Content-Type", "image/jpeg")
            self.send_header("Content-Length", str(len(picture)))
            self.end_headers()
            self.wfile.write(picture)

        def log_message(self, *args):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Camera)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    camera = VideoFrame(f"http://127.0.0.1:{server.server_port}/frame.jpg", None)
    try:
        for picture in pictures()[:3]:
            assert np.abs(VideoFrames().read(camera).astype(int) - picture).mean() < 10
    finally:
        server.shutdown()
        server.server_close()
