"""Poses that a phone's ARKit found, in the folders that Polycam and Record3D export.

In both a camera looks along -z with y up (OpenGL's axes), the centre of the top-left pixel is
(0.5, 0.5), and lengths are metres.

Polycam's raw data, https://github.com/PolyCam/polyform#polycams-data-format: a file of numbers for
each picture of the same name, keyframes/corrected_cameras/ for corrected_images/ if poses were
optimised, else cameras/ for images/. t_00 to t_23 take camera to world, whose y is up. Exports of
today leave out width and height: they are the pictures'.

Record3D's, https://github.com/marek-simonik/record3d: metadata.json, or metadata, beside rgbd/ or
rgb/, whose pictures are numbered from 0: "K" is the matrix of intrinsics, column by column, or
"perFrameIntrinsicCoeffs" has fx, fy, cx, cy of each; "poses" are qx, qy, qz, qw and the place.
Whether they start from the first picture or upright is not said: up is unknown.
"""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.reading.pose_files.json_file import read_json, taken
from facetlog.perception.reading.pose_files.pose_checks import finite, posed, rotation_of
from facetlog.perception.reading.pose_files.pose_reader import PoseOptions, PoseReader, by_unit
from facetlog.perception.reading.pose_files.poses_file import (
    FieldNames,
    PosedPicture,
    PosesFile,
    metres_per,
    posed_pictures,
    read_intrinsics,
)
from facetlog.perception.types import FloatArray

__all__ = ["POLYCAM", "RECORD3D", "read_polycam", "read_record3d"]

# Folders of cameras and of the pictures that they took, the better ones first.
KEYFRAMES = "keyframes"
PAIRS = {"corrected_cameras": "corrected_images", "cameras": "images"}
METADATA, RGB = ("metadata.json", "metadata"), ("rgbd", "rgb")
ZIPPED = ".r3d"
SUFFIXES = (".jpg", ".jpeg", ".png")
OPENCV_FROM_OPENGL = np.diag([1.0, -1.0, -1.0])
OF_POLYCAM = FieldNames("width", "height", "fx", "fy", pixel_centre=0.5)
OF_RECORD3D = FieldNames("w", "h", "fx", "fy", pixel_centre=0.5)


def read_polycam(path: Path, unit: str | None) -> PosesFile:
    """The poses beside one of Polycam's cameras; y is up, lengths are metres or of `unit`.

    InputError for what is no such file, CalibrationError for a camera or pose that cannot be; both
    name the file.
    """
    scale = 1.0 if unit is None else metres_per(unit, "--unit")
    files = sorted(path.parent.glob("*.json"), key=lambda file: (len(file.name), file.name))
    images = path.parent.parent / PAIRS[path.parent.name]
    pictures, faults = posed_pictures(partial(_of_polycam, file, images, scale) for file in files)
    return PosesFile(_capture(path), pictures, np.array([0.0, 1.0, 0.0]), True, faults=faults)


def _capture(path: Path) -> Path:
    keyframes = path.parent.parent
    return keyframes.resolve().parent if keyframes.resolve().name == KEYFRAMES else keyframes


def _of_polycam(file: Path, images: Path, scale: float) -> PosedPicture:
    fields, where = read_json(file), str(file)
    names = [f"t_{row}{column}" for row in range(3) for column in range(4)]
    numbers = finite([taken(fields, where, name) for name in names], 12, where)
    matrix = np.array(numbers).reshape(3, 4)
    pose = posed(matrix[:, :3] @ OPENCV_FROM_OPENGL, matrix[:, 3] * scale, where)
    camera = {key: taken(fields, where, key) for key in ("fx", "fy", "cx", "cy")}
    if isinstance(fields, Mapping):
        camera |= {key: fields.get(key) for key in ("width", "height")}
    picture = _with_suffix(images, file.stem)
    name = f"{images.name}/{picture.name}"
    return PosedPicture(name, picture, read_intrinsics(_pinhole(camera), OF_POLYCAM, where), pose)


