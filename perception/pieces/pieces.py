"""The pieces of a thing: its solid parts with their extents, and how they meet.

A piece's extents are the sides of the least box round its surface, of the boxes that lie along
the grid, one of its faces, or the direction in which it is thinnest. Where it ends at another, that
is at a face of one of them, or known to a cell. What is known by edges alone is a cell thick.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.flat_faces import Estimate, FlatFace, make_plane_axes
from facetlog.perception.pieces.solid_parts import solid_parts
from facetlog.perception.ragged import Indices
from facetlog.perception.space.grid import ROUNDING, Grid, Lattice
from facetlog.perception.space.surface_points import inner_points, sample_lines
from facetlog.perception.surfaces.convex_hulls import find_least_rectangles
from facetlog.perception.types import FloatArray

# A board is no thicker than this share of its width, a bar no wider than this share of its length.
THIN, SLENDER = 0.35, 0.35

# Points of a face are this share of a cell apart.
SPACING = 0.5
# A part of fewer cells than this is no more than where surfaces cross.
FEWEST_CELLS = 8
# What lies within this share of a cell of a plane lies in it, but for rounding.
FLUSH = 1e-3
# What is on no face is curved, or an edge that bounds none.
CURVED, EDGE = -1, -2


class Kind(StrEnum):
    """Words for a piece by its proportions: the words of models, which are soft there."""

    BOARD = "board"
    BAR = "bar"
    BLOCK = "block"


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """A solid part. `axes` (3, 3) are the directions of its length, width and thickness, as rows,
    `middle` (3,) is the middle of its box, all in the scene's frame.

    `faces` are indices of faces that are mostly its own; `round` is the share of its surface that
    is curved, 0..1. `low` and `high` are heights along the grid's last axis, of the scene's frame.
    """

    length: Estimate
    width: Estimate
    thickness: Estimate
    axes: FloatArray
    middle: FloatArray
    low: float
    high: float
    faces: tuple[int, ...]
    round: float

    @property
    def kind(self) -> Kind:
        """The word for it by its proportions."""
        if self.thickness.value <= THIN * self.width.value:
            return Kind.BOARD
        return Kind.BAR if self.width.value <= SLENDER * self.length.value else Kind.BLOCK


@dataclass(frozen=True, eq=False, slots=True)
class Pieces:
    """The pieces of a thing, the largest first. `joins` (p, p) says which touch, `bears` (p, p)
    which carries which directly: it touches what is off the ground and reaches as low, within a
    cell, or lower.
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


def find_pieces(
    grid: Grid, faces: Sequence[FlatFace], curved: FloatArray, lines: FloatArray
) -> Pieces:
    """Return the pieces of a thing that fills a grid, has these flat faces, and besides surface
    that is not flat, at points (n, 3), and edges (l, 2, 3) that bound no face.
    """
    surface = _Surface.of(grid.lattice, faces, curved, lines)
    parts = solid_parts(grid.solid)
    at = surface.cells(grid.lattice)
    part = parts[at]
    sizes = np.bincount(parts.ravel(), minlength=1)
    owner = _owners(part, surface.face, len(faces))
    part = _cut_at_faces(parts, at, owner, surface, grid.cell)
    kept: list[int] = []
    found: list[Piece] = []
    for number in range(1, len(sizes)):
        own = part == number
        if sizes[number] < FEWEST_CELLS or not surface.spans(own):
            continue
        kept.append(number)
        own_faces = tuple(np.flatnonzero(owner == number).tolist())
        piece = _piece(grid, surface, own, own_faces)
        found.append(replace(piece, faces=tuple(faces[i].index for i in own_faces)))
    joins = _joins(parts, len(sizes))[np.ix_(kept, kept)]
    low = np.array([piece.low for piece in found])
    off_ground = low >= low.min(initial=np.inf) + grid.cell
    bears = joins & (low[:, None] <= low[None] + grid.cell) & off_ground
    return Pieces(tuple(found), joins, bears)


