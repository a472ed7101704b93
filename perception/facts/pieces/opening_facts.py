"""Facts about openings and hollows of a thing: their sizes, and what lies round them."""

from collections.abc import Iterator, Sequence

import numpy as np

from facetlog.perception.facts.levels.filled_space import FilledSpace
from facetlog.perception.facts.named_rows import Names
from facetlog.perception.flat_faces import FlatFace
from facetlog.perception.pieces.shown_pieces import Piece
from facetlog.perception.space.grid import ROUNDING
from facetlog.perception.space.hollows import Hollow
from facetlog.perception.space.openings import Opening, find_openings, has_room_for_openings
from facetlog.perception.space.space import Space
from facetlog.perception.types import FloatArray

# A piece frames an opening along this share of its rim at least: it does not just touch a corner.
FRAMES = 0.05
# A face that leans less than this lies across: cos 30°.
ACROSS = 0.866
# An opening lies within a face that leaves it free and reaches round it, or in a piece that is all
# of its rim, but for so much of it.
BESIDE = 0.1

Row = tuple[str, tuple[str | float, ...]]


def find_openings_of(filled: FilledSpace, up: FloatArray | None) -> tuple[Opening, ...]:
    """Return the openings of a thing, in the space whose box fits it best."""
    space, on_ground = _choose_opening_space(filled, up)
    return find_openings(space, on_ground=on_ground)


def openings_known(filled: FilledSpace, up: FloatArray | None, openings: Sequence[Opening]) -> bool:
    """Return whether a thing can have no openings but these, wherever it may stand if up is not
    known.
    """
    space, on_ground = _choose_opening_space(filled, up)
    stands = None if up is None else on_ground
    return not has_room_for_openings(space, openings, on_ground=stands)


def _choose_opening_space(filled: FilledSpace, up: FloatArray | None) -> tuple[Space, bool]:
    return filled.tipped or filled.space, up is not None and filled.tipped is None


def iter_opening_facts(
    name: str, opening: Opening, filled: FilledSpace, up: FloatArray | None, face_names: Names
) -> Iterator[Row]:
    """Yield functors and arguments of the facts about one opening; `face_names` (f,) are of all
    faces.
    """
    yield "opening", (name,)
    yield from iter_extents(name, opening, filled, up)
    middles = opening.places(np.insert(opening.cells, opening.along, 0, axis=1))
    for face in filled.surface.faces:
        if _is_within(middles, opening.lattice.axes[opening.along], face):
            yield "opening_in", (name, str(face_names[face.index]))


def iter_hollow_facts(name: str, hollow: Hollow, thing: str) -> Iterator[Row]:
    """Yield functors and arguments of what a hollow has besides its extents."""
    yield "hollow_of", (name, thing)
    sd = float(np.sqrt(2.0)) * ROUNDING * hollow.lattice.cell
    side = "top" if hollow.at_top else "side"
    yield "hollow_mouth", (name, side, hollow.depth, sd, hollow.mouth, hollow.mouth_sd)


def iter_extents(
    name: str, opening: Opening, filled: FilledSpace, up: FloatArray | None
) -> Iterator[Row]:
    """Yield functors and arguments of how large an opening or hollow is, and how high it lies."""
    sd = float(np.sqrt(2.0)) * ROUNDING * opening.lattice.cell
    yield "opening_size", (name, *opening.extents, sd)
    if up is not None:
        heights = opening.corners @ up - float(filled.space.corner[2])
        low, high = max(0.0, float(heights.min())), float(heights.max())
        yield "opening_heights", (name, low, high, sd)


def _is_within(middles: FloatArray, along: FloatArray, face: FlatFace) -> bool:
    """Return whether a face lies across an opening, reaches round it, and leaves it free: one of
    cells with these middles (m, 3) through a thing along that direction (3,).
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


def iter_rim_facts(
    name: str, opening: Opening, pieces: Sequence[tuple[str, Piece]]
) -> Iterator[Row]:
    """Yield functors and arguments of what pieces, by their names, are along an opening's rim.

    Each place of the rim is of the nearest piece; all of it may be of one, which has a hole.
    """
    if not pieces:
        return
    places = opening.places(opening.rim)
    away = np.array([_measure_outside(piece, places) for _, piece in pieces])
    shares = np.bincount(away.argmin(axis=0), minlength=len(pieces)) / len(places)
    for (piece, _), share in zip(pieces, shares.tolist(), strict=True):
        if share >= FRAMES:
            yield "frames", (piece, name)
        if share >= 1.0 - BESIDE:
            yield "opening_in", (name, piece)


def _measure_outside(piece: Piece, places: FloatArray) -> FloatArray:
    """Return how far places (m, 3) lie outside of a piece's box (m,)."""
    half = np.array([piece.length.value, piece.width.value, piece.thickness.value]) / 2.0
    beyond = np.abs((places - piece.middle) @ piece.axes.T) - half
    found: FloatArray = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    return found
