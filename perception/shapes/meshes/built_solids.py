"""Scenes of solids by name, alone or put together: what the examples of models are made of.

A single flat solid is exact. Round solids, and several put together, are measured as a mesh of
theirs would be, each solid a closed body of its own.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from facetlog.perception.ragged import Indices
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.meshes.mesh_scene import make_mesh_scene
from facetlog.perception.surfaces.exact_solids.builders import (
    BUILDERS,
    LEAST_COUNT,
    MOST_COUNT,
    MOST_LENGTH_M,
    build,
)
from facetlog.perception.surfaces.exact_solids.polyhedra import UP
from facetlog.perception.surfaces.face_table import flat_faces
from facetlog.perception.surfaces.mesh_export import triangulate_face
from facetlog.perception.types import FloatArray

__all__ = ["Solid", "build_solids"]

MOST_COPIES = 400
"""Solids of one scene: more faces than these have are too many for facts."""

_AXES = (("x", "along", "columns"), ("y", "across", "rows"), ("z", "over", "levels"))
"""For each axis the place of the lowest corner, the length over which copies are spread evenly, and
how many there are of them (2)."""


@dataclass(frozen=True, slots=True)
class Solid:
    """A builder with its sizes and its place, metres, radians or numbers; see `_AXES`."""

    builder: str
    sizes: Mapping[str, float] = field(default_factory=dict)

    @property
    def is_exact(self) -> bool:
        """Whether it is one flat solid in its own place."""
        return not BUILDERS[self.builder].is_round and not self._placed

    @property
    def _placed(self) -> dict[str, float]:
        names = {name for axis in _AXES for name in axis}
        return {name: size for name, size in self.sizes.items() if name in names}

    def build(self) -> Scene:
        """Build one, with its lowest corner at the origin; raise ValueError as `builders.build`."""
        return build(self.builder, {n: s for n, s in self.sizes.items() if n not in self._placed})

    def find_places(self, extent: FloatArray) -> FloatArray:
        """Return where the lowest corners (n, 3) of solids of some extent (3,) are.

        Raise ValueError for a place that nothing can have.
        """
        placed = self._placed
        along = []
        for (start, over, count), own in zip(_AXES, extent.tolist(), strict=True):
            first, length = placed.get(start, 0.0), placed.get(over)
            number = placed.get(count, 2.0 if length is not None else 1.0)
            if not all(0 <= x <= MOST_LENGTH_M for x in (first, length or 0.0)):
                raise ValueError(
                    f"the place of a {self.builder} is outside of 0 to {MOST_LENGTH_M:g} m"
                )
            if length is None:
                if count in placed:
                    raise ValueError(f"{count} of a {self.builder}: say {over} which length")
                along.append([first])
                continue
            if number != int(number) or not LEAST_COUNT <= number <= MOST_COUNT:
                raise ValueError(
                    f"the {count} of a {self.builder} are {number:g}: give a whole number between "
                    f"{LEAST_COUNT} and {MOST_COUNT}"
                )
            if length < own:
                raise ValueError(f"{over} {length:g} m: a {self.builder} alone takes {own:g} m")
            along.append(np.linspace(first, first + length - own, int(number)).tolist())
        return np.array([*product(*along)])


def build_solids(solids: Sequence[Solid], name: str = "") -> Scene:
    """Return the scene of solids put together; up is z, lengths are metres.

    Raise ValueError, with the way out, for unknown builders or sizes, and for what nothing can be.

    >>> sizes = {"width": 0.1, "depth": 0.1, "height": 0.6}
    >>> legs = Solid("cuboid", {**sizes, "x": 0.2, "y": 0.2, "along": 0.6, "across": 0.6})
    >>> top = Solid("cylinder", {"diameter": 1.0, "height": 0.05, "z": 0.6})
    >>> scene = build_solids([legs, top])
    >>> scene.metric, len(scene.bodies)
    (True, 1)
    """
    built = [solid.build() for solid in solids]
    if len(solids) == 1 and solids[0].is_exact:
        return built[0]
    points: list[FloatArray] = []
    triangles: list[Indices] = []
    count = copies = 0
    for solid, scene in zip(solids, built, strict=True):
        corners, rows = _triangulate(scene, is_closed=BUILDERS[solid.builder].is_solid)
        low, high = corners.min(axis=0), corners.max(axis=0)
        places = solid.find_places(high - low)
        copies += len(places)
        if copies > MOST_COPIES:
            raise ValueError(f"more than {MOST_COPIES} solids: build a part of them")
        for place in places:
            points.append(corners - low + place)
            triangles.append(rows + count)
            count += len(corners)
    title = name or " and ".join(solid.builder for solid in solids)
    mesh = Mesh.of(
        np.concatenate(points), np.concatenate(triangles), name=title, up=UP, unit_metres=1.0
    )
    return make_mesh_scene(mesh, up=UP, metric=True)


def _triangulate(scene: Scene, *, is_closed: bool) -> tuple[FloatArray, Indices]:
    """Return corners (n, 3) and triangles (m, 3) of the faces of an exact scene.

    Where pieces lie against each other it has no face; `is_closed` puts those back.
    """
    points = scene.points
    found = [triangulate_face(face, points) for face in flat_faces(scene)]
    if is_closed:
        for ring in _iter_open_rings(scene):
            fan = [(ring[0], ring[i], ring[i + 1]) for i in range(1, len(ring) - 1)]
            found.append(points[np.array(fan)])
    corners, rows = np.unique(np.concatenate(found).reshape(-1, 3), axis=0, return_inverse=True)
    return corners, rows.reshape(-1, 3)


def _iter_open_rings(scene: Scene) -> Iterator[list[int]]:
    """Yield the rings of vertices round missing faces, anticlockwise from outside."""
    sides = {
        pair
        for face in scene.faces
        for ring in (face.outline, *face.holes)
        for pair in zip(ring, (*ring[1:], ring[0]), strict=True)
    }
    after = {b: a for a, b in sides if (b, a) not in sides}
    while after:
        first, at = after.popitem()
        ring = [first]
        while at != first:
            ring.append(at)
            at = after.pop(at)
        yield ring