@dataclass(frozen=True, eq=False, slots=True)
class _Surface:
    # Points (n, 3) all over it, and which face (n,) each is on, or else CURVED or EDGE; normals
    # (f, 3) are the faces'.
    points: FloatArray
    face: Indices
    normals: FloatArray

    @classmethod
    def of(
        cls,
        lattice: Lattice,
        faces: Sequence[FlatFace],
        curved: FloatArray,
        lines: FloatArray,
    ) -> "_Surface":
        flat, face = inner_points(faces, SPACING * lattice.cell)
        normals = np.array([face.normal for face in faces]).reshape(-1, 3)
        edges = sample_lines(lines, SPACING * lattice.cell)
        others = np.repeat([CURVED, EDGE], [len(curved), len(edges)])
        return cls(np.concatenate([flat, curved, edges]), np.concatenate([face, others]), normals)

    def cells(self, lattice: Lattice) -> tuple[Indices, ...]:
        """Return indices along each axis of the cell of each point."""
        last = np.array(lattice.shape) - 1
        return tuple(np.clip(np.floor(lattice.local(self.points)).astype(np.intp), 0, last).T)

    def spans(self, own: NDArray[np.bool_]) -> bool:
        """Return whether these of its points (n,) span a plane at least, or are of edges alone."""
        points = self.points[own]
        flat = len(points) > 3 and np.linalg.matrix_rank(points - points[0]) > 1
        return bool(flat) or self.of_edges(own)

    def of_edges(self, own: NDArray[np.bool_]) -> bool:
        """Return whether there are such points, and all are of edges."""
        return bool(own.any() and (self.face[own] == EDGE).all())


def _owners(part: Indices, face: Indices, count: int) -> Indices:
    """Return the part (m,) in which most of each face's points lie; 0 for none."""
    flat = face >= 0
    width = int(part.max(initial=0)) + 1
    votes = np.bincount(face[flat] * width + part[flat], minlength=count * width)
    votes = votes.reshape(count, width)
    votes[:, 0] = 0
    return np.asarray(np.where(votes.any(axis=1), votes.argmax(axis=1), 0))


def _cut_at_faces(
    parts: Indices, at: tuple[Indices, ...], owner: Indices, surface: _Surface, cell: float
) -> Indices:
    """Return the part (m,) of each point, whose cell is `at`: parts are cut where a face is, not
    where a cell ends.

    Past the faces that are wholly a part's own, along a normal of one, others are in it by the
    width of a cell. That is of the other part whose own such a face is, or of none.
    """
    part = parts[at]
    owners = np.append(owner, (0, 0))[surface.face]  # of what is CURVED or EDGE 0
    away = np.flatnonzero((owners > 0) & (owners != part))
    astray = away[~_touching(parts, tuple(cells[away] for cells in at), owners[away])]
    whole = (owners > 0) & ~np.isin(surface.face, surface.face[astray])
    found = part.copy()
    for number in np.unique(part[whole]).tolist():
        here = part == number
        own = here & whole & (owners == number)
        others = np.flatnonzero(here & (owners > 0) & ~own)
        if not own.any() or not len(others):
            continue
        normals = surface.normals[np.unique(surface.face[own])]
        beyond = surface.points[others] @ normals.T - (surface.points[own] @ normals.T).max(axis=0)
        least = np.where(whole[others], -FLUSH, FLUSH)[:, None] * cell
        cut = others[((beyond >= least) & (beyond < cell)).any(axis=1)]
        found[cut] = np.where(whole[cut], owners[cut], 0)
    return found


def _touching(parts: Indices, at: tuple[Indices, ...], wanted: Indices) -> NDArray[np.bool_]:
    """Return whether each cell (m,), or one that touches it, is of the wanted part (m,)."""
    padded = np.pad(parts, 1)
    found = np.zeros(len(wanted), dtype=np.bool_)
    for step in np.ndindex(3, 3, 3):
        found |= padded[tuple(cells + move for cells, move in zip(at, step, strict=True))] == wanted
    return found


