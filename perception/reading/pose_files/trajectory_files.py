"""Poses from trajectories of benchmarks: KITTI's odometry, TUM's RGB-D. Up is unknown in both.

KITTI, by the benchmark's readme: poses.txt and calib.txt beside image_0, …, image_3. As the
benchmark unpacks, the poses of `sequences/00` are in `poses/00.txt` beside `sequences`. Each line
of the poses has 3 x 4 numbers, row by row, that take the first grey camera's axes at a frame to the
world, in metres; a camera looks along z, its y runs down the picture. calib.txt has for each
camera, P0 to P3, the projection of the first camera's axes to its rectified pixels; the middle of
the top-left one is (0, 0). Pictures are those of the first folder that is there, in the order of
their names, one for each line.

TUM, by https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats: groundtruth.txt has lines of
time, tx ty tz and qx qy qz qw, in seconds and metres, camera to world; a camera looks along z, its
y runs down the picture. rgb.txt has lines of time and picture. A picture has the pose nearest in
time, as long as that is within 0.02 s, as in the benchmark's associate.py; others are left out. The
format gives no intrinsics: camera.toml is that of a pan-tilt tour (pan_tilt_file.py), save that
lengths are metres where it names no unit.
"""

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.reading.pose_files.file_values import (
    convert_quaternion,
    iter_numbered_lines,
    make_pose,
    parse_finite,
)
from facetlog.perception.reading.pose_files.pan_tilt_file import CAMERA_FILE, read_camera
from facetlog.perception.reading.pose_files.picture_places import resolve_picture_path
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
from facetlog.perception.reading.skipped_images import LeftOut
from facetlog.perception.types import FloatArray

KITTI_POSES, CALIBRATION = "poses.txt", "calib.txt"
UNPACKED = ("sequences", "poses")
FOLDERS = ("image_0", "image_1", "image_2", "image_3")
TRAJECTORY, TUM_PICTURES = "groundtruth.txt", "rgb.txt"
FARTHEST_S = 0.02
"""Largest difference in time of a picture and its pose: max_difference of associate.py."""

_Row = tuple[float, str, tuple[str, ...]]
"""Time, place in the file, words after the time."""


def read_tum(path: Path) -> PosesFile:
    """Return the poses of the pictures in rgb.txt beside a trajectory."""
    intrinsics, unit = read_camera(path.parent / CAMERA_FILE)
    rows = sorted(_iter_rows(path, 7, "TIME TX TY TZ QX QY QZ QW"))
    listed = [
        (picture, _find_nearest(rows, picture[0]))
        for picture in _iter_rows(path.with_name(TUM_PICTURES), 1, "TIME PICTURE")
    ]
    pictures, faults = collect_posed_pictures(
        partial(_read_tum_picture, picture, row, intrinsics)
        for picture, row in listed
        if row is not None
    )
    left_out = []
    for (_, where, (name,)), row in listed:
        if row is None:
            place = f"{where} ({name!r:.80})"
            line = f"{place}: {path.name} has no pose within {FARTHEST_S} s"
            left_out.append(LeftOut(name, line, place))
    if not pictures and not faults:
        raise InputError(
            f"{path}: no pose is within {FARTHEST_S} s of a picture in {TUM_PICTURES}: "
            "their times must be of one clock"
        )
    return PosesFile(path.parent, pictures, unit=unit, faults=faults, left_out=tuple(left_out))


def _iter_rows(path: Path, count: int, form: str) -> Iterator[_Row]:
    for where, line in iter_numbered_lines(path):
        words = line.split()
        try:
            time = float(words[0])
        except ValueError:
            time = np.nan
        if len(words) != count + 1 or not np.isfinite(time):
            raise InputError(f"{where}: not {form}: write each line so")
        yield time, where, tuple(words[1:])


def _find_nearest(rows: Sequence[_Row], time: float) -> _Row | None:
    nth = bisect_left(rows, (time,))
    near = min(rows[max(nth - 1, 0) : nth + 1], key=lambda row: abs(row[0] - time), default=None)
    return near if near is not None and abs(near[0] - time) <= FARTHEST_S else None


def _read_tum_picture(picture: _Row, row: _Row, intrinsics: Intrinsics) -> PosedPicture:
    (_, listed, (name,)), (_, where, words) = picture, row
    of_picture = f"{where} (of {name!r:.80})"
    *place, x, y, z, w = parse_finite(words, 7, of_picture)
    pose = make_pose(convert_quaternion((w, x, y, z), place, of_picture), np.array(place), where)
    own = replace(intrinsics, where=f"{listed} ({name!r:.80})")
    return PosedPicture(name, resolve_picture_path(Path(listed).parent, name), own, pose)


TUM = PoseReader(
    kind="TUM trajectory",
    needs=f"{TRAJECTORY} and {TUM_PICTURES} with {CAMERA_FILE}",
    find=make_file_finder(TRAJECTORY, TUM_PICTURES),
    lacks=make_missing_check(TRAJECTORY, TUM_PICTURES),
    takes=lambda path: path.name == TRAJECTORY,
    read=make_metric_reader(read_tum, "m"),
)


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
    if path.name == KITTI_POSES or path.parent.name != UNPACKED[1]:
        return path.parent
    return path.parent.with_name(UNPACKED[0]) / path.stem


def _find_kitti(folder: Path) -> Path | None:
    beside = make_file_finder(KITTI_POSES, CALIBRATION)(folder)
    whole = folder.resolve()
    if beside is None and whole.parent.name == UNPACKED[0] and (folder / CALIBRATION).is_file():
        unpacked = whole.parent.with_name(UNPACKED[1]) / f"{whole.name}.txt"
        return unpacked if unpacked.is_file() else None
    return beside


def _is_kitti_poses(path: Path) -> bool:
    unpacked = (
        path.parent.name == UNPACKED[1] and (_find_sequence_folder(path) / CALIBRATION).is_file()
    )
    return path.name == KITTI_POSES or unpacked


def _describe_missing_kitti(folder: Path) -> str:
    """Return what is missing of a sequence; a calib.txt by itself may be of any other camera."""
    sequence = (folder / KITTI_POSES).is_file() or any((folder / name).is_dir() for name in FOLDERS)
    return make_missing_check(KITTI_POSES, CALIBRATION)(folder) if sequence else ""


KITTI = PoseReader(
    kind="KITTI sequence",
    needs=f"KITTI's {KITTI_POSES} and {CALIBRATION} with {FOLDERS[0]}",
    find=_find_kitti,
    lacks=_describe_missing_kitti,
    takes=_is_kitti_poses,
    read=make_metric_reader(read_kitti, "m"),
)
