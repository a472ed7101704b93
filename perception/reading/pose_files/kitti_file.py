"""Poses from KITTI's odometry benchmark: poses.txt and calib.txt beside image_0, …, image_3.

As the benchmark unpacks, the poses of `sequences/00` are in `poses/00.txt` beside `sequences`.

Format: the benchmark's readme – each line of the poses has 3 x 4 numbers, row by row, that take the
first grey camera's axes at a frame to the world, in metres; a camera looks along z, its y runs down
the picture. calib.txt has for each camera, P0 to P3, the projection of the first camera's axes to
its rectified pixels; the middle of the top-left one is (0, 0). Pictures are those of the first
folder that is there, in the order of their names, one for each line. Up is unknown.
"""

from functools import partial
from pathlib import Path

import numpy as np

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.reading.pose_files.file_values import (
    iter_numbered_lines,
    make_pose,
    parse_finite,
)
from facetlog.perception.reading.pose_files.pose_reader import (
    PoseReader,
    make_file_finder,
    make_metric_reader,
    make_missing_check,
)
from facetlog.perception.reading.pose_files.poses_file import (
    PLAIN_NAMES,
    Intrinsics,
    PosedPicture,
    PosesFile,
    collect_posed_pictures,
    read_intrinsics,
)
from facetlog.perception.types import FloatArray

__all__ = ["KITTI"]

POSES, CALIBRATION = "poses.txt", "calib.txt"
UNPACKED = ("sequences", "poses")
FOLDERS = ("image_0", "image_1", "image_2", "image_3")


def read_kitti(path: Path) -> PosesFile:
    """Return the poses of a sequence."""
    folder = _find_sequence_folder(path)
    named = next((name for name in FOLDERS if (folder / name).is_dir()), None)
    if named is None:
        raise InputError(f"{folder} has no folder {FOLDERS[0]} of pictures of {path.name}")
    intrinsics, offset = _read_camera(folder / CALIBRATION, f"P{FOLDERS.index(named)}")
    pictures = sorted(p for p in (folder / named).iterdir() if not p.name.startswith("."))
    lines = list(iter_numbered_lines(path))
    if len(lines) != len(pictures):
        raise InputError(
            f"{path} has {len(lines)} poses, {folder / named} {len(pictures)} pictures: "
            "give each picture its line"
        )

    def read_picture(picture: Path, line: tuple[str, str]) -> PosedPicture:
        name = f"{picture.parent.name}/{picture.name}"
        where = f"{line[0]} ({name!r:.80})"
        matrix = _parse_matrix(line[1], where)
        centre = matrix[:, :3] @ offset + matrix[:, 3]
        return PosedPicture(name, picture, intrinsics, make_pose(matrix[:, :3], centre, where))

    found, faults = collect_posed_pictures(
        partial(read_picture, picture, line) for picture, line in zip(pictures, lines, strict=True)
    )
    return PosesFile(folder, found, faults=faults)


def _read_camera(path: Path, name: str) -> tuple[Intrinsics, FloatArray]:
    """Return the camera of a name in calib.txt, and its centre (3,) in the first camera's axes."""
    for where, line in iter_numbered_lines(path):
        label, _, numbers = line.strip().partition(" ")
        if label.rstrip(":") == name:
            projection = _parse_matrix(numbers, where)
            left, last = projection[:, :3], projection[:, 3]
            fields = {"camera_model": "PINHOLE", "fx": left[0, 0], "fy": left[1, 1]}
            fields |= {"cx": left[0, 2], "cy": left[1, 2]}
            intrinsics = read_intrinsics(fields, PLAIN_NAMES, where)
            try:
                centre = -np.linalg.solve(left, last)
            except np.linalg.LinAlgError as exc:
                raise CalibrationError(
                    f"{where}: it projects all to a line: copy it again"
                ) from exc
            return intrinsics, np.asarray(centre, dtype=np.float64)
    raise CalibrationError(f"{path} has no {name}: add its line of 12 numbers")


def _parse_matrix(text: str, where: str) -> FloatArray:
    return np.reshape(parse_finite(text.split(), 12, where), (3, 4))


def _find_sequence_folder(path: Path) -> Path:
    """Return the folder of the sequence that poses are of."""
    if path.name == POSES or path.parent.name != UNPACKED[1]:
        return path.parent
    return path.parent.with_name(UNPACKED[0]) / path.stem


def _find(folder: Path) -> Path | None:
    beside = make_file_finder(POSES, CALIBRATION)(folder)
    whole = folder.resolve()
    if beside is None and whole.parent.name == UNPACKED[0] and (folder / CALIBRATION).is_file():
        unpacked = whole.parent.with_name(UNPACKED[1]) / f"{whole.name}.txt"
        return unpacked if unpacked.is_file() else None
    return beside


def _is_kitti_poses(path: Path) -> bool:
    unpacked = (
        path.parent.name == UNPACKED[1] and (_find_sequence_folder(path) / CALIBRATION).is_file()
    )
    return path.name == POSES or unpacked


def _lacks(folder: Path) -> str:
    """Return what is missing of a sequence; a calib.txt by itself may be of any other camera."""
    sequence = (folder / POSES).is_file() or any((folder / name).is_dir() for name in FOLDERS)
    return make_missing_check(POSES, CALIBRATION)(folder) if sequence else ""


KITTI = PoseReader(
    kind="KITTI sequence",
    needs=f"KITTI's {POSES} and {CALIBRATION} with {FOLDERS[0]}",
    find=_find,
    lacks=_lacks,
    takes=_is_kitti_poses,
    read=make_metric_reader(read_kitti, "m"),
)
