"""Poses of captures: nerfstudio's and Blender's transforms, Polycam's and Record3D's folders.

In all of them a camera looks along -z with y up (OpenGL's axes: x right, y up, z backward), and the
centre of the top-left pixel is (0.5, 0.5).

nerfstudio's transforms.json, https://docs.nerf.studio/quickstart/data_conventions.html –
camera-to-world matrices, and intrinsics for all frames or for each. The format has neither scale
nor up axis nor pose covariances. Four keys add them, which other readers ignore: "unit", "up" and
"pose_errors" of the whole, and of a frame "covariance", 6 x 6 of x, y, z and of a rotation vector
in the world frame, in radians. "pose_errors" is "odometry", the default (errors add up from frame
to frame), or "independent" (each frame has its own). "video", of the whole or of a frame, takes
pictures from a video: a file beside this one, of which "frame" is the number (from 0; without it
the frame's place in the list), or a camera, a device's number or a stream's address, which takes
its picture when the frame is read.

transforms_train.json of Blender's exports and of NeRF's data is of the same form.

Poses that a phone's ARKit found are in metres. Polycam's raw data,
https://github.com/PolyCam/polyform#polycams-data-format: a file of numbers for each picture of the
same name, keyframes/corrected_cameras/ for corrected_images/ if poses were optimised, else cameras/
for images/. t_00 to t_23 take camera to world, whose y is up. Exports of today leave out width and
height: they are the pictures'.

Record3D's, https://github.com/marek-simonik/record3d: metadata.json, or metadata, beside rgbd/ or
rgb/, whose pictures are numbered from 0: "K" is the matrix of intrinsics, column by column, or
"perFrameIntrinsicCoeffs" has fx, fy, cx, cy of each; "poses" are qx, qy, qz, qw and the place.
Whether they start from the first picture or upright is not said: up is unknown.
"""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.reading.pose_files.file_values import (
    OPENCV_FROM_OPENGL,
    convert_quaternion,
    follow_keys,
    get_metres_per,
    make_pose,
    parse_array,
    parse_finite,
    read_json,
)
from facetlog.perception.reading.pose_files.picture_places import resolve_picture_path
from facetlog.perception.reading.pose_files.pose_reader import (
    PoseOptions,
    PoseReader,
    make_file_finder,
    make_metric_reader,
)
from facetlog.perception.reading.pose_files.poses_file import (
    COEFFICIENTS,
    FieldNames,
    PosedPicture,
    PosesFile,
    collect_posed_pictures,
    read_intrinsics,
)
from facetlog.perception.reading.video_file import VideoFrame
from facetlog.perception.types import FloatArray, Pose, PoseErrorKind

# Folders of cameras and of the pictures that they took, the better ones first.
KEYFRAMES = "keyframes"
PAIRS = {"corrected_cameras": "corrected_images", "cameras": "images"}
METADATA, RGB = ("metadata.json", "metadata"), ("rgbd", "rgb")
ZIPPED = ".r3d"
SUFFIXES = (".jpg", ".jpeg", ".png")
OF_POLYCAM = FieldNames("width", "height", "fx", "fy", pixel_centre=0.5)
OF_RECORD3D = FieldNames("w", "h", "fx", "fy", pixel_centre=0.5)
TRANSFORMS_FILE, TRAIN_FILE = "transforms.json", "transforms_train.json"

NAMES = FieldNames("w", "h", "fl_x", "fl_y", pixel_centre=0.5)
CAMERA_FIELDS = (
    *("camera_model", "w", "h", "fl_x", "fl_y", "cx", "cy", "camera_angle_x", "camera_angle_y"),
    *("is_fisheye", *COEFFICIENTS),
)
FISHEYE = "OPENCV_FISHEYE"
# Names without an extension (as Blender's exports have them) are tried with these, in order.
EXTENSIONS = (".png", ".jpg", ".jpeg", ".JPG", ".JPEG", ".PNG", ".tif", ".tiff", ".webp", ".bmp")
LAST_ROW_TOLERANCE = 1e-6
SYMMETRY = 1e-6
"""Effect of rounding on a covariance, as a share of its largest entry."""


def read_transforms(path: Path) -> PosesFile:
    """Return the poses in a transforms.json; InputError names file and frame of what is none."""
    document = read_json(path)
    if not isinstance(document, dict) or not isinstance(document.get("frames"), list):
        raise InputError(f'{path}: no list of "frames": is this nerfstudio\'s transforms.json?')
    unit = document.get("unit")
    if unit is not None:
        get_metres_per(unit, f"{path}: unit")
    pictures, faults = collect_posed_pictures(
        partial(_read_frame, frame, document, path, index)
        for index, frame in enumerate(document["frames"])
    )
    kind = _error_kind(document.get("pose_errors"), path)
    up = _parse_up(document.get("up"), path)
    return PosesFile(path.parent, pictures, up, unit=unit, error_kind=kind, faults=faults)


def _error_kind(said: object, path: Path) -> PoseErrorKind:
    if said is None:
        return PoseErrorKind.ODOMETRY
    if not isinstance(said, str) or said not in list(PoseErrorKind):
        kinds = " or ".join(PoseErrorKind)
        raise CalibrationError(f"{path}: pose_errors is {said!r:.40}, it must be {kinds}")
    return PoseErrorKind(said)


