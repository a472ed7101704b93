"""The parts of things, their cores, and how cores meet faces of others.

Parts are faces and loose edges. Faces that meet in a convex or flat edge are of one core, as are
loose edges that share an end. Cores meet faces at the rim or within, by a whole side, before or
behind.
"""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np

from facetlog.perception.batch_linalg import dots
from facetlog.perception.ragged import (
    Bools,
    Indices,
    find_pairs_in_rows,
    find_row_starts,
    row_table,
)
from facetlog.perception.surfaces.components import components
from facetlog.perception.surfaces.contacts import SideContacts, touches
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.types import FloatArray

__all__ = ["Cores", "Parts", "Stance", "find_stances"]

NONE = np.zeros(0, dtype=np.intp)
# Contacts this close to the rim, as a share of the face's shorter extent, are at the rim: legs,
# posts and backs are put there.
RIM_SHARE = 0.05


@dataclass(frozen=True, eq=False)
class Parts:
    """All faces and then all loose edges, numbered as parts; who holds which vertex.

    Part `part` (h,) has the vertex `vertex` (h,); those of a part stand together, `counts` (p,) of
    them. `loose` (l, 2) are the loose edges' ends. `rise` (f,) is how far the faces' normals point
    up, 0 where up is not known.
    """

    table: FaceTable
    rise: FloatArray
    loose: Indices
    part: Indices
    vertex: Indices
    counts: Indices

    @classmethod
    def of(cls, table: FaceTable, rise: FloatArray, loose: Indices) -> "Parts":
        counts = np.concatenate((table.members.counts, np.full(len(loose), 2)))
        vertex = np.concatenate((table.members.vertex, loose.ravel()))
        return cls(table, rise, loose, np.repeat(np.arange(len(counts)), counts), vertex, counts)

    @cached_property
    def used(self) -> Indices:
        """All vertices that some part has, ascending."""
        return np.unique(self.vertex)

    @cached_property
    def _ordered(self) -> tuple[Indices, Indices]:
        order = np.argsort(self.vertex, kind="stable")
        return order, self.vertex[order]

    def find_holders(self, vertices: Indices) -> tuple[Indices, Indices]:
        """Return (place among `vertices`, part) (m,) each, for all parts that have one of these
        (v,).
        """
        order, ordered = self._ordered
        first = np.searchsorted(ordered, vertices, "left")
        counts = np.searchsorted(ordered, vertices, "right") - first
        steps = np.arange(int(counts.sum())) - np.repeat(find_row_starts(counts), counts)
        return np.repeat(np.arange(len(vertices)), counts), self.part[
            order[np.repeat(first, counts) + steps]
        ]

    def find_on_loose_edges(self) -> tuple[Indices, Indices]:
        """Return (vertex, part) (m,) each, wherever a vertex lies on a loose edge that ends
        elsewhere.
        """
        points, tolerance = self.table.points, self.table.tolerance
        if not len(self.loose):
            return NONE, NONE
        scenes = len(self.table.face_counts)
        loose_scene = tolerance.scene[self.loose[:, 0]]
        row, edge = find_pairs_in_rows(
            np.bincount(tolerance.scene[self.used], minlength=scenes),
            np.bincount(loose_scene, minlength=scenes),
        )
        vertex, both = self.used[row], self.loose[edge]
        start = points[both[:, 0]]
        span, beside = points[both[:, 1]] - start, points[vertex] - start
        square = np.maximum(dots(span, span), 1e-300)
        t = np.clip(dots(beside, span) / square, 0.0, 1.0)
        away = beside - t[:, None] * span
        sds = tolerance.vertex_sds
        slack = np.hypot(sds[vertex], sds[both].max(axis=1))
        limit = tolerance.within(slack, loose_scene[edge])
        on = (np.sqrt(dots(away, away)) <= limit) & (vertex[:, None] != both).all(axis=1)
        return vertex[on], len(self.table) + edge[on]


