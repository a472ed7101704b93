"""Find the solid pieces of a closed triangle mesh: its exact parts, and how they meet.

Each closed body is cut by itself. A convex one is a piece. Of others, the parts that concave edges
bound all round are pieces if they are round or lie askew (`convex_parts.py`); the rest is cut into
boards, bars and blocks along the planes of its own faces, frame by frame (`lattice.py`,
`box_cover.py`). What is left counts as unexplained.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from facetlog.perception.pieces.exact.box_cover import find_boxes
from facetlog.perception.pieces.exact.convex_parts import (
    CONVEX,
    ConvexPart,
    Hull,
    find_convex_groups,
    find_hull,
    join_through,
    make_convex_piece,
)
from facetlog.perception.pieces.exact.cut_pieces import CutPiece, CutPieces
from facetlog.perception.pieces.exact.lattice import Lattice, cluster_places, make_lattice
from facetlog.perception.pieces.exact.regions import (
    PLANE_SLACK,
    Regions,
    find_along,
    find_frame,
    find_regions,
)
from facetlog.perception.pieces.exact.sheets import Sheets, close_sheets
from facetlog.perception.ragged import Bools, Indices, iter_groups, joined
from facetlog.perception.types import FloatArray

# Further frames are tried for flat surface of more than this share of a body.
FRAME_SHARE = 0.02
MOST_FRAMES = 4
# A box of cells shows at least this share of its surface; one that shows none is no part.
SHOWN = 0.05
# A gap of this share of the thinner piece's thickness is none.
TOUCH = 0.01
_CORNERS = np.array(list(np.ndindex(2, 2, 2)))


@dataclass(slots=True)
class _Found:
    """Pieces and volumes found of the bodies so far."""

    pieces: list[CutPiece] = field(default_factory=list)
    hulls: list[Hull] = field(default_factory=list)
    body: list[int] = field(default_factory=list)
    explained: float = 0.0
    left: list[FloatArray] = field(default_factory=list)


def find_solid_pieces(points: FloatArray, triangles: Indices, *, step: float = 0.0) -> CutPieces:
    """Return the solid pieces of a mesh of points (n, 3), rounded to multiples of `step`.

    False, with the reason, where the mesh is open or encloses nothing.
    """
    sheets = close_sheets(
        np.asarray(points, dtype=np.float64), np.asarray(triangles, dtype=np.int64), step
    )
    if isinstance(sheets, str):
        return CutPieces(reason=sheets)
    regions = find_regions(sheets)
    found = _Found()
    pair_body = sheets.body[sheets.pairs[:, 0]]
    pairs = {int(pair_body[own[0]]): own for own in iter_groups(pair_body)}
    for rows in iter_groups(sheets.body):
        body = int(sheets.body[rows[0]])
        _cut_body(sheets, regions, rows, pairs[body], found)
    return _assemble(sheets, found)


def _cut_body(
    sheets: Sheets, regions: Regions, rows: Indices, pairs: Indices, found: _Found
) -> None:
    body = int(sheets.body[rows[0]])
    whole = float(sheets.volumes[body])
    first = len(found.pieces)
    explained = 0.0

    def add(part: ConvexPart) -> None:
        nonlocal explained
        found.pieces.append(make_convex_piece(sheets, regions, part))
        found.hulls.append(part.hull)
        explained += part.volume

    hull = find_hull(sheets.points[np.unique(sheets.triangles[rows])])
    if hull is None:
        return
    if not regions.concave[pairs].any() and whole >= CONVEX * hull.volume:
        add(ConvexPart(rows, hull, whole))
    else:
        boxes = _cut_apart(sheets, regions, rows, pairs, found, add)
        explained += boxes
        found.pieces[first:], found.hulls[first:] = join_through(
            sheets, rows, found.pieces[first:], found.hulls[first:]
        )
        if len(found.pieces) == first and whole >= CONVEX * hull.volume:
            add(ConvexPart(rows, hull, whole))
    found.body += [body] * (len(found.pieces) - first)
    found.explained += min(explained, whole)
    if explained < (1.0 - FRAME_SHARE) * whole:
        found.left.append(_find_unexplained(sheets, rows, found.hulls[first:]))


def _find_unexplained(sheets: Sheets, rows: Indices, hulls: list[Hull]) -> FloatArray:
    """Return the box (2, 3) round the triangles that are on no piece, of all if there are none."""
    middles = sheets.corners[rows].mean(axis=1)
    free = np.ones(len(rows), dtype=np.bool_)
    for hull in hulls:
        free &= ~hull.contains(middles, PLANE_SLACK * sheets.slack)
    own = sheets.corners[rows[free] if free.any() else rows].reshape(-1, 3) + sheets.centre
    return np.stack([own.min(axis=0), own.max(axis=0)])


def _cut_apart(
    sheets: Sheets,
    regions: Regions,
    rows: Indices,
    pairs: Indices,
    found: _Found,
    add: Callable[[ConvexPart], None],
) -> float:
    """Cut a body that is not convex; return the volume of the boxes found."""
    label = regions.label[rows]
    flat = np.unique(label[~regions.curved[label]])
    frame = find_frame(regions.normals[flat], regions.areas[flat])
    along = np.full(len(regions.normals), -1)
    if frame is not None:
        along[flat] = find_along(frame, regions.normals[flat])
    peeled = np.zeros(len(rows), dtype=np.bool_)
    hulls: list[Hull] = []
    place = np.zeros(len(sheets.triangles), dtype=np.int64)
    place[rows] = np.arange(len(rows))
    groups = [
        group
        for group in find_convex_groups(sheets, regions, rows, pairs)
        if (along[regions.label[group.rows]] < 0).any()
    ]
    for group in groups:
        add(group)
        hulls.append(group.hull)
        peeled[place[group.rows]] = True
    explained = 0.0
    left = ~peeled & ~regions.curved[label]
    usable = left.copy()
    for _ in range(MOST_FRAMES):
        if frame is None or not left.any():
            break
        own = usable & (along[label] >= 0)
        explained += _cut_in_frame(sheets, regions, rows, own, pairs, frame, along, hulls, found)
        left &= ~own
        if sheets.areas[rows[left]].sum() < FRAME_SHARE * sheets.areas[rows].sum():
            break
        # led by what is left; what was used may lie along it, too: the sides of a sloping back
        leading = np.zeros(len(regions.areas))
        leading[np.unique(label[left])] = regions.areas[np.unique(label[left])]
        frame = find_frame(regions.normals[flat], regions.areas[flat], leading[flat])
        along[:] = -1
        if frame is not None:
            along[flat] = find_along(frame, regions.normals[flat])
    return explained


def _cut_in_frame(
    sheets: Sheets,
    regions: Regions,
    rows: Indices,
    level: Bools,
    pairs: Indices,
    frame: FloatArray,
    along: Indices,
    hulls: list[Hull],
    found: _Found,
) -> float:
    """Add the boxes of a body in a frame, along which the triangles `level` (m,) lie; return their
    volume. What lies in the hulls is taken; the boxes found join them.
    """
    slack = PLANE_SLACK * sheets.slack
    corners = sheets.corners[rows] @ frame.T
    places = _find_places(sheets, regions, rows, level, pairs, frame, along, corners)
    lattice = make_lattice(frame, places, corners, corners[~level], slack)
    if lattice is None:
        return 0.0
    free = lattice.solid & ~lattice.mixed
    middles = lattice.middles[free] @ frame
    taken = np.zeros(len(middles), dtype=np.bool_)
    for hull in hulls:
        taken |= hull.contains(middles, 0.0)
    free[free] = ~taken
    if not free.any():
        return 0.0
    parts = find_boxes(lattice, free)
    if parts is None:
        return 0.0
    volumes, owned = lattice.volumes, np.zeros(free.shape, dtype=np.bool_)
    explained = 0.0
    for own in iter_groups(parts.plate):
        boxes = parts.boxes[own]
        if not any(_shows(box, lattice) for box in boxes):
            continue
        filled = 0.0
        for low, high in boxes:
            cells = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
            filled += float(volumes[cells][~owned[cells] & free[cells]].sum())
            owned[cells] = True
        piece, hull = _make_box_piece(sheets, rows[level], lattice, boxes, filled)
        if piece.extents.min() <= slack:
            continue
        explained += filled
        found.pieces.append(piece)
        found.hulls.append(hull)
        hulls.append(hull)
    return explained


def _find_places(
    sheets: Sheets,
    regions: Regions,
    rows: Indices,
    level: Bools,
    pairs: Indices,
    frame: FloatArray,
    along: Indices,
    corners: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the places along each axis: of the faces along it, and of where others begin and end.

    Others are taken patch by patch, and where a patch meets faces along the frame, seam by seam.
    """
    own = np.unique(regions.label[rows[level]])
    is_level = np.zeros(len(sheets.triangles), dtype=np.bool_)
    is_level[rows[level]] = True
    patches = [corners.reshape(-1, 3)]
    slanted = ~is_level[sheets.pairs[pairs]]
    number = np.zeros(len(sheets.triangles), dtype=np.int64)
    number[rows] = np.arange(len(rows))
    _, patch = joined(len(rows), number[sheets.pairs[pairs[slanted.all(axis=1)]]])
    rest = np.flatnonzero(~level)
    patches += [corners[rest[local]].reshape(-1, 3) for local in iter_groups(patch[rest])]
    seams = sheets.edges[pairs[slanted[:, 0] != slanted[:, 1]]]
    if len(seams):
        used, ends = np.unique(seams, return_inverse=True)
        _, loop = joined(len(used), ends.reshape(-1, 2))
        turned = sheets.points[used] @ frame.T
        patches += [turned[local] for local in iter_groups(loop)]
    ends = np.concatenate([[each.min(axis=0), each.max(axis=0)] for each in patches])
    found = []
    for axis in range(3):
        faces = own[along[own] == axis]
        signs = np.sign(regions.normals[faces] @ frame[axis])
        # where faces are, others do not count
        values = np.concatenate([regions.offsets[faces] * signs, ends[:, axis]])
        weights = np.concatenate(
            [regions.areas[faces], np.full(len(ends), 1e-6 * float(regions.areas.min()))]
        )
        found.append(cluster_places(values, weights, PLANE_SLACK * sheets.slack))
    return found[0], found[1], found[2]


