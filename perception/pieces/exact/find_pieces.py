"""Find the solid pieces of a closed triangle mesh: its exact parts, and how they meet.

Each closed body is cut by itself. A convex one is a piece. Of others, the parts that concave edges
bound all round are pieces if they are round or lie askew (`convex_parts.py`); the rest is cut into
boards, bars and blocks along the planes of its own faces, frame by frame (`lattice.py`,
`box_cover.py`). What is left counts as unexplained.
"""

from dataclasses import dataclass, field

import numpy as np

from facetlog.perception.pieces.exact.assemble_pieces import FoundPieces, assemble_pieces
from facetlog.perception.pieces.exact.box_cover import find_boxes
from facetlog.perception.pieces.exact.convex_parts import (
    CONVEX,
    ConvexPart,
    Hull,
    find_convex_groups,
    find_flush_bars,
    find_hull,
    is_turned,
    join_through,
    make_convex_piece,
)
from facetlog.perception.pieces.exact.cut_pieces import CutPiece, CutPieces
from facetlog.perception.pieces.exact.hollows import fill_hollows
from facetlog.perception.pieces.exact.lattice import Lattice, cluster_places, make_lattice
from facetlog.perception.pieces.exact.open_parts import add_open_parts
from facetlog.perception.pieces.exact.regions import (
    PLANE_SLACK,
    Regions,
    find_along,
    find_frame,
    find_regions,
)
from facetlog.perception.pieces.exact.sheets import (
    Sheets,
    close_sheets,
)
from facetlog.perception.ragged import Bools, Indices, iter_groups, joined
from facetlog.perception.types import FloatArray

# Further frames are tried for flat surface of more than this share of a body.
FRAME_SHARE = 0.02
MOST_FRAMES = 4
# A box of cells shows at least this share of its surface; one that shows none is no part.
SHOWN = 0.05
# A body that cannot be cut is still a piece, of which no more is known, if it fills so much of its
# hull: a bent leg.
BENT = 0.5
_CORNERS = np.array(list(np.ndindex(2, 2, 2)))


def find_solid_pieces(
    points: FloatArray, triangles: Indices, *, step: float = 0.0, up: FloatArray | None = None
) -> CutPieces:
    """Return the solid pieces of a mesh of points (n, 3), rounded to multiples of `step`, which
    stands on the ground, if it is known where `up` (3,) is.

    False, with the reason, where the mesh is open or encloses nothing.
    """
    given = close_sheets(
        np.asarray(points, dtype=np.float64), np.asarray(triangles, dtype=np.int64), step, up
    )
    if isinstance(given, str):
        return CutPieces(reason=given)
    regions = find_regions(given)
    sheets = fill_hollows(given, regions)
    if sheets is not given:
        regions = find_regions(sheets)
    found = FoundPieces()
    pair_body = sheets.body[sheets.pairs[:, 0]]
    pairs = {int(pair_body[own[0]]): own for own in iter_groups(pair_body)}
    for rows in iter_groups(sheets.body):
        body = int(sheets.body[rows[0]])
        _BodyCut(sheets, regions, rows, pairs[body]).add_to(found)
    add_open_parts(sheets, found)
    return assemble_pieces(sheets, given, found)


