"""Pictures of a bare mat, warped from its sheet: quick, where no thing needs to stand on it."""

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np

from facetlog.perception.reading.mat.mats import MATS, Mat
from facetlog.perception.types import Camera, Image, Pose
from facetlog.robot.tour import make_ring_poses

A4, A3, _ = MATS
SMALL = Camera(640, 480, 600.0, 600.0, 322.0, 237.5)
PX_PER_MM = 6
NOISE_SD = 2.0


@lru_cache(maxsize=4)
def sheet(mat: Mat, px_per_mm: int = PX_PER_MM) -> Image:
    """The printed sheet, (H, W)."""
    height, width = round(mat.height_mm * px_per_mm), round(mat.width_mm * px_per_mm)
    page = np.full((height, width), 230, dtype=np.uint8)
    for x, y, w, h in mat.black():
        left, right = round(x * px_per_mm), round((x + w) * px_per_mm)
        top, bottom = height - round((y + h) * px_per_mm), height - round(y * px_per_mm)
        page[top:bottom, left:right] = 20
    page.setflags(write=False)
    return page


def photo(
    mat: Mat,
    pose: Pose,
    camera: Camera = SMALL,
    *,
    blur_px: float = 0.6,
    seed: int = 0,
    stretch: float = 1.0,
) -> Image:
    """The mat on grey ground, (H, W), in noise; printed so many times as long away from the reader
    as across."""
    page, finer = sheet(mat), 2
    # Texels of the sheet to the mat's plane, and on to pixels of a finer picture.
    k = PX_PER_MM * 1000.0
    height, width = page.shape
    plane = np.array([[1 / k, 0, (0.5 - width / 2) / k], [0, -1 / k, (height / 2 - 0.5) / k]])
    plane = np.vstack([plane * [[1.0], [stretch]], [0, 0, 1]])
    r = pose.rotation.T
    to_picture = camera.matrix @ np.column_stack([r[:, :2], -r @ pose.centre]) @ plane
    fine = np.array([[finer, 0, (finer - 1) / 2], [0, finer, (finer - 1) / 2], [0, 0, 1]])
    size = finer * camera.width, finer * camera.height
    large = cv2.warpPerspective(
        page, fine @ to_picture, size, flags=cv2.INTER_AREA, borderValue=(120,)
    )
    seen = cv2.resize(large, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
    seen = cv2.GaussianBlur(seen.astype(np.float64), (0, 0), blur_px)
    noise = np.random.default_rng(seed).normal(0.0, NOISE_SD, seen.shape)
    return np.clip(np.rint(seen + noise), 0, 255).astype(np.uint8)


def around(count: int, distance: float = 0.3) -> tuple[Pose, ...]:
    """Poses round the middle of the mat, at two heights."""
    rng = np.random.default_rng(7)
    return make_ring_poses((0, 0, 0), distance, (0.22, 0.34), count, jitter=0.05, rng=rng)


def write_photos(folder: Path, pictures: Sequence[Image], first: int = 0) -> Path:
    """The folder with the pictures as 00.png and so on."""
    folder.mkdir(exist_ok=True)
    for number, picture in enumerate(pictures, start=first):
        assert cv2.imwrite(str(folder / f"{number:02d}.png"), picture)
    return folder


@lru_cache(maxsize=2)
def photos(count: int = 6, mat: Mat = A4) -> tuple[Image, ...]:
    """So many pictures of a mat."""
    return tuple(photo(mat, pose, seed=k) for k, pose in enumerate(around(count)))
