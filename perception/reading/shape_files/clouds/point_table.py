"""Tables of named numbers, as PLY and PCD keep points: sizes are checked before reading."""

import io
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.reading.shape_files.shape_file import ShapeFile
from facetlog.perception.types import FloatArray

# A number in text takes a digit and a blank.
LEAST_TEXT_BYTES = 2
PLACE = ("x", "y", "z")
NORMALS = (("nx", "ny", "nz"), ("normal_x", "normal_y", "normal_z"))


@dataclass(frozen=True, eq=False, slots=True)
class PointTable:
    """Points (n, 3), and normals (n, 3) or None; `warnings` say what had to be assumed."""

    points: FloatArray
    normals: FloatArray | None
    warnings: tuple[str, ...] = ()


def read_binary_rows(
    shape: ShapeFile, data: bytes, dtype: np.dtype[Any], count: int
) -> NDArray[Any]:
    """Return `count` packed rows from the start of the data; InputError where it has fewer."""
    needed = count * dtype.itemsize
    if needed > len(data):
        raise shape.make_false_claim_error(f"{count} points")
    return np.frombuffer(data, dtype, count)


def read_text_rows(shape: ShapeFile, data: bytes, columns: int, count: int) -> FloatArray:
    """Return `count` rows of `columns` numbers, (count, columns); InputError where it has fewer."""
    if count * columns * LEAST_TEXT_BYTES > len(data) + LEAST_TEXT_BYTES:
        raise shape.make_false_claim_error(f"{count} points")
    try:
        rows = np.loadtxt(io.BytesIO(data), max_rows=count, ndmin=2) if count else np.empty((0, 0))
    except (ValueError, UnicodeDecodeError) as exc:
        said = " ".join(str(exc).split())
        raise shape.error(f"has a damaged row ({said[:100]}); export the cloud again") from exc
    if rows.shape[0] < count:
        raise shape.make_false_claim_error(f"{count} points")
    if count and rows.shape[1] != columns:
        raise shape.error(
            f"has rows of {rows.shape[1]} numbers where its header says {columns}; "
            "export the cloud again"
        )
    return rows.reshape(count, columns)


def extract_point_columns(
    shape: ShapeFile, fields: tuple[str, ...], rows: NDArray[Any]
) -> PointTable:
    """Return places and normals of rows, which are packed or (n, fields) numbers."""
    lower = [field.lower() for field in fields]
    if not set(PLACE) <= set(lower):
        raise shape.error("its points have no x, y and z; export the cloud again")

    def taken(wanted: tuple[str, ...]) -> FloatArray:
        at = [lower.index(field) for field in wanted]
        if rows.dtype.names is not None:
            return np.column_stack([rows[rows.dtype.names[k]].astype(np.float64) for k in at])
        return np.ascontiguousarray(rows[:, at], dtype=np.float64)

    normals = next((taken(names) for names in NORMALS if set(names) <= set(lower)), None)
    return PointTable(taken(PLACE), normals)