def _iter_loose_pairs(parts: Parts) -> Iterator[tuple[int, int]]:
    """Return pairs of loose edges that share an end, or of which one ends on the other."""
    count = len(parts.table)
    if not len(parts.loose):
        return
    row, part = parts.find_holders(parts.used)
    for held in np.split(part, np.cumsum(np.bincount(row))[:-1]):
        yield from pairwise(held[held >= count].tolist())
    vertex, edge = parts.find_on_loose_edges()
    row, part = parts.find_holders(vertex)
    keep = part >= count
    yield from zip(edge[row[keep]].tolist(), part[keep].tolist(), strict=True)


@dataclass(frozen=True, eq=False, slots=True)
class Cores:
    """The core (p,) of every part, and whether each core (c,) is a body (has a convex edge)."""

    parts: Parts
    contacts: SideContacts
    of: Indices
    bodies: Bools

    @classmethod
    def among(cls, parts: Parts, contacts: SideContacts) -> "Cores":
        bent = contacts.take(contacts.against)
        flush = bent.faces[~bent.concave & ~bent.back_to_back].tolist()
        groups = np.array(
            components(len(parts.counts), [*_iter_loose_pairs(parts), *flush]), dtype=np.intp
        )
        bodies = np.zeros(int(groups.max()) + 1, dtype=np.bool_)
        bodies[groups[bent.faces[bent.convex, 0]]] = True
        return cls(parts, contacts, groups, bodies)


@dataclass(frozen=True, eq=False, slots=True)
class _Meetings:
    """Parts (m,) that meet faces (m,), at a vertex each; two of them where a side runs along.

    `at_rim` says that it is at the face's outline; `by_side`, that a whole side runs along there.
    """

    part: Indices
    face: Indices
    vertex: Indices
    at_rim: Bools
    by_side: Bools


def _meetings(cores: Cores, near: tuple[Indices, Indices]) -> tuple[_Meetings, ...]:
    """Return all meetings of parts with faces of other cores; `near` are vertices (v,) and faces
    (v,) at whose planes they are.
    """
    found: list[_Meetings] = []

    def add(part: Indices, face: Indices, vertex: Indices, at_rim: Bools, by_side: Bools) -> None:
        keep = cores.of[part] != cores.of[face]
        found.append(_Meetings(part[keep], face[keep], vertex[keep], at_rim[keep], by_side[keep]))

    parts, contacts = cores.parts, cores.contacts
    table = parts.table
    sides, count = table.sides, len(table)
    in_hole = np.column_stack([sides.in_hole[contacts.first], sides.in_hole[contacts.second]])
    by_side = contacts.against & ~in_hole.any(axis=1)
    for own, other in ((0, 1), (1, 0)):
        for end in (0, 1):
            vertex = sides.ends[contacts.shorter, end]
            faces = contacts.faces
            add(faces[:, other], faces[:, own], vertex, ~in_hole[:, own], by_side)

    on_edge = parts.find_on_loose_edges()
    vertex = np.concatenate((parts.vertex, on_edge[0]))
    part = np.concatenate((parts.part, on_edge[1]))
    row, face = parts.find_holders(vertex)
    keep = face < count
    row, face = row[keep], face[keep]
    vertex = vertex[row]
    rim = (table.outlines[face] == vertex[:, None]).any(axis=1)
    add(part[row], face, vertex, rim, np.zeros(len(row), dtype=np.bool_))

    # A vertex may lie within a face: it matters where some part that has it is of another core.
    vertex, face = near
    row, part = parts.find_holders(vertex)
    inside, apart = np.zeros((2, len(vertex)), dtype=np.bool_)
    inside[row[part == face[row]]] = True
    apart[row[cores.of[part] != cores.of[face[row]]]] = True
    vertex, face = vertex[apart & ~inside], face[apart & ~inside]
    touching = touches(table, vertex, face)
    width = np.ptp(table.flat, axis=1).min(axis=1)[touching.face]
    row, part = parts.find_holders(touching.vertex)
    rim = (touching.depth <= RIM_SHARE * width)[row]
    no_side = np.zeros(len(row), dtype=np.bool_)
    add(part, touching.face[row], touching.vertex[row], rim, no_side)
    return tuple(found)


