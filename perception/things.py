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
from collections.abc import Hashable, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from facetlog.perception.behind import stands_behind
from facetlog.perception.contacts import (
    Bend,
    SideContact,
    plane_gaps,
    touches,
)
from facetlog.perception.flat_faces import FlatFace
from facetlog.perception.tolerance import Tolerance
from facetlog.perception.types import FloatArray, Scene

__all__ = ["Thing", "components", "find_things"]

# A face reaches on beyond a contact when it is this much longer than that, along it. A chair's
# back is as wide as its seat; a thing on a floor or table rarely takes two thirds of it.
SUPPORT_REACH = 1.5
# Contacts this close to the rim, as a share of the face's shorter extent, are at the rim: legs,
# posts and backs are put there.
RIM_SHARE = 0.05
# The normal must point this far above or below the horizon to carry or to hang: sin 30°.
LEVEL_ENOUGH = 0.5

BentContacts = tuple[tuple[SideContact, Bend], ...]


@dataclass(frozen=True, slots=True)
class Thing:
    """Faces and loose edges (indices into the scene) that are judged as one object."""

    faces: tuple[int, ...]
    edges: tuple[int, ...]


def components(count: int, pairs: Iterable[tuple[int, int]]) -> tuple[int, ...]:
    """For each of `count` nodes the number of its connected group, numbered by first member.

    >>> components(4, [(3, 1)])
    (0, 1, 2, 1)
    """
    joined = np.array(list(pairs), dtype=np.int64).reshape(-1, 2)
    graph = coo_array((np.ones(len(joined)), (joined[:, 0], joined[:, 1])), shape=(count, count))
    labels = connected_components(graph, directed=False)[1].tolist() if count else []
    names: dict[Hashable, int] = {}
    return tuple(names.setdefault(label, len(names)) for label in labels)


@dataclass(frozen=True, slots=True)
class _Meeting:
    """Part `part` (faces first, then loose edges) meets face `face` at some vertices.

    `at_rim` says that it is at the face's outline; `by_side`, that a whole side runs along there.
    """

    part: int
    face: int
    vertices: tuple[int, ...]
    at_rim: bool
    by_side: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class _Parts:
    """The scene's faces and then its loose edges, numbered as parts; who holds which vertex."""

    scene: Scene
    points: FloatArray
    faces: tuple[FlatFace, ...]
    members: tuple[tuple[int, ...], ...]
    holders: dict[int, tuple[int, ...]]

    @classmethod
    def of(cls, scene: Scene, faces: tuple[FlatFace, ...], loose: tuple[int, ...]) -> "_Parts":
        ends = ((scene.edges[i].start, scene.edges[i].end) for i in loose)
        members = (*(f.members for f in faces), *ends)
        holders: dict[int, tuple[int, ...]] = {}
        for part, own in enumerate(members):
            for vertex in own:
                holders[vertex] = (*holders.get(vertex, ()), part)
        return cls(scene, scene.points, faces, members, holders)

    @property
    def used(self) -> NDArray[np.intp]:
        """All vertices that some part has."""
        return np.array(sorted(self.holders), dtype=np.intp)

    def on_loose_edges(self) -> list[tuple[int, int]]:
        """(vertex, part) wherever a vertex lies on a loose edge that does not end there."""
        points, used = self.points, self.used
        tolerance = Tolerance.of(self.scene)
        sds = tolerance.vertex_sds
        found: list[tuple[int, int]] = []
        for part in range(len(self.faces), len(self.members)):
            start, end = self.members[part]
            span = points[end] - points[start]
            square = max(float(span @ span), 1e-300)
            t = np.clip((points[used] - points[start]) @ span / square, 0.0, 1.0)
            gap = np.linalg.norm(points[used] - points[start] - t[:, None] * span, axis=1)
            slack = np.hypot(sds[used], max(sds[start], sds[end]))
            near = (gap <= tolerance.within(slack)) & ~np.isin(used, (start, end))
            found += [(v, part) for v in used[near].tolist()]
        return found

    def meetings(self, contacts: BentContacts) -> Iterator[_Meeting]:
        """All meetings of parts with faces; a pair may have several."""
        for contact, _ in contacts:
            ends = (contact.shorter.start, contact.shorter.end)
            outer = not (contact.first.in_hole or contact.second.in_hole)
            for side, other in ((contact.first, contact.second), (contact.second, contact.first)):
                by_side = outer and contact.against
                yield _Meeting(other.face, side.face, ends, not side.in_hole, by_side)
        count = len(self.faces)
        corners = [(v, part) for v, parts in self.holders.items() for part in parts]
        for vertex, part in (*corners, *self.on_loose_edges()):
            for face in self.holders[vertex]:
                if face < count and face != part:
                    yield _Meeting(part, face, (vertex,), vertex in self.faces[face].outline)
        for vertex, face, depth in touches(self.scene, self.faces, self.used):
            outline = self.faces[face].flatten(self.points[list(self.faces[face].outline)])
            rim = depth <= RIM_SHARE * float(np.ptp(outline, axis=0).min())
            for part in self.holders[vertex]:
                yield _Meeting(part, face, (vertex,), rim)


