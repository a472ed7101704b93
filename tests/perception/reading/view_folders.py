"""Folders of views for tests: small pictures with poses that look at one place."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np

WIDTH, HEIGHT = 48, 32


def picture(seed: int = 0) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """A picture with detail, for even grey would hide a wrong order of pixels."""
    noise = np.random.default_rng(seed).integers(0, 255, (HEIGHT // 4, WIDTH // 4), dtype=np.uint8)
    return np.asarray(cv2.resize(noise, (WIDTH, HEIGHT)), dtype=np.uint8)


def transforms(count: int = 3) -> dict[str, Any]:
    """The document of `count` frames, in a row along x, all looking along -z (OpenGL)."""
    frames = []
    for i in range(count):
        matrix = np.eye(4)
        matrix[0, 3] = i
        frames.append({"file_path": f"images/{i}.png", "transform_matrix": matrix.tolist()})
    return {
        "camera_model": "OPENCV",
        "fl_x": 50.0,
        "fl_y": 51.0,
        "cx": 24.5,
        "cy": 16.5,
        "w": WIDTH,
        "h": HEIGHT,
        "frames": frames,
    }


def write_transforms(folder: Path, document: Any = None, count: int = 3) -> Path:
    """The folder, filled with transforms.json and its pictures."""
    (folder / "images").mkdir(parents=True, exist_ok=True)
    for i in range(count):
        cv2.imwrite(str(folder / "images" / f"{i}.png"), picture(i))
    document = transforms(count) if document is None else document
    (folder / "transforms.json").write_text(json.dumps(document))
    return folder


CAMERA = 'width = 48\nheight = 32\nfx = 50\nfy = 51\ncx = 23.5\ncy = 15.5\nunit = "in"\n'
POSES = (
    "image,x,y,z,pan_deg,tilt_deg,skew_deg\n"
    "0.png,0,0,10,0,-90,0\n"
    "# a comment\n"
    "1.png,5,0,10,10,-90,0\n"
)


def write_tour(folder: Path, poses: str = POSES, camera: str | None = CAMERA) -> Path:
    """The folder, filled with poses.csv, camera.toml and two pictures."""
    folder.mkdir(parents=True, exist_ok=True)
    for i in range(2):
        cv2.imwrite(str(folder / f"{i}.png"), picture(i))
    (folder / "poses.csv").write_text(poses)
    if camera is not None:
        (folder / "camera.toml").write_text(camera)
    return folder
