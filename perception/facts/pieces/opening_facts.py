"""Facts about the openings of things, and about which pieces hang from others."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.facts.levels.filled_space import FilledSpace
from facetlog.perception.facts.scene_memo import Names
from facetlog.perception.flat_faces import FlatFace
from facetlog.perception.pieces.pieces import Piece, Pieces
from facetlog.perception.space.grid import ROUNDING
from facetlog.perception.space.openings import Opening, find_openings, room_for_openings
from facetlog.perception.space.space import Space
from facetlog.perception.types import FloatArray

__all__ = ["hanging", "opening_rows", "openings_known", "openings_of", "rim_rows"]

# A piece frames an opening along this share of its rim at least: it does not just touch a corner.
FRAMES = 0.05
# A face that leans less than this lies across: cos 30°.
ACROSS = 0.866
# An opening lies within a face that leaves it free and reaches round it, or in a piece that is all
# of its rim, but for so much of it.
BESIDE = 0.1

Row = tuple[str, tuple[str | float, ...]]


def openings_of(filled: FilledSpace, up: FloatArray | None) -> tuple[Opening, ...]:
    """The openings of a thing, in the space whose box fits it best."""
    space, on_ground = _where_they_fit(filled, up)
    return find_openings(space, on_ground=on_ground)


def openings_known(filled: FilledSpace, up: FloatArray | None, openings: Sequence[Opening]) -> bool:
    """Whether a thing can have no openings but these, wherever it may stand if up is not known."""
    space, on_ground = _where_they_fit(filled, up)
    stands = None if up is None else on_ground
    return not room_for_openings(space, openings, on_ground=stands)


def _where_they_fit(filled: FilledSpace, up: FloatArray | None) -> tuple[Space, bool]:
    return filled.tipped or filled.space, up is not None and filled.tipped is None


def opening_rows(
    name: str, opening: Opening, filled: FilledSpace, up: FloatArray | None, face_names: Names
) -> Iterator[Row]:
    """Functors and arguments of the facts about one opening; `face_names` (f,) are of all faces."""
    sd = float(np.sqrt(2.0)) * ROUNDING * opening.lattice.cell
    yield "opening", (name,)
    yield "opening_size", (name, *opening.extents, sd)
    if up is not None:
        heights = opening.corners @ up - float(filled.space.corner[2])
        low, high = max(0.0, float(heights.min())), float(heights.max())
        yield "opening_heights", (name, low, high, sd)
    middles = opening.places(np.insert(opening.cells, opening.along, 0, axis=1))
    for face in filled.surface.faces:
        if _is_within(middles, opening.lattice.axes[opening.along], face):
            yield "opening_in", (name, str(face_names[face.index]))


def _is_within(middles: FloatArray, along: FloatArray, face: FlatFace) -> bool:
    """Whether a face lies across an opening, reaches round it, and leaves it free: one of cells
    with these middles (m, 3) through a thing along that direction (3,).
    """
    import shapely

    across = float(along @ face.normal)
    if abs(across) < ACROSS:
        return False
    # seen along the hole
    reach = (face.middle - middles) @ face.normal / across
    flat = face.flatten(middles + reach[:, None] * along)
    low, high = np.array(face.polygon.bounds).reshape(2, 2)
    if float(((flat >= low) & (flat <= high)).all(axis=1).mean()) < 1.0 - BESIDE:
        return False  # most faces: they need not be looked at closely
    points = shapely.points(flat)
    around = float(shapely.covers(shapely.convex_hull(face.polygon), points).mean())
    taken = float(shapely.covers(face.polygon, points).mean())
    return around >= 1.0 - BESIDE and taken <= BESIDE


def rim_rows(name: str, opening: Opening, pieces: Sequence[tuple[str, Piece]]) -> Iterator[Row]:
    """Functors and arguments of what pieces, by their names, are along an opening's rim.

    Each place of the rim is of the nearest piece; all of it may be of one, which has a hole.
    """
    if not pieces:
        return
    places = opening.places(opening.rim)
    away = np.array([_outside(piece, places) for _, piece in pieces])
    shares = np.bincount(away.argmin(axis=0), minlength=len(pieces)) / len(places)
    for (piece, _), share in zip(pieces, shares.tolist(), strict=True):
        if share >= FRAMES:
            yield "frames", (piece, name)
        if share >= 1.0 - BESIDE:
            yield "opening_in", (name, piece)


def _outside(piece: Piece, places: FloatArray) -> FloatArray:
    """How far places (m, 3) lie outside of a piece's box (m,)."""
    half = np.array([piece.length.value, piece.width.value, piece.thickness.value]) / 2.0
    beyond = np.abs((places - piece.middle) @ piece.axes.T) - half
    found: FloatArray = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    return found


def hanging(pieces: Pieces, cell: float) -> NDArray[np.bool_]:
    """Which piece hangs from which (p, p): they touch, the second's middle is higher, and without
    the second nothing joins the first to the ground.
    """
    count = len(pieces.pieces)
    found = np.zeros((count, count), dtype=np.bool_)
    if not count:
        return found
    low = np.array([piece.low for piece in pieces.pieces])
    middle = np.array([piece.low + piece.high for piece in pieces.pieces]) / 2.0
    ground = low < low.min() + cell
    for holder in range(count):
        hung = ~_joined(pieces.joins, ground & (np.arange(count) != holder), holder)
        found[:, holder] = hung & pieces.joins[:, holder] & (middle < middle[holder]) & ~ground
    return found


def _joined(joins: NDArray[np.bool_], first: NDArray[np.bool_], without: int) -> NDArray[np.bool_]:
    """The pieces (p,) that touch the first ones, or others that do, none of them `without`."""
    reached, more = first, True
    while more:
        wider = reached | joins[:, reached].any(axis=1)
        wider[without] = False
        reached, more = wider, bool((wider != reached).any())
    return reached