def _piece(grid: Grid, surface: _Surface, own: NDArray[np.bool_], faces: Sequence[int]) -> Piece:
    points = surface.points[own]
    heights = points @ grid.lattice.axes[2]
    directions = list(_directions(grid, surface, points, faces))
    at_least = grid.cell if surface.of_edges(own) else 0.0
    extents, axes, middle = _find_least_box(points, directions, at_least)
    sd = ROUNDING * grid.cell
    length, width, thickness = (Estimate(float(extent), sd) for extent in extents)
    return Piece(
        length,
        width,
        thickness,
        axes,
        middle,
        float(heights.min()),
        float(heights.max()),
        tuple(faces),
        float((surface.face[own] == CURVED).mean()),
    )


def _directions(
    grid: Grid, surface: _Surface, points: FloatArray, faces: Sequence[int]
) -> Iterator[FloatArray]:
    """Yield directions along which a piece may be thin, the more likely first."""
    yield from grid.lattice.axes[::-1]
    yield from surface.normals[list(faces)]
    if len(points) > 1:  # a single one has no direction
        yield np.linalg.eigh(np.cov(points.T))[1][:, 0]


def _find_least_box(
    points: FloatArray, directions: Sequence[FloatArray], at_least: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return extents (3,), longest first, directions (3, 3) and middle of the least box round
    points, of those that are so long `at_least` along each side.
    """
    points = _outermost(points)
    normals = np.array(directions)
    plans = make_plane_axes(normals, np.eye(3)[np.abs(normals).argmin(axis=1)])
    flat = np.swapaxes(plans @ points.T, 1, 2)
    along, _, _ = find_least_rectangles(flat, np.ones(flat.shape[:2], dtype=np.bool_))
    first = (along[:, None] @ plans)[:, 0]
    frames = np.stack([first, np.cross(normals, first), normals], axis=1)
    extent = np.maximum(np.ptp(frames @ points.T, axis=2), at_least)
    least, extents, axes = np.inf, np.zeros(3), np.eye(3)
    for own, sides in zip(frames, extent, strict=True):
        # Another direction has to do better than rounding.
        if float(sides.prod()) < least * (1.0 - 1e-6):
            least, extents, axes = float(sides.prod()), sides, own
    order = np.argsort(-extents, kind="stable")
    axes = axes[order]
    local = points @ axes.T
    middle: FloatArray = (local.min(axis=0) + local.max(axis=0)) / 2.0 @ axes
    return extents[order], axes, middle


def _outermost(points: FloatArray) -> FloatArray:
    """Return the points (of n, 3) that span their convex hull; all if they lie in a plane."""
    from scipy.spatial import ConvexHull, QhullError  # loaded only now: few ask for pieces

    try:
        return points[ConvexHull(points).vertices]
    except QhullError:
        return points


def _joins(parts: Indices, count: int) -> NDArray[np.bool_]:
    """Return which parts (count, count), by number, have cells that touch, by a corner at least."""
    joined = np.zeros((count, count), dtype=bool)
    for step in np.ndindex(3, 3, 3):
        move = np.array(step) - 1
        if tuple(move) <= (0, 0, 0):
            continue
        joined[parts[_moved(parts, -move)], parts[_moved(parts, move)]] = True
    joined |= joined.T
    joined[0] = joined[:, 0] = False
    np.fill_diagonal(joined, val=False)
    return joined


def _moved(parts: Indices, move: Indices) -> tuple[slice, ...]:
    """Return the cells that have another so many cells back along each axis."""
    return tuple(
        slice(max(0, m), side + min(0, m))
        for m, side in zip(move.tolist(), parts.shape, strict=True)
    )
