"""All faces of a scene as arrays: what most facts are worked out from, for all at once.

Corners, sides and members of the faces stand end to end, face by face; `row_table` and `sum_rows`
put them in rows. Areas, middles and their derivatives are those of polygons in the faces' planes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.flat_faces import FlatFace, cross, make_plane_axes
from facetlog.perception.ragged import (
    Bools,
    Indices,
    find_entries_of_rows,
    find_row_starts,
    row_table,
    stacked,
    sum_rows,
)
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.outline_overlap import find_convex_loops, make_valid_polygons
from facetlog.perception.surfaces.plane_table import PlaneTable
from facetlog.perception.surfaces.tolerance import Tolerance
from facetlog.perception.types import FloatArray

__all__ = ["FaceTable", "Members", "Sides", "flat_faces"]

# A face with less area than this share of its extent, squared, has no middle to speak of.
LEAST_AREA = 1e-9


@dataclass(frozen=True, eq=False, slots=True)
class Sides:
    """All sides (s,) of all rings, as these run: outlines counter-clockwise, holes clockwise.

    `face` is whose they are, `ends` (s, 2) are vertices, `in_hole` says that the ring is a hole;
    `lengths` (r,) are how many sides each ring has.
    """

    face: Indices
    ends: Indices
    in_hole: Bools
    lengths: Indices


@dataclass(frozen=True, eq=False, slots=True)
class Members:
    """All faces' vertices, each once, the outline's first; and how the faces answer to them.

    `vertex` (m,), of face `face` (m,), `counts` (f,) a face. `area_slope` (m, 3) and
    `middle_slope` (m, 3, 3) are the derivatives of area and middle.
    """

    vertex: Indices
    face: Indices
    counts: Indices
    area_slope: FloatArray
    middle_slope: FloatArray


@dataclass(frozen=True, eq=False)
class FaceTable:
    """The vertices (n,) and flat faces (f,) of a scene.

    `points` (n, 3) and `covs` (n, 3, 3) are the vertices'. `outlines` (f, k) are vertices, where
    `there` (f, k); `flat` (f, k, 2) their coordinates from `middles` (f, 3) along `axes`
    (f, 2, 3), as are `corners` (c, 2) of all rings, and `polygons` (f,). `convex` (f,) are faces
    without holes whose outline turns left at every corner.
    """

    points: FloatArray
    covs: FloatArray
    tolerance: Tolerance
    planes: PlaneTable
    sides: Sides
    members: Members
    outlines: Indices
    there: Bools
    flat: FloatArray
    middles: FloatArray
    axes: FloatArray
    areas: FloatArray
    convex: Bools
    corners: FloatArray

    @classmethod
    def of(cls, scene: Scene) -> "FaceTable":
        """Return the faces of a scene, in order."""
        points = stacked([v.point for v in scene.vertices], 3)
        covs = stacked([v.cov for v in scene.vertices], 3, 3)
        planes = PlaneTable.of(scene)
        sides = _sides(scene, points, planes)
        normals, count = planes.normals, len(planes.offsets)
        corner, face = sides.ends[:, 0], sides.face
        place, there = _find_outline_places(sides, count)
        outlines, sizes = corner[place], there.sum(axis=1)
        loops = points[outlines]

        spans = np.where(there[..., None], points[sides.ends[place, 1]] - loops, 0.0)
        longest = (spans * spans).sum(axis=2).argmax(axis=1) if count else np.zeros(0, np.intp)
        axes = make_plane_axes(normals, spans[np.arange(count), longest])
        starts = np.where(there[..., None], loops, 0.0).sum(axis=1) / sizes[:, None]
        flat = _project_to_faces(points[corner] - starts[face], axes[face])

        before, after = _neighbours(sides.lengths)
        corners = np.bincount(face, minlength=count)
        areas, moments, area_slope, moment_slope = _compute_moments(flat, before, after, corners)
        extents = np.ptp(flat[place], axis=1).max(axis=1) if count else np.zeros(0)
        # A loop that crosses itself may have no area left, or its middle far outside.
        sound = (areas > LEAST_AREA * extents**2) & (np.abs(moments).max(axis=1) <= extents * areas)
        size = np.where(sound, areas, 1.0)[:, None]
        shift = np.where(sound[:, None], moments / size, 0.0)
        middles = starts + (shift[:, :, None] * axes).sum(axis=1)

        row, vertex, counts = _members(sides, corner, count)
        owner = np.repeat(np.arange(count), counts)
        own_area, own_moment = area_slope, moment_slope
        if len(vertex) < len(corner):
            own_area, own_moment = np.zeros((len(vertex), 2)), np.zeros((len(vertex), 2, 2))
            np.add.at(own_area, row, area_slope)
            np.add.at(own_moment, row, moment_slope)
        # d(M / A) = (dM - M / A dA) / A
        slope = own_moment - shift[owner][:, :, None] * own_area[:, None]
        slope /= size[owner][:, :, None]
        outer = np.arange(len(vertex)) - np.repeat(find_row_starts(counts), counts) < sizes[owner]
        mean = np.where(outer, 1.0 / sizes[owner], 0.0)[:, None, None]
        slope = np.where(sound[owner][:, None, None], slope, mean * np.eye(2))
        # Within the plane the middle moves like that, across it with the mean of the outline.
        frames = axes[owner]
        in_space = frames.transpose(0, 2, 1) @ slope @ frames
        in_space += mean * (normals[:, :, None] * normals[:, None])[owner]
        own_slope = (own_area[:, None] @ frames)[:, 0]

        flat = flat - shift[face]
        convex = find_convex_loops(flat[place], sizes) & (corners == sizes)
        members = Members(vertex, owner, counts, own_slope, in_space)
        areas = np.maximum(areas, 0.0)
        return cls(
            points,
            covs,
            Tolerance.of(scene, points, covs),
            planes,
            sides,
            members,
            outlines,
            there,
            flat[place],
            middles,
            axes,
            areas,
            convex,
            flat,
        )

    def __len__(self) -> int:
        return len(self.areas)

    @property
    def sizes(self) -> Indices:
        """Number of corners (f,) of each outline."""
        return np.asarray(self.there.sum(axis=1), dtype=np.intp)

    @cached_property
    def polygons(self) -> NDArray[np.object_]:
        """The faces as valid polygons (f,) in their planes, empty where they have no area."""
        return self.make_face_polygons(np.arange(len(self)))

    def make_face_polygons(self, chosen: Indices) -> NDArray[np.object_]:
        """Return the polygons of chosen faces (r,)."""
        lengths, ring_of = self.sides.lengths, self._ring_of
        rings = np.bincount(ring_of, minlength=len(self))
        corner = find_entries_of_rows(self._corner_counts, chosen)
        owner = np.repeat(np.arange(len(chosen)), rings[chosen])
        return make_valid_polygons(
            self.corners[corner],
            lengths[find_entries_of_rows(rings, chosen)],
            owner,
            self.convex[chosen],
        )

    @property
    def _ring_of(self) -> Indices:
        return np.asarray(self.sides.face[find_row_starts(self.sides.lengths)])

    @property
    def _corner_counts(self) -> Indices:
        return np.bincount(self.sides.face, minlength=len(self))

    @cached_property
    def faces(self) -> tuple[FlatFace, ...]:
        """The faces one by one."""
        return _faces(self)

    def find_member_rows(self, chosen: Sequence[int] | Indices) -> tuple[Indices, Indices]:
        """Return (place among `chosen`, vertex) (c,) each, of all members of some faces."""
        picked = np.asarray(chosen, dtype=np.intp)
        rows = find_entries_of_rows(self.members.counts, picked)
        counts = self.members.counts[picked]
        return np.repeat(np.arange(len(picked)), counts), self.members.vertex[rows]


def flat_faces(scene: Scene) -> tuple[FlatFace, ...]:
    """Return every face of the scene as a polygon in its plane, in order."""
    return FaceTable.of(scene).faces


def _project_to_faces(spokes: FloatArray, axes: FloatArray) -> FloatArray:
    flat: FloatArray = (axes @ spokes[:, :, None])[:, :, 0]
    return flat


def _neighbours(lengths: Indices) -> tuple[Indices, Indices]:
    """Return places of the corners before and after each (c,), round their rings."""
    place = np.arange(int(lengths.sum()))
    starts = find_row_starts(lengths)
    before, after = place - 1, place + 1
    before[starts] = starts + lengths - 1
    after[starts + lengths - 1] = starts
    return before, after


def _sides(scene: Scene, points: FloatArray, planes: PlaneTable) -> Sides:
    """Return the sides of all rings of three corners and more, turned as they should run."""
    rings = [
        (nth, ring, inner > 0)
        for nth, face in enumerate(scene.faces)
        for inner, ring in enumerate((face.outline, *face.holes))
        if len(ring) > 2
    ]
    lengths = np.array([len(ring) for _, ring, _ in rings], dtype=np.intp)
    owner = np.array([nth for nth, _, _ in rings], dtype=np.intp)
    hole = np.array([inner for _, _, inner in rings], dtype=np.bool_)
    corner = np.fromiter(
        chain.from_iterable(ring for _, ring, _ in rings), np.intp, int(lengths.sum())
    )
    _, after = _neighbours(lengths)
    starts = find_row_starts(lengths)
    spokes = points[corner] - np.repeat(points[corner[starts]], lengths, axis=0)
    turn = sum_rows(cross(spokes, spokes[after]), lengths)
    rise = (turn * planes.normals[owner]).sum(axis=1)
    turned = np.where(hole, -rise, rise) < 0.0
    step = np.arange(len(corner)) - np.repeat(starts, lengths)
    back = np.where(step > 0, np.repeat(lengths, lengths) - step, 0)
    corner = corner[np.repeat(starts, lengths) + np.where(np.repeat(turned, lengths), back, step)]
    ends = np.column_stack([corner, corner[after]])
    return Sides(np.repeat(owner, lengths), ends, np.repeat(hole, lengths), lengths)


def _find_outline_places(sides: Sides, count: int) -> tuple[Indices, Bools]:
    """Return places (f, k) of the outlines' corners, and which are there (f, k)."""
    outer = np.flatnonzero(~sides.in_hole)
    places, there = row_table(np.bincount(sides.face[outer], minlength=count))
    return outer[places], there


