"""Poses from KITTI's odometry benchmark: poses.txt and calib.txt beside image_0, …, image_3.

As the benchmark unpacks, the poses of `sequences/00` are in `poses/00.txt` beside `sequences`.

Format: the benchmark's readme – each line of the poses has 3 x 4 numbers, row by row, that take the
first grey camera's axes at a frame to the world, in metres; a camera looks along z, its y runs down
the picture. calib.txt has for each camera, P0 to P3, the projection of the first camera's axes to
its rectified pixels; the middle of the top-left one is (0, 0). Pictures are those of the first
folder that is there, in the order of their names, one for each line. Up is unknown.
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.reading.pose_files.pose_checks import posed
from facetlog.perception.reading.pose_files.pose_reader import (
    PoseReader,
    by_unit,
    first_of,
    missing_of,
)
from facetlog.perception.reading.pose_files.poses_file import (
    FieldNames,
    Intrinsics,
    PosedPicture,
    PosesFile,
    metres_per,
    posed_pictures,
    read_intrinsics,
    read_text,
)
from facetlog.perception.types import FloatArray

__all__ = ["KITTI", "read_kitti"]

POSES, CALIBRATION = "poses.txt", "calib.txt"
UNPACKED = ("sequences", "poses")
FOLDERS = ("image_0", "image_1", "image_2", "image_3")
NAMES = FieldNames("width", "height", "fx", "fy", pixel_centre=0.0)


def read_kitti(path: Path, unit: str | None) -> PosesFile:
    """The poses of a sequence; lengths in metres, or in metres by `unit` if it is given.

    InputError for what is no such file, CalibrationError for a camera or pose that cannot be; both
    name the file and the line.
    """
    scale = 1.0 if unit is None else metres_per(unit, "--unit")
    folder = _sequence(path)
    named = next((name for name in FOLDERS if (folder / name).is_dir()), None)
    if named is None:
        raise InputError(f"{folder} has no folder {FOLDERS[0]} of pictures of {path.name}")
    intrinsics, offset = _camera(folder / CALIBRATION, f"P{FOLDERS.index(named)}")
    pictures = sorted(p for p in (folder / named).iterdir() if not p.name.startswith("."))
    lines = [
        (f"{path}:{number}", line.split())
        for number, line in enumerate(read_text(path).splitlines(), start=1)
        if line.strip()
    ]
    if len(lines) != len(pictures):
        raise InputError(
            f"{path} has {len(lines)} poses, {folder / named} {len(pictures)} pictures: "
            "give each picture its line"
        )
    posed_ones, faults = posed_pictures(
        partial(_picture, picture, line, intrinsics, offset, scale)
        for picture, line in zip(pictures, lines, strict=True)
    )
    return PosesFile(folder, posed_ones, None, metric=True, faults=faults)


def _camera(path: Path, name: str) -> tuple[Intrinsics, FloatArray]:
    """The camera of a name in calib.txt, and its centre (3,) in the first camera's axes."""
    for number, line in enumerate(read_text(path).splitlines(), start=1):
        label, *words = line.split() or [""]
        if label.rstrip(":") == name:
            where = f"{path}:{number}"
            projection = _matrix(words, where)
            left, last = projection[:, :3], projection[:, 3]
            fields = {"camera_model": "PINHOLE", "fx": left[0, 0], "fy": left[1, 1]}
            fields |= {"cx": left[0, 2], "cy": left[1, 2]}
            intrinsics = read_intrinsics(fields, NAMES, where)
            try:
                centre = -np.linalg.solve(left, last)
            except np.linalg.LinAlgError as exc:
                raise CalibrationError(
                    f"{where}: it projects all to a line: copy it again"
                ) from exc
            return intrinsics, np.asarray(centre, dtype=np.float64)
    raise CalibrationError(f"{path} has no {name}: add its line of 12 numbers")


def _matrix(words: Sequence[str], where: str) -> FloatArray:
    try:
        numbers = np.array([float(word) for word in words])
    except ValueError:
        numbers = np.zeros(0)
    if numbers.shape != (12,) or not np.isfinite(numbers).all():
        raise CalibrationError(f"{where}: not 3 x 4 finite numbers, row by row")
    return np.asarray(numbers.reshape(3, 4))


def _picture(
    picture: Path,
    line: tuple[str, list[str]],
    intrinsics: Intrinsics,
    offset: FloatArray,
    scale: float,
) -> PosedPicture:
    name = f"{picture.parent.name}/{picture.name}"
    where = f"{line[0]} ({name!r:.80})"
    matrix = _matrix(line[1], where)
    centre = matrix[:, :3] @ offset + matrix[:, 3]
    return PosedPicture(name, picture, intrinsics, posed(matrix[:, :3], centre * scale, where))


def _sequence(path: Path) -> Path:
    """The folder of the sequence that poses are of."""
    if path.name == POSES or path.parent.name != UNPACKED[1]:
        return path.parent
    return path.parent.with_name(UNPACKED[0]) / path.stem


def _find(folder: Path) -> Path | None:
    beside = first_of(POSES, CALIBRATION)(folder)
    whole = folder.resolve()
    if beside is None and whole.parent.name == UNPACKED[0] and (folder / CALIBRATION).is_file():
        unpacked = whole.parent.with_name(UNPACKED[1]) / f"{whole.name}.txt"
        return unpacked if unpacked.is_file() else None
    return beside


def _takes(path: Path) -> bool:
    unpacked = path.parent.name == UNPACKED[1] and (_sequence(path) / CALIBRATION).is_file()
    return path.name == POSES or unpacked


def _lacks(folder: Path) -> str:
    """What is missing of a sequence; a calib.txt by itself may be of any other camera."""
    sequence = (folder / POSES).is_file() or any((folder / name).is_dir() for name in FOLDERS)
    return missing_of(POSES, CALIBRATION)(folder) if sequence else ""


KITTI = PoseReader(
    kind="KITTI sequence",
    needs=f"KITTI's {POSES} and {CALIBRATION} with {FOLDERS[0]}",
    find=_find,
    lacks=_lacks,
    takes=_takes,
    read=by_unit(read_kitti),
)
