"""Pieces out as a mesh, to look at: glTF with a node per piece, and what nobody saw as a haze."""

from itertools import pairwise

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from facetlog.errors import InputError
from facetlog.perception.pieces.shown_pieces import (
    COLOURS,
    SIDES,
    Piece,
    ShownPiece,
    ShownPieces,
    compute_box_corners,
)
from facetlog.perception.scene import Scene
from facetlog.perception.space.space import Space, State
from facetlog.perception.surfaces.mesh_export import encode_glb
from facetlog.perception.types import FloatArray

OPAQUE, FAINT, HAZE = 235, 70, 28
"""How dense a piece is, the gaps between an implied one's stripes, and unseen space, of 255."""
GREY = (150, 150, 160)
STRIPES = 12  # along an implied piece, every other one faint


def export_pieces(scene: Scene, shown: ShownPieces) -> bytes:
    """Return the pieces of a scene as `.glb`: a node p1, p2, … each, coloured by kind.

    Those of which all faces are implied are striped. Nodes unseen1, … are what is unseen of the
    space round each thing. Raise InputError if there are no pieces.
    """
    if not shown:
        raise InputError(f"{scene.name}: has no pieces, there is no mesh to write")
    graph = trimesh.Scene()
    add_pieces(graph, shown)
    return encode_glb(graph, scene.up)


def add_pieces(graph: trimesh.Scene, shown: ShownPieces) -> None:
    """Add these nodes to a graph in the scene's frame."""
    for each in shown.pieces:
        graph.add_geometry(_box(each), node_name=each.name, geom_name=each.label)
    for number, space in enumerate(shown.spaces, start=1):
        if (space.cells == State.UNSEEN).any():
            graph.add_geometry(_make_haze(space), node_name=f"unseen{number}")


def _box(shown: ShownPiece) -> trimesh.Trimesh:
    count = STRIPES if shown.implied else 1
    colour = COLOURS[shown.piece.kind]
    densities = [OPAQUE if stripe % 2 == 0 else FAINT for stripe in range(count)]
    corners = np.concatenate(list(_split_into_stripes(shown.piece, count)))
    return _mesh(
        corners.reshape(-1, 4, 3), np.repeat([(*colour, density) for density in densities], 6, 0)
    )


def _split_into_stripes(piece: Piece, count: int) -> list[FloatArray]:
    """Return the sides (6, 4, 3) of equal parts of a piece's box, one after the other along it."""
    corners = compute_box_corners(piece)
    # the first four corners are at one end of its length, the others at the other
    near, far = corners[:4], corners[4:]
    ends = [near + share * (far - near) for share in np.linspace(0.0, 1.0, count + 1)]
    return [np.concatenate([one, other])[np.array(SIDES)] for one, other in pairwise(ends)]


def _make_haze(space: Space) -> trimesh.Trimesh:
    """Return the rim of what is unseen, cell by cell."""
    unseen = np.pad(space.cells == State.UNSEEN, 1)
    quads = []
    for axis in range(3):
        for sense in (1, -1):
            rim = np.argwhere(unseen & ~np.roll(unseen, -sense, axis)) - 1
            # the four corners of the side of a cell that looks that way
            across = [k for k in range(3) if k != axis]
            side = np.zeros((4, 3))
            side[:, axis] = (sense + 1) / 2
            side[:, across] = [(0, 0), (1, 0), (1, 1), (0, 1)]
            turned = side if (sense > 0) != (axis != 1) else side[::-1]
            quads.append(rim[:, None] + turned)
    cells = np.concatenate(quads) * space.cell + space.corner
    return _mesh(cells @ space.axes, np.tile((*GREY, HAZE), (len(cells), 1)))


def _mesh(quads: FloatArray, colours: ArrayLike) -> trimesh.Trimesh:
    """Return quadrilaterals (n, 4, 3), counter-clockwise from outside, each of a colour (n, 4)."""
    # glTF has colours at corners: those of two colours are two.
    each = np.repeat(np.asarray(colours, dtype=np.float64), 4, axis=0)
    coloured = np.column_stack([quads.reshape(-1, 3), each])
    corners, rows = np.unique(coloured, axis=0, return_inverse=True)
    one = rows.reshape(-1, 4)
    return trimesh.Trimesh(
        corners[:, :3],
        np.concatenate([one[:, [0, 1, 2]], one[:, [0, 2, 3]]]),
        vertex_colors=corners[:, 3:].astype(np.uint8),
        process=False,
    )
