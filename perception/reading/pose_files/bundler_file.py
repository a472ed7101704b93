"""Poses from Bundler's bundle.out, with the names of its pictures in list.txt.

Format: https://www.cs.cornell.edu/~snavely/bundler/bundler-v0.4-manual.html – for each picture a
line of f, k1, k2, three of a rotation and one of a translation, world to camera. A camera looks
along -z with y up; pixels count from the picture's middle. A picture of focal length 0 was not
registered, and is left out. The world's unit and up are unknown.
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.reading.left_out import LeftOut
from facetlog.perception.reading.lens import Distortion
from facetlog.perception.reading.pose_files.picture_places import picture_path
from facetlog.perception.reading.pose_files.pose_checks import finite, posed
from facetlog.perception.reading.pose_files.pose_reader import PoseReader, by_unit
from facetlog.perception.reading.pose_files.poses_file import (
    Intrinsics,
    PosedPicture,
    PosesFile,
    metres_per,
    posed_pictures,
    read_text,
)

__all__ = ["BUNDLER", "read_bundler"]

BUNDLE, LIST = "bundle.out", "list.txt"
LINES = 5
"""Of each picture."""
OPENCV_FROM_BUNDLER = np.diag([1.0, -1.0, -1.0])

_Line = tuple[str, list[str]]
"""Place in the file, and words."""


def read_bundler(path: Path, unit: str | None) -> PosesFile:
    """The poses in a bundle.out, in metres if `unit` is given.

    InputError for what is no such file, CalibrationError for a camera or pose that cannot be; both
    name the file and the line.
    """
    scale = None if unit is None else metres_per(unit, "--unit")
    listed = _list_of(path)
    names = [line.split()[0] for line in read_text(listed).splitlines() if line.strip()]
    lines = [
        (f"{path}:{number}", line.split())
        for number, line in enumerate(read_text(path).splitlines(), start=1)
        if line.strip() and not line.startswith("#")
    ]
    count = _count(lines, path)
    if count != len(names):
        raise InputError(
            f"{path} has {count} cameras, {listed} {len(names)} pictures: give its own"
        )
    blocks = [lines[1 + LINES * k : 1 + LINES * (k + 1)] for k in range(count)]
    if count and len(blocks[-1]) < LINES:
        raise InputError(f"{path} ends before camera {count}: it is truncated; export it again")
    pictures, faults = posed_pictures(
        partial(_picture, name, block, listed.parent, scale or 1.0)
        for name, block in zip(names, blocks, strict=True)
        if _registered(block[0])
    )
    unposed = tuple(
        LeftOut(name, f"{path}: {name} has no pose: it was not registered", name)
        for name, block in zip(names, blocks, strict=True)
        if not _registered(block[0])
    )
    return PosesFile(
        listed.parent, pictures, None, scale is not None, faults=faults, left_out=unposed
    )


def _list_of(path: Path) -> Path:
    for folder in (path.parent, path.parent.resolve().parent):
        if (folder / LIST).is_file():
            return folder / LIST
    raise InputError(f"{path} has no {LIST} beside or above it: put there the pictures' names")


def _count(lines: Sequence[_Line], path: Path) -> int:
    try:
        return int(lines[0][1][0])
    except (IndexError, ValueError) as exc:
        raise InputError(f"{path}: no number of cameras: is this Bundler's {BUNDLE}?") from exc


def _registered(line: _Line) -> bool:
    try:
        return float(line[1][0]) != 0.0
    except ValueError:  # reported where it is read
        return True


def _numbers(line: _Line, count: int) -> list[float]:
    where, words = line
    return finite(words, count, where)


def _picture(name: str, block: Sequence[_Line], folder: Path, scale: float) -> PosedPicture:
    where = f"{block[0][0]} ({name!r:.80})"
    focal, k1, k2 = _numbers(block[0], 3)
    if focal <= 0:
        raise CalibrationError(
            f"{where}: the focal length is {focal:g}: give it in pixels, above 0"
        )
    rotation = OPENCV_FROM_BUNDLER @ np.array([_numbers(line, 3) for line in block[1:4]])
    shift = OPENCV_FROM_BUNDLER @ np.array(_numbers(block[4], 3))
    intrinsics = Intrinsics(
        where=where,
        size=(None, None),
        focal=(focal, focal),
        field_of_view=(None, None),
        centre=None,  # the picture's middle
        distortion=Distortion.POLYNOMIAL,
        radial=(k1, k2, 0.0, 0.0),
    )
    pose = posed(rotation.T, -rotation.T @ shift * scale, where)
    return PosedPicture(name, picture_path(folder, name), intrinsics, pose)


def _find(folder: Path) -> Path | None:
    for path in (folder / BUNDLE, folder / "bundle" / BUNDLE):
        if path.is_file():
            return path
    return None


BUNDLER = PoseReader(
    kind="Bundler model",
    needs=f"Bundler's {BUNDLE} with {LIST}",
    find=_find,
    takes=lambda path: path.suffix == ".out",
    read=by_unit(read_bundler),
)
