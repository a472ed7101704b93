"""How far pixels are off where the pose is, beside a sample of such poses."""

import cv2
import numpy as np

from facetlog.perception.estimation.pose_noise import compute_pixel_covs
from facetlog.perception.types import Camera, Pose, View

CAMERA = Camera(640, 480, 500, 510, 320, 240)
POINTS = np.array([[0.3, 0.1, 4.0], [-0.5, 0.6, 5.0]])


def _view(pose_cov):
    rotation = cv2.Rodrigues(np.array([0.3, -0.5, 0.2]))[0]
    pose = Pose(rotation, np.array([1.0, 2.0, 3.0]))
    return View("a", np.zeros((480, 640), np.uint8), CAMERA, pose, pose_cov=pose_cov)


def test_pixels_scatter_as_the_covariance_of_the_pose_says():
    rng = np.random.default_rng(0)
    root = 1e-3 * rng.normal(size=(6, 6))
    view = _view(root @ root.T)
    points = view.pose.centre + POINTS @ view.pose.rotation.T
    pixels = []
    for place, turn in (rng.normal(size=(4000, 6)) @ root.T).reshape(-1, 2, 3):
        rotation = cv2.Rodrigues(turn)[0] @ view.pose.rotation
        seen = (points - view.pose.centre - place) @ rotation @ CAMERA.matrix.T
        pixels.append(seen[:, :2] / seen[:, 2:])
    for k, cov in enumerate(compute_pixel_covs(view, points)):
        scattered = np.cov(np.array(pixels)[:, k].T)
        np.testing.assert_allclose(cov, scattered, rtol=0.1)


def test_a_pose_of_which_nothing_is_stated_adds_nothing():
    assert not compute_pixel_covs(_view(None), POINTS + 5.0).any()