def _compute_moments(
    flat: FloatArray, before: Indices, after: Indices, corners: Indices
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return areas A (f,) and moments M (f, 2); at each corner ∂A/∂p (c, 2) and ∂M/∂p (c, 2, 2).

    With ci = xi yi+1 - xi+1 yi:  A = ½ Σ ci  and  M = 1/6 Σ (pi + pi+1) ci; the middle is M / A.
    """
    previous, following = flat[before], flat[after]
    c = flat[:, 0] * following[:, 1] - flat[:, 1] * following[:, 0]
    turned = np.array([[0.0, -1.0], [1.0, 0.0]])  # (x, y) to (y, -x)
    # ∂ci/∂pi is pi+1 turned, ∂ci-1/∂pi is pi-1 turned the other way
    to_after, to_before = following @ turned, -(previous @ turned)
    slope = (flat + following)[:, :, None] * to_after[:, None]
    slope += (previous + flat)[:, :, None] * to_before[:, None]
    slope += (c + c[before])[:, None, None] * np.eye(2)
    moments = sum_rows(c[:, None] * (flat + following), corners) / 6.0
    return 0.5 * sum_rows(c, corners), moments, 0.5 * (to_after + to_before), slope / 6.0


def _members(sides: Sides, corner: Indices, count: int) -> tuple[Indices, Indices, Indices]:
    """Return the member (c,) that each corner is; vertices (m,) of the members, and how many a
    face.
    """
    every = np.arange(len(corner))
    if not sides.in_hole.any():
        return every, corner, np.bincount(sides.face, minlength=count)
    keys = sides.face * (int(corner.max()) + 1) + corner
    _, first, place = np.unique(keys, return_index=True, return_inverse=True)
    kept = np.sort(first)
    row = np.searchsorted(kept, first[place])
    return row, corner[kept], np.bincount(sides.face[kept], minlength=count)


def _faces(table: FaceTable) -> tuple[FlatFace, ...]:
    """Return the faces one by one."""
    sides, members = table.sides, table.members
    corner = sides.ends[:, 0].tolist()
    rings: list[list[tuple[int, ...]]] = [[] for _ in range(len(table))]
    ends = np.cumsum(sides.lengths)
    for start, end in zip((ends - sides.lengths).tolist(), ends.tolist(), strict=True):
        rings[sides.face[start]].append(tuple(corner[start:end]))
    vertex = members.vertex.tolist()
    starts, counts = find_row_starts(members.counts), members.counts
    return tuple(
        FlatFace(
            nth,
            tuple(rings[nth]),
            tuple(vertex[low:high]),
            table.planes.normals[nth],
            table.middles[nth],
            members.middle_slope[low:high],
            table.axes[nth],
            area,
            members.area_slope[low:high],
            table.polygons[nth],
        )
        for nth, (low, high, area) in enumerate(
            zip(starts.tolist(), (starts + counts).tolist(), table.areas.tolist(), strict=True)
        )
    )
