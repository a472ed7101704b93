"""Sparse models of COLMAP: points with their errors, and the cameras that saw them."""

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.reading.colmap_files import (
    EXPORT,
    Numbers,
    find_colmap_models,
    iter_text_lines,
    read_colmap_cameras,
    read_colmap_images,
)
from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.safe_read import MOST_SHAPE_BYTES, read_regular

# A point's place, its reprojection error in px, and the pictures that saw it.
_Point = tuple[tuple[float, float, float], float, tuple[int, ...]]


def find_colmap_model(folder: Path) -> Path | None:
    """Return the folder of the largest model in or below a folder; None where there is none."""
    return next((path.parent for path in find_colmap_models(folder, "points3D")), None)


def read_colmap(folder: Path, most: int) -> Cloud:
    """Return the points of a model with their errors, where they were seen from, and cameras' ups.

    A point's error is that of its reprojection at the mean distance of its cameras, in the model's
    unit of length.
    """
    from scipy.spatial.transform import Rotation  # loaded only now: scenes do without

    binary = (folder / "points3D.bin").is_file()
    name = folder.resolve().name if folder.name in ("", ".") else folder.name
    try:
        suffix = ".bin" if binary else ".txt"
        cameras = read_colmap_cameras(folder / f"cameras{suffix}")
        pictures = read_colmap_images(folder / f"images{suffix}")
        focal = {each.number: cameras[each.camera].parameters[0] for each in pictures}
        turns = [Rotation.from_quat(p.quaternion, scalar_first=True).as_matrix() for p in pictures]
        points = list(_points(folder, binary, most))
    except OSError as exc:
        raise InputError(
            f"{folder}: {exc.filename or 'it'} cannot be read ({exc.strerror})"
        ) from exc
    except (struct.error, ValueError, IndexError, KeyError) as exc:
        raise InputError(f"{folder}: {EXPORT}") from exc
    centres = {
        each.number: -turn.T @ np.array(each.translation)
        for each, turn in zip(pictures, turns, strict=True)
    }
    places = np.array([place for place, _, _ in points]).reshape(-1, 3)
    seen_from = np.full((len(points), 3), np.nan)
    errors = np.full(len(points), np.nan)
    for nth, (place, error_px, seen_by) in enumerate(points):
        seen = [number for number in seen_by if number in centres]
        if seen:
            from_there = np.array([centres[number] for number in seen])
            seen_from[nth] = from_there.mean(axis=0)
            distance = float(np.linalg.norm(from_there - place, axis=1).mean())
            length = float(np.mean([focal[number] for number in seen]))
            errors[nth] = error_px * distance / max(length, 1e-300)
    ups = np.array([-turn[1] for turn in turns]).reshape(-1, 3)
    return Cloud.of(places, name=name, seen_from=seen_from, camera_ups=ups, errors=errors)


def _points(folder: Path, binary: bool, most: int) -> Iterator[_Point]:
    if not binary:
        for nth, words in enumerate(
            line.split() for _, line in iter_text_lines(folder / "points3D.txt") if line
        ):
            _check_count(nth + 1, most, folder)
            x, y, z = (float(word) for word in words[1:4])
            yield (x, y, z), float(words[7]), tuple(int(word) for word in words[8::2])
        return
    data = Numbers(read_regular(folder / "points3D.bin", MOST_SHAPE_BYTES))
    count = data.count(51)
    _check_count(count, most, folder)
    for _ in range(count):
        _, x, y, z, _, _, _, error = data.take("Q3d3Bd")
        track = data.take(f"{2 * data.count(8)}I")
        yield (x, y, z), error, tuple(int(number) for number in track[::2])


def _check_count(count: int, most: int, folder: Path) -> None:
    if count > most:
        raise InputError(f"{folder}: has more than {most} points; thin the cloud")
