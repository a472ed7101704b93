"""The solid pieces that a closed surface is cut into, as parts of a scene's bodies."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from facetlog.perception.flat_faces import FlatFace
from facetlog.perception.pieces.exact.convex_parts import find_hull
from facetlog.perception.pieces.exact.cut_pieces import CutPieces
from facetlog.perception.pieces.exact.find_pieces import find_solid_pieces
from facetlog.perception.ragged import Bools, Indices, sum_by_group
from facetlog.perception.scene import Scene, SolidPiece, Solids
from facetlog.perception.space.surface_points import inner_points
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.mesh_export import triangulate_face
from facetlog.perception.types import FloatArray

# The surface is looked at in places so far apart, as a share of the scene's diagonal.
SPACING_SHARE = 1.0 / 64.0
# A place is on a piece if it is no farther outside its hull than this share of the diagonal: what
# the fit of a face leaves, and the samples of what is curved.
NEAR_SHARE = 1.0 / 512.0
# Pieces have all of a body's surface but for this share: edges that were rounded.
UNOWNED = 0.05
# Planes of hulls times places that are compared, some tenth of a second; a hull of more planes is
# coarsened, which takes so many times what is near from it.
MOST_COMPARED = 5_000_000
COARSE = 4.0
# A body shows more than this share of the surface of each of its pieces: not just a leg's end on a
# floor.
SHOWN = 0.02
# Cells show more of a body of which more than this share of the surface is open.
OPEN_SHARE = 0.1
# So they do where pieces explain less than this share.
LEAST = 0.5


def cut_faces(faces: Sequence[FlatFace], points: FloatArray) -> Solids | None:
    """Return the pieces of what flat faces enclose, if they do; `points` (n, 3) are the scene's
    vertices.
    """
    filled = [triangulate_face(face, points) for face in faces]
    corners = np.concatenate([np.zeros((0, 3, 3)), *filled])
    found = find_solid_pieces(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    if not found:
        return None
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    places, face = inner_points(faces, SPACING_SHARE * size)
    index = np.array([each.index for each in faces])
    shares = np.bincount(face, minlength=len(faces))[face]
    areas = np.array([each.area for each in faces])[face] / shares
    on, _ = _find_on_pieces(found, places, NEAR_SHARE * size)
    owner = np.full(int(index.max()) + 1, -1)
    owner[index] = _choose_owners(_sum_areas(on, face, areas, len(faces)))
    rows = np.arange(len(found.pieces))
    return _make_solids(found, rows, owner, found.explained, found.unexplained)


def add_solids(scene: Scene, found: CutPieces) -> Scene:
    """Return the scene with the pieces of its bodies; a body of which some surface is open, or
    little is in pieces, gets none, but how much of it they would explain.
    """
    if not found or not scene.bodies:
        return scene
    size = float(np.linalg.norm(np.ptp(scene.points, axis=0)))
    points, face, body, areas = _sample_surface(scene, SPACING_SHARE * size)
    on, surface = _find_on_pieces(found, points, NEAR_SHARE * size)
    votes = _sum_areas(on, body, areas, len(scene.bodies))
    body_of = votes.argmax(axis=1)
    owner = _choose_owners(_sum_areas(on, face, areas, len(scene.faces)))
    low, high = found.unexplained[:, :1] - NEAR_SHARE * size, found.unexplained[:, 1:]
    beside = np.asarray(((low <= points) & (points <= high + NEAR_SHARE * size)).all(axis=2))
    is_open = beside[found.left <= 0.0].any(axis=0)
    left_of = _sum_areas(beside, body, areas, len(scene.bodies)).argmax(axis=1)
    bodies = []
    for number, each in enumerate(scene.bodies):
        rows = np.flatnonzero((body_of == number) & (votes.max(axis=1) > SHOWN * surface))
        own = body == number
        covered = float(areas[own & on[rows].any(axis=0)].sum())
        owned = covered / max(float(areas[own].sum()), 1e-300)
        volume = sum(found.pieces[row].volume for row in rows.tolist())
        bare = float(areas[own & ~on[rows].any(axis=0) & is_open].sum())
        lost = float(found.left[left_of == number].sum())
        explained = volume / max(volume + lost, 1e-300)
        explained *= owned if owned < 1.0 - UNOWNED else 1.0
        if explained < LEAST or bare > OPEN_SHARE * float(areas[own].sum()):
            rows = rows[:0]
        gaps = found.unexplained[left_of == number]
        bodies.append(replace(each, solids=_make_solids(found, rows, owner, explained, gaps)))
    return replace(scene, bodies=tuple(bodies))


def _find_on_pieces(found: CutPieces, points: FloatArray, near: float) -> tuple[Bools, FloatArray]:
    """Return which points (n, 3) are on or in which pieces (p, n), and the pieces' surface (p,)."""
    on = np.zeros((len(found.pieces), len(points)), dtype=np.bool_)
    surface = np.full(len(found.pieces), np.inf)
    for number, piece in enumerate(found.pieces):
        hull = find_hull(piece.hull)
        if hull is not None:
            many = len(hull.planes) * len(points) > MOST_COMPARED
            on[number] = (hull.coarsen() if many else hull).contains(
                points, near * COARSE if many else near
            )
            surface[number] = hull.area
    return on, surface


