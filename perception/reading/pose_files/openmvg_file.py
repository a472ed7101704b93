"""Poses from OpenMVG's sfm_data.json.

Format: https://openmvg.readthedocs.io/en/latest/software/SfM/SfM_OutputFormat – lists of views,
intrinsics and extrinsics, each with a key, tied together by id_intrinsic and id_pose. A rotation
(3 x 3) and a centre take world to camera; a camera looks along z, its y runs down the picture, and
the middle of its top-left pixel is (0, 0). The kind of a camera is written by name where it comes
first, and then by number. A view without extrinsics was not registered, and is left out. The
world's unit and up are unknown.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path, PureWindowsPath

import numpy as np

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.reading.left_out import LeftOut
from facetlog.perception.reading.pose_files.json_file import read_json, taken
from facetlog.perception.reading.pose_files.pose_checks import EXPORT, finite, is_file, posed
from facetlog.perception.reading.pose_files.pose_reader import PoseReader, by_unit, first_of
from facetlog.perception.reading.pose_files.poses_file import (
    FieldNames,
    Intrinsics,
    PosedPicture,
    PosesFile,
    metres_per,
    posed_pictures,
    read_intrinsics,
)

__all__ = ["OPENMVG", "read_openmvg"]

SFM_DATA, PICTURES = "sfm_data.json", "images"
BINARY = "sfm_data.bin"
NAMES = FieldNames("width", "height", "fx", "fy", pixel_centre=0.0)
# Kinds of cameras: the model that they are, where their coefficients stand, and these' names.
CAMERAS = {
    "pinhole": ("PINHOLE", "", ()),
    "pinhole_radial_k1": ("OPENCV", "disto_k1", ("k1",)),
    "pinhole_radial_k3": ("OPENCV", "disto_k3", ("k1", "k2", "k3")),
    "pinhole_brown_t2": ("OPENCV", "disto_t2", ("k1", "k2", "k3", "p1", "p2")),
    "fisheye": ("OPENCV_FISHEYE", "fisheye", ("k1", "k2", "k3", "k4")),
}
FIRST_OF_ITS_KIND = 1 << 31
"""The bit of a polymorphic_id beside which the kind's name stands."""


@dataclass(frozen=True, slots=True)
class _View:
    name: str
    intrinsic: object
    pose: object
    where: str


def read_openmvg(path: Path, unit: str | None) -> PosesFile:
    """The poses in a sfm_data.json, in metres if `unit` is given.

    InputError for what is no such file, CalibrationError for a camera or pose that cannot be; both
    name the file and the picture.
    """
    scale = None if unit is None else metres_per(unit, "--unit")
    document, where = read_json(path), str(path)
    views = [_view(entry, path) for _, entry in _entries(document, "views", where)]
    intrinsics = dict(_intrinsics(document, where))
    poses = dict(_entries(document, "extrinsics", where))
    folder, inside = _home(path, str(taken(document, where, "root_path")), views)
    pictures, faults = posed_pictures(
        partial(_picture, view, intrinsics, poses[view.pose], inside, scale or 1.0)
        for view in views
        if view.pose in poses
    )
    unposed = tuple(
        LeftOut(view.name, f"{path}: {view.name} has no pose: it was not registered", view.name)
        for view in views
        if view.pose not in poses
    )
    return PosesFile(folder, pictures, None, scale is not None, faults=faults, left_out=unposed)


def _entries(document: object, name: str, where: str) -> Iterator[tuple[object, object]]:
    entries = taken(document, where, name)
    if not isinstance(entries, list):
        raise InputError(f"{where}: {name!r} is no list: is this OpenMVG's {SFM_DATA}?")
    for number, entry in enumerate(entries, start=1):
        of = f"{where}: {name} {number}"
        yield taken(entry, of, "key"), taken(entry, of, "value")


def _view(entry: object, path: Path) -> _View:
    data = taken(entry, f"{path}: a view", "ptr_wrapper", "data")
    where = f"{path}: view {taken(data, f'{path}: a view', 'id_view')!r:.20}"
    names = [str(taken(data, where, key)) for key in ("local_path", "filename")]
    name = PureWindowsPath(*names).as_posix()  # which reads either kind of slash
    view, pose = taken(data, where, "id_intrinsic"), taken(data, where, "id_pose")
    return _View(name, view, pose, f"{where} ({name!r:.80})")


