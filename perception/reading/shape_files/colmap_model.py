"""Sparse models of COLMAP, text or binary: points with their errors, and the cameras that saw them.

The formats are those of COLMAP's documentation, "Output Format". A quaternion (w, x, y, z) and a
translation take world to camera; a camera looks along z, its y runs down the picture.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.point_cloud import Cloud
from facetlog.perception.types import FloatArray
from facetlog.regular_file import MOST_SHAPE_BYTES, open_regular, read_regular

__all__ = ["find_colmap_model", "read_colmap"]

# Where COLMAP and the programs round it put a model, below the folder that a user names.
PLACES = ("", "sparse", "sparse/0", "0", "colmap/sparse/0")
# Parameters of each camera model by its number; the first is the focal length in all of them.
PARAMETERS = {0: 3, 1: 4, 2: 4, 3: 5, 4: 8, 5: 8, 6: 12, 7: 5, 8: 4, 9: 5, 10: 12}


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


class _Bytes:
    """Numbers from a little-endian file, one after the other; struct.error where it ends."""

    def __init__(self, data: bytes) -> None:
        self.data, self.at = data, 0

    def take(self, form: str) -> tuple[float, ...]:
        """Numbers of a form of `struct`."""
        values = struct.unpack_from(f"<{form}", self.data, self.at)
        self.at += struct.calcsize(f"<{form}")
        return values

    def count(self, least_bytes: int) -> int:
        """A count of records of at least so many bytes, which must be there."""
        count = int(self.take("Q")[0])
        if count * least_bytes > len(self.data) - self.at:
            raise struct.error("count beyond the end")
        return count

    def skip(self, size: int) -> None:
        """Pass over so many bytes."""
        self.at += size

    def text(self) -> str:
        """Text up to a zero."""
        end = self.data.index(b"\0", self.at)
        text = self.data[self.at : end].decode("utf-8", "replace")
        self.at = end + 1
        return text


def find_colmap_model(folder: Path) -> Path | None:
    """The folder of a model in or below a folder; None where there is none."""
    for place in PLACES:
        inner = folder / place
        if any((inner / f"points3D{suffix}").is_file() for suffix in (".bin", ".txt")):
            return inner
    return None


def read_colmap(folder: Path, most: int) -> Cloud:
    """The points of a model with their errors, from where they were seen, and the cameras' ups.

    A point's error is that of its reprojection at the mean distance of its cameras, in the model's
    unit of length.
    """
    binary = (folder / "points3D.bin").is_file()
    name = folder.resolve().name if folder.name in ("", ".") else folder.name
    try:
        focal = dict(_cameras(folder, binary))
        pictures = dict(_pictures(folder, binary))
        points = list(_points(folder, binary, most))
    except OSError as exc:
        raise InputError(
            f"{folder}: {exc.filename or 'it'} cannot be read ({exc.strerror})"
        ) from exc
    except (struct.error, ValueError, IndexError, KeyError) as exc:
        raise InputError(
            f"{folder}: the COLMAP model is truncated or damaged; export it again"
        ) from exc
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


def _lines(path: Path) -> Iterator[list[str]]:
    """Words of the lines that are no comments; empty lines count, as they do in images.txt."""
    with open_regular(path, MOST_SHAPE_BYTES) as file:
        for line in file:
            if not line.startswith(b"#"):
                yield line.decode("utf-8", "replace").split()


def _cameras(folder: Path, binary: bool) -> Iterator[tuple[int, float]]:
    """Number and focal length in px of each camera."""
    if not binary:
        for words in _lines(folder / "cameras.txt"):
            if words:
                yield int(words[0]), float(words[4])
        return
    data = _Bytes(read_regular(folder / "cameras.bin", MOST_SHAPE_BYTES))
    for _ in range(data.count(24)):
        number, model, _, _ = data.take("IiQQ")
        yield int(number), data.take(f"{PARAMETERS[int(model)]}d")[0]


def _pictures(folder: Path, binary: bool) -> Iterator[tuple[int, _Picture]]:
    """Number and pose of each picture."""
    if not binary:
        lines = list(_lines(folder / "images.txt"))
        for words in lines[::2]:  # the second line of each has its features
            if words:
                numbers = [float(word) for word in words[1:8]]
                yield int(words[0]), _picture(int(words[8]), numbers)
        return
    data = _Bytes(read_regular(folder / "images.bin", MOST_SHAPE_BYTES))
    for _ in range(data.count(73)):
        number, *pose, camera = data.take("I7dI")
        data.text()
        data.skip(24 * data.count(24))
        yield int(number), _picture(int(camera), pose)


def _picture(camera: int, pose: list[float]) -> _Picture:
    w, x, y, z = pose[:4]
    from scipy.spatial.transform import Rotation  # loaded only now: scenes do without

    camera_from_world = Rotation.from_quat([x, y, z, w]).as_matrix()
    return _Picture(camera, -camera_from_world.T @ np.array(pose[4:]), -camera_from_world[1])


def _points(folder: Path, binary: bool, most: int) -> Iterator[_Point]:
    if not binary:
        for nth, words in enumerate(words for words in _lines(folder / "points3D.txt") if words):
            _check_count(nth + 1, most, folder)
            x, y, z = (float(word) for word in words[1:4])
            yield _Point((x, y, z), float(words[7]), tuple(int(word) for word in words[8::2]))
        return
    data = _Bytes(read_regular(folder / "points3D.bin", MOST_SHAPE_BYTES))
    count = data.count(51)
    _check_count(count, most, folder)
    for _ in range(count):
        _, x, y, z, _, _, _, error = data.take("Q3d3Bd")
        track = data.take(f"{2 * data.count(8)}I")
        yield _Point((x, y, z), error, tuple(int(number) for number in track[::2]))


def _check_count(count: int, most: int, folder: Path) -> None:
    if count > most:
        raise InputError(f"{folder}: has more than {most} points; thin the cloud")
