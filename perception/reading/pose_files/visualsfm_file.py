"""Poses from a VisualSFM project: a .nvm file beside or above its pictures.

Format: http://ccwu.me/vsfm/doc.html#nvm – models one after the other, each of a number of cameras,
for each a line of its picture's name (a space in it is written as a quotation mark), focal length,
quaternion (w, x, y, z) from world to camera, camera centre, radial distortion and a zero, then a
number of points and their lines. A camera looks along z, its y runs down the picture; the principal
point is the picture's middle unless the first line fixes it. The distortion r takes a measured
point m to the undistorted m (1 + r |m|²), in focal lengths. The world's unit and up are unknown.
"""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.reading.lens import Distortion
from facetlog.perception.reading.pose_files.file_values import (
    EXPORT,
    convert_quaternion,
    iter_numbered_lines,
    make_pose,
    parse_finite,
)
from facetlog.perception.reading.pose_files.pose_reader import PoseReader, make_metric_reader
from facetlog.perception.reading.pose_files.poses_file import (
    Intrinsics,
    PosedPicture,
    PosesFile,
    collect_posed_pictures,
)

__all__ = ["VISUALSFM"]

SUFFIX, VERSION, FIXED = ".nvm", "NVM_V3", "FixedK"
NUMBERS = 10
"""Numbers in the line of a camera, after its name."""
PIXEL_CENTRE = 0.5

_Line = tuple[str, str]
"""Place in the file, and text."""


def read_visualsfm(path: Path) -> PosesFile:
    """Return the poses of the largest model in a .nvm file."""
    lines = iter_numbered_lines(path)
    where, first = next(lines, (str(path), ""))
    version, *words = first.split() or [""]
    if version != VERSION:
        raise InputError(f"{where}: the first word is not {VERSION}: save it as that")
    # What the first line may fix for all cameras, pixels.
    focal = centre = None
    if words[:1] == [FIXED]:
        fx, cx, fy, cy = parse_finite(words[1:], 4, where)
        focal, centre = (fx, fy), (cx - PIXEL_CENTRE, cy - PIXEL_CENTRE)
    largest: list[_Line] = []
    while cameras := list(_iter_counted(lines, path)):
        largest = max(largest, cameras, key=len)
        for _ in _iter_counted(lines, path):  # points
            pass
    pictures, faults = collect_posed_pictures(
        partial(_picture, line, path.parent, focal, centre) for line in largest
    )
    return PosesFile(path.parent, pictures, faults=faults)


def _iter_counted(lines: Iterator[_Line], path: Path) -> Iterator[_Line]:
    """Yield the lines that follow a line with their number; none at the file's end."""
    head = next(lines, None)
    if head is None:
        return
    where, text = head
    try:
        count = int(text)
    except ValueError as exc:
        raise InputError(f"{where}: not a number of cameras or points: {EXPORT}") from exc
    for done in range(count):
        line = next(lines, None)
        if line is None:
            raise InputError(f"{path} ends after {done} of {count} lines: {EXPORT}")
        yield line


def _picture(
    line: _Line,
    folder: Path,
    fixed_focal: tuple[float, float] | None,
    centre: tuple[float, float] | None,
) -> PosedPicture:
    where, text = line
    name, *words = text.rsplit(maxsplit=NUMBERS)
    name = name.strip().replace('"', " ").replace("\\", "/")
    where = f"{where} ({name!r:.80})"
    focal, *numbers, radial, _ = parse_finite(words, NUMBERS, where)
    if focal <= 0:
        raise CalibrationError(
            f"{where}: the focal length is {focal:g}: give it in pixels, above 0"
        )
    intrinsics = Intrinsics(
        where,
        focal=fixed_focal or (focal, focal),
        centre=centre,  # None is the picture's middle
        distortion=Distortion.INVERSE,
        projection=(radial,),
    )
    quaternion, place = numbers[:4], numbers[4:]
    rotation = convert_quaternion(quaternion, place, where)
    return PosedPicture(
        name, folder / name, intrinsics, make_pose(rotation.T, np.array(place), where)
    )


def _find(folder: Path) -> Path | None:
    paths = sorted(folder.glob(f"*{SUFFIX}"))
    return paths[0] if len(paths) == 1 else None


def _lacks(folder: Path) -> str:
    names = sorted(path.name for path in folder.glob(f"*{SUFFIX}"))
    return f"name the one to use of {' and '.join(names)}" if len(names) > 1 else ""


VISUALSFM = PoseReader(
    kind="VisualSFM model",
    needs=f"one {SUFFIX} file of VisualSFM",
    find=_find,
    lacks=_lacks,
    takes=lambda path: path.suffix == SUFFIX,
    read=make_metric_reader(read_visualsfm),
)
