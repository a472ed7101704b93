"""Triangulation of polygons in space: concave ones, not quite flat ones, and with holes.

A fan is right for convex polygons alone; the others are cut by ear clipping (mapbox_earcut) on
their best plane. The triangles do not depend on which corner a polygon begins with, up to ties.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mapbox_earcut
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.flat_faces import cross
from facetlog.perception.ragged import Indices
from facetlog.perception.types import FloatArray


def strip_triangles(corners: Sequence[int] | Indices) -> Indices:
    """Return the triangles (n - 2, 3) of a strip; every other one is turned round.

    >>> strip_triangles([0, 1, 2, 3]).tolist()
    [[0, 1, 2], [2, 1, 3]]
    """
    strip = np.asarray(corners, dtype=np.int64)
    triangles = np.stack((strip[:-2], strip[1:-1], strip[2:]), axis=1) if len(strip) > 2 else None
    if triangles is None:
        return np.zeros((0, 3), dtype=np.int64)
    triangles[1::2, :2] = triangles[1::2, 1::-1]
    return triangles


def fan_triangles(corners: Sequence[int] | Indices) -> Indices:
    """Return the triangles (n - 2, 3) round the first corner.

    >>> fan_triangles([4, 5, 6, 7]).tolist()
    [[4, 5, 6], [4, 6, 7]]
    """
    fan = np.asarray(corners, dtype=np.int64)
    if len(fan) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    return np.stack((np.full(len(fan) - 2, fan[0]), fan[1:-1], fan[2:]), axis=1)


# Coordinates beyond this overflow when they are multiplied three times, as a volume is.
HUGE = 1e75

# Corners that turn by less (sine) are straight: rounding of 32-bit coordinates.
STRAIGHT = 1e-6
# A normal below this share of the squared perimeter is that of no area: rounding of doubles.
NO_AREA = 1e-12
# Triangles of simple polygons have the polygon's area, up to rounding.
SAME_AREA = 1e-6
# Twelve arrays of three doubles for each corner: some 100 MB.
CORNERS_AT_ONCE = 400_000


@dataclass(frozen=True, eq=False, slots=True)
class Triangulation:
    """Triangles (m, 3) of indices; how many faces have fewer than three corners or cross
    themselves.
    """

    triangles: Indices
    narrow: int = 0
    crossing: int = 0

    @property
    def warnings(self) -> tuple[str, ...]:
        said = []
        if self.narrow:
            said.append(f"{self.narrow} faces have fewer than three corners and are left out")
        if self.crossing:
            said.append(
                f"{self.crossing} faces cross themselves: their triangles may cover other areas"
            )
        return tuple(said)


def is_sound(points: FloatArray) -> NDArray[np.bool_]:
    """Return which points (n, 3) are finite, and so small that volumes do not overflow."""
    with np.errstate(invalid="ignore"):
        sound: NDArray[np.bool_] = np.all(np.abs(points) < HUGE, axis=1)
    return sound


def triangulate(points: FloatArray, corners: Indices, sizes: Indices) -> Triangulation:
    """Return the triangles of polygons, whose `corners` (sum of sizes,) index `points` (n, 3).

    A polygon with a missing or infinite corner gives triangles of missing corners (-1).
    """
    sizes = np.asarray(sizes, dtype=np.int64)
    corners = np.asarray(corners, dtype=np.int64)
    if (sizes == 3).all():
        return Triangulation(corners.reshape(-1, 3))
    starts = np.cumsum(sizes) - sizes
    sound = is_sound(points)
    triangles: list[Indices] = [np.zeros((0, 3), dtype=np.int64)]
    owners: list[Indices] = [np.zeros(0, dtype=np.int64)]
    crossing = 0
    for rows in _iter_same_size_blocks(sizes):
        size = int(sizes[rows[0]])
        rings = corners[starts[rows][:, None] + np.arange(size)]
        there = (rings >= 0) & (rings < len(points))
        whole = there.all(axis=1)
        whole[whole] = sound[rings[whole]].all(axis=1)
        first = np.full(len(rows), -1)
        first[whole] = _fan_starts(points[rings[whole]])
        fans = first >= 0
        turned = _roll_rings(rings[fans], first[fans])
        steps = np.arange(1, size - 1)
        fan = np.stack(
            (np.repeat(turned[:, :1], size - 2, axis=1), turned[:, steps], turned[:, steps + 1]), -1
        )
        broken = rows[~whole]
        triangles += [fan.reshape(-1, 3), np.full((len(broken) * (size - 2), 3), -1)]
        owners += [np.repeat(rows[fans], size - 2), np.repeat(broken, size - 2)]
        others = whole & ~fans
        for row, ring in zip(rows[others], rings[others], strict=True):
            cut, crosses = _clip_ears(points, [ring])
            triangles.append(cut)
            owners.append(np.full(len(cut), row))
            crossing += crosses
    order = np.argsort(np.concatenate(owners), kind="stable")
    return Triangulation(np.concatenate(triangles)[order], int((sizes < 3).sum()), crossing)


def _iter_same_size_blocks(sizes: Indices) -> Iterator[Indices]:
    """Yield rows of polygons with as many corners each, never more corners than fit into memory."""
    order = np.argsort(sizes, kind="stable")
    order = order[sizes[order] >= 3]
    for rows in np.split(order, np.flatnonzero(np.diff(sizes[order])) + 1):
        if len(rows):
            step = max(1, CORNERS_AT_ONCE // int(sizes[rows[0]]))
            for start in range(0, len(rows), step):
                yield rows[start : start + step]


def triangulate_rings(points: FloatArray, rings: Sequence[Indices]) -> Triangulation:
    """Return the triangles of one polygon: its outline, and the outlines of its holes."""
    if not rings or len(rings[0]) < 3:
        return Triangulation(np.zeros((0, 3), dtype=np.int64), 1)
    kept = [np.asarray(ring, dtype=np.int64) for ring in rings if len(ring) >= 3]
    every = np.concatenate(kept)
    there = (every >= 0) & (every < len(points))
    if not there.all() or not is_sound(points[every]).all():
        return Triangulation(np.full((len(kept[0]) - 2, 3), -1))
    triangles, crosses = _clip_ears(points, kept)
    return Triangulation(triangles, 0, int(crosses))


def _fan_starts(rings: FloatArray) -> Indices:
    """Return which corner of each polygon (m, n, 3) sees all others without a straight angle beside
    it: of several the one nearest to their middle; -1 where no fan is right.
    """
    if rings.shape[1] == 3:
        return np.zeros(len(rings), dtype=np.int64)
    normals, _ = _compute_area_vectors(rings)
    after = np.roll(rings, -1, axis=1) - rings
    before = np.roll(after, 1, axis=1)
    lengths = np.linalg.norm(after, axis=2)
    scale = lengths * np.roll(lengths, 1, axis=1)
    sine = np.einsum("ijk,ik->ij", cross(before, after), normals)
    cosine = np.einsum("ijk,ijk->ij", before, after)
    left = sine > STRAIGHT * scale
    straight = (np.abs(sine) <= STRAIGHT * scale) & (cosine > 0.0)
    total = np.arctan2(sine, cosine).sum(axis=1)
    convex = (left | straight).all(axis=1) & (np.abs(total - 2.0 * np.pi) < 1.0)
    beside = np.roll(left, 1, axis=1) & np.roll(left, -1, axis=1)
    if rings.shape[1] == 4:
        # the diagonal of a quadrilateral with one inward corner begins there
        inward = ~left & ~straight
        one = (inward.sum(axis=1) == 1) & (np.abs(total - 2.0 * np.pi) < 1.0)
        convex |= one
        beside = np.where(one[:, None], inward, beside)
    usable = beside & convex[:, None]
    first = np.argmin(np.where(usable, _compute_middle_distances(rings), np.inf), axis=1)
    return np.where(usable.any(axis=1), first, -1)


def _compute_area_vectors(rings: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return unit normals (m, 3) and areas (m,) of rings (m, n, 3): Newell's method, about the
    middle.
    """
    about = rings - rings.mean(axis=1, keepdims=True)
    following = np.roll(about, -1, axis=1)
    summed = cross(about, following).sum(axis=1)
    lengths = np.linalg.norm(summed, axis=1)
    return summed / np.where(lengths > 0.0, lengths, 1.0)[:, None], 0.5 * lengths


