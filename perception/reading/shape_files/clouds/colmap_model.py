"""Sparse models of COLMAP: points with their errors, and the cameras that saw them."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.reading.colmap_files import (
    EXPORT,
    ColmapPicture,
    Numbers,
    colmap_cameras,
    colmap_models,
    colmap_pictures,
    text_lines,
)
from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.types import FloatArray
from facetlog.regular_file import MOST_SHAPE_BYTES, read_regular

__all__ = ["find_colmap_model", "read_colmap"]


@dataclass(frozen=True, eq=False, slots=True)
class _Picture:
    """Camera's number, centre and upward axis in the world, (3,) each."""

    camera: int
    centre: FloatArray
    up: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class _Point:
    """A point (3,), its reprojection error in px, and the pictures that saw it."""

    place: tuple[float, float, float]
    error_px: float
    pictures: tuple[int, ...]


def find_colmap_model(folder: Path) -> Path | None:
    """The folder of the largest model in or below a folder; None where there is none."""
    return next((path.parent for path in colmap_models(folder, "points3D")), None)


def read_colmap(folder: Path, most: int) -> Cloud:
    """The points of a model with their errors, from where they were seen, and the cameras' ups.

    A point's error is that of its reprojection at the mean distance of its cameras, in the model's
    unit of length.
    """
    binary = (folder / "points3D.bin").is_file()
    name = folder.resolve().name if folder.name in ("", ".") else folder.name
    try:
        suffix = ".bin" if binary else ".txt"
        cameras = colmap_cameras(folder / f"cameras{suffix}")
        focal = {number: camera.parameters[0] for number, camera in cameras.items()}
        in_order = colmap_pictures(folder / f"images{suffix}")
        pictures = {picture.number: _picture(picture) for picture in in_order}
        points = list(_points(folder, binary, most))
    except OSError as exc:
        raise InputError(
            f"{folder}: {exc.filename or 'it'} cannot be read ({exc.strerror})"
        ) from exc
    except (struct.error, ValueError, IndexError, KeyError) as exc:
        raise InputError(f"{folder}: {EXPORT}") from exc
    places = np.array([p.place for p in points]).reshape(-1, 3)
    seen_from = np.full((len(points), 3), np.nan)
    errors = np.full(len(points), np.nan)
    for nth, point in enumerate(points):
        seen = [pictures[k] for k in point.pictures if k in pictures]
        if not seen:
            continue
        centres = np.array([picture.centre for picture in seen])
        seen_from[nth] = centres.mean(axis=0)
        distance = float(np.linalg.norm(centres - places[nth], axis=1).mean())
        length = float(np.mean([focal[picture.camera] for picture in seen]))
        errors[nth] = point.error_px * distance / max(length, 1e-300)
    ups = np.array([picture.up for picture in pictures.values()]).reshape(-1, 3)
    return Cloud.of(places, name=name, seen_from=seen_from, camera_ups=ups, errors=errors)


def _picture(picture: ColmapPicture) -> _Picture:
    w, x, y, z = picture.quaternion
    from scipy.spatial.transform import Rotation  # loaded only now: scenes do without

    camera_from_world = Rotation.from_quat([x, y, z, w]).as_matrix()
    centre = -camera_from_world.T @ np.array(picture.translation)
    return _Picture(picture.camera, centre, -camera_from_world[1])


def _points(folder: Path, binary: bool, most: int) -> Iterator[_Point]:
    if not binary:
        for nth, words in enumerate(
            line.split() for _, line in text_lines(folder / "points3D.txt") if line
        ):
            _check_count(nth + 1, most, folder)
            x, y, z = (float(word) for word in words[1:4])
            yield _Point((x, y, z), float(words[7]), tuple(int(word) for word in words[8::2]))
        return
    data = Numbers(read_regular(folder / "points3D.bin", MOST_SHAPE_BYTES))
    count = data.count(51)
    _check_count(count, most, folder)
    for _ in range(count):
        _, x, y, z, _, _, _, error = data.take("Q3d3Bd")
        track = data.take(f"{2 * data.count(8)}I")
        yield _Point((x, y, z), error, tuple(int(number) for number in track[::2]))


def _check_count(count: int, most: int, folder: Path) -> None:
    if count > most:
        raise InputError(f"{folder}: has more than {most} points; thin the cloud")