def _shows(box: Indices, lattice: Lattice) -> bool:
    """Return whether faces show enough of the surface of a box (2, 3) of cells."""
    sides = [np.diff(place) for place in lattice.places]
    shown = total = 0.0
    empty = np.pad(~lattice.solid & ~lattice.mixed, 1, constant_values=True)
    for axis in range(3):
        a, b = (k for k in range(3) if k != axis)
        area = np.outer(sides[a][box[0, a] : box[1, a]], sides[b][box[0, b] : box[1, b]])
        for end in (box[0, axis], box[1, axis] + 1):
            beyond = np.take(empty, int(end), axis=axis)
            cells = beyond[box[0, a] + 1 : box[1, a] + 1, box[0, b] + 1 : box[1, b] + 1]
            shown += float(area[cells].sum())
            total += float(area.sum())
    return shown > SHOWN * total


def _make_box_piece(
    sheets: Sheets, rows: Indices, lattice: Lattice, boxes: Indices, volume: float
) -> tuple[CutPiece, Hull]:
    bounds = lattice.bounds(boxes)
    frame = lattice.frame
    corners = np.concatenate([np.where(_CORNERS, high, low) for low, high in bounds])
    hull = find_hull(corners @ frame)
    if hull is None:
        raise ValueError("a box of cells has no volume")
    low, high = bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)
    order = np.argsort(low - high, kind="stable")
    piece = CutPiece(
        hull.points + sheets.centre,
        frame[order],
        0.5 * (low + high) @ frame + sheets.centre,
        (high - low)[order],
        0.0,
        0.0,
        volume,
        np.unique(sheets.source[rows[_find_on_boxes(sheets, rows, bounds, frame)]]),
    )
    return piece, hull


