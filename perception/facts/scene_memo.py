"""What several kinds of facts are made from, worked out once for a scene, and only if asked for."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from facetlog.perception.facts import relations
from facetlog.perception.facts.angles import pairwise_angles
from facetlog.perception.facts.heights import Grounds, tilts, vertical_senses
from facetlog.perception.facts.measures import Estimates, Group
from facetlog.perception.facts.plan_view import Plans
from facetlog.perception.row_table import Indices
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.contacts import SideContacts, edges_along_sides, side_contacts
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.things import Thing, find_things
from facetlog.perception.types import FloatArray

__all__ = ["SceneMemo"]


@dataclass(frozen=True, eq=False)
class SceneMemo:
    """A scene and its faces; all else follows from these when it is first asked for."""

    scene: Scene
    table: FaceTable

    @classmethod
    def of(cls, scene: Scene) -> "SceneMemo":
        """The memo of a scene, with nothing in it yet."""
        return cls(scene, FaceTable.of(scene))

    @cached_property
    def edges(self) -> Indices:
        """The scene's edges (e, 2) and, after these, sides that it has no edge for."""
        listed = [(edge.start, edge.end) for edge in self.scene.edges]
        known = {frozenset(pair) for pair in listed}
        missing = {
            key: (start, end)
            for start, end in self.table.sides.ends.tolist()
            if (key := frozenset((start, end))) not in known
        }
        return np.array([*listed, *missing.values()], dtype=np.intp).reshape(-1, 2)

    @cached_property
    def bounds(self) -> Indices:
        """An edge and a face (b, 2) each, wherever the edge bounds the face."""
        return edges_along_sides(self.table, self.edges)

    @cached_property
    def contacts(self) -> SideContacts:
        """Where sides of faces run along each other."""
        return side_contacts(self.table)

    @cached_property
    def things(self) -> tuple[Thing, ...]:
        """The scene's things, in the order of their names."""
        bounding = set(self.bounds[:, 0].tolist())
        loose = tuple(i for i in range(len(self.scene.edges)) if i not in bounding)
        return find_things(self.scene, self.table, self.contacts, loose)

    @cached_property
    def members(self) -> tuple[Indices, ...]:
        """All vertices of each thing, ascending."""
        patches = self.scene.patches
        return tuple(
            np.unique(
                np.concatenate(
                    (
                        self.table.rows_of(thing.faces)[1],
                        self.edges[list(thing.edges)].ravel(),
                        *(np.array(patches[i].hull, dtype=np.intp) for i in thing.patches),
                    )
                )
            )
            for thing in self.things
        )

    @cached_property
    def groups(self) -> tuple[Group, ...]:
        """The things that have faces, with what their silhouettes are made from."""
        return tuple(
            Group.of(thing.faces, members, self.table.points)
            for thing, members in zip(self.things, self.members, strict=True)
            if thing.faces
        )

    @cached_property
    def angles(self) -> tuple[FloatArray, FloatArray]:
        """Angles (f, f) between the faces' normals and their 1σ, radians."""
        return pairwise_angles([face.plane for face in self.scene.faces])

    @cached_property
    def offsets(self) -> tuple[FloatArray, FloatArray]:
        """Distances [i, j] of the middle of face i from the plane of face j, and their 1σ."""
        return relations.offsets(self.table)

    @cached_property
    def grounds(self) -> Grounds | None:
        """The lowest places of the things, if up is known and there is anything."""
        up = self.scene.up
        if up is None or not self.things or not len(self.table):
            return None
        return Grounds.under(self.members, self.table, up)

    @cached_property
    def plans(self) -> Plans | None:
        """The faces as seen from above, if up is known and there is any."""
        up = self.scene.up
        return None if up is None or not len(self.table) else Plans.of(self.table, up)

    @cached_property
    def leaning(self) -> Estimates:
        """Angles (f,) between the faces and the level, where up is known."""
        return tilts(self.table.planes, self._up)

    @cached_property
    def senses(self) -> Indices:
        """1 (f,) for faces that look up, -1 for those that look down, else 0; up is known."""
        return vertical_senses(self.table.planes, self._up, self.leaning)

    @property
    def _up(self) -> FloatArray:
        if self.scene.up is None:
            raise ValueError("up is not known")
        return self.scene.up
