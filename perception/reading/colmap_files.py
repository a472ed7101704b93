"""Cameras and pictures of a COLMAP model, text or binary: what poses and shapes are read from.

The formats are those of COLMAP's documentation, "Output Format". A quaternion (w, x, y, z) and a
translation take world to camera; a camera looks along z, its y runs down the picture, and the
centre of its top-left pixel is (0.5, 0.5). The files of rigs and frames, which COLMAP has written
beside these since 3.12, add nothing that is needed: a picture's pose here is its whole pose.
"""

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from facetlog.errors import InputError
from facetlog.perception.reading.lens import CAMERA_MODELS
from facetlog.safe_read import MOST_SHAPE_BYTES, open_regular, read_regular

# Where COLMAP and the programs round it put a model, or several in numbered folders, below the
# folder that a user names.
PLACES = ("", "sparse", "colmap/sparse")
SUFFIXES = (".bin", ".txt")  # in the order in which they are preferred
PARAMETERS = {name: tuple(names.split()) for name, (_, names) in CAMERA_MODELS.items()}
MODELS = tuple(CAMERA_MODELS)  # by number
LEAST_CAMERA_BYTES, LEAST_PICTURE_BYTES, FEATURE_BYTES = 24, 73, 24
COUNT_BYTES = 8  # with which a binary file begins
EXPORT = "the COLMAP model is truncated or damaged; export it again"


@dataclass(frozen=True, slots=True)
class ColmapCamera:
    """A camera: its number, model, size in px and parameters; `where` is its place in the file."""

    number: int
    model: str
    width: int
    height: int
    parameters: tuple[float, ...]
    where: str

    def named(self) -> dict[str, float] | None:
        """Return the parameters by their names (MODELS); None for a model that is not known."""
        names = PARAMETERS.get(self.model)
        return None if names is None else dict(zip(names, self.parameters, strict=True))


@dataclass(frozen=True, slots=True)
class ColmapPicture:
    """A picture: number, file name, camera's number, and the pose that takes world to camera."""

    number: int
    name: str
    camera: int
    quaternion: tuple[float, ...]
    """(w, x, y, z), as written: neither of length 1 nor finite for sure."""
    translation: tuple[float, ...]
    where: str


def find_colmap_models(folder: Path, name: str, *beside: str) -> tuple[Path, ...]:
    """Return the files of a name, as "images", of the models in or below a folder, the largest
    first.

    A model has that file and those `beside` it. Of each model it is the binary file if there are
    both. The largest has most pictures; of equals the one of the lowest number is first.
    """
    for place in PLACES:
        parent = folder / place
        if (only := _find_model_file(parent, name, *beside)) is not None:
            return (only,)
        inside = (
            parent.iterdir() if parent.is_dir() and os.access(parent, os.R_OK | os.X_OK) else ()
        )
        numbered = [path for path in inside if path.name.isdecimal() and path.is_dir()]
        in_order = sorted(numbered, key=lambda path: int(path.name))
        files = [_find_model_file(path, name, *beside) for path in in_order]
        if models := [path for path in files if path is not None]:
            # The pictures of a single model need not be counted.
            return tuple(
                sorted(models, key=_count_model_images, reverse=True) if models[1:] else models
            )
    return ()


def _find_model_file(model: Path, *names: str) -> Path | None:
    """Return the first of a model's files of these names, if all are there."""
    for suffix in SUFFIXES:
        paths = [model / f"{name}{suffix}" for name in names]
        if all(path.is_file() for path in paths):
            return paths[0]
    return None


def _count_model_images(path: Path) -> int:
    """Return how many pictures the model of this file has; 0 where that cannot be read."""
    images = path.with_name(f"images{path.suffix}")
    try:
        if images.suffix == ".bin":
            with open_regular(images) as file:
                return int.from_bytes(file.read(COUNT_BYTES), "little")
        return len(read_colmap_images(images))
    except (InputError, OSError):  # who reads it says what is wrong
        return 0


class Numbers:
    """Numbers from a little-endian file, one after the other; struct.error where it ends."""

    def __init__(self, data: bytes) -> None:
        self.data, self.at = data, 0

    def take(self, form: str) -> tuple[float, ...]:
        """Take numbers of a form of `struct`."""
        values = struct.unpack_from(f"<{form}", self.data, self.at)
        self.at += struct.calcsize(f"<{form}")
        return values

    def count(self, least_bytes: int) -> int:
        """Take a count of records of at least so many bytes, which must be there."""
        count = int(self.take("Q")[0])
        if count * least_bytes > len(self.data) - self.at:
            raise struct.error("count beyond the end")
        return count

    def skip(self, size: int) -> None:
        """Pass over so many bytes, which must be there."""
        if size > len(self.data) - self.at:
            raise struct.error("beyond the end")
        self.at += size

    def text(self) -> str:
        """Take text up to a zero."""
        end = self.data.find(b"\0", self.at)
        if end < 0:
            raise struct.error("text without an end")
        text = self.data[self.at : end].decode("utf-8", "surrogateescape")
        self.at = end + 1
        return text


