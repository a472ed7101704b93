"""The pieces of a thing: its solid parts with their extents, and how they meet.

A piece's extents are the sides of the least box round its surface, of the boxes that lie along
the grid, one of its faces, or the direction in which it is thinnest. Where a piece ends at another
there is no surface: its end is known to a cell.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.flat_faces import Estimate, plane_axes
from facetlog.perception.pieces.solid_parts import solid_parts
from facetlog.perception.row_table import Indices
from facetlog.perception.surfaces.convex_hulls import least_rectangle
from facetlog.perception.surfaces.occupancy import Grid
from facetlog.perception.types import FloatArray

__all__ = ["Piece", "Pieces", "SurfacePoints", "find_pieces"]

# sd of a place that is known to a cell, in cells: of a uniform distribution.
ROUNDING = 0.29
# A part of fewer cells than this is no more than where surfaces cross.
FEWEST_CELLS = 8


@dataclass(frozen=True, eq=False, slots=True)
class SurfacePoints:
    """Points (n, 3) all over a thing's surface, with the face (n,) of each, -1 where it is curved,
    and the `normals` of the faces by their numbers (m, 3).
    """

    points: FloatArray
    face: Indices
    normals: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """A solid part. `axes` (3, 3) are the directions of its length, width and thickness, as rows,
    `middle` (3,) is the middle of its box, all in the scene's frame; `volume` is that of its cells.

    `faces` are numbers of faces that are mostly its own; `round` is the share of its surface that
    is curved, 0..1. `low` and `high` are heights along the grid's last axis.
    """

    length: Estimate
    width: Estimate
    thickness: Estimate
    axes: FloatArray
    middle: FloatArray
    volume: float
    low: float
    high: float
    faces: tuple[int, ...]
    round: float


@dataclass(frozen=True, eq=False, slots=True)
class Pieces:
    """The pieces of a thing, the largest first. `joins` (p, p) says which touch, `bears` (p, p)
    which carries which directly: it touches the other and reaches lower.
    """

    pieces: tuple[Piece, ...]
    joins: NDArray[np.bool_]
    bears: NDArray[np.bool_]

    @property
    def carries(self) -> NDArray[np.bool_]:
        """Which carries which (p, p), directly or through others."""
        carried = self.bears.copy()
        for middle in range(len(self.pieces)):
            carried |= carried[:, middle : middle + 1] & carried[middle]
        np.fill_diagonal(carried, val=False)
        return carried


def find_pieces(grid: Grid, surface: SurfacePoints) -> Pieces:
    """The pieces of a thing that fills a grid and has some surface."""
    parts = solid_parts(grid.solid)
    local = surface.points @ grid.axes.T - grid.corner
    last = np.array(parts.shape) - 1
    cells = np.clip(np.floor(local / grid.cell).astype(np.intp), 0, last)
    part = parts[tuple(cells.T)]
    sizes = np.bincount(parts.ravel(), minlength=1)
    owner = _owners(part, surface.face, len(surface.normals))
    kept, found = [], []
    for number in range(1, len(sizes)):
        own = part == number
        if sizes[number] < FEWEST_CELLS or not _spans(local[own]):
            continue
        faces = tuple(np.flatnonzero(owner == number).tolist())
        kept.append(number)
        found.append(_piece(grid, surface, own, faces, int(sizes[number])))
    joins = _joins(parts, len(sizes))[np.ix_(kept, kept)]
    low = np.array([piece.low for piece in found])
    bears = joins & (low[:, None] < low[None] - grid.cell)
    return Pieces(tuple(found), joins, bears)


def _spans(points: FloatArray) -> bool:
    """Whether points span a plane at least."""
    return len(points) > 3 and bool(np.linalg.matrix_rank(points - points[0]) > 1)


def _owners(part: Indices, face: Indices, count: int) -> Indices:
    """The part (m,) in which most of each face's points lie; 0 for none."""
    flat = face >= 0
    width = int(part.max(initial=0)) + 1
    votes = np.bincount(face[flat] * width + part[flat], minlength=count * width)
    votes = votes.reshape(count, width)
    votes[:, 0] = 0
    return np.asarray(np.where(votes.any(axis=1), votes.argmax(axis=1), 0))


def _piece(
    grid: Grid, surface: SurfacePoints, own: NDArray[np.bool_], faces: Sequence[int], cells: int
) -> Piece:
    points = surface.points[own]
    heights = points @ grid.axes[2]
    extents, axes, middle = _least_box(points, list(_directions(grid, surface, points, faces)))
    sd = ROUNDING * grid.cell
    length, width, thickness = (Estimate(float(extent), sd) for extent in extents)
    return Piece(
        length,
        width,
        thickness,
        axes,
        middle,
        cells * grid.cell**3,
        float(heights.min()),
        float(heights.max()),
        tuple(faces),
        float((surface.face[own] < 0).mean()),
    )


def _directions(
    grid: Grid, surface: SurfacePoints, points: FloatArray, faces: Sequence[int]
) -> Iterator[FloatArray]:
    """Along which a piece may be thin, the more likely first."""
    yield from grid.axes[::-1]
    yield from surface.normals[list(faces)]
    yield np.linalg.eigh(np.cov(points.T))[1][:, 0]


def _least_box(
    points: FloatArray, directions: Sequence[FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Extents (3,), longest first, directions (3, 3) and middle of the least box round points."""
    best: tuple[float, FloatArray, FloatArray] | None = None
    for direction in directions:
        flat_axes = plane_axes(direction, np.eye(3)[int(np.argmin(np.abs(direction)))])
        along, _, _ = least_rectangle(points @ flat_axes.T)
        first = along @ flat_axes
        axes = np.array([first, np.cross(direction, first), direction])
        extents = np.ptp(points @ axes.T, axis=0)
        size = float(extents.prod())
        # Another direction has to do better than rounding.
        if best is None or size < best[0] * (1.0 - 1e-6):
            best = size, extents, axes
    assert best is not None
    _, extents, axes = best
    order = np.argsort(-extents, kind="stable")
    axes = axes[order]
    local = points @ axes.T
    middle: FloatArray = (local.min(axis=0) + local.max(axis=0)) / 2.0 @ axes
    return extents[order], axes, middle


def _joins(parts: Indices, count: int) -> NDArray[np.bool_]:
    """Which parts (count, count), by number, have cells that touch, by a corner at least."""
    joined = np.zeros((count, count), dtype=bool)
    for step in np.ndindex(3, 3, 3):
        move = np.array(step) - 1
        if tuple(move) <= (0, 0, 0):
            continue
        here = parts[tuple(slice(max(0, -m), parts.shape[i] - max(0, m)) for i, m in enumerate(move))]
        there = parts[tuple(slice(max(0, m), parts.shape[i] - max(0, -m)) for i, m in enumerate(move))]
        joined[here, there] = True
    joined |= joined.T
    joined[0] = joined[:, 0] = False
    np.fill_diagonal(joined, val=False)
    return joined
