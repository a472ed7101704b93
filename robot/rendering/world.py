"""The world of the simulated camera: solids with flat faces on a floor, lit by one sun.

World frame: right-handed, z up, the floor at z = 0; any unit of length.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from facetlog.perception.types import FloatArray
from facetlog.robot.rendering.texture import Sheet, Texture

# A corner may lie off the plane of its face by this share of the solid's size: rounding only.
FLATNESS = 1e-9


@dataclass(frozen=True, eq=False, slots=True)
class Solid:
    """A polyhedron: `vertices` (n, 3), `faces` as loops counter-clockwise from outside.

    `albedo` in [0, 1] and `prints` are per face; `size` holds the three lengths that its maker
    was given (of a wedge or cylinder: of the box round it); faces in `curved` stand for one
    curved surface, and edges between two of them are none. A face may be left out where another
    part of the same solid covers it.
    """

    name: str
    vertices: FloatArray
    faces: tuple[tuple[int, ...], ...]
    albedo: tuple[float, ...]
    size: tuple[float, float, float]
    prints: tuple[Texture | None, ...] = ()
    curved: frozenset[int] = frozenset()

    def __post_init__(self) -> None:
        vertices = np.array(self.vertices, dtype=np.float64).reshape(-1, 3)
        vertices.setflags(write=False)
        object.__setattr__(self, "vertices", vertices)
        if not self.prints:
            object.__setattr__(self, "prints", (None,) * len(self.faces))
        if len(self.albedo) != len(self.faces) or len(self.prints) != len(self.faces):
            raise ValueError(f"{self.name}: one albedo and one print for each face are needed")
        if not all(0 <= a <= 1 for a in self.albedo):
            raise ValueError(f"{self.name}: an albedo is outside [0, 1]")
        directed = [e for face in self.faces for e in _list_sides(face)]
        if len(set(directed)) != len(directed):
            raise ValueError(f"{self.name}: two faces run along an edge in the same direction")
        extent = float(np.ptp(vertices, axis=0).max())
        for face in self.faces:
            corners = vertices[list(face)]
            normal = _compute_newell_normal(corners)
            if np.abs((corners - corners.mean(axis=0)) @ normal).max() > FLATNESS * extent:
                raise ValueError(f"{self.name}: face {face} is not flat")

    def moved(self, rotation: ArrayLike, shift: ArrayLike, scale: float = 1.0) -> "Solid":
        """Return the solid at scale * rotation @ x + shift; rotation (3, 3), shift (3,)."""
        turned = scale * self.vertices @ np.asarray(rotation, dtype=np.float64).T
        return replace(
            self,
            vertices=turned + np.asarray(shift, dtype=np.float64),
            size=(scale * self.size[0], scale * self.size[1], scale * self.size[2]),
            prints=tuple(p and p.scaled(scale) for p in self.prints),
        )

    @property
    def edges(self) -> tuple[tuple[int, int], ...]:
        """Pairs of vertices joined by a true edge, each once, sorted."""
        owners: dict[tuple[int, int], list[int]] = {}
        for index, face in enumerate(self.faces):
            for start, end in _list_sides(face):
                owners.setdefault((min(start, end), max(start, end)), []).append(index)
        return tuple(
            sorted(
                edge
                for edge, faces in owners.items()
                if len(faces) < 2 or not self.curved.issuperset(faces)
            )
        )


@dataclass(frozen=True, slots=True)
class Floor:
    """The plane z = 0, seen from above."""

    albedo: float
    texture: Texture | Sheet | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Facet:
    """A face prepared for ray casting: its frame, and its sides (x0, y0, x1, y1) in that frame.

    `axes` (2, 3) span the plane from `origin`; all of the face lies within [0, reach] along both.
    `surface` is equal for the facets of one curved surface and else different.
    """

    corners: FloatArray
    origin: FloatArray
    axes: FloatArray
    normal: FloatArray
    sides: tuple[tuple[float, float, float, float], ...]
    reach: float
    convex: bool
    albedo: float
    texture: Texture | None
    solid: int
    surface: int


@dataclass(frozen=True, slots=True)
class SolidTruth:
    """The true shape of one solid in the world frame."""

    name: str
    vertices: tuple[tuple[float, float, float], ...]
    edges: tuple[tuple[int, int], ...]
    faces: tuple[tuple[int, ...], ...]
    size: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class GroundTruth:
    """The true shapes of all solids of a world; perception never reads it."""

    solids: tuple[SolidTruth, ...]


@dataclass(frozen=True, eq=False)
class World:
    """Solids, floor and light. `sun` points towards the sun, `background` is a grey in 0..255.

    `ambient` is the share of the light that comes from everywhere; `sided` says how much of that
    share depends on the side a face looks to (a window at right angles to the sun), so that two
    faces in the shade still differ. `exposure` is the grey of a white face in full light, over
    255. The solids are models of things that are `model_scale` times larger.
    """

    solids: tuple[Solid, ...]
    floor: Floor | None
    sun: FloatArray
    background: float = 60.0
    ambient: float = 0.68
    sided: float = 0.12
    exposure: float = 1.12
    name: str = field(default="world")
    model_scale: float = 1.0

    def __post_init__(self) -> None:
        sun = np.array(self.sun, dtype=np.float64).reshape(3)
        if not (np.isfinite(sun).all() and np.linalg.norm(sun) > 0):
            raise ValueError("the direction of the sun must be finite and not zero")
        sun /= np.linalg.norm(sun)
        sun.setflags(write=False)
        object.__setattr__(self, "sun", sun)
        if not (0 <= self.ambient <= 1 and 0 <= self.sided <= 1):
            raise ValueError("ambient and sided are shares in [0, 1]")
        if not self.exposure > 0:
            raise ValueError("the exposure must be positive")
        if not (np.isfinite(self.model_scale) and self.model_scale > 0):
            raise ValueError("the scale of a model must be positive and finite")

    @cached_property
    def facets(self) -> tuple[Facet, ...]:
        """All faces of all solids, prepared for ray casting."""
        facets: list[Facet] = []
        for index, solid in enumerate(self.solids):
            curved_surface = 2 * len(facets)
            for face, corners in enumerate(solid.faces):
                # even for a solid's curved surface, odd for its flat faces
                surface = curved_surface if face in solid.curved else 2 * len(facets) + 1
                facets.append(
                    _make_facet(solid, index, face, solid.vertices[list(corners)], surface)
                )
        return tuple(facets)

    @property
    def truth(self) -> GroundTruth:
        """The true vertices, edges and faces of each solid."""
        return GroundTruth(
            tuple(
                SolidTruth(
                    solid.name,
                    tuple((float(x), float(y), float(z)) for x, y, z in solid.vertices),
                    solid.edges,
                    solid.faces,
                    solid.size,
                )
                for solid in self.solids
            )
        )


def _make_facet(solid: Solid, index: int, face: int, corners: FloatArray, surface: int) -> Facet:
    normal = _compute_newell_normal(corners)
    x_axis = corners[1] - corners[0]
    x_axis /= np.linalg.norm(x_axis)
    axes = np.array([x_axis, np.cross(normal, x_axis)])
    flat = (corners - corners[0]) @ axes.T
    low = flat.min(axis=0)
    outline = flat - low
    along = np.roll(outline, -1, axis=0) - outline
    after = np.roll(along, -1, axis=0)
    sides = np.column_stack([outline, np.roll(outline, -1, axis=0)])
    turns = along[:, 0] * after[:, 1] - along[:, 1] * after[:, 0]
    return Facet(
        corners=corners,
        origin=corners[0] + low @ axes,
        axes=axes,
        normal=normal,
        sides=tuple((x0, y0, x1, y1) for x0, y0, x1, y1 in sides.tolist()),
        reach=float(outline.max()),
        convex=bool((turns > 0).all()),
        albedo=solid.albedo[face],
        texture=solid.prints[face],
        solid=index,
        surface=surface,
    )


def _list_sides(loop: Sequence[int]) -> list[tuple[int, int]]:
    return [(loop[i - 1], loop[i]) for i in range(len(loop))]


def _compute_newell_normal(corners: FloatArray) -> FloatArray:
    """Return unit normal of a loop (n, 3), convex or not, on the side from which it runs ccw."""
    after = np.roll(corners, -1, axis=0)
    total = np.cross(corners - corners[0], after - corners[0]).sum(axis=0)
    length = np.linalg.norm(total)
    if not length > 0:
        raise ValueError("a face without area has no normal")
    return np.asarray(total / length)