def read_record3d(path: Path, unit: str | None) -> PosesFile:
    """The poses in Record3D's metadata.json; lengths are metres, or of `unit`; errors as above."""
    scale = 1.0 if unit is None else metres_per(unit, "--unit")
    document, where = read_json(path), str(path)
    poses = taken(document, where, "poses")
    if not isinstance(document, Mapping) or not isinstance(poses, list):
        raise InputError(f'{path}: no list of "poses": is this Record3D\'s {METADATA[0]}?')
    images = next((path.parent / name for name in RGB if (path.parent / name).is_dir()), None)
    if images is None:
        raise InputError(f"{path.parent} has no folder {RGB[0]} of pictures beside {path.name}")
    pictures, faults = posed_pictures(
        partial(_of_record3d, number, document, images, scale, f"{path}: pose {number + 1}")
        for number in range(len(poses))
    )
    return PosesFile(path.parent, pictures, None, True, faults=faults)


def _of_record3d(
    number: int, document: Mapping[str, object], images: Path, scale: float, where: str
) -> PosedPicture:
    x, y, z, w, *place = finite(_row(document["poses"], number), 7, where)
    rotation = rotation_of((w, x, y, z), place, where) @ OPENCV_FROM_OPENGL
    pose = posed(rotation, np.array(place) * scale, where)
    each = document.get("perFrameIntrinsicCoeffs")
    if each:
        fx, fy, cx, cy = finite(_row(each, number), 4, f"{where}: its intrinsics")
    else:
        matrix: FloatArray = np.array(finite(_list(document.get("K")), 9, f"{where}: K"))
        (fx, _, cx), (_, fy, cy), _ = matrix.reshape(3, 3).T
    camera = {key: taken(document, where, key) for key in ("w", "h")}
    camera |= {"fx": float(fx), "fy": float(fy), "cx": float(cx), "cy": float(cy)}
    picture = _with_suffix(images, str(number))
    name = f"{images.name}/{picture.name}"
    return PosedPicture(name, picture, read_intrinsics(_pinhole(camera), OF_RECORD3D, where), pose)


def _pinhole(camera: Mapping[str, object]) -> Mapping[str, object]:
    return {"camera_model": "PINHOLE", **camera}


def _list(value: object) -> list[object]:
    return value if isinstance(value, list) else []


def _row(rows: object, number: int) -> list[object]:
    listed = _list(rows)
    return _list(listed[number]) if number < len(listed) else []


def _with_suffix(folder: Path, stem: str) -> Path:
    """The picture of a name; with the usual suffix where there is none, so that it is reported."""
    paths = [folder / f"{stem}{suffix}" for suffix in SUFFIXES]
    return next((path for path in paths if path.is_file()), paths[0])


def _find_polycam(folder: Path) -> Path | None:
    for cameras, images in PAIRS.items():
        for inside in (folder / KEYFRAMES, folder):
            if (inside / images).is_dir() and (files := sorted((inside / cameras).glob("*.json"))):
                return files[0]
    return None


def _find_record3d(folder: Path) -> Path | None:
    if not any((folder / name).is_dir() for name in RGB):
        return None
    return next((path for name in METADATA if (path := folder / name).is_file()), None)


def _refuse_zipped(path: Path, _options: PoseOptions) -> PosesFile:
    raise InputError(f"{path} is Record3D's export, {_unpack(path)}")


def _unpack(path: Path) -> str:
    return f"a zip: unpack it (unzip {path.name} -d {path.stem}) and give that folder"


def _lacks_unpacked(folder: Path) -> str:
    path = next(iter(sorted(folder.glob(f"*{ZIPPED}"))), None)
    return "" if path is None else f"{path.name} is {_unpack(path)}"


POLYCAM = PoseReader(
    kind="Polycam capture",
    needs=f"Polycam's {KEYFRAMES} folder",
    find=_find_polycam,
    takes=lambda path: path.suffix == ".json" and path.parent.name in PAIRS,
    read=by_unit(read_polycam),
)
RECORD3D = PoseReader(
    kind="Record3D capture",
    needs=f"Record3D's {METADATA[0]} with {RGB[0]}",
    find=_find_record3d,
    takes=lambda path: path.name in METADATA,
    read=by_unit(read_record3d),
)
RECORD3D_ZIP = PoseReader(
    kind="Record3D export",
    needs=f"Record3D's {ZIPPED}, unpacked",
    find=lambda _: None,
    lacks=_lacks_unpacked,
    takes=lambda path: path.suffix.lower() == ZIPPED,
    read=_refuse_zipped,
)
