"""The one picture by which a camera is checked before anything moves."""

from contextlib import ExitStack
from pathlib import Path

import cv2
import numpy as np
import pytest

from facetlog.errors import DeviceError, InputError
from facetlog.robot.camera.optics import Optics
from facetlog.robot.collecting.run import open_checked_camera
from facetlog.robot.collecting.simulated_robot import CameraAndOptics
from facetlog.robot.tour import tour_camera


def _sight(folder: Path, width: int, height: int, count: int = 2) -> CameraAndOptics:
    """A camera of numbered files, each of one grey: 10, 20 and so on."""
    for number in range(1, count + 1):
        picture = np.full((height, width), 10 * number, np.uint8)
        cv2.imwrite(str(folder / f"shot{number:03d}.png"), picture)
    return CameraAndOptics(str(folder / "shot%03d.png"), Optics(tour_camera()))


def test_pictures_of_another_size_are_refused(tmp_path: Path) -> None:
    said = "pictures are 320 x 240, its calibration is for 640 x 480: give the --camera-file"
    with ExitStack() as stack, pytest.raises(DeviceError, match=said):
        open_checked_camera(stack, _sight(tmp_path, 320, 240))


def test_a_camera_without_a_picture_is_refused(tmp_path: Path) -> None:
    with ExitStack() as stack, pytest.raises((DeviceError, InputError), match=r"shot%03d\.png"):
        open_checked_camera(stack, _sight(tmp_path, 640, 480, count=0))


def test_the_picture_that_was_looked_at_is_not_lost_of_a_file(tmp_path: Path) -> None:
    with ExitStack() as stack:
        camera = open_checked_camera(stack, _sight(tmp_path, 640, 480))
        assert [int(camera.shot(0.0, 1.0).image.max()) for _ in range(2)] == [10, 20]
