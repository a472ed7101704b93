"""Where faces meet: sides that run along each other, and corners that lie on another face."""

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np
import shapely

from facetlog.perception.batch_linalg import compute_quadratic_forms, dots
from facetlog.perception.flat_faces import cross
from facetlog.perception.ragged import Bools, Indices, find_row_starts
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.outline_overlap import measure_loop_distances
from facetlog.perception.surfaces.plane_table import PlaneTable
from facetlog.perception.surfaces.tolerance import ANGLE_RESOLUTION, SDS
from facetlog.perception.types import FloatArray

__all__ = [
    "Segments",
    "SideContacts",
    "Touches",
    "find_edges_along_sides",
    "find_side_contacts",
    "measure_face_distances",
    "touches",
]

# Two sides adjoin where they run together over this share of the shorter (language vocabulary).
LEAST_OVERLAP = 0.2

Boxes = tuple[FloatArray, FloatArray]

NONE = np.zeros(0, dtype=np.intp)

FEW_PAIRS = 250_000
"""Up to so many pairs of boxes numpy compares all sooner than a tree is made (measured)."""


@dataclass(frozen=True, eq=False, slots=True)
class SideContacts:
    """Pairs (c,) of two faces' sides that run along each other, by the first and the second.

    `first` and `second` are the sides' places, `faces` (c, 2) whose they are. `against` says that
    they run against each other, as two sides of one solid's edge do. They do so over `length`;
    `shorter` is the side that names the contact.

    `turn` is the signed angle by which the solid turns there, radians: > 0 convex, < 0 concave; its
    1σ is `sd`. Two faces back to back turn by π, or by -π: which of them is the same, so it is π.
    """

    first: Indices
    second: Indices
    faces: Indices
    length: FloatArray
    against: Bools
    shorter: Indices
    turn: FloatArray
    sd: FloatArray

    @property
    def back_to_back(self) -> Bools:
        """The two faces lie on each other, within 3 sd: sides of one sheet, or bodies touching."""
        return np.asarray(np.abs(self.turn) >= np.pi - SDS * self.sd - ANGLE_RESOLUTION)

    @property
    def convex(self) -> Bools:
        """The solid bulges, by more than 3 sd."""
        return (self.turn > SDS * self.sd + ANGLE_RESOLUTION) & ~self.back_to_back

    @property
    def concave(self) -> Bools:
        """The solid is hollow, by more than 3 sd."""
        return (self.turn < -SDS * self.sd - ANGLE_RESOLUTION) & ~self.back_to_back

    def take(self, rows: Indices | Bools) -> "SideContacts":
        """Return the chosen rows."""
        return SideContacts(*(getattr(self, field.name)[rows] for field in fields(self)))