def _find_on_boxes(sheets: Sheets, rows: Indices, bounds: FloatArray, frame: FloatArray) -> Bools:
    """Return which triangles (m,) along the frame lie on sides of boxes (n, 2, 3)."""
    slack = PLANE_SLACK * sheets.slack
    corners = sheets.corners[rows] @ frame.T
    lowest, highest = corners.min(axis=1), corners.max(axis=1)
    axis = np.ptp(corners, axis=1).argmin(axis=1)
    each = np.arange(len(rows))
    at = corners.mean(axis=1)[each, axis]
    on = np.zeros(len(rows), dtype=np.bool_)
    for low, high in bounds:
        beside = np.minimum(np.abs(at - low[axis]), np.abs(at - high[axis])) <= slack
        overlap = np.minimum(highest, high) - np.maximum(lowest, low) > slack
        overlap[each, axis] = True
        on |= beside & overlap.all(axis=1)
    return on


def _assemble(sheets: Sheets, found: _Found) -> CutPieces:
    """Return the pieces, the largest first, without those that lie inside others."""
    kept = _drop_inner(sheets, found)
    order = sorted(kept, key=lambda i: _rank(found.pieces[i], sheets.size))
    pieces = tuple(found.pieces[i] for i in order)
    left = np.concatenate([np.array(found.left).reshape(-1, 2, 3), sheets.open_boxes])
    total = float(sheets.volumes.sum())
    # what is open encloses nothing: it counts by its share of the surface
    closed = 1.0 - sheets.open_share
    explained = closed * min(1.0, found.explained / total) if total > 0.0 else 0.0
    hulls = [found.hulls[i].coarsen() for i in order]
    contacts = _find_contacts(pieces, hulls, sheets)
    reason = "" if pieces else "the solid is neither convex nor made of flat or round parts"
    return CutPieces(pieces, contacts, explained if pieces else 0.0, left, reason)