def _loose_pairs(parts: _Parts) -> Iterator[tuple[int, int]]:
    """Pairs of loose edges that share an end, or of which one ends on the other."""
    count = len(parts.faces)
    for held in parts.holders.values():
        edges = [part for part in held if part >= count]
        yield from pairwise(edges)
    for vertex, edge in parts.on_loose_edges():
        yield from ((edge, part) for part in parts.holders[vertex] if part >= count)


@dataclass(frozen=True, eq=False, slots=True)
class _Cores:
    """The core of every part, and which cores are bodies (have a convex edge)."""

    of: tuple[int, ...]
    bodies: frozenset[int]

    @classmethod
    def among(cls, parts: _Parts, contacts: BentContacts) -> "_Cores":
        joined = list(_loose_pairs(parts))
        convex: list[int] = []
        for contact, turn in contacts:
            if contact.against:
                if not turn.concave and not turn.back_to_back:
                    joined.append((contact.first.face, contact.second.face))
                if turn.convex:
                    convex.append(contact.first.face)
        groups = components(len(parts.members), joined)
        return cls(groups, frozenset(groups[face] for face in convex))


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
    parts: _Parts, cores: _Cores, contacts: BentContacts
) -> dict[tuple[int, int], _Stance]:
    """For each core and each face of another core that it meets, its stance."""
    used = parts.used
    row = {vertex: nth for nth, vertex in enumerate(used.tolist())}
    gaps, limits = plane_gaps(parts.scene, used)
    stances: dict[tuple[int, int], _Stance] = defaultdict(_Stance)
    for meeting in parts.meetings(contacts):
        core, face = cores.of[meeting.part], meeting.face
        if core == cores.of[face]:
            continue
        rows = [row[v] for v in parts.members[meeting.part]]
        farthest = rows[int(np.argmax(np.abs(gaps[rows, face])))]
        in_front = gaps[farthest, face] > limits[farthest, face]
        if abs(gaps[farthest, face]) <= limits[farthest, face] and meeting.part < len(parts.faces):
            # Flat on the face and facing it: the underside of something that stands there.
            in_front = parts.faces[meeting.part].normal @ parts.faces[face].normal < 0.0
        stance = stances[core, face]
        stance.vertices.update(meeting.vertices)
        stance.in_front |= bool(in_front)
        stance.at_rim |= meeting.at_rim
        stance.by_side |= meeting.by_side
        if meeting.part >= len(parts.faces) and meeting.vertices[0] in parts.faces[face].outline:
            stance.by_side = True  # pictures say that the edge starts at a corner of the face
    return stances


def _hanging(parts: _Parts, cores: _Cores) -> Iterator[tuple[int, int]]:
    """Pairs of cores: loose edges that stand behind a face within its outline, near enough."""
    loose = parts.members[len(parts.faces) :]
    if not loose:
        return
    ends = parts.points[np.array(loose)]
    for face in parts.faces:
        if face.area == 0.0:
            continue
        behind = stands_behind(ends, parts.points[list(face.outline)], face.normal)
        for nth in np.nonzero(behind)[0].tolist():
            core, other = cores.of[len(parts.faces) + nth], cores.of[face.index]
            if core != other:
                yield min(core, other), max(core, other)


def _stands_apart(parts: _Parts, cores: _Cores, core: int, face: FlatFace, how: _Stance) -> bool:
    """Whether a core in front of a face only stands there: see the module's rules."""
    up, points = parts.scene.up, parts.points
    rise = 0.0 if up is None else float(face.normal @ up)
    if not how.in_front or rise < -LEVEL_ENOUGH:
        return False
    if cores.of[face.index] in cores.bodies:
        if how.at_rim or rise <= LEVEL_ENOUGH:
            return False
    elif how.by_side and core not in cores.bodies:
        return False
    return _reaches_on(face, _farthest(points[sorted(how.vertices)]), points)


def find_things(
    scene: Scene,
    faces: tuple[FlatFace, ...],
    contacts: BentContacts,
    loose: tuple[int, ...],
) -> tuple[Thing, ...]:
    """The scene's things, in the order of their first faces.

    `loose` are the edges that bound no face; those that join no face belong to no thing.
    """
    if not faces:
        return ()
    parts = _Parts.of(scene, faces, loose)
    cores = _Cores.among(parts, contacts)
    met = set(_hanging(parts, cores))
    apart: set[tuple[int, int]] = set()
    for (core, face), stance in _stances(parts, cores, contacts).items():
        pair = (min(core, cores.of[face]), max(core, cores.of[face]))
        met.add(pair)
        if _stands_apart(parts, cores, core, faces[face], stance):
            apart.add(pair)
    groups = components(max(cores.of) + 1, met - apart)
    things: dict[int, tuple[list[int], list[int]]] = {}
    for part, core in enumerate(cores.of):
        own_faces, own_edges = things.setdefault(groups[core], ([], []))
        if part < len(faces):
            own_faces.append(part)
        else:
            own_edges.append(loose[part - len(faces)])
    return tuple(Thing(tuple(f), tuple(e)) for f, e in things.values() if f)
