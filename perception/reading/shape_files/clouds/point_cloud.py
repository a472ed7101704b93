"""A point cloud as a value: points, with the file's normals, viewpoints and errors, if any."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from facetlog.errors import InputError
from facetlog.perception.types import FloatArray

# Fewer points are no surface: a neighbourhood has 16.
LEAST_POINTS = 16
# Coordinates beyond this overflow when they are multiplied three times, as a covariance's are.
HUGE = 1e75


@dataclass(frozen=True, eq=False, slots=True)
class Cloud:
    """Different points (n, 3), all finite, in the file's own frame and unit.

    Unit `normals` (n, 3) outwards, or None where the file has none; `seen_from` (n, 3), a place
    from which each point was seen, rows of NaN where that is not known, or None; `camera_ups`
    (m, 3), unit vectors upwards in the cameras' pictures; `errors` (n,), the standard deviation of
    each point in the unit of length. `warnings` say what was left out.

    `sensor_places` (k, 3) are those of which one, or none, may be where all points were seen from,
    the likeliest first; with `seen_from` beside it, that is sure. `world_axes` (3, 3) turns the
    sensor's frame into the world's, for a file that does not say in which its points are.
    """

    points: FloatArray
    normals: FloatArray | None = None
    name: str = "cloud"
    seen_from: FloatArray | None = None
    camera_ups: FloatArray | None = None
    errors: FloatArray | None = None
    warnings: tuple[str, ...] = ()
    sensor_places: FloatArray | None = None
    world_axes: FloatArray | None = None

    @classmethod
    def of(
        cls,
        points: ArrayLike,
        *,
        normals: ArrayLike | None = None,
        name: str = "cloud",
        seen_from: ArrayLike | None = None,
        camera_ups: ArrayLike | None = None,
        errors: ArrayLike | None = None,
        sensor_places: ArrayLike | None = None,
        world_axes: ArrayLike | None = None,
    ) -> "Cloud":
        """Make a cloud of any arrays: points that are not finite, or there already, are dropped.

        Normals of no length are taken for unknown. Raise InputError for fewer than 16 points.
        """
        every = np.array(points, dtype=np.float64).reshape(-1, 3)
        with np.errstate(invalid="ignore"):
            sound = (np.abs(every) < HUGE).all(axis=1)
        rows = np.flatnonzero(sound)
        order = np.lexsort(every[rows].T)
        same = (np.diff(every[rows][order], axis=0) == 0.0).all(axis=1)
        rows = np.sort(np.delete(rows[order], np.flatnonzero(same) + 1))
        if len(rows) < LEAST_POINTS:
            raise InputError(
                f"{name}: {len(rows) or 'no'} different points with finite coordinates, at least "
                f"{LEAST_POINTS} are needed: export the cloud again"
            )
        said = []
        for lost, what in ((int((~sound).sum()), "not finite"), (int(same.sum()), "there twice")):
            if lost:
                said.append(f"{lost} of {len(every)} points left out: {what}")
        extra = [
            None if given is None else np.array(given, dtype=np.float64)[rows]
            for given in (normals, seen_from, errors)
        ]
        ups, places, axes = (
            None
            if given is None
            else _make_read_only(np.array(given, dtype=np.float64).reshape(-1, 3))
            for given in (camera_ups, sensor_places, world_axes)
        )
        return cls(
            _make_read_only(every[rows]),
            _normalize_rows(extra[0]),
            name,
            None if extra[1] is None else _make_read_only(extra[1]),
            ups,
            None if extra[2] is None else _make_read_only(extra[2]),
            tuple(said),
            places,
            axes,
        )


def _make_read_only(values: FloatArray) -> FloatArray:
    values.setflags(write=False)
    return values


def _normalize_rows(normals: FloatArray | None) -> FloatArray | None:
    """Return normals (n, 3) of unit length; zeros where they had none; None where none has any."""
    if normals is None:
        return None
    with np.errstate(over="ignore", invalid="ignore"):
        length = np.linalg.norm(normals, axis=1)
    known = np.isfinite(length) & (length > 0.0)
    if not known.any():
        return None
    unit = np.zeros_like(normals)
    unit[known] = normals[known] / length[known, None]
    return _make_read_only(unit)
