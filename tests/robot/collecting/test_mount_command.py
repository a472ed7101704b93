"""`facetlog mount` with the simulated robot, and a camera that sees a board from where it is."""

import json
import math
import threading
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import cv2
import numpy as np
import pytest

from facetlog.cli import main
from facetlog.perception.types import Pose
from facetlog.robot.mount.kinematics import Gaze, camera_pose
from facetlog.robot.mount.mount import Mount, read_mount
from facetlog.robot.pose2 import Pose2
from facetlog.robot.simulator.station import Station
from tests.robot.collecting.test_run import simulated
from tests.robot.mount.test_board import CHARUCO, seen_by

pytestmark = pytest.mark.slow

FACING = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
BOARD = Pose(FACING, np.array([1.5, 0.2, 0.85]))
TRUE = Mount(x=0.05, z=0.73, yaw=math.radians(1.5), tilt_zero=math.radians(0.9), pinhole_ahead=0.03)
NOISE_SD = 2.0


@contextmanager
def _camera_on(station: Station) -> Iterator[str]:
    """The address of a camera that is where the station's robot and head are."""
    noise = np.random.default_rng(0)

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            with urllib.request.urlopen(station.addresses.state) as answer:  # noqa: S310
                state = json.load(answer)
            robot = Pose2(*(state["truth"][key] for key in ("x", "y", "heading")))
            pose = camera_pose(robot, TRUE, Gaze(state["pan"], state["tilt"]))
            image = seen_by(CHARUCO, pose, BOARD) + noise.normal(0, NOISE_SD, (480, 640))
            _, data = cv2.imencode(".png", np.clip(image, 0, 255).astype(np.uint8))
            self.send_response(200)
            self.send_header("Content-Type", "image/png")
            self.send_header("Content-Length", str(len(data)))
            self.end_headers()
            self.wfile.write(data.tobytes())

        def log_message(self, *_: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, args=(0.02,))
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/frame.png"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


def test_the_mount_is_written_with_its_deviations(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "mount.toml"
    with simulated() as station, _camera_on(station) as camera:
        code = main(
            [
                *("mount", station.addresses.robot, "--camera", camera, "-o", str(out)),
                *("--board", "7x5", "--square", "0.05", "--marker", "0.037"),
                *("--board-height", "0.85", "--json"),
            ]
        )
    told = capsys.readouterr()
    assert told.out, told.err
    document = json.loads(told.out)
    assert code == 0
    assert all(row["determined"] for row in document["mount"].values())
    assert document["rms_px"] < 0.5
    found = read_mount(out)
    # What odometry's own errors leave: its turns are off by half a per cent, the driver allows two.
    assert math.degrees(abs(found.tilt_zero - TRUE.tilt_zero)) < 0.3
    assert math.degrees(abs(found.yaw - TRUE.yaw)) < 2.0
    assert abs(found.z - TRUE.z) < 0.01
    assert abs(found.pinhole_ahead - TRUE.pinhole_ahead) < 0.01
    assert abs(found.x - TRUE.x) < 0.02