def _compute_middle_distances(rings: FloatArray) -> FloatArray:
    distances: FloatArray = np.linalg.norm(rings - rings.mean(axis=1, keepdims=True), axis=2)
    return distances


def _roll_rings(rings: Indices, first: Indices) -> Indices:
    """Return rings (m, n) turned round so that each begins with its corner `first` (m,)."""
    columns = (np.arange(rings.shape[1]) + first[:, None]) % rings.shape[1]
    return np.take_along_axis(rings, columns, axis=1)


def _clip_ears(points: FloatArray, rings: Sequence[Indices]) -> tuple[Indices, bool]:
    """Return triangles (m, 3) of one polygon by its rings, and whether it crosses itself."""
    outline = points[rings[0]]
    normals, areas = _compute_area_vectors(outline[None])
    normal, area = normals[0], float(areas[0])
    perimeter = float(np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1).sum())
    if not area > NO_AREA * perimeter**2:
        normal = np.linalg.svd(outline - outline.mean(axis=0), full_matrices=False)[2][2]
    start = int(np.argmin(_compute_middle_distances(outline[None])))
    order = np.concatenate((np.roll(rings[0], -start), *rings[1:]))
    # axes in the plane: of a frame turned so that its last axis is the normal
    _, _, axes = np.linalg.svd(normal[None])
    flat = (points[order] - outline.mean(axis=0)) @ axes[1:].T
    ends = np.cumsum([len(ring) for ring in rings]).astype(np.uint32)
    cut = mapbox_earcut.triangulate_float64(np.ascontiguousarray(flat), ends)
    if not len(cut):
        return fan_triangles(rings[0]), False  # without area
    triangles: Indices = order[cut.astype(np.int64).reshape(-1, 3)]
    a, b, c = (points[triangles[:, k]] for k in range(3))
    signed = 0.5 * cross(b - a, c - a) @ normal
    if signed.sum() < 0.0:
        triangles, signed = triangles[:, ::-1], -signed
    holes = [abs(_signed_area(points[ring], normal)) for ring in rings[1:]]
    meant = abs(_signed_area(outline, normal)) - sum(holes)
    return triangles, bool(abs(float(np.abs(signed).sum()) - meant) > SAME_AREA * perimeter**2)


def _signed_area(ring: FloatArray, normal: FloatArray) -> float:
    about = ring - ring.mean(axis=0)
    return 0.5 * float(cross(about, np.roll(about, -1, axis=0)).sum(axis=0) @ normal)
