"""Lazily computed values of scenes that several kinds of facts are made from."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.facts import relations
from facetlog.perception.facts.gaps.carried_things import join_carried_things
from facetlog.perception.facts.heights import Grounds, find_vertical_senses, tilts
from facetlog.perception.facts.levels.filled_space import FilledSpace, compute_filled_spaces
from facetlog.perception.facts.measures import Estimates, FaceSizes, Group, face_sizes
from facetlog.perception.facts.named_rows import make_names_in_order
from facetlog.perception.facts.plan_view import Plans
from facetlog.perception.facts.relations import FacePairs
from facetlog.perception.ragged import Bools, Indices, find_row_starts
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

Names = NDArray[np.object_]


@dataclass(frozen=True, eq=False)
class SceneMemo:
    """The scenes of a block and their faces; all else follows from these when first asked for.

    Vertices, edges, faces and things stand scene by scene, and are numbered through; each has the
    name that it has in its own scene.
    """

    scenes: tuple[Scene, ...]
    table: FaceTable

    @classmethod
    def of(cls, *scenes: Scene) -> "SceneMemo":
        """Return the memo of some scenes, with nothing in it yet."""
        return cls(scenes, FaceTable.of(*scenes))

    def alone(self, which: Bools) -> Iterator[tuple[int, "SceneMemo"]]:
        """Yield places and memos of some of the scenes (s,), each alone: for facts that
        take long.
        """
        for nth in np.flatnonzero(which).tolist():
            yield nth, self if len(self.scenes) == 1 else SceneMemo.of(self.scenes[nth])

    @cached_property
    def _edges(self) -> tuple[Indices, Indices]:
        """Edges (e, 2), of each scene its own and then the sides it has none for; how many (s,)."""
        sides = np.split(self.table.sides.ends, np.cumsum(self.table.side_counts)[:-1])
        found: list[tuple[int, int]] = []
        counts: list[int] = []
        firsts = find_row_starts(self.table.vertex_counts).tolist()
        for scene, own, first in zip(self.scenes, sides, firsts, strict=True):
            listed = [(first + edge.start, first + edge.end) for edge in scene.edges]
            known = {(a, b) if a < b else (b, a) for a, b in listed}
            missing: dict[tuple[int, int], tuple[int, int]] = {}
            for a, b in own.tolist():
                key = (a, b) if a < b else (b, a)
                if key not in known:
                    missing[key] = (a, b)
            found += listed
            found += missing.values()
            counts.append(len(listed) + len(missing))
        return np.array(found, dtype=np.intp).reshape(-1, 2), np.array(counts, dtype=np.intp)

    @property
    def edges(self) -> Indices:
        """The scenes' edges (e, 2) and, after those of each, sides that it has no edge for."""
        return self._edges[0]

    @property
    def edge_counts(self) -> Indices:
        """How many edges each scene has (s,)."""
        return self._edges[1]

    @cached_property
    def edge_scene(self) -> Indices:
        """The scene (e,) of each edge."""
        return np.repeat(np.arange(len(self.scenes)), self.edge_counts)

    @cached_property
    def listed(self) -> Bools:
        """Which edges (e,) the scenes list themselves."""
        place = np.arange(len(self.edges)) - find_row_starts(self.edge_counts)[self.edge_scene]
        own = np.array([len(scene.edges) for scene in self.scenes], dtype=np.intp)
        return place < own[self.edge_scene]

    @cached_property
    def bounds(self) -> Indices:
        """An edge and a face (b, 2) each, wherever the edge bounds the face."""
        return find_edges_along_sides(self.table, self.edges, self.edge_counts)

    @cached_property
    def contacts(self) -> SideContacts:
        """Where sides of faces run along each other."""
        return find_side_contacts(self.table)

    @cached_property
    def things(self) -> tuple[Thing, ...]:
        """The scenes' things, in the order of their names."""
        loose = self.listed.copy()
        loose[self.bounds[:, 0]] = False
        found = find_things(
            self.scenes, self.table, self.contacts, self._edges, np.flatnonzero(loose)
        )
        grounded = [bool(scene.seen_ground) for scene in self.scenes]
        if not any(grounded):
            return found
        if len(self.scenes) == 1:
            return join_carried_things(self.scenes[0], self.table, self.edges, found)
        faces, edges = find_row_starts(self.table.face_counts), find_row_starts(self.edge_counts)
        return tuple(
            _moved(thing, int(faces[nth]), int(edges[nth]), nth)
            for nth, own in self.alone(np.ones(len(self.scenes), dtype=np.bool_))
            for thing in own.things
        )

    @cached_property
    def thing_scene(self) -> Indices:
        """The scene (t,) of each thing."""
        return np.array([thing.scene for thing in self.things], dtype=np.intp)

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
        first = find_row_starts(self.table.vertex_counts)
        hulls = [
            tuple(
                int(first[thing.scene]) + i
                for patch in thing.patches
                for i in self.scenes[thing.scene].patches[patch].hull
            )
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
        """Every two faces of a scene."""
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
    def upright(self) -> Bools:
        """Whether up is known of each scene (s,)."""
        return np.array([scene.up is not None for scene in self.scenes])

    @cached_property
    def ups(self) -> FloatArray:
        """Up in each scene (s, 3), zero where it is not known."""
        return np.array([np.zeros(3) if s.up is None else s.up for s in self.scenes])

    @cached_property
    def floors(self) -> FloatArray:
        """The height (t,) of the ground that views show beneath each thing; infinite without."""
        owners = np.full(len(self.table), -1)
        thing, face = self.thing_faces
        owners[face] = thing
        return find_floor_heights(self.scenes, self.table, owners, self.members, self.thing_scene)

    @cached_property
    def grounds(self) -> Grounds | None:
        """The lowest places of the things, if there is anything."""
        if not len(self.thing_vertices[0]) or not len(self.table):
            return None
        return Grounds.under(self.thing_vertices, self.table, self.ups, self.floors)

    @cached_property
    def plans(self) -> Plans | None:
        """The faces as seen from above, of scenes of which up is known, if there are any."""
        return Plans.of(self.table, self.ups) if len(self.table) else None

    @cached_property
    def leaning(self) -> Estimates:
        """Angles (f,) between the faces and the level, where up is known."""
        return tilts(self.table.planes, self.ups[self.table.scene])

    @cached_property
    def senses(self) -> Indices:
        """1 (f,) for faces that look up, -1 for those that look down, else 0, where up is known."""
        return find_vertical_senses(self.table.planes, self.ups[self.table.scene], self.leaning)

    @cached_property
    def filled(self) -> dict[int, FilledSpace]:
        """The filled space of each thing, by its index."""
        return compute_filled_spaces(
            self.scenes, self.table, self.edges, self.things, self.members, self.floors
        )

    @cached_property
    def face_names(self) -> Names:
        """Names (f,) of the faces."""
        return make_names_in_order("f", self.table.face_counts)

    @cached_property
    def vertex_names(self) -> Names:
        """Names (n,) of the vertices."""
        return make_names_in_order("v", self.table.vertex_counts)

    @cached_property
    def edge_names(self) -> Names:
        """Names (e,) of the edges."""
        return make_names_in_order("e", self.edge_counts)

    @cached_property
    def thing_names(self) -> Names:
        """Names (t,) of the things."""
        return make_names_in_order("t", np.bincount(self.thing_scene, minlength=len(self.scenes)))


def _moved(thing: Thing, faces: int, edges: int, scene: int) -> Thing:
    """Return a thing of a scene alone, in a block that has so many faces and edges before."""
    return replace(
        thing,
        faces=tuple(faces + i for i in thing.faces),
        edges=tuple(edges + i for i in thing.edges),
        scene=scene,
    )


def _listed(rows: Iterable[tuple[int, ...]]) -> tuple[Indices, Indices]:
    """Return the row of each entry, and the entry."""
    kept = tuple(rows)
    owner = np.repeat(np.arange(len(kept)), [len(row) for row in kept])
    return owner, np.fromiter(chain.from_iterable(kept), np.intp, len(owner))