def _intrinsics(document: object, where: str) -> Iterator[tuple[object, Intrinsics]]:
    kinds: dict[int, str] = {}
    for key, entry in _entries(document, "intrinsics", where):
        of = f"{where}: intrinsic {key!r:.20}"
        number = taken(entry, of, "polymorphic_id")
        data = taken(entry, of, "ptr_wrapper", "data")
        if not isinstance(number, int) or not isinstance(data, Mapping):
            raise InputError(f"{of}: not a camera as OpenMVG writes it: {EXPORT}")
        if number & FIRST_OF_ITS_KIND:
            number -= FIRST_OF_ITS_KIND
            kinds[number] = str(taken(entry, of, "polymorphic_name"))
        yield key, _camera(kinds.get(number, ""), data, of)


def _camera(kind: str, data: Mapping[str, object], where: str) -> Intrinsics:
    if kind not in CAMERAS:
        raise CalibrationError(
            f"{where}: the camera is of kind {kind!r:.40}, not one of {', '.join(CAMERAS)}: "
            "undistort the pictures and give a pinhole"
        )
    base = data.get("value0")  # where some versions put what all cameras have
    data = {**(base if isinstance(base, Mapping) else {}), **data}
    model, key, names = CAMERAS[kind]
    given = data.get(key, ())
    numbers = finite(given if isinstance(given, list | tuple) else (), len(names), where)
    fields: dict[str, object] = {"camera_model": model, **dict(zip(names, numbers, strict=True))}
    fields |= {name: data.get(name) for name in ("width", "height")}
    fields["fx"] = fields["fy"] = data.get("focal_length")
    centre = data.get("principal_point")
    fields["cx"], fields["cy"] = finite(
        centre if isinstance(centre, list) else (), 2, f"{where}: principal_point"
    )
    return read_intrinsics(fields, NAMES, where)


def _home(path: Path, root: str, views: list[_View]) -> tuple[Path, Path]:
    """The folder of the whole project, and the one that picture names start from.

    That is root_path, if it is below; but projects are moved, so that the pictures may be in
    images/ beside the file or beside its folder, or right there: where most of them are found.
    """
    folder = path.parent
    places = [(folder, folder / root)]
    places += [
        (each, inside)
        for each in (folder, folder.resolve().parent)
        for inside in (each / PICTURES, each)
    ]
    return max(places, key=lambda place: sum(is_file(place[1] / view.name) for view in views))


def _picture(
    view: _View,
    intrinsics: Mapping[object, Intrinsics],
    pose: object,
    inside: Path,
    scale: float,
) -> PosedPicture:
    if view.intrinsic not in intrinsics:
        raise CalibrationError(
            f"{view.where}: there is no intrinsic {view.intrinsic!r:.20}: {EXPORT}"
        )
    rows, place = taken(pose, view.where, "rotation"), taken(pose, view.where, "center")
    numbers = (
        [n for row in rows if isinstance(row, list) for n in row] if isinstance(rows, list) else []
    )
    rotation = np.array(finite(numbers, 9, f"{view.where}: rotation")).reshape(3, 3)
    centre = finite(place if isinstance(place, list) else (), 3, f"{view.where}: center")
    found = posed(rotation.T, np.array(centre) * scale, view.where)
    return PosedPicture(view.name, inside / view.name, intrinsics[view.intrinsic], found)


def _lacks(folder: Path) -> str:
    if not (folder / BINARY).is_file() or (folder / SFM_DATA).is_file():
        return ""
    convert = f"openMVG_main_ConvertSfM_DataFormat -V -I -E -i {BINARY} -o {SFM_DATA}"
    return f"{SFM_DATA} is missing beside {BINARY}: write it by {convert}"


OPENMVG = PoseReader(
    kind="OpenMVG model",
    needs=f"OpenMVG's {SFM_DATA}",
    find=first_of(SFM_DATA),
    lacks=_lacks,
    takes=lambda path: path.name == SFM_DATA,
    read=by_unit(read_openmvg),
)
