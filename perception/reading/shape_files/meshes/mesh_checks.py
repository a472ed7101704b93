"""What readers of mesh files share: limits, refusals, and the triangles that they return."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.ragged import Indices
from facetlog.perception.reading.shape_files.meshes.polygons import triangulate
from facetlog.perception.reading.shape_files.suffixes import MESH_SUFFIXES
from facetlog.perception.types import FloatArray

__all__ = [
    "DEFAULT_LIMITS",
    "Limits",
    "NoTrianglesError",
    "TriangleList",
    "check_file",
    "check_triangles",
    "cut_polygons",
    "merge_parts",
]

# Four times the 5 million triangles that must work: a binary STL of them has 1 GB.
MAX_TRIANGLES = 20_000_000
MAX_BYTES = 4 << 30


class NoTrianglesError(InputError):
    """The file is sound and has no faces: it may be a point cloud."""


@dataclass(frozen=True, slots=True)
class Limits:
    """What is refused: files of more `size_bytes`, meshes of more `triangles`."""

    size_bytes: int = MAX_BYTES
    triangles: int = MAX_TRIANGLES


DEFAULT_LIMITS = Limits()


@dataclass(frozen=True, eq=False, slots=True)
class TriangleList:
    """Triangles (m, 3) of indices into vertices (n, 3), as a file has them.

    `up` (3,) and `unit_metres` where the format says them; `step` is the distance of neighbouring
    coordinates where they were rounded to whole numbers.
    """

    vertices: FloatArray
    triangles: Indices
    up: tuple[float, float, float] | None = None
    unit_metres: float | None = None
    warnings: tuple[str, ...] = ()
    step: float = 0.0


def cut_polygons(
    points: FloatArray, corners: Indices, sizes: Indices, name: str, limits: Limits
) -> TriangleList:
    """Return polygons as triangles.

    Raises InputError where there are too many, or no polygon has three corners.
    """
    check_triangles(int(np.maximum(sizes - 2, 0).sum()), name, limits)
    cut = triangulate(points, corners, sizes)
    if not len(cut.triangles):
        raise InputError(f"{name}: no face has three corners; export the mesh again")
    return TriangleList(points, cut.triangles, warnings=cut.warnings)


def check_file(path: Path, limits: Limits = DEFAULT_LIMITS) -> str:
    """Return the kind of a mesh file: its suffix in lower case, without the dot.

    Raises InputError where the file is missing, empty, too large or of no known kind.
    """
    suffix = path.suffix.lower()
    if suffix not in MESH_SUFFIXES:
        raise InputError(f"{path.name}: is no mesh file; give one of {', '.join(MESH_SUFFIXES)}")
    try:
        size = path.stat().st_size
    except OSError as exc:
        raise InputError(f"{path.name}: cannot be read ({exc.strerror}); check the path") from exc
    if not path.is_file():
        raise InputError(f"{path.name}: is no file; give a mesh file")
    if size == 0:
        raise InputError(f"{path.name}: is empty; export the mesh again")
    if size > limits.size_bytes:
        raise InputError(
            f"{path.name}: has {size} bytes, more than {limits.size_bytes}; reduce the mesh"
        )
    return suffix.removeprefix(".")


def check_triangles(count: int, name: str, limits: Limits) -> None:
    """Raise InputError where a file has more triangles than the limit."""
    if count > limits.triangles:
        raise InputError(
            f"{name}: has more than {limits.triangles} triangles; reduce or split the mesh"
        )


def merge_parts(
    parts: Iterable[tuple[FloatArray, Indices]], name: str, limits: Limits
) -> tuple[FloatArray, Indices]:
    """Return one list of vertices (n, 3) and triangles (m, 3); refused above the limit."""
    vertices: list[FloatArray] = [np.zeros((0, 3))]
    triangles: list[Indices] = [np.zeros((0, 3), dtype=np.int64)]
    count, start = 0, 0
    for points, corners in parts:
        count += len(corners)
        check_triangles(count, name, limits)
        vertices.append(points)
        # missing corners stay missing
        triangles.append(np.where((corners >= 0) & (corners < len(points)), corners + start, -1))
        start += len(points)
    return np.concatenate(vertices), np.concatenate(triangles)
