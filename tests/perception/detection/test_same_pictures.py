"""One picture that stands under several poses is named."""

from dataclasses import replace

import numpy as np

from facetlog.perception.detection.picture_faults import same_pictures
from facetlog.perception.types import Camera, Pose, View

CAMERA = Camera(64, 48, 60.0, 60.0, 31.5, 23.5)


def view(k: int, picture: int) -> View:
    image = np.random.default_rng(picture).integers(0, 255, (48, 64), dtype=np.uint8)
    return View(f"{k}.png", image, CAMERA, Pose(np.eye(3), np.array([float(k), 0.0, 0.0])))


def test_pictures_that_differ_are_no_fault() -> None:
    assert same_pictures([view(k, k) for k in range(5)]) == ()


def test_a_picture_at_two_poses_is_named() -> None:
    views = [view(k, 1 if k in (1, 4) else 10 + k) for k in range(6)]
    (warning,) = same_pictures(views)
    assert warning.startswith("1.png, 4.png: one and the same picture at different poses")


def test_a_picture_given_twice_at_its_pose_contradicts_nothing() -> None:
    first = view(0, 7)
    assert same_pictures([first, replace(first, name="again.png"), view(1, 1)]) == ()
