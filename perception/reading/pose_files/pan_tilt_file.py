"""Poses from a pan-tilt tour: a CSV file of poses and the camera.toml beside it.

The CSV has the columns image, x, y, z, pan_deg, tilt_deg, skew_deg: the pinhole's place in the
tour's unit of length and the paper's angles A, B, C (see pan_tilt.py). Lines that start with # are
comments. camera.toml has width, height, fx, fy, cx, cy in pixels (centre of the top-left pixel at
(0, 0)), unit ("m", "cm", "mm", "in", "ft"), and optionally camera_model, k1 to k4, p1, p2. The z
axis of such a tour points up.
"""

import csv
import io
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.pan_tilt import pan_tilt_pose
from facetlog.perception.reading.pose_files.file_values import get_metres_per, read_text
from facetlog.perception.reading.pose_files.picture_places import resolve_picture_path
from facetlog.perception.reading.pose_files.pose_reader import PoseReader, make_metric_reader
from facetlog.perception.reading.pose_files.poses_file import (
    PLAIN_NAMES,
    Intrinsics,
    PosedPicture,
    PosesFile,
    collect_posed_pictures,
    read_intrinsics,
)
from facetlog.toml_text import parse_toml_fields

CAMERA_FILE = "camera.toml"
POSES_FILE = "poses.csv"
COLUMNS = ("image", "x", "y", "z", "pan_deg", "tilt_deg", "skew_deg")
CAMERA_EXAMPLE = (
    'width, height, fx, fy, cx, cy, and the unit of the poses, as unit = "m" (or cm, mm, in, ft)'
)


def read_pan_tilt(path: Path) -> PosesFile:
    """Return the poses of a pan-tilt tour; InputError names file and line of what is none."""
    intrinsics, unit = read_camera(path.parent / CAMERA_FILE)
    pictures, faults = collect_posed_pictures(
        partial(_picture, row, path, f"{path}:{line}", intrinsics) for line, row in _rows(path)
    )
    return PosesFile(path.parent, pictures, np.array([0.0, 0.0, 1.0]), unit=unit, faults=faults)


def read_camera(path: Path) -> tuple[Intrinsics, str | None]:
    """Return the camera in a camera.toml, and the unit of length that it names, if any."""
    if not path.exists():
        raise CalibrationError(f"{path} is missing: write it with {CAMERA_EXAMPLE}")
    fields = parse_toml_fields(read_text(path), str(path))
    unit = fields.get("unit")
    if not isinstance(unit, str | None):
        raise InputError(f'{path}: unit is {unit!r:.40}: write it in quotes, as in "in"')
    if unit is not None:
        get_metres_per(unit, str(path))
    return read_intrinsics(fields, PLAIN_NAMES, str(path)), unit


def _rows(path: Path) -> Iterator[tuple[int, Mapping[str, str]]]:
    """Yield line number and fields of every pose."""
    lines = csv.reader(io.StringIO(read_text(path)), strict=True)
    header: tuple[str, ...] | None = None
    try:
        for cells in lines:
            if not any(cell.strip() for cell in cells) or cells[0].startswith("#"):
                continue
            if header is None:
                header = tuple(cell.strip() for cell in cells)
                missing = [name for name in COLUMNS if name not in header]
                if missing:
                    raise InputError(
                        f"{path}:{lines.line_num}: no column {', '.join(missing)}: "
                        f"the first line must be {','.join(COLUMNS)}"
                    )
                continue
            if len(cells) != len(header):
                raise InputError(
                    f"{path}:{lines.line_num}: {len(cells)} fields, the first line has "
                    f"{len(header)}"
                )
            yield lines.line_num, dict(zip(header, cells, strict=True))
    except csv.Error as exc:
        raise InputError(f"{path}:{lines.line_num}: not CSV: {exc}: correct it there") from exc
    if header is None:
        raise InputError(f"{path} is empty: the first line must be {','.join(COLUMNS)}")


def _picture(
    row: Mapping[str, str], path: Path, where: str, intrinsics: Intrinsics
) -> PosedPicture:
    name = row["image"].strip()
    if not name:
        raise InputError(f"{where}: no image: give the picture's path relative to this file")
    x, y, z, pan, tilt, skew = (_parse_finite_field(row[key], key, where) for key in COLUMNS[1:])
    angles = math.radians(pan), math.radians(tilt), math.radians(skew)
    try:
        pose = pan_tilt_pose(x, y, z, *angles)
    except CalibrationError as exc:
        raise CalibrationError(f"{where}: {exc}") from exc
    of_picture = replace(intrinsics, where=f"{where} ({name!r:.80})")
    return PosedPicture(name, resolve_picture_path(path.parent, name), of_picture, pose)


def _parse_finite_field(text: str, key: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise CalibrationError(f"{where}: {key} is {text!r:.40}: give a finite number")
    return value


def _find(folder: Path) -> Path | None:
    """Return poses.csv, or the only CSV; other tables that go with no camera are not meant as
    poses.
    """
    tables = sorted(p for p in folder.iterdir() if p.suffix.lower() == ".csv" and p.is_file())
    named = [p for p in tables if p.name == POSES_FILE]
    if not named and not (folder / CAMERA_FILE).is_file():
        return None
    if len(named or tables) > 1:
        raise InputError(f"{folder} has {len(tables)} CSV files: name the one with the poses")
    return next(iter(named or tables), None)


PAN_TILT = PoseReader(
    kind="pan-tilt tour",
    needs=f"{POSES_FILE} ({','.join(COLUMNS)}) with {CAMERA_FILE}",
    find=_find,
    takes=lambda path: path.suffix.lower() == ".csv",
    read=make_metric_reader(read_pan_tilt),
)