@dataclass(eq=False, slots=True)
class _BodyCut:
    """The cutting of a body: its triangles `rows` (m,) and pairs (k,), the pieces found and their
    hulls, and the volume that they explain.
    """

    sheets: Sheets
    regions: Regions
    rows: Indices
    pairs: Indices
    pieces: list[CutPiece] = field(default_factory=list)
    hulls: list[Hull] = field(default_factory=list)
    explained: float = 0.0

    def add_to(self, found: FoundPieces) -> None:
        """Cut the body, and add its pieces to what was found."""
        sheets, rows = self.sheets, self.rows
        body = int(sheets.body[rows[0]])
        whole = float(sheets.volumes[body])
        hull = find_hull(sheets.points[np.unique(sheets.triangles[rows])])
        if hull is None:
            return
        convex = whole >= CONVEX * hull.volume
        if not convex or self.regions.concave[self.pairs].any():
            self._cut_apart()
            self.pieces, self.hulls = join_through(sheets, rows, self.pieces, self.hulls)
        if not self.pieces and (convex or is_turned(sheets, rows, hull)):
            self._add_part(ConvexPart(rows, hull, whole), explains=whole)
        if not self.pieces and whole > BENT * hull.volume:
            self._add_part(ConvexPart(rows, hull, whole), explains=0.0)
        found.pieces += self.pieces
        found.hulls += self.hulls
        found.body += [body] * len(self.pieces)
        found.explained += min(self.explained, whole)
        if self.explained < (1.0 - FRAME_SHARE) * whole:
            found.left.append(self._find_unexplained())
            found.left_volumes.append(whole - self.explained)

    def _add_part(self, part: ConvexPart, *, explains: float) -> None:
        self.pieces.append(make_convex_piece(self.sheets, self.regions, part))
        self.hulls.append(part.hull)
        self.explained += explains

    def _find_unexplained(self) -> FloatArray:
        """Return the box (2, 3) round the triangles that are on no piece, of all if there are
        none.
        """
        corners = self.sheets.corners(self.rows)
        free = np.ones(len(corners), dtype=np.bool_)
        for hull in self.hulls if self.explained else ():
            free &= ~hull.contains(corners.mean(axis=1), PLANE_SLACK * self.sheets.slack)
        own = corners[free if free.any() else slice(None)].reshape(-1, 3) + self.sheets.centre
        return np.stack([own.min(axis=0), own.max(axis=0)])

    def _cut_apart(self) -> None:
        """Cut a body that is not convex."""
        sheets, regions, rows = self.sheets, self.regions, self.rows
        label = regions.label[rows]
        flat = np.unique(label[~regions.curved[label]])
        frame, along = self._find_frame(flat)
        peeled = np.zeros(len(sheets.triangles), dtype=np.bool_)
        parts = [
            part
            for part in find_convex_groups(sheets, regions, rows, self.pairs)
            if (along[regions.label[part.rows]] < 0).any()
        ]
        for part in parts:
            peeled[part.rows] = True
        parts += find_flush_bars(sheets, regions, rows[regions.curved[label] & ~peeled[rows]])
        for part in parts:
            self._add_part(part, explains=part.volume)
        usable = ~peeled[rows] & ~regions.curved[label]
        left = usable.copy()
        for _ in range(MOST_FRAMES):
            if frame is None or not left.any():
                break
            own = usable & (along[label] >= 0)
            self._cut_in_frame(own, frame, along)
            left &= ~own
            if sheets.areas[rows[left]].sum() < FRAME_SHARE * sheets.areas[rows].sum():
                break
            # led by what is left; what was used may lie along it, too: the sides of a sloping back
            frame, along = self._find_frame(flat, np.unique(label[left]))

    def _find_frame(
        self, flat: Indices, leading: Indices | None = None
    ) -> tuple[FloatArray | None, Indices]:
        """Return the frame of flat regions, led by some or by all, and along which of its axes each
        region lies.
        """
        normals, areas = self.regions.normals, self.regions.areas
        lead = np.isin(flat, flat if leading is None else leading)
        frame = find_frame(normals[flat], areas[flat], np.where(lead, areas[flat], 0.0))
        along = np.full(len(normals), -1)
        if frame is not None:
            along[flat] = find_along(frame, normals[flat])
        return frame, along

    def _cut_in_frame(self, level: Bools, frame: FloatArray, along: Indices) -> None:
        """Add the boxes of a body in a frame, along which the triangles `level` (m,) lie; what lies
        in hulls of pieces is taken.
        """
        sheets, rows = self.sheets, self.rows
        slack = PLANE_SLACK * sheets.slack
        corners = sheets.corners(rows) @ frame.T
        places = self._find_places(level, frame, along, corners)
        lattice = make_lattice(frame, places, corners, corners[~level], slack)
        if lattice is None:
            return
        free = lattice.solid & ~lattice.mixed
        middles = lattice.middles[free] @ frame
        taken = np.zeros(len(middles), dtype=np.bool_)
        for hull in self.hulls:
            taken |= hull.contains(middles, 0.0)
        free[free] = ~taken
        parts = find_boxes(lattice, free) if free.any() else None
        if parts is None:
            return
        volumes, owned = lattice.volumes, np.zeros(free.shape, dtype=np.bool_)
        for own in iter_groups(parts.plate):
            boxes = parts.boxes[own]
            if not any(_shows(box, lattice) for box in boxes):
                continue
            filled = 0.0
            for low, high in boxes:
                cells = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
                filled += float(volumes[cells][~owned[cells] & free[cells]].sum())
                owned[cells] = True
            piece, hull = _make_box_piece(sheets, lattice, boxes, filled)
            if piece.extents.min() <= slack:
                continue
            self.explained += filled
            self.pieces.append(piece)
            self.hulls.append(hull)

    def _find_places(
        self, level: Bools, frame: FloatArray, along: Indices, corners: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the places along each axis: of the faces along it, and of where others begin and
        end.

        Others are taken patch by patch, and where a patch meets faces along the frame, seam by
        seam.
        """
        sheets, regions, rows, pairs = self.sheets, self.regions, self.rows, self.pairs
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
    sheets: Sheets, lattice: Lattice, boxes: Indices, volume: float
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
        volume,
    )
    return piece, hull