def _bends(planes: PlaneTable, faces: Indices, d: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return turns (c,) of the solid where faces (c, 2) meet along unit vectors d (c, 3), and their
    1σ.

    φ = atan2((n1 × n2) · d, n1 · n2). About the edge only the part of a normal's error along d × n
    counts, so var φ = Σ (d × n)ᵀ C (d × n).
    """
    n1, n2 = planes.normals[faces[:, 0]], planes.normals[faces[:, 1]]
    turns = np.arctan2((cross(n1, n2) * d).sum(axis=1), (n1 * n2).sum(axis=1))
    turns[turns < ANGLE_RESOLUTION - np.pi] = np.pi
    variance = np.zeros(len(d))
    for face, n in ((faces[:, 0], n1), (faces[:, 1], n2)):
        axis = cross(d, n)
        variance += compute_quadratic_forms(axis, planes.normal_covs[face])
    return turns, np.sqrt(np.maximum(variance, 0.0))


def _lengths(spans: FloatArray) -> FloatArray:
    """Return lengths (n,) of vectors (n, 3)."""
    lengths: FloatArray = np.sqrt(dots(spans, spans))
    return lengths


def along(
    a: tuple[FloatArray, FloatArray], b: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return for each pair of segments, ends (m, 3) each, the overlap along a, worst gap there,
    cosine; (m,).
    """
    span, other = a[1] - a[0], b[1] - b[0]
    size = _lengths(span)
    u = span / np.maximum(size, 1e-300)[:, None]
    t0 = dots(b[0] - a[0], u)
    t1 = dots(b[1] - a[0], u)
    low, high = np.maximum(np.minimum(t0, t1), 0.0), np.minimum(np.maximum(t0, t1), size)
    step = t1 - t0
    safe = np.where(np.abs(step) > 0.0, step, 1.0)
    gap = np.zeros(len(size))
    for t in (low, high):
        on_b = b[0] + ((t - t0) / safe)[:, None] * other
        gap = np.maximum(gap, _lengths(on_b - a[0] - t[:, None] * u))
    cosine = step / np.maximum(_lengths(other), 1e-300)
    return high - low, gap, cosine


@dataclass(frozen=True, eq=False, slots=True)
class Segments:
    """Segments (n, 2, 3), scene by scene, `counts` (s,) of them each; each with its slack (n,)."""

    ends: FloatArray
    slack: FloatArray
    counts: Indices

    def boxes(self) -> Iterator[Boxes]:
        """Return the boxes round the segments of each scene, widened by the slack: lows and
        highs.
        """
        slack = self.slack[:, None]
        first, second = self.ends[:, 0], self.ends[:, 1]
        low, high = np.minimum(first, second) - slack, np.maximum(first, second) + slack
        cuts = np.cumsum(self.counts)[:-1]
        return zip(np.split(low, cuts), np.split(high, cuts), strict=True)


def find_near_segments(first: Segments, second: Segments) -> tuple[Indices, Indices]:
    """Return pairs of segments of one scene whose boxes meet, by the first."""
    found = [
        _find_meeting_boxes(*boxes) for boxes in zip(first.boxes(), second.boxes(), strict=True)
    ]
    begins = zip(
        find_row_starts(first.counts).tolist(), find_row_starts(second.counts).tolist(), strict=True
    )
    moved = [(one + a, two + b) for (one, two), (a, b) in zip(found, begins, strict=True)]
    return (
        np.concatenate([NONE, *(one for one, _ in moved)]),
        np.concatenate([NONE, *(two for _, two in moved)]),
    )


def _find_meeting_boxes(first: Boxes, second: Boxes) -> tuple[Indices, Indices]:
    (low1, high1), (low2, high2) = first, second
    if len(low1) * len(low2) <= FEW_PAIRS:
        meet = np.ones((len(low1), len(low2)), dtype=np.bool_)
        for axis in range(3):
            meet &= low1[:, axis, None] <= high2[:, axis]
            meet &= low2[:, axis] <= high1[:, axis, None]
        one, two = np.nonzero(meet)
        return one, two
    flat1, flat2 = (shapely.box(*low[:, :2].T, *high[:, :2].T) for low, high in (first, second))
    one, two = shapely.STRtree(flat2).query(flat1)
    keep = (low1[one, 2] <= high2[two, 2]) & (low2[two, 2] <= high1[one, 2])
    one, two = one[keep], two[keep]
    order = np.lexsort((two, one))
    return one[order], two[order]


def find_side_contacts(table: FaceTable) -> SideContacts:
    """Return all contacts between sides of two different faces, each pair of faces in one order
    only.

    Sides with the same two vertices meet. Others meet where they run along each other, no further
    apart than 3 sd, over 20 % of the shorter one and more than twice that tolerance.
    """
    ends, owner, tolerance = table.sides.ends, table.sides.face, table.tolerance
    segments = table.points[ends]
    sds, scene = tolerance.vertex_sds[ends].max(axis=1), table.scene[owner]
    boxed = Segments(segments, tolerance.within(sds, scene), table.side_counts)
    one, two = find_near_segments(boxed, boxed)
    keep = owner[one] < owner[two]
    one, two = one[keep], two[keep]
    overlap, gap, cosine = along(
        (segments[one, 0], segments[one, 1]), (segments[two, 0], segments[two, 1])
    )
    spans = segments[:, 1] - segments[:, 0]
    size = _lengths(spans)
    limit = tolerance.within(np.hypot(sds[one], sds[two]), scene[one])
    least = np.minimum(size[one], size[two])
    same = _have_same_ends(ends[one], ends[two])
    meets = same | ((gap <= limit) & (overlap >= LEAST_OVERLAP * least) & (overlap > 2.0 * limit))
    one, two, same = one[meets], two[meets], same[meets]
    faces = np.column_stack([owner[one], owner[two]])
    directions = spans[one] / np.maximum(size[one], 1e-300)[:, None]
    return SideContacts(
        one,
        two,
        faces,
        np.where(same, size[one], overlap[meets]),
        np.where(same, ends[one, 0] != ends[two, 0], cosine[meets] < 0.0),
        np.where(size[one] <= size[two], one, two),
        *_bends(table.planes, faces, directions),
    )


def _have_same_ends(one: Indices, two: Indices) -> Bools:
    """Return which pairs of vertices (m, 2) are the same, in whichever order."""
    (a, b), (c, d) = one.T, two.T
    same: Bools = ((a == c) & (b == d)) | ((a == d) & (b == c))
    return same


def find_edges_along_sides(table: FaceTable, edges: Indices, counts: Indices) -> Indices:
    """Return (edge, face) (b, 2), ascending, wherever an edge (e, 2) is or lies along a side, by 3
    sd.

    The scenes (s,) have `counts` of the edges each.
    """
    points, ends, tolerance = table.points, table.sides.ends, table.tolerance
    sds = tolerance.vertex_sds[edges].max(axis=1)
    side_sds = tolerance.vertex_sds[ends].max(axis=1)
    scene, side_scene = np.repeat(np.arange(len(counts)), counts), table.scene[table.sides.face]
    one, two = find_near_segments(
        Segments(points[edges], tolerance.within(sds, scene), counts),
        Segments(points[ends], tolerance.within(side_sds, side_scene), table.side_counts),
    )
    overlap, gap, _ = along(
        (points[edges[one, 0]], points[edges[one, 1]]), (points[ends[two, 0]], points[ends[two, 1]])
    )
    size = _lengths(points[edges[:, 1]] - points[edges[:, 0]])[one]
    limit = tolerance.within(np.hypot(sds[one], side_sds[two]), scene[one])
    lies = (gap <= limit) & (overlap >= size - 2.0 * limit) & (overlap > 2.0 * limit)
    lies |= _have_same_ends(edges[one], ends[two])
    count = max(len(table), 1)
    found = np.unique(one[lies] * count + table.sides.face[two[lies]])
    return np.column_stack(np.divmod(found, count))


@dataclass(frozen=True, eq=False, slots=True)
class Touches:
    """Vertices (t,) that lie on faces (t,) they are no corners of, and how far from the rim.

    The depth is negative, down to the tolerance, for a vertex just outside the outline.
    """

    vertex: Indices
    face: Indices
    depth: FloatArray


def touches(table: FaceTable, vertices: Indices, faces: Indices) -> Touches:
    """Return which of these vertices (c,), near the planes of these faces (c,), lie on them, by 3
    sd.
    """
    spokes = table.points[vertices] - table.middles[faces]
    flat = (table.axes[faces] @ spokes[:, :, None])[:, :, 0]
    slack = table.tolerance.within(table.tolerance.vertex_sds[vertices], table.scene[faces])
    low, high = table.flat.min(axis=1), table.flat.max(axis=1)
    within = (flat >= low[faces] - slack[:, None]) & (flat <= high[faces] + slack[:, None])
    inside = within[:, 0] & within[:, 1]
    vertices, faces, flat, slack = vertices[inside], faces[inside], flat[inside], slack[inside]
    outside, rim = measure_face_distances(table, faces, flat[:, None])
    on = outside[:, 0] <= slack
    depth = np.where(outside == 0.0, rim, -outside)[on, 0]
    return Touches(vertices[on], faces[on], depth)


def measure_face_distances(
    table: FaceTable, faces: Indices, where: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return distances (r, q) of points (r, q, 2) from faces (r,), in their planes: outside, from
    the rim.

    The former is 0 within the outline, outside of holes; both are NaN where the face has no area.
    """
    outside, rim = measure_loop_distances(table.flat[faces], table.sizes[faces], where)
    others = np.flatnonzero(~table.convex[faces])
    if len(others):
        shown, of = np.unique(faces[others], return_inverse=True)
        polygons = table.make_face_polygons(shown)[of, None]
        dots = shapely.points(where[others])
        outside[others] = shapely.distance(dots, polygons)
        rim[others] = shapely.distance(dots, shapely.boundary(polygons))
    return outside, rim
