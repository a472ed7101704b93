"""Where faces meet: sides that run along each other, and corners that lie on another face."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.flat_faces import FlatFace, cross
from facetlog.perception.tolerance import ANGLE_RESOLUTION, SDS, Tolerance
from facetlog.perception.types import FloatArray, Scene

__all__ = [
    "Bend",
    "Side",
    "SideContact",
    "Touch",
    "bends",
    "plane_gaps",
    "side_contacts",
    "sides",
    "touches",
]

# Two sides adjoin where they run together over this share of the shorter (language vocabulary).
LEAST_OVERLAP = 0.2


class Side(NamedTuple):
    """One side of a face, from vertex `start` to `end` as its ring runs."""

    face: int
    start: int
    end: int
    in_hole: bool


@dataclass(frozen=True, eq=False, slots=True)
class SideContact:
    """Two faces' sides that run along each other over `length`; `direction` is the first one's.

    `against` says that the sides run against each other, as two sides of one solid's edge do.
    `shorter` is the side that names the contact.
    """

    first: Side
    second: Side
    length: float
    direction: FloatArray
    against: bool
    shorter: Side


class Bend(NamedTuple):
    """Signed angle by which a solid turns at an edge, radians: > 0 convex, < 0 concave; 1σ.

    Two faces back to back turn by π, or by -π: which of them is the same, so it is π, and neither
    convex nor concave. They are two sides of one sheet, or of two bodies that touch.
    """

    turn: float
    sd: float

    @property
    def back_to_back(self) -> bool:
        """The two faces lie on each other, within 3 sd."""
        return abs(self.turn) >= np.pi - SDS * self.sd - ANGLE_RESOLUTION

    @property
    def convex(self) -> bool:
        """The solid bulges, by more than 3 sd."""
        return self.turn > SDS * self.sd + ANGLE_RESOLUTION and not self.back_to_back

    @property
    def concave(self) -> bool:
        """The solid is hollow, by more than 3 sd."""
        return self.turn < -SDS * self.sd - ANGLE_RESOLUTION and not self.back_to_back


def sides(faces: tuple[FlatFace, ...]) -> tuple[Side, ...]:
    """All sides of all faces, in order."""
    return tuple(
        Side(face.index, a, b, nth > 0)
        for face in faces
        for nth, ring in enumerate(face.rings)
        for a, b in zip(ring, (*ring[1:], ring[0]), strict=True)
    )


def bends(scene: Scene, contacts: Sequence[SideContact]) -> tuple[Bend, ...]:
    """Turn of the solid at each contact: φ = atan2((n1 × n2) · d, n1 · n2), d along the first side.

    About the edge only the part of a normal's error along d × n counts, so
    var φ = Σ (d × n)ᵀ C (d × n).
    """
    if not contacts:
        return ()
    d = np.array([contact.direction for contact in contacts])
    normals = np.array([face.plane.normal for face in scene.faces])
    covs = np.array([face.plane.cov[:3, :3] for face in scene.faces])
    first = np.array([contact.first.face for contact in contacts])
    second = np.array([contact.second.face for contact in contacts])
    n1, n2 = normals[first], normals[second]
    turns = np.arctan2((cross(n1, n2) * d).sum(axis=1), (n1 * n2).sum(axis=1))
    turns[turns < ANGLE_RESOLUTION - np.pi] = np.pi
    variance = np.zeros(len(d))
    for face, n in ((first, n1), (second, n2)):
        axis = cross(d, n)
        variance += np.einsum("ni,nij,nj->n", axis, covs[face], axis)
    sds = np.sqrt(np.maximum(variance, 0.0))
    return tuple(Bend(turn, sd) for turn, sd in zip(turns.tolist(), sds.tolist(), strict=True))


def along(
    a: tuple[FloatArray, FloatArray], b: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """For pairs of segments, ends (m, 3) each: overlap along a, worst gap there, cosine; (m,)."""
    span, other = a[1] - a[0], b[1] - b[0]
    size = np.linalg.norm(span, axis=1)
    u = span / np.maximum(size, 1e-300)[:, None]
    t0 = np.einsum("ij,ij->i", b[0] - a[0], u)
    t1 = np.einsum("ij,ij->i", b[1] - a[0], u)
    low, high = np.maximum(np.minimum(t0, t1), 0.0), np.minimum(np.maximum(t0, t1), size)
    step = t1 - t0
    safe = np.where(np.abs(step) > 0.0, step, 1.0)
    gap = np.zeros(len(size))
    for t in (low, high):
        on_b = b[0] + ((t - t0) / safe)[:, None] * other
        gap = np.maximum(gap, np.linalg.norm(on_b - a[0] - t[:, None] * u, axis=1))
    cosine = step / np.maximum(np.linalg.norm(other, axis=1), 1e-300)
    return high - low, gap, cosine


def near_segments(
    first: FloatArray, first_slack: FloatArray, second: FloatArray, second_slack: FloatArray
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs of segments (n, 2, 3) whose boxes, widened by their slack (n,), meet."""
    boxes = []
    for segments, slack in ((first, first_slack), (second, second_slack)):
        low, high = segments.min(axis=1) - slack[:, None], segments.max(axis=1) + slack[:, None]
        boxes.append((low, high, shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])))
    (low1, high1, flat1), (low2, high2, flat2) = boxes
    one, two = shapely.STRtree(flat2).query(flat1)
    keep = (low1[one, 2] <= high2[two, 2]) & (low2[two, 2] <= high1[one, 2])
    return one[keep], two[keep]


