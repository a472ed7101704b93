"""Boxes as people have them in meshes: what is a box by rules/box.model, told in many ways.

A box is closed and solid, with three pairs of parallel faces, and its least side is at least 8 % of
its longest. Each maker takes a generator of random numbers and gives a mesh, with z upwards.
"""

from collections.abc import Callable, Mapping

import numpy as np
import shapely
import trimesh

from benchmarks.shapes.own_solids import block, extruded, joined, make_rounded_block, moved, tapered
from facetlog.perception.types import FloatArray

LEAST_SIDE = 0.12
"""Of the longest side: thinner is a board (rules/box.model)."""
# What lies on a face, or in it, is this share of the shortest side at most: it is no part of the
# block's form.
DETAIL = 0.03
ORIGIN = (0.0, 0.0, 0.0)

Maker = Callable[[np.random.Generator], trimesh.Trimesh]


def _size(rng: np.random.Generator, least: float = 0.25, most: float = 1.0) -> FloatArray:
    """Return sides in any order, the longest about 1, none below `least` of it."""
    return rng.permutation([1.0, *rng.uniform(least, most, 2)])


def _plain(rng: np.random.Generator) -> trimesh.Trimesh:
    return block(ORIGIN, _size(rng))


def _cube(rng: np.random.Generator) -> trimesh.Trimesh:
    return block(ORIGIN, np.full(3, rng.uniform(0.5, 2.0)))


def _cereal(rng: np.random.Generator) -> trimesh.Trimesh:
    """Return a thin upright carton."""
    return block(ORIGIN, [rng.uniform(0.6, 0.8), rng.uniform(0.14, 0.25), 1.0])


def _flat(rng: np.random.Generator) -> trimesh.Trimesh:
    return block(ORIGIN, [1.0, rng.uniform(0.6, 1.0), rng.uniform(LEAST_SIDE, 0.2)])


def _beam(rng: np.random.Generator) -> trimesh.Trimesh:
    side = rng.uniform(LEAST_SIDE, 0.25)
    return block(ORIGIN, rng.permutation([1.0, side, side]))


def _rounded(rng: np.random.Generator) -> trimesh.Trimesh:
    size = _size(rng, 0.4)
    return make_rounded_block(size, rng.uniform(0.02, 0.05) * size.min())


def _chamfered(rng: np.random.Generator) -> trimesh.Trimesh:
    size = _size(rng, 0.4)
    return tapered(size, rng.uniform(0.02, 0.05) * size.min())


def _fine(rng: np.random.Generator) -> trimesh.Trimesh:
    mesh = _plain(rng)
    for _ in range(4):
        mesh = mesh.subdivide()
    return mesh


def _doubled(rng: np.random.Generator) -> trimesh.Trimesh:
    """Return every face twice, the second time looking inwards."""
    mesh = _plain(rng)
    inwards = trimesh.Trimesh(mesh.vertices, mesh.faces[:, ::-1], process=False)
    return joined(mesh, inwards)


def _inside_out(rng: np.random.Generator) -> trimesh.Trimesh:
    mesh = _plain(rng)
    return trimesh.Trimesh(mesh.vertices, mesh.faces[:, ::-1], process=False)


def _in_millimetres(rng: np.random.Generator) -> trimesh.Trimesh:
    return block(ORIGIN, 1000.0 * _size(rng))


def _skewed(rng: np.random.Generator) -> trimesh.Trimesh:
    """Return it leaning by 2 degrees, as a carton that was sat upon."""
    mesh = _plain(rng)
    lean = np.tan(np.deg2rad(2.0)) * mesh.vertices[:, [2]] * [[1.0, 0.0, 0.0]]
    return trimesh.Trimesh(mesh.vertices + lean, mesh.faces, process=False)


def _with_lid_line(rng: np.random.Generator) -> trimesh.Trimesh:
    """Return a groove all round below the lid."""
    size = _size(rng, 0.5)
    depth = 0.5 * DETAIL * float(size.min())
    low, high = rng.uniform(0.7, 0.9) * size[2], size[2]
    groove = low + depth
    inner = block([depth, depth, low], [size[0] - depth, size[1] - depth, groove])
    return joined(
        block(ORIGIN, [size[0], size[1], low]), inner, block([0.0, 0.0, groove], [*size[:2], high])
    )


