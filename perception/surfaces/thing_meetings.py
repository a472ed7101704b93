"""How cores meet faces of others: at the rim or within, by a whole side, before or behind."""

from collections import defaultdict
from dataclasses import dataclass, field

import numpy as np

from facetlog.perception.ragged import Bools, Indices, row_starts, row_table
from facetlog.perception.surfaces.contacts import SideContacts, touches
from facetlog.perception.surfaces.thing_parts import Cores, Parts
from facetlog.perception.types import FloatArray

__all__ = ["Stance", "stances"]

# Contacts this close to the rim, as a share of the face's shorter extent, are at the rim: legs,
# posts and backs are put there.
RIM_SHARE = 0.05


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


def _meetings(
    parts: Parts, cores: Cores, contacts: SideContacts, near: tuple[Indices, Indices]
) -> tuple[_Meetings, ...]:
    """All meetings of parts with faces of other cores; `near` are vertices (v,) and faces (v,) at
    whose planes they are.
    """
    found: list[_Meetings] = []

    def add(part: Indices, face: Indices, vertex: Indices, at_rim: Bools, by_side: Bools) -> None:
        keep = cores.of[part] != cores.of[face]
        found.append(_Meetings(part[keep], face[keep], vertex[keep], at_rim[keep], by_side[keep]))

    table = parts.table
    sides, count = table.sides, len(table)
    in_hole = np.column_stack([sides.in_hole[contacts.first], sides.in_hole[contacts.second]])
    by_side = contacts.against & ~in_hole.any(axis=1)
    for own, other in ((0, 1), (1, 0)):
        for end in (0, 1):
            vertex = sides.ends[contacts.shorter, end]
            faces = contacts.faces
            add(faces[:, other], faces[:, own], vertex, ~in_hole[:, own], by_side)

    on_edge = parts.on_loose_edges()
    vertex = np.concatenate((parts.vertex, on_edge[0]))
    part = np.concatenate((parts.part, on_edge[1]))
    row, face = parts.holders(vertex)
    keep = face < count
    row, face = row[keep], face[keep]
    vertex = vertex[row]
    rim = (table.outlines[face] == vertex[:, None]).any(axis=1)
    add(part[row], face, vertex, rim, np.zeros(len(row), dtype=np.bool_))

    # A vertex may lie within a face: it matters where some part that has it is of another core.
    vertex, face = near
    row, part = parts.holders(vertex)
    inside, apart = np.zeros((2, len(vertex)), dtype=np.bool_)
    inside[row[part == face[row]]] = True
    apart[row[cores.of[part] != cores.of[face[row]]]] = True
    vertex, face = vertex[apart & ~inside], face[apart & ~inside]
    touching = touches(table, vertex, face)
    width = np.ptp(table.flat, axis=1).min(axis=1)[touching.face]
    row, part = parts.holders(touching.vertex)
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
    def of(cls, parts: Parts, cores: Cores) -> "_Heights":
        table, tolerance, used = parts.table, parts.table.tolerance, parts.used
        faces = table.face_counts
        first = row_starts(faces)
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
        begin[used] = row_starts(counts) - first[scene]
        row = np.repeat(np.arange(len(used)), counts)
        vertex = used[row]
        face = np.arange(len(row)) - begin[vertex]
        gap, sds = table.planes.heights(face, vertex, table.points, table.covs)
        return cls(vertex, face, begin, gap, tolerance.within(sds, table.scene[face]))

    def near(self) -> tuple[Indices, Indices]:
        """Vertices (v,) and the faces (v,) at whose planes they are."""
        near = np.abs(self.gap) <= self.limit
        return self.vertex[near], self.face[near]


def stances(parts: Parts, cores: Cores, contacts: SideContacts) -> dict[tuple[int, int], Stance]:
    """For each core and each face of another core that it meets, its stance."""
    found: dict[tuple[int, int], Stance] = defaultdict(Stance)
    if len(cores.bodies) == 1:
        return found
    table, planes = parts.table, parts.table.planes
    count = len(table)
    heights = _Heights.of(parts, cores)
    place, there = row_table(parts.counts)
    vertices = parts.vertex[place]
    for met in _meetings(parts, cores, contacts, heights.near()):
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