def _parse_up(said: object, path: Path) -> FloatArray | None:
    if said is None:
        return None
    direction = parse_array(said, 3)
    if direction is None or not direction.any():
        raise CalibrationError(f"{path}: up is not three numbers, not all 0: give a direction")
    direction = direction / np.abs(direction).max()  # whose squares neither over- nor underflow
    return np.asarray(direction / np.linalg.norm(direction))


def _parse_covariance(rows: object, where: str) -> FloatArray | None:
    """Return the covariance of a frame, if it has one; CalibrationError if it is none."""
    if rows is None:
        return None
    fault = f"{where}: covariance is not a symmetric, positive 6 x 6 matrix of finite numbers"
    matrix = parse_array(rows, 6, 6)
    if matrix is None:
        raise CalibrationError(fault)
    largest = np.abs(matrix).max()
    if np.abs(matrix - matrix.T).max() > SYMMETRY * largest:
        raise CalibrationError(fault)
    matrix = matrix / 2 + matrix.T / 2
    if largest > 0 and np.linalg.eigvalsh(matrix / largest).min() < -SYMMETRY:
        raise CalibrationError(fault)
    return matrix


def _read_frame(
    frame: object, document: Mapping[str, object], path: Path, index: int
) -> PosedPicture:
    where = f"{path}: frame {index + 1}"
    entries = frame if isinstance(frame, dict) else {}
    of_video = _parse_video_frame(entries, document, path, index, where)
    name = entries.get("file_path", of_video and of_video.name(index))
    if not isinstance(frame, dict) or not isinstance(name, str) or not name:
        raise InputError(f"{where}: no file_path: give the picture's path relative to this file")
    where = f"{where} ({name!r:.80})"
    fields = {key: frame.get(key, document.get(key)) for key in CAMERA_FIELDS}
    fields = _apply_is_fisheye(fields, where)
    matrix = _parse_transform(frame.get("transform_matrix"), where)
    rotation = matrix[:3, :3] @ OPENCV_FROM_OPENGL
    return PosedPicture(
        name=name,
        path=Path(of_video.source)
        if of_video
        else resolve_picture_path(path.parent, name, EXTENSIONS),
        intrinsics=read_intrinsics(fields, NAMES, where),
        pose=make_pose(rotation, matrix[:3, 3], f"{where}: transform_matrix"),
        covariance=_parse_covariance(frame.get("covariance"), where),
        frame=of_video,
    )


def _apply_is_fisheye(fields: dict[str, object], where: str) -> dict[str, object]:
    """Return the fields with instant-ngp's `is_fisheye`, by which OpenCV's fisheye is meant, as a
    model.

    Source: read_lens of instant-ngp's nerf_loader.cu.
    """
    said = fields.pop("is_fisheye")
    if said is None or said is False:
        return fields
    if said is not True:
        raise CalibrationError(f"{where}: is_fisheye is {said!r:.40}: give true or false")
    model = fields["camera_model"]
    if model not in (None, FISHEYE):
        raise CalibrationError(
            f"{where}: is_fisheye is true, yet camera_model is {model!r:.40}: leave one out"
        )
    return {**fields, "camera_model": FISHEYE}


def _parse_video_frame(
    frame: Mapping[str, object],
    document: Mapping[str, object],
    path: Path,
    index: int,
    where: str,
) -> VideoFrame | None:
    """Return the frame of a video that a picture is, None if it is a file of its own."""
    video = frame.get("video", document.get("video"))
    if video is None:
        return None
    if type(video) is int and video >= 0:
        return VideoFrame(str(video), None)
    if not isinstance(video, str) or not video:
        raise InputError(f"{where}: video is {video!r:.40}: give a file, a device or an address")
    if "://" in video or video.startswith("/dev/"):
        return VideoFrame(video, None)
    number = frame.get("frame", index)
    if type(number) is not int or number < 0:
        raise InputError(f"{where}: frame is {number!r:.40}: give its number in the video, from 0")
    return VideoFrame(str(path.parent / video), number)


def _parse_transform(rows: object, where: str) -> FloatArray:
    """Return the 4 x 4 (or 3 x 4) camera-to-world matrix of a frame, its last row checked."""
    whole = parse_array(rows, 4, 4)
    matrix = parse_array(rows, 3, 4) if whole is None else whole
    if matrix is None:
        fault = "is missing" if rows is None else "is not 4 x 4 finite numbers"
        raise CalibrationError(f"{where}: transform_matrix {fault}: give camera-to-world")
    if len(matrix) == 4 and np.abs(matrix[3] - [0, 0, 0, 1]).max() > LAST_ROW_TOLERANCE:
        raise CalibrationError(
            f"{where}: the last row of transform_matrix is not 0 0 0 1: "
            "give camera-to-world with the position in the last column"
        )
    return matrix


TRANSFORMS = PoseReader(
    kind="nerfstudio's transforms.json",
    needs=TRANSFORMS_FILE,
    find=make_file_finder(TRANSFORMS_FILE),
    takes=lambda path: path.suffix.lower() == ".json",
    read=make_metric_reader(read_transforms),
    made_from=("COLMAP model",),  # by nerfstudio's tools; and `facetlog collect` writes both
)
BLENDER = PoseReader(
    kind=f"Blender's {TRAIN_FILE}",
    needs=TRAIN_FILE,
    find=make_file_finder(TRAIN_FILE),
    takes=lambda path: path.name == TRAIN_FILE,
    read=make_metric_reader(read_transforms),
)


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
    return _make_picture(images, file.stem, camera, OF_POLYCAM, pose, where)


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
    return _make_picture(images, str(number), camera, OF_RECORD3D, pose, where)


def _make_picture(
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
