"""Which faces and loose edges are one thing: parts that are joined, without what they stand on.

Faces that meet in a convex or flat edge are of one body (a core); a core without a convex edge is
a sheet. Then cores join where they touch, unless one merely stands on a face of the other:

- What touches a face from behind (a leg under a table top) or in its plane belongs to it; so does
  a loose edge that begins a little behind it: of a thick top pictures show the upper side only.
- What stands before a *sheet* that reaches on beyond the contact is not part of it: the sheet is
  a support, such as a floor. Two sheets that share a side join: a room's corner is a thing.
- What stands before an upward face of a *body* is not part of it either, unless it stands at the
  rim or takes most of it, as a chair's back does. Without a known up it counts as joined.
- Nothing stands on a face that looks down; what touches it hangs there.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from facetlog.perception.behind_face import stands_behind
from facetlog.perception.flat_faces import FlatFace
from facetlog.perception.row_table import Bools, Indices, row_starts, row_table
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.contacts import SideContacts, touches
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.types import FloatArray

__all__ = ["Thing", "components", "find_things"]

# A face reaches on beyond a contact when it is this much longer than that, along it. A chair's
# back is as wide as its seat; a thing on a floor or table rarely takes two thirds of it.
SUPPORT_REACH = 1.5
# Contacts this close to the rim, as a share of the face's shorter extent, are at the rim: legs,
# posts and backs are put there.
RIM_SHARE = 0.05
# The normal must point this far above or below the horizon to carry or to hang: sin 30°.
LEVEL_ENOUGH = 0.5


@dataclass(frozen=True, slots=True)
class Thing:
    """Faces, loose edges and patches (indices into the scene) that are judged as one object.

    `whole` says that its surface is known from all sides.
    """

    faces: tuple[int, ...]
    edges: tuple[int, ...]
    patches: tuple[int, ...] = ()
    whole: bool = False


def components(count: int, pairs: Iterable[tuple[int, int]]) -> tuple[int, ...]:
    """For each of `count` nodes the number of its connected group, numbered by first member.

    >>> components(4, [(3, 1)])
    (0, 1, 2, 1)
    """
    parent = list(range(count))

    def root(node: int) -> int:
        while parent[node] != node:
            parent[node] = node = parent[parent[node]]
        return node

    for one, two in pairs:
        first, second = root(one), root(two)
        parent[max(first, second)] = min(first, second)
    names: dict[int, int] = {}
    return tuple(names.setdefault(root(node), len(names)) for node in range(count))


@dataclass(frozen=True, eq=False, slots=True)
class _Parts:
    """The scene's faces and then its loose edges, numbered as parts; who holds which vertex.

    Part `part` (h,) has the vertex `vertex` (h,); those of a part stand together, `counts` (p,) of
    them. `loose` (l, 2) are the loose edges' ends.
    """

    table: FaceTable
    up: FloatArray | None
    loose: Indices
    part: Indices
    vertex: Indices
    counts: Indices

    @classmethod
    def of(cls, table: FaceTable, up: FloatArray | None, loose: Indices) -> "_Parts":
        counts = np.concatenate((table.members.counts, np.full(len(loose), 2)))
        vertex = np.concatenate((table.members.vertex, loose.ravel()))
        return cls(table, up, loose, np.repeat(np.arange(len(counts)), counts), vertex, counts)

    @property
    def used(self) -> Indices:
        """All vertices that some part has, ascending."""
        return np.unique(self.vertex)

    def holders(self, vertices: Indices) -> tuple[Indices, Indices]:
        """(place among `vertices`, part) (m,) each, for all parts that have one of these (v,)."""
        order = np.argsort(self.vertex, kind="stable")
        ordered = self.vertex[order]
        first = np.searchsorted(ordered, vertices, "left")
        counts = np.searchsorted(ordered, vertices, "right") - first
        steps = np.arange(int(counts.sum())) - np.repeat(row_starts(counts), counts)
        return np.repeat(np.arange(len(vertices)), counts), self.part[
            order[np.repeat(first, counts) + steps]
        ]

    def on_loose_edges(self) -> tuple[Indices, Indices]:
        """(vertex, part) (m,) each, wherever a vertex lies on a loose edge that ends elsewhere."""
        points, used, tolerance = self.table.points, self.used, self.table.tolerance
        sds = tolerance.vertex_sds
        ends = points[self.loose]
        span = ends[:, 1] - ends[:, 0]
        square = np.maximum((span * span).sum(axis=1), 1e-300)
        beside = points[used][:, None] - ends[:, 0]
        t = np.clip((beside * span).sum(axis=2) / square, 0.0, 1.0)
        gap = np.linalg.norm(beside - t[:, :, None] * span, axis=2)
        slack = np.hypot(sds[used][:, None], sds[self.loose].max(axis=1))
        own = (used[:, None, None] == self.loose).any(axis=2)
        row, edge = np.nonzero((gap <= tolerance.within(slack)) & ~own)
        return used[row], len(self.table) + edge


def _loose_pairs(parts: _Parts) -> Iterator[tuple[int, int]]:
    """Pairs of loose edges that share an end, or of which one ends on the other."""
    count = len(parts.table)
    if not len(parts.loose):
        return
    row, part = parts.holders(parts.used)
    for held in np.split(part, np.cumsum(np.bincount(row))[:-1]):
        yield from pairwise(held[held >= count].tolist())
    vertex, edge = parts.on_loose_edges()
    row, part = parts.holders(vertex)
    keep = part >= count
    yield from zip(edge[row[keep]].tolist(), part[keep].tolist(), strict=True)


@dataclass(frozen=True, eq=False, slots=True)
class _Cores:
    """The core (p,) of every part, and whether each core (c,) is a body (has a convex edge)."""

    of: Indices
    bodies: Bools

    @classmethod
    def among(cls, parts: _Parts, contacts: SideContacts) -> "_Cores":
        bent = contacts.take(contacts.against)
        flush = bent.faces[~bent.concave & ~bent.back_to_back].tolist()
        groups = np.array(
            components(len(parts.counts), [*_loose_pairs(parts), *flush]), dtype=np.intp
        )
        bodies = np.zeros(int(groups.max()) + 1, dtype=np.bool_)
        bodies[groups[bent.faces[bent.convex, 0]]] = True
        return cls(groups, bodies)


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
    parts: _Parts, cores: _Cores, contacts: SideContacts, near: Bools
) -> tuple[_Meetings, ...]:
    """All meetings of parts with faces of other cores; `near` (v, f): which of the used vertices
    are at a face's plane.
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
    row, face = np.nonzero(near)
    vertex = parts.used[row]
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


