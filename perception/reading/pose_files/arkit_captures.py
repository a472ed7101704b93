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
from facetlog.perception.reading.pose_files.file_values import (
    OPENCV_FROM_OPENGL,
    convert_quaternion,
    follow_keys,
    make_pose,
    parse_finite,
    read_json,
)
from facetlog.perception.reading.pose_files.pose_reader import (
    PoseOptions,
    PoseReader,
    make_metric_reader,
)
from facetlog.perception.reading.pose_files.poses_file import (
    FieldNames,
    PosedPicture,
    PosesFile,
    collect_posed_pictures,
    read_intrinsics,
)
from facetlog.perception.types import FloatArray, Pose

__all__ = ["POLYCAM", "RECORD3D", "RECORD3D_ZIP"]

# Folders of cameras and of the pictures that they took, the better ones first.
KEYFRAMES = "keyframes"
PAIRS = {"corrected_cameras": "corrected_images", "cameras": "images"}
METADATA, RGB = ("metadata.json", "metadata"), ("rgbd", "rgb")
ZIPPED = ".r3d"
SUFFIXES = (".jpg", ".jpeg", ".png")
OF_POLYCAM = FieldNames("width", "height", "fx", "fy", pixel_centre=0.5)
OF_RECORD3D = FieldNames("w", "h", "fx", "fy", pixel_centre=0.5)


def read_polycam(path: Path) -> PosesFile:
    """Return the poses beside one of Polycam's cameras; y is up."""
    files = sorted(path.parent.glob("*.json"), key=lambda file: (len(file.name), file.name))
    keyframes = path.parent.parent
    images = keyframes / PAIRS[path.parent.name]
    whole = keyframes.resolve()
    folder = whole.parent if whole.name == KEYFRAMES else keyframes
    pictures, faults = collect_posed_pictures(
        partial(_read_polycam_picture, file, images) for file in files
    )
    return PosesFile(folder, pictures, np.array([0.0, 1.0, 0.0]), faults=faults)


def _read_polycam_picture(file: Path, images: Path) -> PosedPicture:
    fields, where = read_json(file), str(file)
    names = [f"t_{row}{column}" for row in range(3) for column in range(4)]
    numbers = parse_finite([follow_keys(fields, where, name) for name in names], 12, where)
    matrix: FloatArray = np.reshape(numbers, (3, 4))
    pose = make_pose(matrix[:, :3] @ OPENCV_FROM_OPENGL, matrix[:, 3], where)
    camera = {key: follow_keys(fields, where, key) for key in ("fx", "fy", "cx", "cy")}
    if isinstance(fields, Mapping):
        camera |= {key: fields.get(key) for key in ("width", "height")}
    return _picture(images, file.stem, camera, OF_POLYCAM, pose, where)


def read_record3d(path: Path) -> PosesFile:
    """Return the poses in Record3D's metadata.json."""
    document, where = read_json(path), str(path)
    poses = follow_keys(document, where, "poses")
    if not isinstance(document, Mapping) or not isinstance(poses, list):
        raise InputError(f'{path}: no list of "poses": is this Record3D\'s {METADATA[0]}?')
    images = next((path.parent / name for name in RGB if (path.parent / name).is_dir()), None)
    if images is None:
        raise InputError(f"{path.parent} has no folder {RGB[0]} of pictures beside {path.name}")
    pictures, faults = collect_posed_pictures(
        partial(_read_record3d_picture, number, document, images, f"{path}: pose {number + 1}")
        for number in range(len(poses))
    )
    return PosesFile(path.parent, pictures, faults=faults)


def _read_record3d_picture(
    number: int, document: Mapping[str, object], images: Path, where: str
) -> PosedPicture:
    x, y, z, w, *place = parse_finite(_row(document["poses"], number), 7, where)
    rotation = convert_quaternion((w, x, y, z), place, where) @ OPENCV_FROM_OPENGL
    pose = make_pose(rotation, np.array(place), where)
    each = document.get("perFrameIntrinsicCoeffs")
    if each:
        fx, fy, cx, cy = parse_finite(_row(each, number), 4, f"{where}: its intrinsics")
    else:
        fx, _, _, _, fy, _, cx, cy, _ = parse_finite(document.get("K"), 9, f"{where}: K")
    camera = {key: follow_keys(document, where, key) for key in ("w", "h")}
    camera |= {"fx": fx, "fy": fy, "cx": cx, "cy": cy}
    return _picture(images, str(number), camera, OF_RECORD3D, pose, where)


def _picture(
    images: Path,
    stem: str,
    camera: Mapping[str, object],
    names: FieldNames,
    pose: Pose,
    where: str,
) -> PosedPicture:
    """Return a pinhole's picture; with the usual suffix where it is missing, to be reported."""
    paths = [images / f"{stem}{suffix}" for suffix in SUFFIXES]
    path = next((path for path in paths if path.is_file()), paths[0])
    intrinsics = read_intrinsics({"camera_model": "PINHOLE", **camera}, names, where)
    return PosedPicture(f"{images.name}/{path.name}", path, intrinsics, pose)


def _row(rows: object, number: int) -> object:
    return rows[number] if isinstance(rows, list) and number < len(rows) else None


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


def _find_zipped_export(folder: Path) -> str:
    path = next(iter(sorted(folder.glob(f"*{ZIPPED}"))), None)
    return "" if path is None else f"{path.name} is {_unpack(path)}"


POLYCAM = PoseReader(
    kind="Polycam capture",
    needs=f"Polycam's {KEYFRAMES} folder",
    find=_find_polycam,
    takes=lambda path: path.suffix == ".json" and path.parent.name in PAIRS,
    read=make_metric_reader(read_polycam, "m"),
)
RECORD3D = PoseReader(
    kind="Record3D capture",
    needs=f"Record3D's {METADATA[0]} with {RGB[0]}",
    find=_find_record3d,
    takes=lambda path: path.name in METADATA,
    read=make_metric_reader(read_record3d, "m"),
)
RECORD3D_ZIP = PoseReader(
    kind="Record3D export",
    needs=f"Record3D's {ZIPPED}, unpacked",
    find=lambda _: None,
    lacks=_find_zipped_export,
    takes=lambda path: path.suffix.lower() == ZIPPED,
    read=_refuse_zipped,
)