def _sum_areas(on: Bools, of: Indices, areas: FloatArray, count: int) -> FloatArray:
    """Return the areas (p, count) that pieces have of each group; places (n,) are of group `of`, -1
    for none, and `on` (p, n) says which are on a piece.
    """
    counted = on & (of >= 0)
    sums = [sum_by_group(of[own], areas[own], count) for own in counted]
    return np.array(sums).reshape(len(on), count)


def _choose_owners(shares: FloatArray) -> Indices:
    """Return the piece with the greatest share (p, g) of each group, -1 where none has any."""
    return np.where(shares.any(axis=0), shares.argmax(axis=0), -1)


def _make_solids(
    found: CutPieces, rows: Indices, owner: Indices, explained: float, gaps: FloatArray
) -> Solids:
    """Return the pieces with these numbers; `owner` (f,) is the number of each face's piece."""
    pieces = tuple(
        SolidPiece(
            cut.hull,
            cut.axes,
            cut.round,
            tuple(np.flatnonzero(owner == row).tolist()),
        )
        for row, cut in ((row, found.pieces[row]) for row in rows.tolist())
    )
    place = {row: i for i, row in enumerate(rows.tolist())}
    joins = tuple(
        (place[one], place[other])
        for one, other in found.contacts
        if one in place and other in place
    )
    boxes = tuple((*low, *high) for low, high in gaps.tolist())
    return Solids(pieces, joins, min(1.0, explained), boxes)


def _sample_surface(
    scene: Scene, spacing: float
) -> tuple[FloatArray, Indices, Indices, FloatArray]:
    """Return places (n, 3) all over the surface, their faces and bodies (n,), -1 for none, and the
    area (n,) that each stands for.
    """
    table = FaceTable.of(scene)
    points, face = inner_points(table.faces, spacing)
    counts = np.bincount(face, minlength=len(scene.faces))
    areas = (table.areas / np.maximum(counts, 1))[face]
    body_of_face = np.full(len(scene.faces), -1, dtype=np.intp)
    body_of_patch = np.full(len(scene.patches), -1, dtype=np.intp)
    for number, body in enumerate(scene.bodies):
        body_of_face[list(body.faces)] = number
        body_of_patch[list(body.patches)] = number
    patches = scene.patches
    lengths = [len(patch.points) for patch in patches]
    return (
        np.concatenate([points, *(patch.points for patch in patches)]),
        np.concatenate([face, np.full(sum(lengths), -1)]).astype(np.intp),
        np.concatenate([body_of_face[face], np.repeat(body_of_patch, lengths)]).astype(np.intp),
        np.concatenate([areas, *(patch.areas for patch in patches)]),
    )