def _reaches_on(face: FlatFace, span: FloatArray, points: FloatArray) -> bool:
    """Whether the face is much longer than the contact, whose farthest points `span` (3,) joins."""
    length = float(np.linalg.norm(span))
    if length == 0.0:
        return True
    extent = float(np.ptp(points[list(face.outline)] @ span)) / length
    return extent > SUPPORT_REACH * length


def _farthest(points: FloatArray) -> FloatArray:
    """The longest of the differences between points (n, 3), n small."""
    differences = points[:, None] - points[None]
    squares = np.einsum("ijk,ijk->ij", differences, differences)
    longest: FloatArray = differences[np.unravel_index(int(np.argmax(squares)), squares.shape)]
    return longest


@dataclass(slots=True)
class _Stance:
    """How one core meets one face: all its meetings there, gathered."""

    vertices: set[int] = field(default_factory=set)
    in_front: bool = False
    at_rim: bool = False
    by_side: bool = False


def _stances(
    parts: _Parts, cores: _Cores, contacts: SideContacts
) -> dict[tuple[int, int], _Stance]:
    """For each core and each face of another core that it meets, its stance."""
    stances: dict[tuple[int, int], _Stance] = defaultdict(_Stance)
    if len(cores.bodies) == 1:
        return stances
    table, planes, used = parts.table, parts.table.planes, parts.used
    count = len(table)
    gaps, sds = planes.distances(table.points[used], table.covs[used])
    limits = table.tolerance.within(sds)
    place, there = row_table(parts.counts)
    rows = np.searchsorted(used, parts.vertex)[place]
    for met in _meetings(parts, cores, contacts, np.abs(gaps) <= limits):
        part, face = met.part, met.face
        own = np.where(there[part], np.abs(gaps[rows[part], face[:, None]]), -1.0)
        farthest = rows[part, own.argmax(axis=1)]
        reach, limit = gaps[farthest, face], limits[farthest, face]
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
            stance = stances[core, i]
            stance.vertices.add(vertex)
            stance.in_front |= front
            stance.at_rim |= rim
            stance.by_side |= side
    return stances


