"""The files of a collection's folder: each written atomically, and up to date after every view.

- the pictures (PNG), by the names of the tour;
- collect.jsonl: for each run a line about it, then what happened, in order: a line for each view,
  and one for the end;
- transforms.json (nerfstudio): intrinsics and poses, and what else is known of each view;
- cameras.txt, images.txt, points3D.txt (COLMAP's text form, points3D.txt without points);
- trajectory.tum: the camera's poses (time, place, quaternion).

Poses are of the camera in the world, metres. Times are seconds since 1970.
"""

import json
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from facetlog.errors import InputError
from facetlog.perception.types import FloatArray, Image, Pose
from facetlog.robot.camera.checks import Quality
from facetlog.robot.camera.optics import Optics
from facetlog.robot.pose2 import Pose2
from facetlog.robot.recording import (
    HALF_PIXEL,
    OPENCV_FROM_OPENGL,
    list_intrinsics,
    make_transform_matrix,
)
from facetlog.safe_read import read_regular_text

LOG_FILE, TRANSFORMS_FILE, WAY_FILE = "collect.jsonl", "transforms.json", "odometry.tum"
SCHEMA = "facetlog-collect/1"


@dataclass(frozen=True, eq=False, slots=True)
class Taken:
    """One view that was taken; metres, radians, seconds.

    `covariance` (6, 6) is of the pose, rows as in `kinematics.compute_pose_covariance`;
    `odometry` is in the robot's own frame, `robot` in the world. `notes` say what was unusual.
    """

    number: int
    name: str
    pose: Pose
    covariance: FloatArray
    robot: Pose2
    odometry: Pose2
    pan: float
    tilt: float
    zoom: int
    time: float
    quality: Quality
    notes: tuple[str, ...] = ()

    def to_json(self) -> dict[str, object]:
        """Return it for a line of collect.jsonl; lengths in metres, angles in degrees."""
        return {
            "view": self.number,
            "image": self.name,
            "result": "taken",
            "matrix": make_transform_matrix(self.pose).tolist(),
            "covariance": self.covariance.tolist(),
            "robot": _format_pose2(self.robot),
            "odometry": _format_pose2(self.odometry),
            "pan_deg": math.degrees(self.pan),
            "tilt_deg": math.degrees(self.tilt),
            "zoom": self.zoom,
            "time": self.time,
            "blur_px": [self.quality.across, self.quality.down],
            "clipped": self.quality.clipped,
            "notes": list(self.notes),
        }

    @classmethod
    def from_json(cls, line: Mapping[str, object]) -> "Taken":
        """Read the output of `to_json`; KeyError, TypeError or ValueError for anything else."""
        matrix = np.array(line["matrix"], dtype=np.float64)
        pose = Pose(matrix[:3, :3] @ OPENCV_FROM_OPENGL, matrix[:3, 3])
        notes = line["notes"]
        if not isinstance(notes, list):
            raise TypeError("notes are a list")
        # Older ones have another measure, which does not compare.
        blur = line.get("blur_px", [None, None])
        if not isinstance(blur, list):
            raise TypeError("a blur is a list")
        across, down = (None if each is None else float(str(each)) for each in blur)
        return cls(
            int(str(line["view"])),
            str(line["image"]),
            pose,
            np.array(line["covariance"], dtype=np.float64).reshape(6, 6),
            _parse_pose2(line["robot"]),
            _parse_pose2(line["odometry"]),
            math.radians(float(str(line["pan_deg"]))),
            math.radians(float(str(line["tilt_deg"]))),
            int(str(line["zoom"])),
            float(str(line["time"])),
            Quality(across, down, float(str(line["clipped"]))),
            tuple(map(str, notes)),
        )


def _format_pose2(pose: Pose2) -> list[float]:
    return [pose.x, pose.y, math.degrees(pose.heading)]


def _parse_pose2(value: object) -> Pose2:
    if not isinstance(value, list):
        raise TypeError("a place is a list")
    x, y, heading = (float(str(v)) for v in value)
    return Pose2(x, y, math.radians(heading))


