"""Poses from a trajectory of the TUM RGB-D benchmark: groundtruth.txt, rgb.txt and camera.toml.

Format: https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats – groundtruth.txt has lines
of time, tx ty tz and qx qy qz qw, in seconds and metres, camera to world; a camera looks along z,
its y runs down the picture. rgb.txt has lines of time and picture. A picture has the pose nearest
in time, as long as that is within 0.02 s, as in the benchmark's associate.py; others are left out.
The format gives no intrinsics: camera.toml is that of a pan-tilt tour (pan_tilt_file.py), save that
lengths are metres where it names no unit. Up is unknown.
"""

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.reading.left_out import LeftOut
from facetlog.perception.reading.pose_files.pan_tilt_file import CAMERA_FILE, read_camera
from facetlog.perception.reading.pose_files.picture_places import picture_path
from facetlog.perception.reading.pose_files.pose_checks import posed, rotation_of
from facetlog.perception.reading.pose_files.pose_reader import (
    PoseReader,
    by_unit,
    first_of,
    missing_of,
)
from facetlog.perception.reading.pose_files.poses_file import (
    Intrinsics,
    PosedPicture,
    PosesFile,
    posed_pictures,
    read_text,
)

__all__ = ["TUM", "read_tum"]

TRAJECTORY, PICTURES = "groundtruth.txt", "rgb.txt"
FARTHEST_S = 0.02
"""Largest difference in time of a picture and its pose: max_difference of associate.py."""

_Row = tuple[float, str, tuple[str, ...]]
"""Time, place in the file, words after the time."""


def read_tum(path: Path, unit: str | None) -> PosesFile:
    """The poses of the pictures in rgb.txt beside a trajectory; lengths in metres.

    InputError for what is no such file, CalibrationError for a camera or pose that cannot be; both
    name the file and the line.
    """
    intrinsics, scale = read_camera(path.parent / CAMERA_FILE, unit)
    rows = sorted(_rows(path, 7, "TIME TX TY TZ QX QY QZ QW"))
    listed = [
        (picture, _nearest(rows, picture[0]))
        for picture in _rows(path.with_name(PICTURES), 1, "TIME PICTURE")
    ]
    pictures, faults = posed_pictures(
        partial(_picture, picture, row, intrinsics, 1.0 if scale is None else scale)
        for picture, row in listed
        if row is not None
    )
    unposed = tuple(_unposed(picture, path) for picture, row in listed if row is None)
    if not pictures and not faults:
        raise InputError(
            f"{path}: no pose is within {FARTHEST_S} s of a picture in {PICTURES}: "
            "their times must be of one clock"
        )
    return PosesFile(path.parent, pictures, None, metric=True, faults=faults, left_out=unposed)


def _rows(path: Path, count: int, form: str) -> Iterator[_Row]:
    for number, line in enumerate(read_text(path).splitlines(), start=1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        where = f"{path}:{number}"
        try:
            time = float(words[0])
        except ValueError:
            time = np.nan
        if len(words) != count + 1 or not np.isfinite(time):
            raise InputError(f"{where}: not {form}: write each line so")
        yield time, where, tuple(words[1:])


def _nearest(rows: Sequence[_Row], time: float) -> _Row | None:
    nth = bisect_left(rows, (time,))
    near = min(rows[max(nth - 1, 0) : nth + 1], key=lambda row: abs(row[0] - time), default=None)
    return near if near is not None and abs(near[0] - time) <= FARTHEST_S else None


def _unposed(picture: _Row, path: Path) -> LeftOut:
    _, where, (name,) = picture
    line = f"{where} ({name!r:.80}): {path.name} has no pose within {FARTHEST_S} s"
    return LeftOut(name, line, f"{where} ({name!r:.80})")


def _picture(picture: _Row, row: _Row, intrinsics: Intrinsics, scale: float) -> PosedPicture:
    (_, listed, (name,)), (_, where, words) = picture, row
    try:
        numbers = tuple(float(word) for word in words)
    except ValueError as exc:
        raise InputError(f"{where}: a pose is seven numbers, not {' '.join(words)!r:.80}") from exc
    place, (x, y, z, w) = numbers[:3], numbers[3:]
    rotation = rotation_of((w, x, y, z), place, f"{where} (of {name!r:.80})")
    pose = posed(rotation, np.array(place) * scale, where)
    of_picture = replace(intrinsics, where=f"{listed} ({name!r:.80})")
    return PosedPicture(name, picture_path(Path(listed).parent, name), of_picture, pose)


TUM = PoseReader(
    kind="TUM trajectory",
    needs=f"{TRAJECTORY} and {PICTURES} with {CAMERA_FILE}",
    find=first_of(TRAJECTORY, PICTURES),
    lacks=missing_of(TRAJECTORY, PICTURES),
    takes=lambda path: path.name == TRAJECTORY,
    read=by_unit(read_tum),
)