def _hanging(parts: _Parts, cores: _Cores) -> Iterator[tuple[int, int]]:
    """Pairs of cores: loose edges that stand behind a face within its outline, near enough."""
    table = parts.table
    if not len(parts.loose):
        return
    ends = table.points[parts.loose]
    for face in table.faces:
        if face.area == 0.0:
            continue
        behind = stands_behind(ends, table.points[list(face.outline)], face.normal)
        other = int(cores.of[face.index])
        for core in cores.of[len(table) :][behind].tolist():
            if core != other:
                yield min(core, other), max(core, other)


def _stands_apart(parts: _Parts, cores: _Cores, core: int, face: FlatFace, how: _Stance) -> bool:
    """Whether a core in front of a face only stands there: see the module's rules."""
    points = parts.table.points
    rise = 0.0 if parts.up is None else float(face.normal @ parts.up)
    if not how.in_front or rise < -LEVEL_ENOUGH:
        return False
    if cores.bodies[cores.of[face.index]]:
        if how.at_rim or rise <= LEVEL_ENOUGH:
            return False
    elif how.by_side and not cores.bodies[core]:
        return False
    return _reaches_on(face, _farthest(points[sorted(how.vertices)]), points)


def find_things(
    scene: Scene, table: FaceTable, contacts: SideContacts, loose: tuple[int, ...]
) -> tuple[Thing, ...]:
    """The scene's bodies where it tells them apart, else its things in the order of first faces.

    `loose` are the edges that bound no face; those that join no face belong to no thing.
    """
    if scene.bodies:
        known = set(loose)
        own = ((b, tuple(e for e in b.edges if e in known)) for b in scene.bodies)
        return tuple(Thing(b.faces, edges, b.patches, b.whole) for b, edges in own)
    if not len(table):
        return ()
    ends = np.array([(scene.edges[i].start, scene.edges[i].end) for i in loose], dtype=np.intp)
    parts = _Parts.of(table, scene.up, ends.reshape(-1, 2))
    cores = _Cores.among(parts, contacts)
    met = set(_hanging(parts, cores))
    apart: set[tuple[int, int]] = set()
    for (core, face), stance in _stances(parts, cores, contacts).items():
        other = int(cores.of[face])
        pair = (min(core, other), max(core, other))
        met.add(pair)
        if _stands_apart(parts, cores, core, table.faces[face], stance):
            apart.add(pair)
    groups = components(len(cores.bodies), met - apart)
    things: dict[int, tuple[list[int], list[int]]] = {}
    for part, core in enumerate(cores.of.tolist()):
        own_faces, own_edges = things.setdefault(groups[core], ([], []))
        if part < len(table):
            own_faces.append(part)
        else:
            own_edges.append(loose[part - len(table)])
    return tuple(Thing(tuple(f), tuple(e)) for f, e in things.values() if f)
