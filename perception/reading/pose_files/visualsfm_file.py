"""Poses from a VisualSFM project: a .nvm file beside or above its pictures.

Format: http://ccwu.me/vsfm/doc.html#nvm – models one after the other, each of a number of cameras,
for each a line of its picture's name (a space in it is written as a quotation mark), focal length,
quaternion (w, x, y, z) from world to camera, camera centre, radial distortion and a zero, then a
number of points and their lines. A camera looks along z, its y runs down the picture; the principal
point is the picture's middle unless the first line fixes it. The distortion r takes a measured
point m to the undistorted m (1 + r |m|²), in focal lengths. The world's unit and up are unknown.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.reading.lens import Distortion
from facetlog.perception.reading.pose_files.pose_checks import EXPORT, finite, posed, rotation_of
from facetlog.perception.reading.pose_files.pose_reader import PoseReader, by_unit
from facetlog.perception.reading.pose_files.poses_file import (
    Intrinsics,
    PosedPicture,
    PosesFile,
    metres_per,
    posed_pictures,
    read_text,
)

__all__ = ["VISUALSFM", "read_visualsfm"]

SUFFIX, VERSION, FIXED = ".nvm", "NVM_V3", "FixedK"
NUMBERS = 10
"""Of a camera's line, after its name."""
PIXEL_CENTRE = 0.5

_Line = tuple[str, str]
"""Place in the file, and text."""


@dataclass(frozen=True, slots=True)
class _Calibration:
    """What the first line fixes for all cameras, if it does: focal lengths and centre, px."""

    focal: tuple[float, float] | None = None
    centre: tuple[float, float] | None = None


def read_visualsfm(path: Path, unit: str | None) -> PosesFile:
    """The poses of the largest model in a .nvm file, in metres if `unit` is given.

    InputError for what is no such file, CalibrationError for a camera or pose that cannot be; both
    name the file and the line.
    """
    scale = None if unit is None else metres_per(unit, "--unit")
    calibration, models = _contents(path)
    largest = max(models, key=len, default=[])
    pictures, faults = posed_pictures(
        partial(_picture, line, path.parent, calibration, scale or 1.0) for line in largest
    )
    return PosesFile(path.parent, pictures, None, scale is not None, faults=faults)


def _contents(path: Path) -> tuple[_Calibration, list[list[_Line]]]:
    """The calibration, and of each model that has any the lines of its cameras."""
    lines = (
        (f"{path}:{number}", line)
        for number, line in enumerate(read_text(path).splitlines(), start=1)
        if line.strip() and not line.startswith("#")
    )
    where, first = next(lines, (str(path), ""))
    if first.split()[:1] != [VERSION]:
        raise InputError(f"{where}: the first word is not {VERSION}: save it as that")
    calibration = _calibration(where, first.split()[1:])
    models = []
    while cameras := list(_counted(lines, path)):
        models.append(cameras)
        for _ in _counted(lines, path):  # points
            pass
    return calibration, models


def _calibration(where: str, words: Sequence[str]) -> _Calibration:
    if words[:1] != [FIXED]:
        return _Calibration()
    fx, cx, fy, cy = finite(words[1:], 4, where)
    return _Calibration((fx, fy), (cx - PIXEL_CENTRE, cy - PIXEL_CENTRE))


def _counted(lines: Iterator[_Line], path: Path) -> Iterator[_Line]:
    """The lines that follow a line with their number; none at the file's end."""
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


def _picture(line: _Line, folder: Path, fixed: _Calibration, scale: float) -> PosedPicture:
    where, text = line
    name, *words = text.rsplit(maxsplit=NUMBERS)
    name = name.strip().replace('"', " ").replace("\\", "/")
    where = f"{where} ({name!r:.80})"
    focal, *turn_and_place, radial, _ = finite(words, NUMBERS, where)
    if focal <= 0:
        raise CalibrationError(
            f"{where}: the focal length is {focal:g}: give it in pixels, above 0"
        )
    intrinsics = Intrinsics(
        where=where,
        size=(None, None),
        focal=fixed.focal or (focal, focal),
        field_of_view=(None, None),
        centre=fixed.centre,  # None is the picture's middle
        distortion=Distortion.INVERSE,
        projection=(radial,),
    )
    quaternion, centre = turn_and_place[:4], turn_and_place[4:]
    rotation = rotation_of(quaternion, centre, where)
    pose = posed(rotation.T, np.array(centre) * scale, where)
    return PosedPicture(name, folder / name, intrinsics, pose)


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
    read=by_unit(read_visualsfm),
)