def side_contacts(scene: Scene, faces: tuple[FlatFace, ...]) -> tuple[SideContact, ...]:
    """All contacts between sides of two different faces, each pair of faces in one order only.

    Sides with the same two vertices meet. Others meet where they run along each other, no further
    apart than 3 sd, over 20 % of the shorter one and more than twice that tolerance.
    """
    every = sides(faces)
    if not every:
        return ()
    points = scene.points
    segments = points[[(s.start, s.end) for s in every]]
    tolerance = Tolerance.of(scene)
    ends = np.array([(s.start, s.end) for s in every])
    sds = tolerance.vertex_sds[ends].max(axis=1)
    one, two = near_segments(
        segments,
        tolerance.within(sds),
        segments,
        tolerance.within(sds),
    )
    owner = np.array([s.face for s in every])
    keep = owner[one] < owner[two]
    one, two = one[keep], two[keep]
    overlap, gap, cosine = along(
        (segments[one, 0], segments[one, 1]), (segments[two, 0], segments[two, 1])
    )
    size = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    limit = tolerance.within(np.hypot(sds[one], sds[two]))
    least = np.minimum(size[one], size[two])
    shared = (np.sort(ends[one], axis=1) == np.sort(ends[two], axis=1)).all(axis=1)
    meets = shared | ((gap <= limit) & (overlap >= LEAST_OVERLAP * least) & (overlap > 2.0 * limit))
    contacts = []
    for k in np.flatnonzero(meets).tolist():
        i, j = int(one[k]), int(two[k])
        span = segments[i, 1] - segments[i, 0]
        same = bool(shared[k])
        contacts.append(
            SideContact(
                every[i],
                every[j],
                float(size[i] if same else overlap[k]),
                span / max(float(size[i]), 1e-300),
                every[i].start != every[j].start if same else bool(cosine[k] < 0.0),
                every[i] if size[i] <= size[j] else every[j],
            )
        )
    return tuple(contacts)


