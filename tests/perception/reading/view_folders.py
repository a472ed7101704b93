"""Folders of views for tests: small pictures with poses that look at one place."""

import json
import struct
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
    write_pictures(folder / "images", count)
    document = transforms(count) if document is None else document
    (folder / "transforms.json").write_text(json.dumps(document))
    return folder


def colmap_rows(count: int = 3) -> list[tuple[str, list[float]]]:
    """Name and QW QX QY QZ TX TY TZ of the pictures of `transforms`, world to camera.

    Their cameras look along the world's -z with y up: OpenCV's axes turned half round x.
    """
    return [(f"{i}.png", [0.0, 1.0, 0.0, 0.0, -float(i), 0.0, 0.0]) for i in range(count)]


OF_TRANSFORMS = ("PINHOLE", 1, (50.0, 51.0, 24.5, 16.5))
"""The camera of `transforms`: COLMAP's model, its number, parameters."""


def write_colmap_text(
    model: Path, rows: list[tuple[str, list[float]]], camera: Any = OF_TRANSFORMS
) -> Path:
    """A folder with cameras.txt and images.txt."""
    model.mkdir(parents=True, exist_ok=True)
    name, _, parameters = camera
    row = " ".join(map(str, (7, name, WIDTH, HEIGHT, *parameters)))
    (model / "cameras.txt").write_text(f"# cameras\n{row}\n")
    lines = ["# images"]
    for number, (picture_name, pose) in enumerate(rows, start=1):
        lines += [" ".join(map(str, (number, *pose, 7, picture_name)))]
        lines += ["1.5 2.5 -1 3.5 4.5 -1" if number == 1 else ""]
    (model / "images.txt").write_text("\n".join(lines) + "\n")
    return model


def write_colmap_binary(
    model: Path, rows: list[tuple[str, list[float]]], camera: Any = OF_TRANSFORMS
) -> Path:
    """A folder with cameras.bin and images.bin."""
    model.mkdir(parents=True, exist_ok=True)
    _, kind, parameters = camera
    head = struct.pack("<QIiQQ", 1, 7, kind, WIDTH, HEIGHT)
    (model / "cameras.bin").write_bytes(head + struct.pack(f"<{len(parameters)}d", *parameters))
    data = struct.pack("<Q", len(rows))
    for number, (picture_name, pose) in enumerate(rows, start=1):
        data += struct.pack("<I7dI", number, *pose, 7) + picture_name.encode() + b"\0"
        features = 2 if number == 1 else 0
        data += struct.pack("<Q", features) + struct.pack("<ddq", 1.5, 2.5, -1) * features
    (model / "images.bin").write_bytes(data)
    return model


def write_pictures(folder: Path, count: int = 3) -> Path:
    """The folder, with the pictures of `transforms` in it."""
    folder.mkdir(parents=True, exist_ok=True)
    for i in range(count):
        cv2.imwrite(str(folder / f"{i}.png"), picture(i))
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
