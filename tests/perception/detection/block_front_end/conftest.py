"""A block drawn by OpenCV: what the front end's tests look at, with its exact ground truth."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import pytest

from facetlog.perception.pan_tilt import pan_tilt_pose
from facetlog.perception.types import Camera, FloatArray, Image, Pose, View

FACES = ((4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6))
SHADES = (225, 160, 195, 178, 206)  # top, front, right, back, left
OVERSAMPLING = 16
CAMERA = Camera(320, 240, 330.0, 330.0, 159.5, 119.5)


@dataclass(frozen=True, slots=True)
class DrawnBlock:
    """The views of a block, its corners (8, 3), and per view all pixels and the visible corners."""

    views: tuple[View, ...]
    corners: FloatArray
    pixels: tuple[FloatArray, ...]
    visible: tuple[tuple[int, ...], ...]


def block_corners(size: tuple[float, float, float], yaw: float) -> FloatArray:
    length, width, height = size
    corners = np.array(
        [
            [x, y, z]
            for z in (0.0, height)
            for y in (-width / 2, width / 2)
            for x in (-length / 2, length / 2)
        ]
    )
    c, s = np.cos(yaw), np.sin(yaw)
    return corners @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def round_tour(azimuths_deg: Sequence[float], distance: float, height: float) -> tuple[Pose, ...]:
    tilt = -np.pi / 2 - np.arctan2(0.85 * height, distance)
    return tuple(
        pan_tilt_pose(
            distance * np.sin(np.deg2rad(a)), -distance * np.cos(np.deg2rad(a)), height,
            np.deg2rad(a), tilt,
        )
        for a in azimuths_deg
    )  # fmt: skip


def draw(
    corners: FloatArray, pose: Pose, camera: Camera, noise: float, rng: np.random.Generator
) -> tuple[Image, FloatArray, tuple[int, ...]]:
    rotation = pose.rotation.T
    projected = (corners - pose.centre) @ rotation.T @ camera.matrix.T
    pixels = projected[:, :2] / projected[:, 2:]
    canvas = np.full((camera.height * OVERSAMPLING, camera.width * OVERSAMPLING), 80, np.uint8)
    seen: set[int] = set()
    for face, shade in zip(FACES, SHADES, strict=True):
        a, b, c = corners[list(face[:3])]
        if np.cross(b - a, c - b) @ (pose.centre - a) <= 0:
            continue
        seen.update(face)
        outline = (pixels[list(face)] + 0.5) * OVERSAMPLING - 0.5
        cv2.fillPoly(canvas, [np.rint(outline * 16).astype(np.int32)], shade, shift=4)
    small = cv2.resize(canvas, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
    blurred = cv2.GaussianBlur(small.astype(np.float64), (0, 0), 1.0)
    noisy = np.clip(np.rint(blurred + rng.normal(0.0, noise, blurred.shape)), 0, 255)
    return noisy.astype(np.uint8), pixels, tuple(sorted(seen))


@pytest.fixture(scope="session")
def draw_block() -> Callable[..., DrawnBlock]:
    def build(
        azimuths_deg: Sequence[float] = (10, 55, 100, 145, 190, 235, 280, 325),
        *,
        size: tuple[float, float, float] = (10.0, 8.0, 6.0),
        yaw: float = 0.2,
        scale: float = 1.0,
        noise: float = 3.0,
        seed: int = 0,
    ) -> DrawnBlock:
        corners = block_corners(size, yaw) * scale
        poses = round_tour(azimuths_deg, 26.0 * scale, 16.0 * scale)
        views, pixels, visible = [], [], []
        for index, pose in enumerate(poses):
            image, uv, seen = draw(
                corners, pose, CAMERA, noise, np.random.default_rng([seed, index])
            )
            views.append(View(f"view{index}", image, CAMERA, pose))
            pixels.append(uv)
            visible.append(seen)
        return DrawnBlock(tuple(views), corners, tuple(pixels), tuple(visible))

    return build


@pytest.fixture(scope="session")
def tour(draw_block: Callable[..., DrawnBlock]) -> DrawnBlock:
    return draw_block()
