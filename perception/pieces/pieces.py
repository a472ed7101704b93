"""The pieces of a thing: its solid parts with their extents, and how they meet.

A piece's extents are the sides of the least box round its surface, of the boxes that lie along
the grid, one of its faces, or the direction in which it is thinnest. Where it ends at another, that
is at a face of one of them, or known to a cell. What is known by edges alone is a cell thick.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.flat_faces import Estimate, FlatFace, make_plane_axes
from facetlog.perception.pieces.shown_pieces import Piece, Pieces
from facetlog.perception.ragged import Indices
from facetlog.perception.space.grid import ROUNDING, Grid, Lattice
from facetlog.perception.space.surface_points import inner_points, sample_lines
from facetlog.perception.surfaces.convex_hulls import find_least_rectangles
from facetlog.perception.types import FloatArray

# Points of a face are this share of a cell apart.
SPACING = 0.5
# A part of fewer cells than this is no more than where surfaces cross.
FEWEST_CELLS = 8
# What lies within this share of a cell of a plane lies in it, but for rounding.
FLUSH = 1e-3
# What is on no face is curved, or an edge that bounds none.
CURVED, EDGE = -1, -2
_Cells = NDArray[np.bool_]

# Share of the convex hull that parts fill together. A slope in steps of cells takes some per cent
# from it; a flight of three steps, which is not one part, fills .88.
CONVEX = 0.9
# A cut has to fill so much more of the hulls.
GAIN = 1.0 - CONVEX
# Cuts are tried where the section changes most: so many along each axis.
CUTS = 2
_CORNERS = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(-1, 3)


def is_convex(cells: NDArray[np.bool_]) -> bool:
    """Return whether cells (nx, ny, nz), some at least, are nearly their own convex hull."""
    volume, _ = _hull(_find_outer_corners(np.argwhere(cells)))
    return int(cells.sum()) >= CONVEX * volume


def cut_to_convex(cells: _Cells) -> list[_Cells]:
    """Return cells (nx, ny, nz), some at least, cut square to the grid as long as that makes them
    more convex: a seat off the back that is as thick as it, a step off the next.
    """
    volume, _ = _hull(_find_outer_corners(np.argwhere(cells)))
    if cells.sum() >= CONVEX * volume:
        return [cells]
    best, filled = None, float(cells.sum()) / volume + GAIN
    # level cuts first: a seat goes through below its back
    for axis in (2, 1, 0):
        areas = np.moveaxis(cells, axis, 0).sum(axis=(1, 2))
        for last in np.argsort(-np.abs(np.diff(areas)), kind="stable")[:CUTS]:
            sides = _split_cells(cells, axis, int(last) + 1)
            hulls = sum(_hull(_find_outer_corners(np.argwhere(side)))[0] for side in sides)
            if len(sides) > 1 and cells.sum() / hulls > filled:
                best, filled = sides, float(cells.sum()) / hulls
    return [cells] if best is None else [part for side in best for part in cut_to_convex(side)]


def _split_cells(cells: _Cells, axis: int, place: int) -> list[_Cells]:
    """Return the connected parts of cells before a place along an axis, and of cells from it on."""
    from scipy import ndimage

    first = (np.arange(cells.shape[axis]) < place).reshape(
        [-1 if i == axis else 1 for i in range(3)]
    )
    found = []
    for side in (cells & first, cells & ~first):
        labels, count = ndimage.label(side)
        found += [labels == number for number in range(1, count + 1)]
    return found


def join_convex_parts(parts: Indices) -> Indices:
    """Return the parts (nx, ny, nz) with those that are nearly convex together under one number.

    The two that together fill their hull the most are joined first.
    """
    found = parts.copy()
    count = int(parts.max())
    sizes = np.bincount(parts.ravel(), minlength=count + 1).tolist()
    hulls = {i: _hull(_find_outer_corners(np.argwhere(parts == i)))[1] for i in range(1, count + 1)}
    fills: dict[tuple[int, int], float] = {}

    def together(one: int, other: int) -> float:
        if (one, other) not in fills:
            volume, _ = _hull(np.concatenate([hulls[one], hulls[other]]))
            fills[one, other] = (sizes[one] + sizes[other]) / volume
        return fills[one, other]

    touching = _touching(found)
    while touching:
        best = max(touching, key=lambda pair: (together(*pair), pair))
        if together(*best) < CONVEX:
            break
        one, other = best
        found[found == other] = one
        hulls[one] = _hull(np.concatenate([hulls[one], hulls.pop(other)]))[1]
        sizes[one] += sizes[other]
        for pair in [pair for pair in fills if one in pair or other in pair]:
            del fills[pair]
        renamed = (tuple(sorted(one if i == other else i for i in pair)) for pair in touching)
        touching = {(a, b) for a, b in renamed if a != b}
    return found


def _touching(parts: Indices) -> set[tuple[int, int]]:
    """Return pairs of parts, the lower number first, of which cells share a side."""
    found: set[tuple[int, int]] = set()
    for axis in range(3):
        moved = np.moveaxis(parts, axis, 0)
        one, other = moved[:-1], moved[1:]
        meet = (one != other) & (one > 0) & (other > 0)
        pairs = np.sort(np.stack([one[meet], other[meet]], axis=-1), axis=-1)
        found.update((a, b) for a, b in np.unique(pairs, axis=0).tolist())
    return found


def _find_outer_corners(cells: Indices) -> FloatArray:
    """Return corners (k, 3) of cells (n, 3) in their order, all of their convex hull among them."""
    # Between the lowest and the highest of a column nothing is a corner.
    ends = np.any(cells[1:, :2] != cells[:-1, :2], axis=1)
    outer = cells[np.concatenate([[True], ends]) | np.concatenate([ends, [True]])]
    corners: FloatArray = (outer[:, None] + _CORNERS).reshape(-1, 3).astype(np.float64)
    return corners


def _hull(points: FloatArray) -> tuple[float, FloatArray]:
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    return float(hull.volume), points[hull.vertices]


# How long a probe is, of the thing's longest side: a fifth, then a tenth.
PROBES = (0.2, 0.1)
# What lies this near to a larger part, of the thing's longest side, and nowhere farther away from
# it, is no part of its own.
CRUMB = 0.05
_AROUND = np.ones((3, 3, 3), dtype=bool)


def solid_parts(solid: _Cells) -> Indices:
    """Return the part (nx, ny, nz), from 1, to which each of these solid cells belongs; 0
    elsewhere.

    Parts stand in the order of their sizes, the largest first.
    """
    if not solid.any() or is_convex(solid):
        return solid.astype(np.intp)
    longest = max(solid.shape)
    left = solid.copy()
    parts = np.zeros(solid.shape, dtype=np.intp)
    count = 0
    for cores in _iter_probed(left, longest):
        # Where two cross the larger goes through.
        for core in sorted(cores, key=lambda cells: -int(cells.sum())):
            own = core & left
            if own.any():
                count += 1
                parts[own] = count
                left &= ~own
    parts = _in_order(parts)
    parts = _in_order(_merge_crumbs(parts, max(1, round(CRUMB * longest))))
    return _in_order(join_convex_parts(parts))


def _iter_probed(left: _Cells, longest: int) -> Iterator[list[_Cells]]:
    """Yield the parts that each sort of probe finds in the cells left by then; at last the rest."""
    lengths = [max(3, round(share * longest)) for share in PROBES]
    for long in lengths:
        blocks = _connected(_opened(left, (long, long, long)))
        yield [part for block in blocks for part in cut_to_convex(block)]
        squares = [[1 if axis == flat else long for axis in range(3)] for flat in range(3)]
        yield [part for probe in squares for part in _connected(_opened(left, probe))]
    for long in lengths:
        sticks = [[long if axis == along else 1 for axis in range(3)] for along in range(3)]
        yield [part for probe in sticks for part in _connected(_opened(left, probe))]
    yield _connected(left)


def _connected(cells: _Cells) -> list[_Cells]:
    from scipy import ndimage

    labels, count = ndimage.label(cells, _AROUND)
    return [labels == number for number in range(1, count + 1)]


def _opened(cells: _Cells, probe: Sequence[int]) -> _Cells:
    """Return the cells that a box of so many cells fills which lies wholly inside."""
    if any(length > side for length, side in zip(probe, cells.shape, strict=True)):
        return np.zeros_like(cells)
    starts = cells
    for axis, length in enumerate(probe):
        starts = _find_full_stretches(starts, axis, length)
    for axis, length in enumerate(probe):
        starts = _mark_stretches(starts, axis, length)
    return starts


def _count_in_stretches(cells: _Cells, axis: int, length: int) -> NDArray[np.int16]:
    """Return how many of so many cells from each on along the axis are there: shorter by length -
    1.
    """
    sums = np.cumsum(cells, axis=axis, dtype=np.int16)  # there are some tens of cells
    sums = np.moveaxis(np.pad(sums, [(int(i == axis), 0) for i in range(3)]), axis, 0)
    found: NDArray[np.int16] = np.moveaxis(sums[length:] - sums[:-length], 0, axis)
    return found


def _find_full_stretches(cells: _Cells, axis: int, length: int) -> _Cells:
    """Return where so many cells from here on along the axis are all there."""
    return np.asarray(_count_in_stretches(cells, axis, length) == length)


def _mark_stretches(starts: _Cells, axis: int, length: int) -> _Cells:
    """Return the cells of stretches of this length along the axis that begin here."""
    margin = [(length - 1) * int(i == axis) for i in range(3)]
    padded = np.pad(starts, [(each, each) for each in margin])
    return np.asarray(_count_in_stretches(padded, axis, length) > 0)


def _merge_crumbs(parts: Indices, near: int) -> Indices:
    """Return the parts with all that lies wholly within `near` cells of a larger one as
    part of it.
    """
    from scipy import ndimage

    found = parts.copy()
    boxes = ndimage.find_objects(parts)
    for number in range(len(boxes), 1, -1):
        around = tuple(
            slice(max(0, own.start - near), own.stop + near) for own in boxes[number - 1]
        )
        window = found[around]
        own = window == number
        for larger in np.unique(window[ndimage.binary_dilation(own, _AROUND)]).tolist():
            if 0 < larger < number:
                away = ndimage.distance_transform_cdt(window != larger, metric="chessboard")
                if int(away[own].max()) <= near:
                    window[own] = larger
                    break
    return found


def _in_order(parts: Indices) -> Indices:
    """Return the parts numbered anew, without gaps, the largest first."""
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    order = np.argsort(-sizes, kind="stable")
    numbers = np.zeros(len(sizes), dtype=np.intp)
    there = order[sizes[order] > 0]
    numbers[there] = np.arange(1, len(there) + 1)
    found: Indices = numbers[parts]
    return found


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
    convex = 0
    found: list[Piece] = []
    for number in range(1, len(sizes)):
        own = part == number
        if sizes[number] < FEWEST_CELLS or not surface.spans(own):
            continue
        kept.append(number)
        own_faces = tuple(np.flatnonzero(owner == number).tolist())
        piece = _piece(grid, surface, own, own_faces)
        found.append(replace(piece, faces=tuple(faces[i].index for i in own_faces)))
        convex += int(sizes[number]) if is_convex(parts == number) else 0
    joins = _joins(parts, len(sizes))[np.ix_(kept, kept)]
    low = np.array([piece.low for piece in found])
    off_ground = low >= low.min(initial=np.inf) + grid.cell
    bears = joins & (low[:, None] <= low[None] + grid.cell) & off_ground
    explained = convex / max(1, int(sizes[1:].sum()))
    return Pieces(tuple(found), joins, bears, explained)


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
    astray = away[~_are_touching(parts, tuple(cells[away] for cells in at), owners[away])]
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


def _are_touching(parts: Indices, at: tuple[Indices, ...], wanted: Indices) -> NDArray[np.bool_]:
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
    extents, axes, middle = find_least_box(points, directions, at_least)
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


def find_least_box(
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