class Record:
    """The folder of a collection. InputError where it cannot be written, a full disk included.

    `about` is the first line of this run in collect.jsonl; `taken` are the views and `lines` all
    lines of earlier runs: odometry restarts with each run, so its views need the run's `start`.
    """

    def __init__(
        self,
        folder: Path,
        optics: Optics,
        about: Mapping[str, object],
        taken: Sequence[Taken] = (),
        lines: Sequence[Mapping[str, object]] = (),
    ) -> None:
        self.folder, self._optics = folder, optics
        self._taken = list(taken)
        self._lines = [*lines, {"schema": SCHEMA, **about}]
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as exc:
            raise InputError(f"{folder} cannot be made: {exc.strerror}: give another -o") from exc
        self._write_all()

    @property
    def taken(self) -> tuple[Taken, ...]:
        """All views so far, in the order in which they were taken."""
        return tuple(self._taken)

    def add(self, view: Taken, image: Image) -> None:
        """Write a view: its picture first, so that every pose listed has its picture."""
        grey = _convert_to_grey(image)
        done, data = cv2.imencode(".png", grey)
        if not done:
            raise InputError(f"{self.folder / view.name}: the picture cannot be encoded")
        write_file(self.folder / view.name, data.tobytes())
        self._taken.append(view)
        self._lines.append(view.to_json())
        self._write_all()

    def note(self, line: Mapping[str, object]) -> None:
        """Write a line about something else: a view that was not taken, a verdict, the end."""
        self._lines.append(line)
        self._write_log()

    def _write_all(self) -> None:
        """Write the log first, then the rest: a later run resumes from the log."""
        self._write_log()
        for name, text in (
            (TRANSFORMS_FILE, _format_transforms(self._optics, self._taken)),
            ("cameras.txt", _format_colmap_camera(self._optics)),
            ("images.txt", _format_colmap_images(self._taken)),
            ("points3D.txt", "# 3D points: none, the poses are the robot's own\n"),
            ("trajectory.tum", _format_tum(self._taken)),
        ):
            write_file(self.folder / name, text.encode())

    def _write_log(self) -> None:
        text = "".join(json.dumps(line, allow_nan=False) + "\n" for line in self._lines)
        write_file(self.folder / LOG_FILE, text.encode())


def write_file(path: Path, content: bytes) -> None:
    """Write a temporary file and rename it (atomic): readers see the old or the new file.

    InputError if that fails, as on a full disk; an older file then stays as it was.
    """
    part = path.with_name(f".{path.name}.part")
    try:
        try:
            with part.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
    except OSError as exc:
        raise InputError(
            f"{path} cannot be written: {exc.strerror or exc}: make room, then go on with --resume"
        ) from exc


def read_log(folder: Path) -> tuple[Mapping[str, object], ...]:
    """Return all lines of collect.jsonl, the first one about the first run.

    InputError if the folder holds no collection or one that cannot be read.
    """
    path = folder / LOG_FILE
    try:
        lines = [json.loads(line) for line in read_regular_text(path).splitlines()]
    except FileNotFoundError as exc:
        raise InputError(
            f"{folder} holds no collection: give what `facetlog collect` has left"
        ) from exc
    except (OSError, ValueError) as exc:
        raise InputError(f"{path} cannot be read: {exc}: collect into another folder") from exc
    if not lines or not isinstance(lines[0], dict) or lines[0].get("schema") != SCHEMA:
        raise InputError(f"{path} is not of the form {SCHEMA}: collect into another folder")
    for number, line in enumerate(lines, start=1):
        if not isinstance(line, dict):
            raise InputError(f"{path}:{number}: is no object: collect into another folder")
    return tuple(lines)


def read_record(folder: Path) -> tuple[Mapping[str, object], tuple[Taken, ...]]:
    """Return the record of earlier runs: the first line, and the views whose pictures exist.

    If a view was taken again because its picture was gone, its last line counts. InputError as of
    `read_log`.
    """
    lines = read_log(folder)
    taken: dict[str, Taken] = {}
    for number, line in enumerate(lines[1:], start=2):
        if line.get("result") != "taken":
            continue
        try:
            view = Taken.from_json(line)
        except (KeyError, TypeError, ValueError) as exc:
            raise InputError(
                f"{folder / LOG_FILE}:{number}: is no line of a view: {exc!r}"
            ) from exc
        taken.pop(view.name, None)
        if (folder / view.name).is_file():
            taken[view.name] = view
    return lines[0], tuple(taken.values())


