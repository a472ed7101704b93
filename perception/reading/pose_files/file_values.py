"""Values in files of poses: text, JSON and numbers, with faults named by their place."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.length_units import METRES_PER
from facetlog.perception.types import FloatArray, Pose
from facetlog.safe_read import read_regular_text

EXPORT = "export it again"
"""The way out of what a program wrote in part."""
OPENCV_FROM_OPENGL = np.diag([1.0, -1.0, -1.0])
"""OpenGL's camera looks along -z with y up, OpenCV's along +z with y down."""


def is_file(path: Path) -> bool:
    """Return whether a file is there; False for names that no file can have."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def read_text(path: Path) -> str:
    """Return the text of a UTF-8 file; InputError if it is missing, no file, or not text."""
    try:
        return read_regular_text(path)
    except UnicodeDecodeError as exc:
        raise InputError(f"{path} is not text in UTF-8: write it again as such") from exc
    except FileNotFoundError as exc:
        raise InputError(f"{path} is missing") from exc
    except OSError as exc:
        raise InputError(f"{str(path)!r} cannot be read: {exc.strerror or exc}") from exc


def iter_numbered_lines(path: Path) -> Iterator[tuple[str, str]]:
    """Yield place and text of the lines of a file that are neither empty nor a comment (#)."""
    for number, line in enumerate(read_text(path).splitlines(), start=1):
        if line.strip() and not line.lstrip().startswith("#"):
            yield f"{path}:{number}", line


def read_json(path: Path) -> object:
    """Return the value in a file; InputError with line and column for what is not JSON."""
    text = read_text(path)
    try:
        return json.loads(text)
    except json.JSONDecodeError as exc:
        raise InputError(
            f"{path}:{exc.lineno}:{exc.colno}: not JSON: {exc.msg}: correct it there, or {EXPORT}"
        ) from exc
    except (RecursionError, ValueError) as exc:  # nested or long beyond what Python reads
        raise InputError(f"{path}: not JSON that can be read: too deep or too long") from exc


def follow_keys(value: object, where: str, *keys: str) -> object:
    """Return the value under nested keys; InputError names the first key that is missing."""
    for key in keys:
        if not isinstance(value, Mapping) or key not in value:
            raise InputError(f"{where}: no {key!r}: {EXPORT}")
        value = value[key]
    return value


def parse_finite(words: object, count: int, where: str) -> list[float]:
    """Return so many finite numbers of a list of words or numbers; CalibrationError for others."""
    try:
        numbers = [float(word) for word in words]  # type: ignore[attr-defined]
    except (TypeError, ValueError, OverflowError):
        numbers = []
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise CalibrationError(f"{where}: not {count} finite numbers: {EXPORT}")
    return numbers


def flatten_rows(rows: object) -> list[object]:
    """Return the entries of a list of lists; none where it is something else."""
    listed = rows if isinstance(rows, list) else []
    return [entry for row in listed if isinstance(row, list) for entry in row]


def parse_array(rows: object, *shape: int) -> FloatArray | None:
    """Return the finite numbers of nested lists as an array of this shape; None for all else.

    >>> parse_array([[1, 2.5]], 1, 2)
    array([[1. , 2.5]])
    >>> parse_array([True], 1), parse_array([10**400], 1), parse_array([1.0, 2.0], 1)
    (None, None, None)
    """
    leaves = [rows]
    for count in shape:
        if not all(isinstance(each, list) and len(each) == count for each in leaves):
            return None
        leaves = [each for some in leaves for each in some]  # type: ignore[attr-defined]
    if not all(type(x) in (int, float) for x in leaves):
        return None
    try:
        found = np.array(rows, dtype=np.float64)
    except OverflowError:
        return None
    return found if np.isfinite(found).all() else None


def number(fields: Mapping[str, object], key: str, where: str) -> float:
    """Return a finite number from a parsed file; CalibrationError names what is there instead."""
    value = fields.get(key)
    if isinstance(value, int | float) and not isinstance(value, bool):
        try:
            result = float(value)
        except OverflowError:
            result = math.inf
        if math.isfinite(result):
            return result
    shown = "missing" if value is None else f"{value!r:.40}: give a finite number"
    raise CalibrationError(f"{where}: {key} is {shown}")


def get_metres_per(unit: object, where: str) -> float:
    """Return the metres in one unit of length; InputError lists the units there are.

    >>> get_metres_per("in", "--unit")
    0.0254
    """
    if not isinstance(unit, str) or unit not in METRES_PER:
        raise InputError(f"{where}: unknown unit {unit!r:.40}: use one of {', '.join(METRES_PER)}")
    return METRES_PER[unit]


def convert_quaternion(
    quaternion: Sequence[float], place: Sequence[float], where: str
) -> FloatArray:
    """Return the rotation (3, 3) of a quaternion (w, x, y, z) of any length but 0.

    CalibrationError if it is of length 0, or it or the `place` (3,) beside it is not finite.
    """
    from scipy.spatial.transform import Rotation  # loaded only now: other kinds do without

    if not np.isfinite([*quaternion, *place]).all():
        raise CalibrationError(f"{where}: its pose is not finite: register the picture again")
    largest = float(np.abs(quaternion).max())
    if largest == 0.0:
        raise CalibrationError(
            f"{where}: its quaternion is of length 0: register the picture again"
        )
    w, x, y, z = (number / largest for number in quaternion)  # whose squares neither over- nor
    return np.asarray(Rotation.from_quat([x, y, z, w]).as_matrix())  # underflow


def make_pose(world_from_camera: FloatArray, centre: FloatArray, where: str) -> Pose:
    """Return the pose of a rotation (3, 3) and a centre (3,); CalibrationError if it is none."""
    try:
        return Pose(world_from_camera, centre)
    except CalibrationError as exc:
        raise CalibrationError(f"{where}: {exc}") from exc
