"""Drawn pictures whose edges are known exactly."""

import cv2
import numpy as np

from facetlog.perception.types import Camera, FloatArray, Image, Pose, View

WIDTH, HEIGHT = 320, 240
CAMERA = Camera(WIDTH, HEIGHT, 300.0, 300.0, 159.5, 119.5)


def half_plane(
    direction: float, through: FloatArray, *, low: float = 80, high: float = 180, blur: float = 1.0
) -> Image:
    """A blurred step along `direction` (radians) through a pixel (2,)."""
    v, u = np.mgrid[:HEIGHT, :WIDTH].astype(np.float64)
    away = -(u - through[0]) * np.sin(direction) + (v - through[1]) * np.cos(direction)
    step = 1.0 / (1.0 + np.exp(-1.702 * away / blur))  # a normal distribution to 1 %
    return np.rint(low + (high - low) * step).astype(np.uint8)


def along(direction: float, through: FloatArray, *, reach: float = 60, count: int = 61):
    """Pixels (count, 2) on that edge."""
    t = np.linspace(-reach, reach, count)
    return through + t[:, None] * np.array([np.cos(direction), np.sin(direction)])


def polygon(corners: FloatArray, *, low: float = 80, high: float = 180) -> Image:
    """A filled polygon (n, 2), drawn with an edge that is smooth to a fraction of a pixel."""
    scale = 16  # cv2 takes integers of 1/16 px
    image = np.zeros((HEIGHT, WIDTH), np.uint8)
    ring = np.rint(np.asarray(corners) * scale).astype(np.int32)
    cv2.fillPoly(image, [ring], 255, lineType=cv2.LINE_AA, shift=4)
    smooth = cv2.GaussianBlur(image.astype(np.float64), (0, 0), 0.7) / 255
    return np.rint(low + (high - low) * smooth).astype(np.uint8)


def with_noise(image: Image, sd: float, seed: int = 0) -> Image:
    rng = np.random.default_rng(seed)
    return np.clip(np.rint(image + rng.normal(0, sd, image.shape)), 0, 255).astype(np.uint8)


def flat(grey: float = 120.0) -> Image:
    return np.full((HEIGHT, WIDTH), grey, np.uint8)


def view(image: Image | None = None, pose: Pose | None = None) -> View:
    """A view of an image; the camera stands at the origin and looks along z if no pose is given."""
    return View(
        "drawn.png",
        flat() if image is None else image,
        CAMERA,
        Pose(np.eye(3), np.zeros(3)) if pose is None else pose,
    )


def project(seen_by: View, points: FloatArray) -> FloatArray:
    """Pixels (..., 2) of points (..., 3)."""
    h = points @ seen_by.projection[:, :3].T + seen_by.projection[:, 3]
    return h[..., :2] / h[..., 2:]
