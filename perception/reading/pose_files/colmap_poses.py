"""Poses from a COLMAP model, text or binary, beside or below the pictures (colmap_files.py).

The world's unit and up are unknown: structure from motion finds neither.
"""

from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.reading.colmap_files import (
    ColmapCamera,
    ColmapPicture,
    find_colmap_models,
    read_colmap_cameras,
    read_colmap_images,
)
from facetlog.perception.reading.pose_files.file_values import convert_quaternion, make_pose
from facetlog.perception.reading.pose_files.picture_places import may_be_below, resolve_picture_path
from facetlog.perception.reading.pose_files.pose_reader import PoseReader, make_metric_reader
from facetlog.perception.reading.pose_files.poses_file import (
    FieldNames,
    Intrinsics,
    PosedPicture,
    PosesFile,
    collect_posed_pictures,
    read_intrinsics,
)

NAMES = FieldNames("width", "height", "fx", "fy", pixel_centre=0.5)
PICTURES = "images"
# Folders that COLMAP and the programs round it put models into.
LAYOUT = ("sparse", "dense", "colmap")


def find_colmap_poses(folder: Path) -> Path | None:
    """Return the images.bin or images.txt of the largest model in or below a folder; None without
    one.
    """
    return next(iter(find_colmap_models(folder, "images", "cameras")), None)


def describe_model_choice(folder: Path) -> str:
    """Return which of several models in a folder is read, for people; empty where there is one."""
    models = find_colmap_models(folder, "images", "cameras")
    if len(models) < 2:
        return ""
    return f"{models[0].parent.relative_to(folder)}, the largest of {len(models)}"


def read_colmap_poses(path: Path) -> PosesFile:
    """Return the poses in an images.bin or images.txt."""
    try:
        cameras = read_colmap_cameras(path.with_name(f"cameras{path.suffix}"))
        pictures = read_colmap_images(path)
    except OSError as exc:
        raise InputError(f"{exc.filename or path} cannot be read: {exc.strerror}") from exc
    names = [picture.name for picture in pictures]
    project, inside = _find_image_folder(path, names)
    lenses: dict[int, Intrinsics] = {}
    posed, faults = collect_posed_pictures(
        partial(_posed, picture, cameras, lenses, inside) for picture in pictures
    )
    advice = "" if _there(names, inside) else f"put the pictures into {_suggest_image_folder(path)}"
    return PosesFile(project, posed, faults=faults, advice=advice)


def _suggest_image_folder(path: Path) -> Path:
    """Return where the pictures of a model belong by COLMAP's layouts."""
    model = path.parent.resolve()
    *_, above = _iter_parent_folders(model)
    return (above if model.name in LAYOUT or model.name.isdigit() else model) / PICTURES


def _find_image_folder(path: Path, names: Iterable[str]) -> tuple[Path, Path]:
    """Return the folder of the whole project, and the one in it that picture names start from.

    The pictures are in images/ beside the model or above it, or else right there: where most of
    them are found. Above is the folder that holds the model's, and on through those of COLMAP's
    layouts.
    """
    names = tuple(names)
    places = [
        (folder, inside)
        for folder in _iter_parent_folders(path.parent.resolve())
        for inside in (folder / PICTURES, folder)
    ]
    return max(places, key=lambda place: _there(names, place[1]))  # of equals the nearest


def _there(names: Iterable[str], folder: Path) -> int:
    return sum(may_be_below(folder, name) for name in names)


def _iter_parent_folders(model: Path) -> Iterator[Path]:
    yield model
    folder = model.parent
    while folder.name in LAYOUT or folder.name.isdigit():
        yield folder
        folder = folder.parent
    yield folder


def has_pictures(path: Path) -> bool:
    """Return whether any picture that an images.bin or images.txt names is there: else it is a
    cloud.
    """
    try:
        names = [picture.name for picture in read_colmap_images(path)]
    except (InputError, OSError):
        return False
    _, inside = _find_image_folder(path, names)
    return _there(names, inside) > 0


def _posed(
    picture: ColmapPicture,
    cameras: Mapping[int, ColmapCamera],
    lenses: dict[int, Intrinsics],
    inside: Path,
) -> PosedPicture:
    where = f"{picture.where} ({picture.name!r:.80})"
    camera = cameras.get(picture.camera)
    if camera is None:
        raise CalibrationError(f"{where}: there is no camera {picture.camera}: export it again")
    if camera.number not in lenses:
        lenses[camera.number] = _parse_colmap_intrinsics(camera)
    camera_from_world = convert_quaternion(picture.quaternion, picture.translation, where)
    centre = -camera_from_world.T @ np.array(picture.translation)
    pose = make_pose(camera_from_world.T, centre, where)
    path = resolve_picture_path(inside, picture.name)
    return PosedPicture(picture.name, path, lenses[camera.number], pose)


def _parse_colmap_intrinsics(camera: ColmapCamera) -> Intrinsics:
    fields: dict[str, object] = {"camera_model": camera.model}
    fields |= {"width": camera.width, "height": camera.height}
    fields |= camera.named() or {}
    if "f" in fields:
        fields["fx"] = fields["fy"] = fields["f"]
    return read_intrinsics(fields, NAMES, camera.where)


def _lacks(folder: Path) -> str:
    for name, other in (("images", "cameras"), ("cameras", "images")):
        if found := find_colmap_models(folder, name):
            path = found[0].relative_to(folder)
            return f"{path.with_name(other + path.suffix)} is missing beside {path.name}"
    return ""


COLMAP = PoseReader(
    kind="COLMAP model",
    needs="a COLMAP model (cameras and images, .bin or .txt, there or in sparse/)",
    find=find_colmap_poses,
    takes=lambda path: path.name in ("images.bin", "images.txt"),
    read=make_metric_reader(read_colmap_poses),
    choice=describe_model_choice,
    lacks=_lacks,
)
