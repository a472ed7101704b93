"""Meshes in PLY files: text or binary of either byte order, faces of any number of corners."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from facetlog.perception.ragged import Indices
from facetlog.perception.reading.shape_files.meshes.mesh_checks import (
    NoTrianglesError,
    TriangleList,
    cut_polygons,
)
from facetlog.perception.reading.shape_files.meshes.polygons import strip_triangles
from facetlog.perception.reading.shape_files.ply_rows import (
    PlyRows,
    parse_ply_header,
    read_ply_rows,
)
from facetlog.perception.reading.shape_files.shape_file import ShapeFile

# Names in use for the list of a face.
CORNERS = ("vertex_indices", "vertex_index")


def read_ply(data: bytes, shape: ShapeFile) -> TriangleList:
    """Return the triangles of a PLY.

    Raise NoTrianglesError for a PLY without faces, InputError where it ends before its last row
    or has more rows than its header counts.
    """
    header = parse_ply_header(data, shape)
    if not header.count("face") and not header.count("tristrips"):
        raise NoTrianglesError(
            f"{shape.name}: has no faces; read it as a cloud, or export the faces too"
        )
    shape.check_triangles(header.count("face"))
    rows, warnings = read_ply_rows(header, shape)
    if "vertex" not in rows:
        raise shape.error("has no vertices; export the mesh again")
    points = rows["vertex"].stack_numbers("xyz")
    if points is None:
        raise shape.error("its vertices have no x, y and z; export the mesh again")
    corners, sizes = _read_corners(rows.get("face"), shape)
    if (sizes < 2).any():
        row = int(np.flatnonzero(sizes < 2)[0])
        raise shape.make_inconsistency_error(f"face {row} has {sizes[row]} corners")
    flat, lengths = _read_corners(rows.get("tristrips"), shape)
    stripped = _strip_corners(np.split(flat, np.cumsum(lengths)[:-1]))
    corners = np.concatenate((corners, stripped.ravel()))
    sizes = np.concatenate((sizes, np.full(len(stripped), 3)))
    beyond = np.flatnonzero((corners < 0) | (corners >= len(points)))
    if len(beyond):
        raise shape.make_inconsistency_error(
            f"a face names vertex {corners[beyond[0]]}, its vertices are 0 to {len(points) - 1}",
        )
    found = cut_polygons(points, corners, sizes, shape)
    return replace(found, warnings=(*found.warnings, *warnings))


def _read_corners(rows: PlyRows | None, shape: ShapeFile) -> tuple[Indices, Indices]:
    """Return the vertices of all rows, -1 for what is no index, and how many each row has."""
    if rows is None or rows.element.count == 0:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    lists = rows.read_lists(CORNERS)
    if lists is None:
        raise shape.error(
            f"its {rows.element.name} rows have no list vertex_indices; export the mesh again"
        )
    values, lengths = lists
    with np.errstate(invalid="ignore"):
        corners: Indices = values.astype(np.int64)
    return np.where(corners == values, corners, -1), lengths


def _strip_corners(strips: Sequence[Indices]) -> Indices:
    """Return triangles (m, 3) of strips, which -1 cuts into several."""
    pieces = [
        strip_triangles(piece[piece >= 0])
        for strip in strips
        for piece in np.split(strip, np.flatnonzero(strip == -1))
    ]
    return np.concatenate((np.zeros((0, 3), dtype=np.int64), *pieces))
