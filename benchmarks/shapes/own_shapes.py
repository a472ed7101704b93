"""Two hundred shapes of our own, by seed, with their right answers: 80 boxes and what is none.

Fifty kinds in turn. Each has its own sizes, is turned about up and put anywhere; every second one
stands in a frame that is turned in any way, its up along with it.
"""

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray

from benchmarks.shapes.own_boxes import BOXES, Maker
from benchmarks.shapes.own_furniture import CHAIRS, NONE_OF_THESE, TABLES
from facetlog.perception.types import FloatArray

OWN_SHAPES = 200
REACH = 3.0  # of the shape's size: how far from the origin it is put

KINDS: tuple[tuple[str, str, Maker], ...] = (
    *((name, "box", maker) for name, maker in BOXES.items()),
    *((name, "table", maker) for name, maker in TABLES.items()),
    *((name, "chair", maker) for name, maker in CHAIRS.items()),
    *((name.replace("_", " "), name, maker) for name, maker in NONE_OF_THESE.items()),
)
"""Names of what there is, the labels that say what is right, and the makers."""


@dataclass(frozen=True, eq=False, slots=True)
class OwnShape:
    """Triangles (m, 3) of indices into vertices (n, 3), with what it is and its up (3,)."""

    name: str
    label: str
    vertices: FloatArray
    triangles: NDArray[np.int64]
    up: FloatArray


def make_own_shape(seed: int) -> OwnShape:
    """Return the shape of a seed, the same on every machine."""
    name, label, maker = KINDS[seed % len(KINDS)]
    generator = np.random.default_rng(seed)
    mesh = maker(generator)
    size = float(np.linalg.norm(mesh.extents))
    turn = trimesh.transformations.rotation_matrix(generator.uniform(0.0, 2 * np.pi), [0, 0, 1])
    if (seed // len(KINDS)) % 2:
        every_way = generator.uniform(size=3)
        turn = trimesh.transformations.random_rotation_matrix(every_way) @ turn
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    about = vertices.mean(axis=0)
    shift = generator.uniform(-REACH, REACH, 3) * size + about
    vertices = (vertices - about) @ turn[:3, :3].T + shift
    return OwnShape(name, label, vertices, np.asarray(mesh.faces), turn[:3, 2])