@dataclass(slots=True)
class Stance:
    """How one core meets one face: all its meetings there, gathered."""

    vertices: set[int] = field(default_factory=set)
    in_front: bool = False
    at_rim: bool = False
    by_side: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class _Heights:
    """Used vertices over planes of faces of their scenes: pair (p,) is of `vertex` and `face`.

    `begin` (n,) is where the pairs of each vertex of a scene begin, less its scene's first face.
    Scenes of one core have none.
    """

    vertex: Indices
    face: Indices
    begin: Indices
    gap: FloatArray
    limit: FloatArray

    @classmethod
    def of(cls, cores: Cores) -> "_Heights":
        parts = cores.parts
        table, tolerance, used = parts.table, parts.table.tolerance, parts.used
        faces = table.face_counts
        first = find_row_starts(faces)
        several = np.zeros(len(faces), dtype=np.bool_)
        of_face = cores.of[: len(table)]
        several[table.scene[of_face != of_face[first[table.scene]]]] = True
        loose = tolerance.scene[parts.loose[:, 0]]
        some = faces[loose] > 0
        several[loose[some]] |= (cores.of[len(table) :] != of_face[first[loose] % len(table)])[some]
        scene = tolerance.scene[used]
        used, scene = used[several[scene]], scene[several[scene]]
        counts = faces[scene]
        begin = np.zeros(len(table.points), dtype=np.intp)
        begin[used] = find_row_starts(counts) - first[scene]
        row = np.repeat(np.arange(len(used)), counts)
        vertex = used[row]
        face = np.arange(len(row)) - begin[vertex]
        gap, sds = table.planes.heights(face, vertex, table.points, table.covs)
        return cls(vertex, face, begin, gap, tolerance.within(sds, table.scene[face]))

    def near(self) -> tuple[Indices, Indices]:
        """Return vertices (v,) and the faces (v,) at whose planes they are."""
        near = np.abs(self.gap) <= self.limit
        return self.vertex[near], self.face[near]


def find_stances(cores: Cores) -> dict[tuple[int, int], Stance]:
    """Return the stance of each core at each face of another core that it meets."""
    found: dict[tuple[int, int], Stance] = defaultdict(Stance)
    if len(cores.bodies) == 1:
        return found
    parts = cores.parts
    table, planes = parts.table, parts.table.planes
    count = len(table)
    heights = _Heights.of(cores)
    place, there = row_table(parts.counts)
    vertices = parts.vertex[place]
    for met in _meetings(cores, heights.near()):
        part, face = met.part, met.face
        pairs = heights.begin[vertices[part]] + face[:, None]
        own = np.where(there[part], np.abs(heights.gap[pairs]), -1.0)
        farthest = pairs[np.arange(len(part)), own.argmax(axis=1)]
        reach, limit = heights.gap[farthest], heights.limit[farthest]
        in_front = reach > limit
        # Flat on the face and facing it: the underside of something that stands there.
        flat = (np.abs(reach) <= limit) & (part < count)
        facing = (planes.normals[part[flat]] * planes.normals[face[flat]]).sum(axis=1)
        in_front[flat] = facing < 0.0
        # Of an edge that starts at a corner of the face pictures say that it belongs there.
        starts = (table.outlines[face] == met.vertex[:, None]).any(axis=1)
        by_side = met.by_side | ((part >= count) & starts)
        for core, i, vertex, front, rim, side in zip(
            cores.of[part].tolist(),
            face.tolist(),
            met.vertex.tolist(),
            in_front.tolist(),
            met.at_rim.tolist(),
            by_side.tolist(),
            strict=True,
        ):
            stance = found[core, i]
            stance.vertices.add(vertex)
            stance.in_front |= front
            stance.at_rim |= rim
            stance.by_side |= side
    return found