def edges_along_sides(
    scene: Scene, faces: tuple[FlatFace, ...], edges: Sequence[tuple[int, int]]
) -> tuple[tuple[int, int], ...]:
    """(edge, face) wherever an edge is a side of the face or lies along one, within 3 sd."""
    every = sides(faces)
    if not every or not edges:
        return ()
    points = scene.points
    tolerance = Tolerance.of(scene)
    ends, side_ends = np.array(edges), np.array([(s.start, s.end) for s in every])
    sds = tolerance.vertex_sds[ends].max(axis=1)
    side_sds = tolerance.vertex_sds[side_ends].max(axis=1)
    one, two = near_segments(
        points[ends],
        tolerance.within(sds),
        points[side_ends],
        tolerance.within(side_sds),
    )
    overlap, gap, _ = along(
        (points[ends[one, 0]], points[ends[one, 1]]),
        (points[side_ends[two, 0]], points[side_ends[two, 1]]),
    )
    size = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)[one]
    limit = tolerance.within(np.hypot(sds[one], side_sds[two]))
    same = (np.sort(ends[one], axis=1) == np.sort(side_ends[two], axis=1)).all(axis=1)
    lies = (gap <= limit) & (overlap >= size - 2.0 * limit) & (overlap > 2.0 * limit)
    owner = np.array([s.face for s in every])
    found = np.column_stack([one, owner[two]])[same | lies]
    return tuple(dict.fromkeys((e, f) for e, f in sorted(found.tolist())))


class Touch(NamedTuple):
    """A vertex that lies on a face it is no corner of; `depth` is its distance from the rim.

    The depth is negative, down to the tolerance, for a vertex just outside the outline.
    """

    vertex: int
    face: int
    depth: float


def plane_gaps(scene: Scene, vertices: NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
    """Signed distances (n, faces) of vertices from faces' planes, and 3 sd of each as tolerance."""
    points = scene.points[vertices]
    covs = np.array([v.cov for v in scene.vertices])[vertices]
    levers = np.column_stack([points, np.ones(len(points))])
    normals = np.array([f.plane.normal for f in scene.faces])
    offsets = np.array([f.plane.offset for f in scene.faces])
    plane_covs = np.array([f.plane.cov for f in scene.faces])
    # var d = (p, 1) C (p, 1)ᵀ + nᵀ V n, both as products of flattened squares
    squares = np.einsum("ni,nj->nij", levers, levers).reshape(-1, 16)
    variance = squares @ plane_covs.reshape(-1, 16).T
    outer = np.einsum("fi,fj->fij", normals, normals).reshape(-1, 9)
    variance += covs.reshape(-1, 9) @ outer.T
    limit = Tolerance.of(scene).within(np.sqrt(np.maximum(variance, 0.0)))
    return points @ normals.T + offsets, limit


def touches(
    scene: Scene, faces: tuple[FlatFace, ...], vertices: NDArray[np.intp]
) -> Iterator[Touch]:
    """All of the given vertices that lie on faces within 3 sd of plane and vertex."""
    if not len(vertices) or not faces:
        return
    points = scene.points[vertices]
    tolerance = Tolerance.of(scene)
    gaps, limits = plane_gaps(scene, vertices)
    near = np.abs(gaps) <= limits
    for face in faces:
        rows = np.flatnonzero(near[:, face.index] & ~np.isin(vertices, face.members))
        if not len(rows):
            continue
        flat = face.flatten(points[rows])
        low, high = np.array(face.polygon.bounds).reshape(2, 2)
        slack = tolerance.within(tolerance.vertex_sds[vertices[rows]])
        inside = ((flat >= low - slack[:, None]) & (flat <= high + slack[:, None])).all(axis=1)
        rows, flat, slack = rows[inside], flat[inside], slack[inside]
        if not len(rows):
            continue
        dots = shapely.points(flat)
        outside = shapely.distance(dots, face.polygon)
        rim = shapely.distance(dots, face.polygon.boundary)
        for k in np.flatnonzero(outside <= slack).tolist():
            depth = float(rim[k]) if outside[k] == 0.0 else -float(outside[k])
            yield Touch(int(vertices[rows[k]]), face.index, depth)
