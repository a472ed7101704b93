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
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.attached_edges import (
    find_risen_segments,
    find_segments_behind,
    is_hung_behind,
)
from facetlog.perception.batch_linalg import dots
from facetlog.perception.ragged import Indices, find_row_starts
from facetlog.perception.scene import Body, Scene
from facetlog.perception.surfaces.components import components
from facetlog.perception.surfaces.contacts import SideContacts
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.thing_parts import Cores, Parts, Stance, find_stances
from facetlog.perception.types import FloatArray

__all__ = ["Thing", "find_things"]

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

    Faces and edges are indices into all that the scenes of a block have, patches into those of the
    thing's own `scene`. `whole` is its body's.
    """

    faces: tuple[int, ...]
    edges: tuple[int, ...]
    patches: tuple[int, ...] = ()
    whole: bool = False
    scene: int = 0


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


def _iter_attached_edge_pairs(cores: Cores, ups: FloatArray) -> Iterator[tuple[int, int]]:
    """Return pairs of cores: loose edges that stand behind a face within its outline, near enough,
    or rise from its rim. `ups` (s, 3) are the scenes', zero where up is not known.
    """
    parts, table = cores.parts, cores.parts.table
    if not len(parts.loose):
        return
    scene = table.tolerance.scene[parts.loose[:, 0]]
    for face in np.flatnonzero((table.areas > 0.0) & np.isin(table.scene, scene)).tolist():
        own = scene == table.scene[face]
        outline = table.points[table.outlines[face, table.there[face]]]
        edges, normal = table.points[parts.loose[own]], table.planes.normals[face]
        joined = find_segments_behind(edges, outline, normal)
        joined |= find_risen_segments(edges, outline, normal, ups[table.scene[face]])
        other = int(cores.of[face])
        for core in cores.of[len(table) :][own][joined].tolist():
            if core != other:
                yield min(core, other), max(core, other)


def _iter_pairs_under_tops(cores: Cores, pictured: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Return pairs of cores: an upward face, and an upright one that stands beneath it within its
    outline and begins as near behind it as boards are thick. What has a top of its own is another
    thing.

    `pictured` (s,) are scenes of pictures.
    """
    parts, table = cores.parts, cores.parts.table
    of = cores.of[: len(table)]
    usable = pictured[table.scene] & (table.areas > 0.0)
    tops = usable & (parts.rise > LEVEL_ENOUGH)
    uprights = usable & ~np.isin(of, of[tops]) & (np.abs(parts.rise) < LEVEL_ENOUGH)
    sides = table.points[table.sides.ends]
    for top in np.flatnonzero(tops).tolist():
        outline = table.points[table.outlines[top, table.there[top]]]
        for side in np.flatnonzero(uprights & (table.scene == table.scene[top])).tolist():
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
    scenes: Sequence[Scene],
    table: FaceTable,
    contacts: SideContacts,
    edges: tuple[Indices, Indices],
    loose: Indices,
) -> tuple[Thing, ...]:
    """Return the bodies of scenes that tell them apart, of others their things by their first
    faces.

    `edges` are vertices (e, 2) and how many of them each scene has (s,); `loose` (l,) are those
    that bound no face, ascending. What of these joins no face belongs to no thing.
    """
    ends, counts = edges
    bodies = [scene.bodies for scene in scenes]
    told = list(_told(bodies, find_row_starts(table.face_counts), find_row_starts(counts), loose))
    if all(bodies) or not len(table):
        return tuple(told)
    unknown = np.zeros(3)
    ups = np.array([unknown if scene.up is None else scene.up for scene in scenes])
    rise = dots(table.planes.normals, ups[table.scene])
    parts = Parts.of(table, rise, ends[loose])
    cores = Cores.among(parts, contacts)
    met = set(_iter_attached_edge_pairs(cores, ups))
    met |= set(_iter_pairs_under_tops(cores, np.array([bool(scene.views) for scene in scenes])))
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
    of = table.scene.tolist()
    found = (Thing(tuple(f), tuple(e), scene=of[f[0]]) for f, e in things.values() if f)
    return tuple(
        sorted((*told, *(t for t in found if not bodies[t.scene])), key=lambda thing: thing.scene)
    )


def _told(
    bodies: Sequence[tuple[Body, ...]], first_face: Indices, first_edge: Indices, loose: Indices
) -> Iterator[Thing]:
    """Return the bodies that scenes tell apart as things."""
    known = set(loose.tolist())
    begins = zip(first_face.tolist(), first_edge.tolist(), strict=True)
    for scene, (own, (face, edge)) in enumerate(zip(bodies, begins, strict=True)):
        for body in own:
            edges = tuple(edge + i for i in body.edges if edge + i in known)
            faces = tuple(face + i for i in body.faces)
            yield Thing(faces, edges, body.patches, body.whole, scene)
