"""Which faces and loose edges are one thing: parts that are joined, without what they stand on.

Faces that meet in a convex or flat edge are of one body (a core); a core without a convex edge is
a sheet. Then cores join where they touch, unless one merely stands on a face of the other:

- What touches a face from behind (a leg under a table top) or in its plane belongs to it; so does
  what begins a little behind it: of a thick top pictures show the upper side only. Nor
  is what rises from the rim of an upward face in loose edges, as a back of bars, another thing.
- What stands before a *sheet* that reaches on beyond the contact is not part of it: the sheet is
  a support, such as a floor. Two sheets that share a side join: a room's corner is a thing.
- What stands before an upward face of a *body* is not part of it either, unless it stands at the
  rim or takes most of it, as a chair's back does. Without a known up it counts as joined.
- A body beside an upright face of another is not part of it if none of its own upright faces is
  along or square to that one: things are built square, and put beside one another any way round.
  Without a known up it counts as joined.
- Nothing stands on a face that looks down; what touches it hangs there.

The parts of things are faces and loose edges; a core is faces that meet in a convex or flat edge,
or loose edges that share an end. Cores meet faces at the rim or within, by a whole side, before or
behind.
"""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np

from facetlog.perception.attached_edges import (
    find_risen_segments,
    find_segments_behind,
    is_hung_behind,
)
from facetlog.perception.batch_linalg import dots
from facetlog.perception.ragged import Bools, Indices, find_row_starts, row_table
from facetlog.perception.scene import Scene, Solids
from facetlog.perception.surfaces.components import components
from facetlog.perception.surfaces.contacts import SideContacts, touches
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.types import FloatArray

__all__ = ["Thing", "find_things"]

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
        edge = np.tile(np.arange(len(self.loose)), len(self.used))
        vertex, both = np.repeat(self.used, len(self.loose)), self.loose[edge]
        start = points[both[:, 0]]
        span, beside = points[both[:, 1]] - start, points[vertex] - start
        square = np.maximum(dots(span, span), 1e-300)
        t = np.clip(dots(beside, span) / square, 0.0, 1.0)
        away = beside - t[:, None] * span
        sds = tolerance.vertex_sds
        slack = np.hypot(sds[vertex], sds[both].max(axis=1))
        on = (np.sqrt(dots(away, away)) <= tolerance.within(slack)) & (vertex[:, None] != both).all(
            axis=1
        )
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
    """Used vertices over planes of all faces: pair (p,) is of `vertex` and `face`.

    `begin` (n,) is where the pairs of each vertex begin.
    """

    vertex: Indices
    face: Indices
    begin: Indices
    gap: FloatArray
    limit: FloatArray

    @classmethod
    def of(cls, parts: Parts) -> "_Heights":
        table, used = parts.table, parts.used
        begin = np.zeros(len(table.points), dtype=np.intp)
        begin[used] = np.arange(len(used)) * len(table)
        vertex = np.repeat(used, len(table))
        face = np.tile(np.arange(len(table)), len(used))
        gap, sds = table.planes.heights(face, vertex, table.points, table.covs)
        return cls(vertex, face, begin, gap, table.tolerance.within(sds))

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
    heights = _Heights.of(parts)
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


# A face reaches on beyond a contact when it is this much longer than that, along it. A chair's
# back is as wide as its seat; a thing on a floor or table rarely takes two thirds of it.
SUPPORT_REACH = 1.5
# Of faces along or square to one another: normals found in pictures are known to a degree or two.
SQUARE = float(np.sin(np.deg2rad(5.0)))
# The normal must point this far above or below the horizon to carry or to hang: sin 30°.
LEVEL_ENOUGH = 0.5


@dataclass(frozen=True, slots=True)
class Thing:
    """Faces, loose edges and patches that are judged as one object.

    They are indices into what the scene has. `whole` and `solids` are its body's.
    """

    faces: tuple[int, ...]
    edges: tuple[int, ...]
    patches: tuple[int, ...] = ()
    whole: bool = False
    solids: Solids | None = None


def _extends_beyond_contact(outline: FloatArray, span: FloatArray) -> bool:
    """Return whether a face of some outline (k, 3) is much longer than the contact, whose farthest
    points `span` (3,) joins.
    """
    length = float(np.linalg.norm(span))
    if length == 0.0:
        return True
    extent = float(np.ptp(outline @ span)) / length
    return extent > SUPPORT_REACH * length


def _find_longest_difference(points: FloatArray) -> FloatArray:
    """Return the longest of the differences between points (n, 3), n small."""
    differences = points[:, None] - points[None]
    squares = np.einsum("ijk,ijk->ij", differences, differences)
    longest: FloatArray = differences[np.unravel_index(int(np.argmax(squares)), squares.shape)]
    return longest


