"""Pictures, as a phone takes them, of a box on a newspaper: what it lies on has texture."""

from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image

from facetlog.perception.types import Camera, Pose
from facetlog.robot.rendering.solids import cuboid, placed
from facetlog.robot.rendering.texture import Pattern, Sheet, Texture
from facetlog.robot.rendering.world import Floor, World
from facetlog.robot.tour import make_ring_poses
from tests.robot.phone import Phone, take_phone_picture

CAMERA = Camera(480, 360, 450.0, 450.0, 241.0, 178.0)
BOX = (0.18, 0.12, 0.1)
SIDE_M, PX_PER_MM, COLUMNS = 1.0, 2, 8
PAPER, INK = 235, 40
LETTERS = [*"abcdefghijklmnopqrstuvwxyzABCDEFGHKLMNOPRSTUVW    "]


@lru_cache(maxsize=2)
def newspaper(seed: int) -> NDArray[np.float32]:
    """Factors (H, W) of a square sheet of columns with lines of letters, headings and pictures."""
    rng = np.random.default_rng(seed)
    size = round(1000 * SIDE_M * PX_PER_MM)
    page = np.full((size, size), PAPER, np.uint8)
    wide = size // COLUMNS
    for x in range(0, size, wide):
        y = 10
        while y < size:
            if rng.random() < 0.3:
                high = int(rng.integers(60, 240))
                few = rng.integers(30, 225, (max(high // 24, 3), wide // 24)).astype(np.uint8)
                picture = np.asarray(
                    cv2.resize(few, (wide - 12, high), interpolation=cv2.INTER_CUBIC)
                )
                page[y : y + high, x + 6 : x + wide - 6] = picture[: size - y]
                y += high + 12
                continue
            scale = float(rng.choice([0.7, 0.7, 0.7, 1.0, 1.8]))
            for _ in range(int(rng.integers(2, 9)) if scale < 1.5 else 1):
                y += int(30 * scale)
                line = "".join(rng.choice(LETTERS, int(wide / (18 * scale))))
                thick = max(1, int(2 * scale))
                font = cv2.FONT_HERSHEY_SIMPLEX
                cv2.putText(page, line, (x + 8, y), font, scale, INK, thick, cv2.LINE_AA)
            y += 20
    return (page / PAPER).astype(np.float32)


def taken(folder: Path, poses: tuple[Pose, ...], *, first: int = 0, paper: int = 0) -> None:
    """Write pictures of a box on a newspaper, from these poses, as 00.jpg and so on."""
    folder.mkdir(exist_ok=True)
    box = placed(cuboid(*BOX, albedo=0.8), 0, 0, yaw=0.4)
    wood = Texture(Pattern.WOOD, 3, 1.2, 0.35)
    floor = Floor(0.9, Sheet(newspaper(paper), (SIDE_M, SIDE_M), 0.4, wood))
    world = World((box,), floor, np.array([0.5, -0.3, 1.2]), exposure=1.05)
    rng, phone = np.random.default_rng(paper), Phone(CAMERA)
    for number, pose in enumerate(poses, start=first):
        # As phones store it that are held upright: on its side, and EXIF says so.
        lying = Image.fromarray(np.rot90(take_phone_picture(world, phone, pose, rng)))
        exif = Image.Exif()
        exif[ExifTags.Base.Orientation] = 6
        lying.save(folder / f"{number:02d}.jpg", quality=phone.jpeg_quality, exif=exif)


def around(count: int) -> tuple[Pose, ...]:
    """Poses round the box, from three heights."""
    rng = np.random.default_rng(4)
    return make_ring_poses((0, 0, 0.04), 0.5, (0.28, 0.42, 0.58), count, jitter=0.06, rng=rng)