def _with_tape(rng: np.random.Generator) -> trimesh.Trimesh:
    """Return a strip of tape along the top and down both ends."""
    size = _size(rng, 0.5)
    thick, half = 0.2 * DETAIL * float(size.min()), 0.06 * size[1]
    low, high = size[1] / 2 - half, size[1] / 2 + half
    down = 0.7 * size[2]
    return joined(
        block(ORIGIN, size),
        block([-thick, low, size[2]], [size[0] + thick, high, size[2] + thick]),
        block([-thick, low, down], [0.0, high, size[2]]),
        block([size[0], low, down], [size[0] + thick, high, size[2]]),
    )


def _recessed(rng: np.random.Generator) -> trimesh.Trimesh:
    """Return the top a little below its rim, as of a crate with a lid let in."""
    size = _size(rng, 0.5)
    depth, rim = DETAIL * float(size.min()), 0.06 * float(size[:2].min())
    plan = shapely.box(0.0, 0.0, *size[:2])
    frame = plan.difference(shapely.box(rim, rim, size[0] - rim, size[1] - rim))
    base = block(ORIGIN, [*size[:2], size[2] - depth])
    return joined(base, extruded(frame, size[2] - depth, size[2]))


def _tipped(rng: np.random.Generator) -> trimesh.Trimesh:
    """Return it turned any way round, as something thrown into a corner."""
    mesh = _plain(rng)
    turn = trimesh.transformations.random_rotation_matrix(rng.uniform(size=3))
    return mesh.apply_transform(turn)


def _soup(rng: np.random.Generator) -> trimesh.Trimesh:
    """Return triangles that share no corner."""
    mesh = _plain(rng).subdivide()
    corners = mesh.vertices[mesh.faces].reshape(-1, 3)
    return trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)


def _hollow(rng: np.random.Generator) -> trimesh.Trimesh:
    """Return a closed carton with walls of some thickness: the inner side is there as well."""
    size = _size(rng, 0.4)
    wall = rng.uniform(0.02, 0.05) * float(size.min())
    inner = block([wall] * 3, size - wall)
    return joined(block(ORIGIN, size), trimesh.Trimesh(inner.vertices, inner.faces[:, ::-1]))


def _of_boards(rng: np.random.Generator) -> trimesh.Trimesh:
    """Return six boards nailed together, each a cuboid of its own."""
    x, y, z = _size(rng, 0.4)
    wall = 0.04 * min(x, y, z)
    return joined(
        block(ORIGIN, [x, y, wall]),
        block([0.0, 0.0, z - wall], [x, y, z]),
        block([0.0, 0.0, wall], [wall, y, z - wall]),
        block([x - wall, 0.0, wall], [x, y, z - wall]),
        block([wall, 0.0, wall], [x - wall, wall, z - wall]),
        block([wall, y - wall, wall], [x - wall, y, z - wall]),
    )


def _far_away(rng: np.random.Generator) -> trimesh.Trimesh:
    """Return it at coordinates as of a map's."""
    return moved(_plain(rng), (rng.uniform(-1.0, 1.0, 3) * 1e4).tolist())


BOXES: Mapping[str, Maker] = {
    "plain box": _plain,
    "cube": _cube,
    "cereal box": _cereal,
    "flat box": _flat,
    "beam": _beam,
    "rounded box": _rounded,
    "chamfered box": _chamfered,
    "finely meshed box": _fine,
    "box with doubled faces": _doubled,
    "box inside out": _inside_out,
    "box in millimetres": _in_millimetres,
    "skewed box": _skewed,
    "box with a lid line": _with_lid_line,
    "box with tape": _with_tape,
    "box with a recessed top": _recessed,
    "tipped box": _tipped,
    "box of loose triangles": _soup,
    "hollow closed box": _hollow,
    "box of boards": _of_boards,
    "box far away": _far_away,
}