def _iter_attached_edge_pairs(cores: Cores, up: FloatArray) -> Iterator[tuple[int, int]]:
    """Return pairs of cores: loose edges that stand behind a face within its outline, near enough,
    or rise from its rim. `up` (3,) is zero where it is not known.
    """
    parts, table = cores.parts, cores.parts.table
    if not len(parts.loose):
        return
    edges = table.points[parts.loose]
    for face in np.flatnonzero(table.areas > 0.0).tolist():
        outline = table.points[table.outlines[face, table.there[face]]]
        normal = table.planes.normals[face]
        joined = find_segments_behind(edges, outline, normal)
        joined |= find_risen_segments(edges, outline, normal, up)
        other = int(cores.of[face])
        for core in cores.of[len(table) :][joined].tolist():
            if core != other:
                yield min(core, other), max(core, other)


def _iter_pairs_under_tops(cores: Cores) -> Iterator[tuple[int, int]]:
    """Return pairs of cores: an upward face, and an upright one that stands beneath it within its
    outline and begins as near behind it as boards are thick. What has a top of its own is another
    thing.
    """
    parts, table = cores.parts, cores.parts.table
    of = cores.of[: len(table)]
    usable = table.areas > 0.0
    tops = usable & (parts.rise > LEVEL_ENOUGH)
    uprights = usable & ~np.isin(of, of[tops]) & (np.abs(parts.rise) < LEVEL_ENOUGH)
    sides = table.points[table.sides.ends]
    for top in np.flatnonzero(tops).tolist():
        outline = table.points[table.outlines[top, table.there[top]]]
        for side in np.flatnonzero(uprights).tolist():
            own = sides[table.sides.face == side]
            if is_hung_behind(own, outline, table.planes.normals[top]):
                yield min(int(of[top]), int(of[side])), max(int(of[top]), int(of[side]))


def _is_apart_from_face(cores: Cores, core: int, face: int, how: Stance) -> bool:
    """Return whether a core in front of a face only stands there: see the module's rules."""
    table, rise = cores.parts.table, float(cores.parts.rise[face])
    if not how.in_front or rise < -LEVEL_ENOUGH:
        return False
    if cores.bodies[cores.of[face]]:
        if rise <= LEVEL_ENOUGH:
            return bool(cores.bodies[core]) and _is_turned(cores, core, face)
        if how.at_rim:
            return False
    elif how.by_side and not cores.bodies[core]:
        return False
    outline = table.points[table.outlines[face, table.there[face]]]
    return _extends_beyond_contact(
        outline, _find_longest_difference(table.points[sorted(how.vertices)])
    )


def _is_turned(cores: Cores, core: int, face: int) -> bool:
    """Return whether no face of a core but level ones is along or square to an upright face."""
    parts = cores.parts
    own = np.flatnonzero(cores.of[: len(parts.table)] == core)
    upright = own[np.abs(parts.rise[own]) <= LEVEL_ENOUGH]
    normals = parts.table.planes.normals
    along = np.abs(normals[upright] @ normals[face])
    return bool(len(upright)) and not bool(
        ((along < SQUARE) | (along > np.sqrt(1.0 - SQUARE**2))).any()
    )


def find_things(
    scene: Scene, table: FaceTable, contacts: SideContacts, edges: Indices, loose: Indices
) -> tuple[Thing, ...]:
    """Return the bodies of a scene that tells them apart, of another its things by their first
    faces.

    `edges` (e, 2) are vertices, `loose` (l,) edges that bound no face, ascending. What of these
    joins no face belongs to no thing.
    """
    if scene.bodies:
        known = set(loose.tolist())
        return tuple(
            Thing(
                body.faces,
                tuple(i for i in body.edges if i in known),
                body.patches,
                body.whole,
                body.solids,
            )
            for body in scene.bodies
        )
    if not len(table):
        return ()
    up = np.zeros(3) if scene.up is None else scene.up
    parts = Parts.of(table, dots(table.planes.normals, up), edges[loose])
    cores = Cores.among(parts, contacts)
    met = set(_iter_attached_edge_pairs(cores, up))
    if scene.views:
        met |= set(_iter_pairs_under_tops(cores))
    # What is so placed is no support, whatever else of it meets: a leg's slanted side touches its
    # seat at a corner, from which the seat reaches on.
    joined = met.copy()
    apart: set[tuple[int, int]] = set()
    for (core, face), stance in find_stances(cores).items():
        other = int(cores.of[face])
        pair = (min(core, other), max(core, other))
        met.add(pair)
        if _is_apart_from_face(cores, core, face, stance):
            apart.add(pair)
    groups = components(len(cores.bodies), met - (apart - joined))
    things: dict[int, tuple[list[int], list[int]]] = {}
    for part, core in enumerate(cores.of.tolist()):
        own_faces, own_edges = things.setdefault(groups[core], ([], []))
        if part < len(table):
            own_faces.append(part)
        else:
            own_edges.append(int(loose[part - len(table)]))
    return tuple(Thing(tuple(f), tuple(e)) for f, e in things.values() if f)
