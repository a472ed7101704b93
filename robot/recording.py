"""A folder of views on disk, as a robot or a structure-from-motion program would write it.

Two formats: the paper's pan-tilt head (poses.csv beside camera.toml) and nerfstudio's
transforms.json. The ground truth of the world goes beside them into ground_truth.json.
"""

import csv
import json
from collections.abc import Sequence
from dataclasses import asdict
from enum import StrEnum
from pathlib import Path

import cv2
import numpy as np

from facetlog.errors import InputError
from facetlog.perception.types import Camera, FloatArray, Image, Pose, View
from facetlog.robot.rendering.world import GroundTruth

# OpenGL's camera (x right, y up, z backward) from OpenCV's (x right, y down, z forward).
OPENCV_FROM_OPENGL = np.diag([1.0, -1.0, -1.0])
# transforms.json and COLMAP count pixels from the first one's corner, facetlog from its middle.
HALF_PIXEL = 0.5
# Below this sine of the tilt from the vertical, pan and skew turn about the same axis.
GIMBAL_SINE = 1e-9


class Format(StrEnum):
    """How poses and intrinsics are written."""

    PAN_TILT = "pan-tilt"
    TRANSFORMS = "transforms"


def compute_pan_tilt_angles(pose: Pose) -> tuple[float, float, float]:
    """Return pan, tilt and skew (radians) of any pose: the inverse of `pan_tilt_pose`.

    The tilt is in [-π, 0]; where the camera looks straight up or down, the skew is 0.

    >>> from facetlog.perception.pan_tilt import pan_tilt_pose
    >>> [round(a, 9) for a in compute_pan_tilt_angles(pan_tilt_pose(1, 2, 3, 0.5, -2.0, 0.1))]
    [0.5, -2.0, 0.1]
    """
    # R diag(-1, -1, 1) = Rz(pan + π) Rx(-tilt) Rz(skew): Euler angles z-x-z.
    m: FloatArray = pose.rotation @ np.diag([-1.0, -1.0, 1.0])
    sine = float(np.hypot(m[0, 2], m[1, 2]))
    tilt = -float(np.arctan2(sine, m[2, 2]))
    if sine < GIMBAL_SINE:
        turn, skew = float(np.arctan2(m[1, 0], m[0, 0])), 0.0
    else:
        turn = float(np.arctan2(m[0, 2], -m[1, 2]))
        skew = float(np.arctan2(m[2, 0], m[2, 1]))
    pan = turn - np.pi
    return float(np.arctan2(np.sin(pan), np.cos(pan))), tilt, skew


def write_views(
    folder: Path, views: Sequence[View], *, layout: Format = Format.PAN_TILT, unit: str = "in"
) -> None:
    """Write pictures (PNG, by the views' names), poses and intrinsics into a folder.

    All views have one camera. `unit` is the name of the poses' unit of length; transforms.json
    has no place for it. InputError if the folder or a picture cannot be written.
    """
    if not views:
        raise ValueError("there are no views to write")
    if any(view.camera != views[0].camera for view in views):
        raise ValueError("the views are of different cameras")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for view in views:
            _write_png(folder / view.name, view.image)
        if layout is Format.PAN_TILT:
            _write_poses_csv(folder / "poses.csv", views)
            _write_camera_toml(folder / "camera.toml", views[0].camera, unit)
        else:
            _write_transforms(folder / "transforms.json", views)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror})") from error


def make_transform_matrix(pose: Pose) -> FloatArray:
    """Return camera to world (4, 4), with OpenGL's axes, as transforms.json has it."""
    matrix = np.eye(4)
    matrix[:3, :3] = pose.rotation @ OPENCV_FROM_OPENGL
    matrix[:3, 3] = pose.centre
    return matrix


def list_intrinsics(camera: Camera) -> dict[str, float]:
    """Return size and intrinsics of a pinhole camera by their names in transforms.json."""
    return {
        "w": camera.width,
        "h": camera.height,
        "fl_x": camera.fx,
        "fl_y": camera.fy,
        "cx": camera.cx + HALF_PIXEL,
        "cy": camera.cy + HALF_PIXEL,
    }


def write_ground_truth(folder: Path, truth: GroundTruth, *, unit: str = "in") -> None:
    """Write ground_truth.json: vertices, edges, faces and size of each solid, and the unit."""
    solids = [asdict(solid) for solid in truth.solids]
    try:
        (folder / "ground_truth.json").write_text(
            json.dumps({"unit": unit, "solids": solids}, indent=1) + "\n", encoding="utf-8"
        )
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror})") from error


def _write_png(path: Path, image: Image) -> None:
    done, data = cv2.imencode(".png", image)
    if not done:
        raise InputError(f"{path}: the picture cannot be encoded")
    path.write_bytes(data.tobytes())


def _write_poses_csv(path: Path, views: Sequence[View]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["image", "x", "y", "z", "pan_deg", "tilt_deg", "skew_deg"])
        for view in views:
            angles = np.rad2deg(compute_pan_tilt_angles(view.pose)).tolist()
            writer.writerow([view.name, *view.pose.centre.tolist(), *angles])


def _write_camera_toml(path: Path, camera: Camera, unit: str) -> None:
    lines = [f"{name} = {value}" for name, value in asdict(camera).items()]
    path.write_text("\n".join([*lines, f'unit = "{unit}"', ""]), encoding="utf-8")


def _write_transforms(path: Path, views: Sequence[View]) -> None:
    frames = [
        {"file_path": view.name, "transform_matrix": make_transform_matrix(view.pose).tolist()}
        for view in views
    ]
    content = {
        "camera_model": "OPENCV",
        **list_intrinsics(views[0].camera),
        "k1": 0.0,
        "k2": 0.0,
        "p1": 0.0,
        "p2": 0.0,
        "frames": frames,
    }
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
