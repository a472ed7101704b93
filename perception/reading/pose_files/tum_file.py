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
    Intrinsics,
    PosedPicture,
    PosesFile,
    collect_posed_pictures,
)
from facetlog.perception.reading.skipped_images import LeftOut

__all__ = ["TUM"]

TRAJECTORY, PICTURES = "groundtruth.txt", "rgb.txt"
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
        for picture in _iter_rows(path.with_name(PICTURES), 1, "TIME PICTURE")
    ]
    pictures, faults = collect_posed_pictures(
        partial(_picture, picture, row, intrinsics) for picture, row in listed if row is not None
    )
    left_out = []
    for (_, where, (name,)), row in listed:
        if row is None:
            place = f"{where} ({name!r:.80})"
            line = f"{place}: {path.name} has no pose within {FARTHEST_S} s"
            left_out.append(LeftOut(name, line, place))
    if not pictures and not faults:
        raise InputError(
            f"{path}: no pose is within {FARTHEST_S} s of a picture in {PICTURES}: "
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


def _picture(picture: _Row, row: _Row, intrinsics: Intrinsics) -> PosedPicture:
    (_, listed, (name,)), (_, where, words) = picture, row
    of_picture = f"{where} (of {name!r:.80})"
    *place, x, y, z, w = parse_finite(words, 7, of_picture)
    pose = make_pose(convert_quaternion((w, x, y, z), place, of_picture), np.array(place), where)
    own = replace(intrinsics, where=f"{listed} ({name!r:.80})")
    return PosedPicture(name, resolve_picture_path(Path(listed).parent, name), own, pose)


TUM = PoseReader(
    kind="TUM trajectory",
    needs=f"{TRAJECTORY} and {PICTURES} with {CAMERA_FILE}",
    find=make_file_finder(TRAJECTORY, PICTURES),
    lacks=make_missing_check(TRAJECTORY, PICTURES),
    takes=lambda path: path.name == TRAJECTORY,
    read=make_metric_reader(read_tum, "m"),
)
