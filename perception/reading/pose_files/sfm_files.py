"""Poses that programs for structure from motion write: OpenMVG, Bundler and VisualSFM.

OpenMVG's sfm_data.json: https://openmvg.readthedocs.io/en/latest/software/SfM/SfM_OutputFormat –
lists of views, intrinsics and extrinsics, each with a key, tied together by id_intrinsic and
id_pose. A rotation (3 x 3) and a centre take world to camera; a camera looks along z, its y runs
down the picture, and the middle of its top-left pixel is (0, 0). The kind of a camera is written by
name where it comes first, and then by number. A view without extrinsics was not registered, and is
left out.

Bundler's bundle.out, with the names of its pictures in list.txt:
https://www.cs.cornell.edu/~snavely/bundler/bundler-v0.4-manual.html – for each picture a line of f,
k1, k2, three of a rotation and one of a translation, world to camera. A camera looks along -z with
y up; pixels count from the picture's middle. A picture of focal length 0 was not registered, and is
left out.

VisualSFM's .nvm file beside or above its pictures: http://ccwu.me/vsfm/doc.html#nvm – models one
after the other, each of a number of cameras, for each a line of its picture's name (a space in it
is written as a quotation mark), focal length, quaternion (w, x, y, z) from world to camera, camera
centre, radial distortion and a zero, then a number of points and their lines. A camera looks along
z, its y runs down the picture; the principal point is the picture's middle unless the first line
fixes it. The distortion r takes a measured point m to the undistorted m (1 + r |m|²), in focal
lengths.

Of all three the world's unit and up are unknown.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path, PureWindowsPath

import numpy as np

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.reading.lens import Distortion
from facetlog.perception.reading.pose_files.file_values import (
    EXPORT,
    OPENCV_FROM_OPENGL,
    convert_quaternion,
    flatten_rows,
    follow_keys,
    is_file,
    iter_numbered_lines,
    make_pose,
    parse_finite,
    read_json,
)
from facetlog.perception.reading.pose_files.picture_places import resolve_picture_path
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

SFM_DATA, OPENMVG_PICTURES = "sfm_data.json", "images"
SFM_DATA_BINARY = "sfm_data.bin"
# Kinds of cameras: the model that they are, and the key and names of their coefficients.
OPENMVG_CAMERAS = {
    "pinhole": ("PINHOLE", "", ()),
    "pinhole_radial_k1": ("OPENCV", "disto_k1", ("k1",)),
    "pinhole_radial_k3": ("OPENCV", "disto_k3", ("k1", "k2", "k3")),
    "pinhole_brown_t2": ("OPENCV", "disto_t2", ("k1", "k2", "k3", "p1", "p2")),
    "fisheye": ("OPENCV_FISHEYE", "fisheye", ("k1", "k2", "k3", "k4")),
}
FIRST_OF_ITS_KIND = 1 << 31
"""The bit of a polymorphic_id beside which the kind's name is."""
BUNDLE, LIST = "bundle.out", "list.txt"
CAMERA_LINES = 5
"""Lines of each picture."""

_Words = tuple[str, list[str]]
"""Place in the file, and words."""
NVM_SUFFIX, NVM_VERSION, FIXED = ".nvm", "NVM_V3", "FixedK"
CAMERA_NUMBERS = 10
"""Numbers in the line of a camera, after its name."""
PIXEL_CENTRE = 0.5

_Line = tuple[str, str]
"""Place in the file, and text."""


def read_bundler(path: Path) -> PosesFile:
    """Return the poses in a bundle.out."""
    folder = path.parent
    if not (folder / LIST).is_file():
        folder = folder.resolve().parent
    if not (folder / LIST).is_file():
        raise InputError(f"{path} has no {LIST} beside or above it: put there the pictures' names")
    names = [line.split()[0] for _, line in iter_numbered_lines(folder / LIST)]
    lines: list[_Words] = [(where, line.split()) for where, line in iter_numbered_lines(path)]
    try:
        count = int(lines[0][1][0])
    except (IndexError, ValueError) as exc:
        raise InputError(f"{path}: no number of cameras: is this Bundler's {BUNDLE}?") from exc
    if count != len(names):
        raise InputError(
            f"{path} has {count} cameras, {folder / LIST} {len(names)} pictures: give its own"
        )
    blocks = [lines[1 + CAMERA_LINES * k : 1 + CAMERA_LINES * (k + 1)] for k in range(count)]
    if count and len(blocks[-1]) < CAMERA_LINES:
        raise InputError(f"{path} ends before camera {count}: it is truncated; export it again")
    named = list(zip(names, blocks, strict=True))
    pictures, faults = collect_posed_pictures(
        partial(_read_bundler_picture, name, block, folder)
        for name, block in named
        if _is_in_bundle(block)
    )
    lost = list_unregistered(path, (name for name, block in named if not _is_in_bundle(block)))
    return PosesFile(folder, pictures, faults=faults, left_out=lost)


