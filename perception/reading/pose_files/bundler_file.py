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
from facetlog.perception.reading.lens import Distortion
from facetlog.perception.reading.pose_files.file_values import (
    OPENCV_FROM_OPENGL,
    iter_numbered_lines,
    make_pose,
    parse_finite,
)
from facetlog.perception.reading.pose_files.picture_places import resolve_picture_path
from facetlog.perception.reading.pose_files.pose_reader import PoseReader, make_metric_reader
from facetlog.perception.reading.pose_files.poses_file import (
    Intrinsics,
    PosedPicture,
    PosesFile,
    collect_posed_pictures,
    list_unregistered,
)

__all__ = ["BUNDLER"]

BUNDLE, LIST = "bundle.out", "list.txt"
LINES = 5
"""Lines of each picture."""

_Line = tuple[str, list[str]]
"""Place in the file, and words."""


def read_bundler(path: Path) -> PosesFile:
    """Return the poses in a bundle.out."""
    folder = path.parent
    if not (folder / LIST).is_file():
        folder = folder.resolve().parent
    if not (folder / LIST).is_file():
        raise InputError(f"{path} has no {LIST} beside or above it: put there the pictures' names")
    names = [line.split()[0] for _, line in iter_numbered_lines(folder / LIST)]
    lines: list[_Line] = [(where, line.split()) for where, line in iter_numbered_lines(path)]
    try:
        count = int(lines[0][1][0])
    except (IndexError, ValueError) as exc:
        raise InputError(f"{path}: no number of cameras: is this Bundler's {BUNDLE}?") from exc
    if count != len(names):
        raise InputError(
            f"{path} has {count} cameras, {folder / LIST} {len(names)} pictures: give its own"
        )
    blocks = [lines[1 + LINES * k : 1 + LINES * (k + 1)] for k in range(count)]
    if count and len(blocks[-1]) < LINES:
        raise InputError(f"{path} ends before camera {count}: it is truncated; export it again")
    named = list(zip(names, blocks, strict=True))
    pictures, faults = collect_posed_pictures(
        partial(_picture, name, block, folder) for name, block in named if _is_registered(block)
    )
    lost = list_unregistered(path, (name for name, block in named if not _is_registered(block)))
    return PosesFile(folder, pictures, faults=faults, left_out=lost)


def _is_registered(block: Sequence[_Line]) -> bool:
    try:
        return float(block[0][1][0]) != 0.0
    except ValueError:  # reported where it is read
        return True


def _picture(name: str, block: Sequence[_Line], folder: Path) -> PosedPicture:
    where = f"{block[0][0]} ({name!r:.80})"
    focal, k1, k2 = parse_finite(block[0][1], 3, block[0][0])
    if focal <= 0:
        raise CalibrationError(
            f"{where}: the focal length is {focal:g}: give it in pixels, above 0"
        )
    *rows, shift = (parse_finite(words, 3, place) for place, words in block[1:])
    rotation = OPENCV_FROM_OPENGL @ np.array(rows)
    centre = -rotation.T @ (OPENCV_FROM_OPENGL @ np.array(shift))
    intrinsics = Intrinsics(
        where, focal=(focal, focal), distortion=Distortion.POLYNOMIAL, radial=(k1, k2, 0.0, 0.0)
    )
    pose = make_pose(rotation.T, centre, where)
    return PosedPicture(name, resolve_picture_path(folder, name), intrinsics, pose)


def _find(folder: Path) -> Path | None:
    paths = folder / BUNDLE, folder / "bundle" / BUNDLE
    return next((path for path in paths if path.is_file()), None)


BUNDLER = PoseReader(
    kind="Bundler model",
    needs=f"Bundler's {BUNDLE} with {LIST}",
    find=_find,
    takes=lambda path: path.suffix == ".out",
    read=make_metric_reader(read_bundler),
)
