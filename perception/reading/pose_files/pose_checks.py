"""Poses from the numbers that files have, with faults named by their place."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from facetlog.errors import CalibrationError
from facetlog.perception.types import FloatArray, Pose

__all__ = ["EXPORT", "finite", "is_file", "posed", "rotation_of"]

EXPORT = "export it again"
"""The way out of what a program wrote in part."""


def is_file(path: Path) -> bool:
    """Whether it is there; not if no file can have such a name, which is reported on reading it."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def finite(words: Sequence[object], count: int, where: str) -> list[float]:
    """So many finite numbers, from words or numbers; CalibrationError, with `where`, if not."""
    try:
        numbers = [float(word) for word in words]  # type: ignore[arg-type]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise CalibrationError(f"{where}: not {count} finite numbers: {EXPORT}")
    return numbers


def rotation_of(quaternion: Sequence[float], place: Sequence[float], where: str) -> FloatArray:
    """The matrix (3, 3) of a quaternion (w, x, y, z) of any length but 0.

    CalibrationError if it is of length 0, or it or the `place` (3,) beside it is not finite.
    """
    from scipy.spatial.transform import Rotation  # loaded only now: other kinds do without

    if not np.isfinite([*quaternion, *place]).all():
        raise CalibrationError(f"{where}: its pose is not finite: register the picture again")
    w, x, y, z = quaternion
    try:
        return np.asarray(Rotation.from_quat([x, y, z, w]).as_matrix())
    except ValueError as exc:
        raise CalibrationError(
            f"{where}: its quaternion is of length 0: register the picture again"
        ) from exc


def posed(world_from_camera: FloatArray, centre: FloatArray, where: str) -> Pose:
    """The pose of a rotation (3, 3) and a centre (3,); CalibrationError, with `where`, if none."""
    try:
        return Pose(world_from_camera, centre)
    except CalibrationError as exc:
        raise CalibrationError(f"{where}: {exc}") from exc