def _is_in_bundle(block: Sequence[_Words]) -> bool:
    try:
        return float(block[0][1][0]) != 0.0
    except ValueError:  # reported where it is read
        return True


def _read_bundler_picture(name: str, block: Sequence[_Words], folder: Path) -> PosedPicture:
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


def _find_bundle(folder: Path) -> Path | None:
    paths = folder / BUNDLE, folder / "bundle" / BUNDLE
    return next((path for path in paths if path.is_file()), None)


BUNDLER = PoseReader(
    kind="Bundler model",
    needs=f"Bundler's {BUNDLE} with {LIST}",
    find=_find_bundle,
    takes=lambda path: path.suffix == ".out",
    read=make_metric_reader(read_bundler),
)


def read_visualsfm(path: Path) -> PosesFile:
    """Return the poses of the largest model in a .nvm file."""
    lines = iter_numbered_lines(path)
    where, first = next(lines, (str(path), ""))
    version, *words = first.split() or [""]
    if version != NVM_VERSION:
        raise InputError(f"{where}: the first word is not {NVM_VERSION}: save it as that")
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
        partial(_read_nvm_picture, line, path.parent, focal, centre) for line in largest
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


def _read_nvm_picture(
    line: _Line,
    folder: Path,
    fixed_focal: tuple[float, float] | None,
    centre: tuple[float, float] | None,
) -> PosedPicture:
    where, text = line
    name, *words = text.rsplit(maxsplit=CAMERA_NUMBERS)
    name = name.strip().replace('"', " ").replace("\\", "/")
    where = f"{where} ({name!r:.80})"
    focal, *numbers, radial, _ = parse_finite(words, CAMERA_NUMBERS, where)
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


def _find_project(folder: Path) -> Path | None:
    paths = sorted(folder.glob(f"*{NVM_SUFFIX}"))
    return paths[0] if len(paths) == 1 else None


def _list_projects(folder: Path) -> str:
    names = sorted(path.name for path in folder.glob(f"*{NVM_SUFFIX}"))
    return f"name the one to use of {' and '.join(names)}" if len(names) > 1 else ""


VISUALSFM = PoseReader(
    kind="VisualSFM model",
    needs=f"one {NVM_SUFFIX} file of VisualSFM",
    find=_find_project,
    lacks=_list_projects,
    takes=lambda path: path.suffix == NVM_SUFFIX,
    read=make_metric_reader(read_visualsfm),
)


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
    folder, inside = _find_openmvg_pictures(
        path, str(follow_keys(document, where, "root_path")), views
    )
    pictures, faults = collect_posed_pictures(
        partial(_read_openmvg_picture, view, intrinsics, poses[view.pose], inside)
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
    if kind not in OPENMVG_CAMERAS:
        raise CalibrationError(
            f"{where}: the camera is of kind {kind!r:.40}, "
            f"not one of {', '.join(OPENMVG_CAMERAS)}: undistort the pictures and give a pinhole"
        )
    base = data.get("value0")  # where some versions put what all cameras have
    data = {**(base if isinstance(base, Mapping) else {}), **data}
    model, key, names = OPENMVG_CAMERAS[kind]
    numbers = parse_finite(data.get(key, ()), len(names), where)
    fields: dict[str, object] = {"camera_model": model, **dict(zip(names, numbers, strict=True))}
    fields |= {name: data.get(name) for name in ("width", "height")}
    fields["fx"] = fields["fy"] = data.get("focal_length")
    fields["cx"], fields["cy"] = parse_finite(
        data.get("principal_point"), 2, f"{where}: principal_point"
    )
    return read_intrinsics(fields, PLAIN_NAMES, where)


def _find_openmvg_pictures(path: Path, root: str, views: list[_View]) -> tuple[Path, Path]:
    """Return the folder of the whole project, and the one that picture names start from.

    That is root_path, if it is below; but projects are moved, so that the pictures may be in
    images/ beside the file or beside its folder, or right there: where most of them are found.
    """
    folder = path.parent
    places = [(folder, folder / root)]
    places += [
        (each, inside)
        for each in (folder, folder.resolve().parent)
        for inside in (each / OPENMVG_PICTURES, each)
    ]
    return max(places, key=lambda place: sum(is_file(place[1] / view.name) for view in views))


def _read_openmvg_picture(
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


def _explain_binary_openmvg(folder: Path) -> str:
    if not (folder / SFM_DATA_BINARY).is_file() or (folder / SFM_DATA).is_file():
        return ""
    convert = f"openMVG_main_ConvertSfM_DataFormat -V -I -E -i {SFM_DATA_BINARY} -o {SFM_DATA}"
    return f"{SFM_DATA} is missing beside {SFM_DATA_BINARY}: write it by {convert}"


OPENMVG = PoseReader(
    kind="OpenMVG model",
    needs=f"OpenMVG's {SFM_DATA}",
    find=make_file_finder(SFM_DATA),
    lacks=_explain_binary_openmvg,
    takes=lambda path: path.name == SFM_DATA,
    read=make_metric_reader(read_openmvg),
)