def iter_text_lines(path: Path) -> Iterator[tuple[str, str]]:
    """Place and text of the lines that are no comments; empty ones count, as in images.txt."""
    with open_regular(path, MOST_SHAPE_BYTES) as file:
        for number, line in enumerate(file, start=1):
            if not line.startswith(b"#"):
                yield f"{path}:{number}", line.decode("utf-8", "surrogateescape").strip()


def read_colmap_cameras(path: Path) -> dict[int, ColmapCamera]:
    """Return the cameras in a cameras.txt or cameras.bin, by number.

    InputError, with the place, for what is no such file; OSError where it cannot be read.
    """
    read = _parse_text_cameras if path.suffix == ".txt" else _parse_binary_cameras
    return {camera.number: camera for camera in read(path)}


def read_colmap_images(path: Path) -> tuple[ColmapPicture, ...]:
    """Return the pictures in an images.txt or images.bin, in the file's order; errors as of
    cameras.
    """
    return tuple((_parse_text_images if path.suffix == ".txt" else _parse_binary_images)(path))


def _parse_text_cameras(path: Path) -> Iterator[ColmapCamera]:
    for where, line in iter_text_lines(path):
        if not (words := line.split()):
            continue
        try:
            number, width, height = int(words[0]), int(words[2]), int(words[3])
            parameters = tuple(float(word) for word in words[4:])
        except (ValueError, IndexError) as exc:
            raise InputError(
                _describe_bad_line(where, "CAMERA_ID MODEL WIDTH HEIGHT PARAMS…", line)
            ) from exc
        names = PARAMETERS.get(words[1])
        if not parameters or (names is not None and len(names) != len(parameters)):
            wanted = "parameters" if names is None else f"{len(names)} ({', '.join(names)})"
            raise InputError(f"{where}: {words[1]} has {len(parameters)} parameters, not {wanted}")
        yield ColmapCamera(number, words[1], width, height, parameters, where)


def _parse_binary_cameras(path: Path) -> Iterator[ColmapCamera]:
    data = Numbers(read_regular(path, MOST_SHAPE_BYTES))
    try:
        for _ in range(data.count(LEAST_CAMERA_BYTES)):
            number, model, width, height = map(int, data.take("IiQQ"))
            where = f"{path}: camera {number}"
            if not 0 <= model < len(MODELS):  # how many parameters follow is not known
                raise InputError(
                    f"{where} is of model {model}, which is not known: undistort the pictures "
                    "(colmap image_undistorter) and give the model that it writes"
                )
            name = MODELS[model]
            parameters = data.take(f"{len(PARAMETERS[name])}d")
            yield ColmapCamera(number, name, width, height, parameters, where)
    except struct.error as exc:
        raise InputError(f"{path}: {EXPORT}") from exc


def _describe_bad_line(where: str, form: str, line: str) -> str:
    return f"{where}: {line!r:.60} is not {form}: correct it there, or export the model again"


def _parse_text_images(path: Path) -> Iterator[ColmapPicture]:
    lines = iter_text_lines(path)
    for where, line in lines:
        if not line:
            continue
        words = line.split(maxsplit=9)
        try:
            number, camera, name = int(words[0]), int(words[8]), words[9]
            pose = tuple(float(word) for word in words[1:8])
        except (ValueError, IndexError) as exc:
            form = "IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME"
            raise InputError(_describe_bad_line(where, form, line)) from exc
        _, features = next(lines, ("", ""))  # the second line of each picture; it may be empty
        if len(features.split()) % 3:
            raise InputError(
                f"{where}: the line after it has no features X Y POINT3D_ID: leave one empty there"
            )
        yield ColmapPicture(number, name, camera, pose[:4], pose[4:], where)


def _parse_binary_images(path: Path) -> Iterator[ColmapPicture]:
    data = Numbers(read_regular(path, MOST_SHAPE_BYTES))
    try:
        for _ in range(data.count(LEAST_PICTURE_BYTES)):
            number, *pose, camera = data.take("I7dI")
            name = data.text()
            data.skip(FEATURE_BYTES * data.count(FEATURE_BYTES))
            where = f"{path}: picture {int(number)}"
            yield ColmapPicture(
                int(number), name, int(camera), tuple(pose[:4]), tuple(pose[4:]), where
            )
    except struct.error as exc:
        raise InputError(f"{path}: {EXPORT}") from exc