def _convert_to_grey(image: Image) -> Image:
    """Return the picture with one channel where all three are the same."""
    if image.ndim == 3 and (image == image[:, :, :1]).all():
        return np.ascontiguousarray(image[:, :, 0])
    return image


def _format_transforms(optics: Optics, taken: Iterable[Taken]) -> str:
    frames = [
        {
            "file_path": view.name,
            "transform_matrix": make_transform_matrix(view.pose).tolist(),
            "pan_deg": math.degrees(view.pan),
            "tilt_deg": math.degrees(view.tilt),
            "odometry": _format_pose2(view.odometry),
            "robot": _format_pose2(view.robot),
            "covariance": view.covariance.tolist(),
            "time": view.time,
        }
        for view in taken
    ]
    content = {
        # A pinhole is the general model without coefficients to the readers of this format.
        "camera_model": "OPENCV" if optics.model == "PINHOLE" else optics.model,
        **list_intrinsics(optics.camera),
        **dict(optics.coefficients),
        "unit": "m",
        "up": [0.0, 0.0, 1.0],
        "frames": frames,
    }
    return json.dumps(content, indent=1, allow_nan=False) + "\n"


def _format_colmap_camera(optics: Optics) -> str:
    camera = optics.camera
    model = optics.model
    if model == "OPENCV" and optics.coefficient("k3"):
        model = "FULL_OPENCV"
    names = {
        "OPENCV": ("k1", "k2", "p1", "p2"),
        "OPENCV_FISHEYE": ("k1", "k2", "k3", "k4"),
        "FULL_OPENCV": ("k1", "k2", "p1", "p2", "k3", "denominator", "denominator", "denominator"),
    }.get(model, ())
    numbers = (
        *(camera.fx, camera.fy, camera.cx + HALF_PIXEL, camera.cy + HALF_PIXEL),
        *(optics.coefficient(name) for name in names),
    )
    parameters = " ".join(repr(float(v)) for v in numbers)
    return (
        "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n"
        f"1 {model} {camera.width} {camera.height} {parameters}\n"
    )


def _format_colmap_images(taken: Iterable[Taken]) -> str:
    """Return world to camera, a quaternion with its real part first; the second line is for
    points."""
    lines = ["# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME", "# POINTS2D[] as X Y POINT3D_ID"]
    for number, view in enumerate(taken, start=1):
        turn = view.pose.rotation.T
        quaternion = Rotation.from_matrix(turn).as_quat(canonical=True, scalar_first=True)
        numbers = [*quaternion.tolist(), *(-turn @ view.pose.centre).tolist()]
        lines += [f"{number} {' '.join(map(repr, numbers))} 1 {view.name}", ""]
    return "\n".join(lines) + "\n"


def format_robot_tum(way: Iterable[tuple[float, Pose2]]) -> str:
    """Return the robot's poses on the floor with their times (s since 1970) as a TUM trajectory."""
    lines = ["# timestamp tx ty tz qx qy qz qw"]
    for at, place in way:
        half = place.heading / 2
        lines.append(
            f"{at:.3f} {place.x:.4f} {place.y:.4f} 0 0 0 {math.sin(half):.6f} {math.cos(half):.6f}"
        )
    return "\n".join(lines) + "\n"


def read_robot_tum(path: Path) -> list[tuple[float, Pose2]]:
    """Read a file of `format_robot_tum`; InputError for anything else."""
    try:
        lines = read_regular_text(path).splitlines()
        rows = [list(map(float, line.split())) for line in lines if not line.startswith("#")]
        return [(at, Pose2(x, y, 2 * math.atan2(qz, qw))) for at, x, y, _, _, _, qz, qw in rows]
    except (OSError, ValueError) as exc:
        raise InputError(f"{path} cannot be read: {exc}: remove it, then go on") from exc


def _format_tum(taken: Iterable[Taken]) -> str:
    lines = ["# timestamp tx ty tz qx qy qz qw"]
    for view in taken:
        quaternion = Rotation.from_matrix(view.pose.rotation).as_quat(canonical=True)
        numbers = [*view.pose.centre.tolist(), *quaternion.tolist()]
        lines.append(f"{view.time:.6f} {' '.join(map(repr, numbers))}")
    return "\n".join(lines) + "\n"