def _rank(piece: CutPiece, size: float) -> tuple[float, ...]:
    volume = -round(float(np.log(max(piece.volume, 1e-300))), 6)
    return (volume, *np.round(piece.middle / size, 6).tolist())


def _drop_inner(sheets: Sheets, found: _Found) -> list[int]:
    """Return the pieces that do not lie inside one of another body: those are drawn twice."""
    kept: list[int] = []
    volumes = [piece.volume for piece in found.pieces]
    slack = PLANE_SLACK * sheets.slack
    for number in sorted(range(len(volumes)), key=lambda i: -volumes[i]):
        points = found.hulls[number].points
        low, high = points.min(axis=0), points.max(axis=0)
        inner = False
        for other in kept:
            if found.body[other] == found.body[number]:
                continue
            outer = found.hulls[other].points
            if (outer.min(axis=0) <= low + slack).all() and (
                outer.max(axis=0) >= high - slack
            ).all():
                inner = bool(found.hulls[other].coarsen().contains(points, slack).all())
                if inner:
                    break
        if not inner:
            kept.append(number)
    return kept


def _find_contacts(
    pieces: tuple[CutPiece, ...], hulls: list[Hull], sheets: Sheets
) -> tuple[tuple[int, int], ...]:
    """Return the pairs of pieces between which no plane of either leaves a gap."""
    found = []
    low = np.array([hull.points.min(axis=0) for hull in hulls]).reshape(-1, 3)
    high = np.array([hull.points.max(axis=0) for hull in hulls]).reshape(-1, 3)
    near = TOUCH * np.array([float(piece.extents.min()) for piece in pieces])
    near = np.minimum(near[:, None], near) + PLANE_SLACK * sheets.slack
    close = (low[:, None] <= high + near[..., None]) & (low <= high[:, None] + near[..., None])
    for one, two in np.argwhere(np.triu(close.all(axis=2), 1)).tolist():
        a, b = hulls[one], hulls[two]
        gaps = [
            (b.points @ a.planes[:, :3].T + a.planes[:, 3]).min(axis=0).max(),
            (a.points @ b.planes[:, :3].T + b.planes[:, 3]).min(axis=0).max(),
        ]
        if max(gaps) <= near[one, two]:
            found.append((one, two))
    return tuple(found)
