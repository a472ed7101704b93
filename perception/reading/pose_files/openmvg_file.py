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
from facetlog.perception.reading.pose_files.file_values import (
    EXPORT,
    flatten_rows,
    follow_keys,
    is_file,
    make_pose,
    parse_finite,
    read_json,
)
from facetlog.perception.reading.pose_files.pose_reader import (
    PoseReader,
    make_file_finder,
    make_metric_reader,
)
from facetlog.perception.reading.pose_files.poses_file import (
    PLAIN_NAMES,
    Intrinsics,
    PosedPicture,
    PosesFile,
    collect_posed_pictures,
    list_unregistered,
    read_intrinsics,
)

__all__ = ["OPENMVG"]

SFM_DATA, PICTURES = "sfm_data.json", "images"
BINARY = "sfm_data.bin"
# Kinds of cameras: the model that they are, and the key and names of their coefficients.
CAMERAS = {
    "pinhole": ("PINHOLE", "", ()),
    "pinhole_radial_k1": ("OPENCV", "disto_k1", ("k1",)),
    "pinhole_radial_k3": ("OPENCV", "disto_k3", ("k1", "k2", "k3")),
    "pinhole_brown_t2": ("OPENCV", "disto_t2", ("k1", "k2", "k3", "p1", "p2")),
    "fisheye": ("OPENCV_FISHEYE", "fisheye", ("k1", "k2", "k3", "k4")),
}
FIRST_OF_ITS_KIND = 1 << 31
"""The bit of a polymorphic_id beside which the kind's name is."""


@dataclass(frozen=True, slots=True)
class _View:
    name: str
    intrinsic: object
    pose: object
    where: str


def read_openmvg(path: Path) -> PosesFile:
    """Return the poses in a sfm_data.json."""
    document, where = read_json(path), str(path)
    views = [_parse_view(entry, path) for _, entry in _iter_entries(document, "views", where)]
    intrinsics = dict(_iter_intrinsics(document, where))
    poses = dict(_iter_entries(document, "extrinsics", where))
    folder, inside = _find_pictures(path, str(follow_keys(document, where, "root_path")), views)
    pictures, faults = collect_posed_pictures(
        partial(_picture, view, intrinsics, poses[view.pose], inside)
        for view in views
        if view.pose in poses
    )
    lost = list_unregistered(path, (view.name for view in views if view.pose not in poses))
    return PosesFile(folder, pictures, faults=faults, left_out=lost)


def _iter_entries(document: object, name: str, where: str) -> Iterator[tuple[object, object]]:
    entries = follow_keys(document, where, name)
    if not isinstance(entries, list):
        raise InputError(f"{where}: {name!r} is no list: is this OpenMVG's {SFM_DATA}?")
    for number, entry in enumerate(entries, start=1):
        place = f"{where}: {name} {number}"
        yield follow_keys(entry, place, "key"), follow_keys(entry, place, "value")


def _parse_view(entry: object, path: Path) -> _View:
    data = follow_keys(entry, f"{path}: a view", "ptr_wrapper", "data")
    where = f"{path}: view {follow_keys(data, f'{path}: a view', 'id_view')!r:.20}"
    folder, name, intrinsic, pose = (
        follow_keys(data, where, key)
        for key in ("local_path", "filename", "id_intrinsic", "id_pose")
    )
    name = PureWindowsPath(str(folder), str(name)).as_posix()  # which reads either kind of slash
    return _View(name, intrinsic, pose, f"{where} ({name!r:.80})")


def _iter_intrinsics(document: object, where: str) -> Iterator[tuple[object, Intrinsics]]:
    kinds: dict[int, str] = {}
    for key, entry in _iter_entries(document, "intrinsics", where):
        place = f"{where}: intrinsic {key!r:.20}"
        number = follow_keys(entry, place, "polymorphic_id")
        data = follow_keys(entry, place, "ptr_wrapper", "data")
        if not isinstance(number, int) or not isinstance(data, Mapping):
            raise InputError(f"{place}: not a camera as OpenMVG writes it: {EXPORT}")
        if number & FIRST_OF_ITS_KIND:
            number -= FIRST_OF_ITS_KIND
            kinds[number] = str(follow_keys(entry, place, "polymorphic_name"))
        yield key, _parse_camera(kinds.get(number, ""), data, place)


def _parse_camera(kind: str, data: Mapping[str, object], where: str) -> Intrinsics:
    if kind not in CAMERAS:
        raise CalibrationError(
            f"{where}: the camera is of kind {kind!r:.40}, not one of {', '.join(CAMERAS)}: "
            "undistort the pictures and give a pinhole"
        )
    base = data.get("value0")  # where some versions put what all cameras have
    data = {**(base if isinstance(base, Mapping) else {}), **data}
    model, key, names = CAMERAS[kind]
    numbers = parse_finite(data.get(key, ()), len(names), where)
    fields: dict[str, object] = {"camera_model": model, **dict(zip(names, numbers, strict=True))}
    fields |= {name: data.get(name) for name in ("width", "height")}
    fields["fx"] = fields["fy"] = data.get("focal_length")
    fields["cx"], fields["cy"] = parse_finite(
        data.get("principal_point"), 2, f"{where}: principal_point"
    )
    return read_intrinsics(fields, PLAIN_NAMES, where)


def _find_pictures(path: Path, root: str, views: list[_View]) -> tuple[Path, Path]:
    """Return the folder of the whole project, and the one that picture names start from.

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
    view: _View, intrinsics: Mapping[object, Intrinsics], pose: object, inside: Path
) -> PosedPicture:
    if view.intrinsic not in intrinsics:
        raise CalibrationError(
            f"{view.where}: there is no intrinsic {view.intrinsic!r:.20}: {EXPORT}"
        )
    rows, place = follow_keys(pose, view.where, "rotation"), follow_keys(pose, view.where, "center")
    rotation = np.reshape(parse_finite(flatten_rows(rows), 9, f"{view.where}: rotation"), (3, 3))
    centre = np.array(parse_finite(place, 3, f"{view.where}: center"))
    found = make_pose(rotation.T, centre, view.where)
    return PosedPicture(view.name, inside / view.name, intrinsics[view.intrinsic], found)


def _lacks(folder: Path) -> str:
    if not (folder / BINARY).is_file() or (folder / SFM_DATA).is_file():
        return ""
    convert = f"openMVG_main_ConvertSfM_DataFormat -V -I -E -i {BINARY} -o {SFM_DATA}"
    return f"{SFM_DATA} is missing beside {BINARY}: write it by {convert}"


OPENMVG = PoseReader(
    kind="OpenMVG model",
    needs=f"OpenMVG's {SFM_DATA}",
    find=make_file_finder(SFM_DATA),
    lacks=_lacks,
    takes=lambda path: path.name == SFM_DATA,
    read=make_metric_reader(read_openmvg),
)
