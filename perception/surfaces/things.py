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
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np

from facetlog.perception.behind_face import stands_behind
from facetlog.perception.row_products import dots
from facetlog.perception.row_table import Bools, Indices, pairs_in_rows, row_starts, row_table
from facetlog.perception.scene import Body, Scene
from facetlog.perception.surfaces.contacts import SideContacts, touches
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.types import FloatArray

__all__ = ["Thing", "components", "find_things"]

NONE = np.zeros(0, dtype=np.intp)

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
    """Faces, loose edges and patches that are judged as one object.

    Faces and edges are indices into all that the scenes of a block have, patches into those of the
    thing's own `scene`. `whole` says that its surface is known from all sides.
    """

    faces: tuple[int, ...]
    edges: tuple[int, ...]
    patches: tuple[int, ...] = ()
    whole: bool = False
    scene: int = 0


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


@dataclass(frozen=True, eq=False)
class _Parts:
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
    def of(cls, table: FaceTable, rise: FloatArray, loose: Indices) -> "_Parts":
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

    def holders(self, vertices: Indices) -> tuple[Indices, Indices]:
        """(place among `vertices`, part) (m,) each, for all parts that have one of these (v,)."""
        order, ordered = self._ordered
        first = np.searchsorted(ordered, vertices, "left")
        counts = np.searchsorted(ordered, vertices, "right") - first
        steps = np.arange(int(counts.sum())) - np.repeat(row_starts(counts), counts)
        return np.repeat(np.arange(len(vertices)), counts), self.part[
            order[np.repeat(first, counts) + steps]
        ]

    def on_loose_edges(self) -> tuple[Indices, Indices]:
        """(vertex, part) (m,) each, wherever a vertex lies on a loose edge that ends elsewhere."""
        points, tolerance = self.table.points, self.table.tolerance
        if not len(self.loose):
            return NONE, NONE
        scenes = len(self.table.face_counts)
        loose_scene = tolerance.scene[self.loose[:, 0]]
        row, edge = pairs_in_rows(
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
    parts: _Parts, cores: _Cores, contacts: SideContacts, near: tuple[Indices, Indices]
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


def _reaches_on(outline: FloatArray, span: FloatArray) -> bool:
    """Whether a face of some outline (k, 3) is much longer than the contact, whose farthest points
    `span` (3,) joins.
    """
    length = float(np.linalg.norm(span))
    if length == 0.0:
        return True
    extent = float(np.ptp(outline @ span)) / length
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
    def of(cls, parts: _Parts, cores: _Cores) -> "_Heights":
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


def _stances(
    parts: _Parts, cores: _Cores, contacts: SideContacts
) -> dict[tuple[int, int], _Stance]:
    """For each core and each face of another core that it meets, its stance."""
    stances: dict[tuple[int, int], _Stance] = defaultdict(_Stance)
    if len(cores.bodies) == 1:
        return stances
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
    scene = table.tolerance.scene[parts.loose[:, 0]]
    for face in np.flatnonzero((table.areas > 0.0) & np.isin(table.scene, scene)).tolist():
        own = scene == table.scene[face]
        outline = table.points[table.outlines[face, table.there[face]]]
        behind = stands_behind(table.points[parts.loose[own]], outline, table.planes.normals[face])
        other = int(cores.of[face])
        for core in cores.of[len(table) :][own][behind].tolist():
            if core != other:
                yield min(core, other), max(core, other)


def _stands_apart(parts: _Parts, cores: _Cores, core: int, face: int, how: _Stance) -> bool:
    """Whether a core in front of a face only stands there: see the module's rules."""
    table, rise = parts.table, float(parts.rise[face])
    if not how.in_front or rise < -LEVEL_ENOUGH:
        return False
    if cores.bodies[cores.of[face]]:
        if how.at_rim or rise <= LEVEL_ENOUGH:
            return False
    elif how.by_side and not cores.bodies[core]:
        return False
    outline = table.points[table.outlines[face, table.there[face]]]
    return _reaches_on(outline, _farthest(table.points[sorted(how.vertices)]))


def find_things(
    scenes: Sequence[Scene],
    table: FaceTable,
    contacts: SideContacts,
    edges: tuple[Indices, Indices],
    loose: Indices,
) -> tuple[Thing, ...]:
    """The bodies of scenes that tell them apart, of others their things by their first faces.

    `edges` are vertices (e, 2) and how many of them each scene has (s,); `loose` (l,) are those
    that bound no face, ascending. What of these joins no face belongs to no thing.
    """
    ends, counts = edges
    bodies = [scene.bodies for scene in scenes]
    told = list(_told(bodies, row_starts(table.face_counts), row_starts(counts), loose))
    if all(bodies) or not len(table):
        return tuple(told)
    unknown = np.zeros(3)
    ups = np.array([unknown if scene.up is None else scene.up for scene in scenes])
    rise = dots(table.planes.normals, ups[table.scene])
    parts = _Parts.of(table, rise, ends[loose])
    cores = _Cores.among(parts, contacts)
    met = set(_hanging(parts, cores))
    apart: set[tuple[int, int]] = set()
    for (core, face), stance in _stances(parts, cores, contacts).items():
        other = int(cores.of[face])
        pair = (min(core, other), max(core, other))
        met.add(pair)
        if _stands_apart(parts, cores, core, face, stance):
            apart.add(pair)
    groups = components(len(cores.bodies), met - apart)
    things: dict[int, tuple[list[int], list[int]]] = {}
    for part, core in enumerate(cores.of.tolist()):
        own_faces, own_edges = things.setdefault(groups[core], ([], []))
        if part < len(table):
            own_faces.append(part)
        else:
            own_edges.append(int(loose[part - len(table)]))
    of = table.scene.tolist()
    found = (Thing(tuple(f), tuple(e), scene=of[f[0]]) for f, e in things.values() if f)
    return tuple(
        sorted((*told, *(t for t in found if not bodies[t.scene])), key=lambda thing: thing.scene)
    )


def _told(
    bodies: Sequence[tuple[Body, ...]], first_face: Indices, first_edge: Indices, loose: Indices
) -> Iterator[Thing]:
    """The bodies that scenes tell apart as things."""
    known = set(loose.tolist())
    begins = zip(first_face.tolist(), first_edge.tolist(), strict=True)
    for scene, (own, (face, edge)) in enumerate(zip(bodies, begins, strict=True)):
        for body in own:
            edges = tuple(edge + i for i in body.edges if edge + i in known)
            faces = tuple(face + i for i in body.faces)
            yield Thing(faces, edges, body.patches, body.whole, scene)
