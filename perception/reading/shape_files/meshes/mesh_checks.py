"""Triangles as readers of mesh files return them, and how their parts are cut, moved and merged."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.ragged import Indices
from facetlog.perception.reading.shape_files.meshes.polygons import triangulate
from facetlog.perception.reading.shape_files.shape_file import ShapeFile
from facetlog.perception.types import FloatArray


class NoTrianglesError(InputError):
    """The file is sound and has no faces: it may be a point cloud."""


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
    points: FloatArray, corners: Indices, sizes: Indices, shape: ShapeFile
) -> TriangleList:
    """Return polygons as triangles.

    Raise InputError where there are too many, or no polygon has three corners.
    """
    shape.check_triangles(int(np.maximum(sizes - 2, 0).sum()))
    cut = triangulate(points, corners, sizes)
    if not len(cut.triangles):
        raise shape.error("no face has three corners; export the mesh again")
    return TriangleList(points, cut.triangles, warnings=cut.warnings)


def merge_parts(
    parts: Iterable[tuple[FloatArray, Indices]], shape: ShapeFile
) -> tuple[FloatArray, Indices]:
    """Return one list of vertices (n, 3) and triangles (m, 3); refused above the limit."""
    vertices: list[FloatArray] = [np.zeros((0, 3))]
    triangles: list[Indices] = [np.zeros((0, 3), dtype=np.int64)]
    count, start = 0, 0
    for points, corners in parts:
        count += len(corners)
        shape.check_triangles(count)
        vertices.append(points)
        # missing corners stay missing
        triangles.append(np.where((corners >= 0) & (corners < len(points)), corners + start, -1))
        start += len(points)
    return np.concatenate(vertices), np.concatenate(triangles)


def move_part(
    points: FloatArray, triangles: Indices, matrix: FloatArray
) -> tuple[FloatArray, Indices]:
    """Return points and triangles moved by a matrix (4, 4); a mirror turns no triangle over."""
    if np.array_equal(matrix, np.eye(4)):
        return points, triangles
    moved = points @ matrix[:3, :3].T + matrix[:3, 3]
    mirrored = np.linalg.det(matrix[:3, :3]) < 0.0
    return moved, triangles[:, ::-1] if mirrored else triangles


def skin_points(
    points: FloatArray, matrices: FloatArray, owners: Indices, weights: FloatArray
) -> FloatArray:
    """Return points (n, 3) moved by their joints (j, 4, 4): Σ w_k M_k p, weights normalised to 1.

    `owners` (n, k) are each point's joints, `weights` (n, k) their shares. Raise ValueError for a
    joint that there is not, and for points that hang on none.
    """
    total = weights.sum(axis=1, keepdims=True)
    used = weights != 0.0
    if not (len(owners) == len(weights) == len(points)) or not (total > 0.0).all():
        raise ValueError("a skin without weights for each vertex")
    if (owners[used] < 0).any() or (owners[used] >= len(matrices)).any():
        raise ValueError("a skin with a missing joint")
    moved = np.zeros_like(points)
    for k in range(owners.shape[1]):
        on = np.flatnonzero(used[:, k])
        matrix = matrices[owners[on, k]]
        placed = np.einsum("nij,nj->ni", matrix[:, :3, :3], points[on]) + matrix[:, :3, 3]
        moved[on] += (weights[on, k] / total[on, 0])[:, None] * placed
    return moved
