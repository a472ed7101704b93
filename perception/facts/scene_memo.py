"""Lazily computed values of a scene that several kinds of facts are made from."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import chain

import numpy as np

from facetlog.perception.facts import relations
from facetlog.perception.facts.gaps.carried_things import join_carried_things
from facetlog.perception.facts.heights import Grounds, find_vertical_senses, tilts
from facetlog.perception.facts.levels.filled_space import FilledSpace, compute_filled_spaces
from facetlog.perception.facts.measures import Estimates, FaceSizes, Group, face_sizes
from facetlog.perception.facts.named_rows import Names, make_names
from facetlog.perception.facts.plan_view import Plans
from facetlog.perception.facts.relations import FacePairs
from facetlog.perception.ragged import Bools, Indices
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.contacts import (
    SideContacts,
    find_edges_along_sides,
    find_side_contacts,
)
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.floors import find_floor_heights
from facetlog.perception.surfaces.things import Thing, find_things
from facetlog.perception.types import FloatArray


@dataclass(frozen=True, eq=False)
class SceneMemo:
    """A scene and its faces; all else follows from these when first asked for."""

    scene: Scene
    table: FaceTable
    kinds: Collection[str] | None = None
    """The functors that are asked for, None: all."""

    @classmethod
    def of(cls, scene: Scene, kinds: Collection[str] | None = None) -> "SceneMemo":
        """Return the memo of a scene, with nothing in it yet."""
        return cls(scene, FaceTable.of(scene), kinds)

    @cached_property
    def edges(self) -> Indices:
        """The scene's edges (e, 2), and after them the sides that it has no edge for."""
        found = [(edge.start, edge.end) for edge in self.scene.edges]
        known = {(a, b) if a < b else (b, a) for a, b in found}
        missing: dict[tuple[int, int], tuple[int, int]] = {}
        for a, b in self.table.sides.ends.tolist():
            key = (a, b) if a < b else (b, a)
            if key not in known:
                missing[key] = (a, b)
        return np.array([*found, *missing.values()], dtype=np.intp).reshape(-1, 2)

    @cached_property
    def listed(self) -> Bools:
        """Which edges (e,) the scene lists itself."""
        return np.arange(len(self.edges)) < len(self.scene.edges)

    @cached_property
    def bounds(self) -> Indices:
        """An edge and a face (b, 2) each, wherever the edge bounds the face."""
        return find_edges_along_sides(self.table, self.edges)

    @cached_property
    def contacts(self) -> SideContacts:
        """Where sides of faces run along each other."""
        return find_side_contacts(self.table)

    @cached_property
    def things(self) -> tuple[Thing, ...]:
        """The scene's things, in the order of their names."""
        loose = self.listed.copy()
        loose[self.bounds[:, 0]] = False
        found = find_things(
            self.scene, self.table, self.contacts, self.edges, np.flatnonzero(loose)
        )
        return join_carried_things(self.scene, self.table, self.edges, found)

    @cached_property
    def thing_faces(self) -> tuple[Indices, Indices]:
        """(thing, face) (g,) each, thing by thing."""
        return _listed([thing.faces for thing in self.things])

    @cached_property
    def thing_edges(self) -> tuple[Indices, Indices]:
        """(thing, loose edge) (l,) each, thing by thing."""
        return _listed([thing.edges for thing in self.things])

    @cached_property
    def thing_vertices(self) -> tuple[Indices, Indices]:
        """(thing, vertex) (m,) each, by the things, all their vertices, ascending."""
        hulls = [
            tuple(i for patch in thing.patches for i in self.scene.patches[patch].hull)
            for thing in self.things
        ]
        owner, face = self.thing_faces
        place, of_faces = self.table.find_member_rows(face)
        of_edges, edge = self.thing_edges
        of_hulls, in_hulls = _listed(hulls)
        thing = np.concatenate((owner[place], np.repeat(of_edges, 2), of_hulls))
        vertex = np.concatenate((of_faces, self.edges[edge].ravel(), in_hulls))
        count = max(len(self.table.points), 1)
        found = np.unique(thing * count + vertex)
        return found // count, found % count

    @cached_property
    def members(self) -> tuple[Indices, ...]:
        """All vertices of each thing, ascending."""
        thing, vertex = self.thing_vertices
        cuts = np.searchsorted(thing, np.arange(1, len(self.things)))
        return tuple(np.split(vertex, cuts)) if self.things else ()

    @cached_property
    def groups(self) -> tuple[Group, ...]:
        """The things that have faces, with what their silhouettes are made from."""
        return tuple(
            Group.of(thing.faces, members, self.table.points)
            for thing, members in zip(self.things, self.members, strict=True)
            if thing.faces
        )

    @cached_property
    def face_sizes(self) -> FaceSizes:
        """How large all faces are."""
        return face_sizes(self.table)

    @cached_property
    def pairs(self) -> FacePairs:
        """Every two faces of the scene."""
        return FacePairs.of(self.table)

    @cached_property
    def angles(self) -> tuple[FloatArray, FloatArray]:
        """Angles (p,) between the normals of pairs of faces and their 1σ, radians."""
        return relations.angles(self.table, self.pairs)

    @cached_property
    def offsets(self) -> tuple[FloatArray, FloatArray]:
        """Distances (p,) of the middles of faces from the planes of others, and their 1σ."""
        return relations.offsets(self.table, self.pairs)

    @cached_property
    def up(self) -> FloatArray:
        """Up in the scene (3,), zero where it is not known."""
        return np.zeros(3) if self.scene.up is None else self.scene.up

    @cached_property
    def floors(self) -> FloatArray:
        """The height (t,) of the ground that views show beneath each thing; infinite without."""
        owners = np.full(len(self.table), -1)
        thing, face = self.thing_faces
        owners[face] = thing
        return find_floor_heights(self.scene, self.table, owners, self.members)

    @cached_property
    def grounds(self) -> Grounds | None:
        """The lowest places of the things, if there is anything and up is known."""
        if self.scene.up is None or not len(self.thing_vertices[0]) or not len(self.table):
            return None
        return Grounds.under(self.thing_vertices, self.table, self.scene.up, self.floors)

    @cached_property
    def plans(self) -> Plans | None:
        """The faces as seen from above; None where up is not known, or all are upright."""
        return None if self.scene.up is None else Plans.of(self.table, self.scene.up)

    @cached_property
    def leaning(self) -> Estimates:
        """Angles (f,) between the faces and the level, where up is known."""
        return tilts(self.table.planes, self.up)

    @cached_property
    def senses(self) -> Indices:
        """1 (f,) for faces that look up, -1 for those that look down, else 0, where up is known."""
        return find_vertical_senses(self.table.planes, self.up, self.leaning)

    @cached_property
    def filled(self) -> dict[int, FilledSpace]:
        """The filled space of each thing, by its index."""
        return compute_filled_spaces(
            self.scene, self.table, self.edges, self.things, self.members, self.floors, self.kinds
        )

    @cached_property
    def face_names(self) -> Names:
        """Names (f,) of the faces."""
        return make_names("f", len(self.table))

    @cached_property
    def vertex_names(self) -> Names:
        """Names (n,) of the vertices."""
        return make_names("v", len(self.scene.vertices))

    @cached_property
    def edge_names(self) -> Names:
        """Names (e,) of the edges."""
        return make_names("e", len(self.edges))

    @cached_property
    def thing_names(self) -> Names:
        """Names (t,) of the things."""
        return make_names("t", len(self.things))


def _listed(rows: Iterable[tuple[int, ...]]) -> tuple[Indices, Indices]:
    """Return the row of each entry, and the entry."""
    kept = tuple(rows)
    owner = np.repeat(np.arange(len(kept)), [len(row) for row in kept])
    return owner, np.fromiter(chain.from_iterable(kept), np.intp, len(owner))
