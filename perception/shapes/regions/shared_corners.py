"""Regions as faces that share vertices: corners that lie as near as they are uncertain are one."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from facetlog.perception.ragged import Indices, group_sums, joined
from facetlog.perception.scene import Face, Vertex
from facetlog.perception.shapes.regions.flat_region import FlatRegion
from facetlog.perception.surfaces.scene_json.scene_checks import unsound_faces
from facetlog.perception.surfaces.tolerance import LENGTH_RESOLUTION, SDS, WIDEST
from facetlog.perception.types import FloatArray

__all__ = ["faces_with_shared_corners"]

# Corners are not merged over more than this share of a side that ends there: a thin board keeps its
# rim.
SIDE_SHARE = 0.25

Ring = tuple[int, ...]


@dataclass(frozen=True, eq=False, slots=True)
class _Rings:
    """Corners of all rings of all regions, one after the other.

    `points` (n, 3), `sds` (n,), `slacks` (n,) how far each may move, `bodies` (n,); `ends` number
    the corners of each ring, and `owners` say which region each ring is of, the outline's first.
    """

    points: FloatArray
    sds: FloatArray
    slacks: FloatArray
    bodies: Indices
    ends: tuple[range, ...]
    owners: tuple[int, ...]

    @classmethod
    def of(cls, regions: Sequence[FlatRegion], sizes: Mapping[int, float]) -> "_Rings":
        rings = [
            (k, r) for k, region in enumerate(regions) for r in (region.outline, *region.holes)
        ]
        ends, start = [], 0
        for _, ring in rings:
            ends.append(range(start, start + len(ring)))
            start += len(ring)
        owner = np.repeat([k for k, _ in rings], [len(ring) for _, ring in rings])
        size = np.array([sizes[region.body] for region in regions])[owner]
        sds = np.array([region.corner_sd for region in regions])[owner]
        shorter = np.concatenate([_shorter_sides(ring) for _, ring in rings])
        return cls(
            np.concatenate([ring for _, ring in rings]),
            np.maximum(sds, LENGTH_RESOLUTION * size),
            np.minimum(SIDE_SHARE * shorter, WIDEST * size),
            np.array([region.body for region in regions], dtype=np.int64)[owner],
            tuple(ends),
            tuple(k for k, _ in rings),
        )

    def merged(self) -> tuple[Indices, tuple[Vertex, ...]]:
        """The vertex of each corner, and the vertices: corners within 3 sd are one."""
        tree = cKDTree(self.points)
        reach = np.minimum(SDS * np.sqrt(2.0) * self.sds, self.slacks)
        pairs = tree.query_pairs(float(reach.max()), output_type="ndarray")
        one, two = pairs.T
        gaps = np.sqrt(((self.points[one] - self.points[two]) ** 2).sum(axis=1))
        limits = np.minimum(SDS * np.hypot(self.sds[one], self.sds[two]), self.slacks[pairs].min(1))
        near = (gaps <= limits) & (self.bodies[one] == self.bodies[two])
        groups, labels = joined(len(self.points), pairs[near])
        # the more certain corner counts for more: weights 1 / sd²
        weights = self.sds**-2.0
        total = group_sums(labels, weights, groups)
        means = group_sums(labels, weights[:, None] * self.points, groups) / total[:, None]
        off = ((self.points - means[labels]) ** 2).sum(axis=1)
        spread = group_sums(labels, weights * off, groups) / total
        least = np.full(groups, np.inf)
        np.minimum.at(least, labels, self.sds)
        variances = least**2 + spread
        vertices = tuple(
            Vertex(p, v * np.eye(3)) for p, v in zip(means, variances.tolist(), strict=True)
        )
        return labels, vertices

    def with_own(
        self, merged: Sequence[Ring], vertices: Sequence[Vertex], apart: Collection[int]
    ) -> tuple[list[Ring], tuple[Vertex, ...]]:
        """The `merged` rings, but for those numbered in `apart`, which have vertices of their own
        behind the others.
        """
        loops = list(merged)
        every = list(vertices)
        for k in sorted(apart):
            loops[k] = tuple(range(len(every), len(every) + len(self.ends[k])))
            every += (
                Vertex(self.points[i], float(self.sds[i]) ** 2 * np.eye(3)) for i in self.ends[k]
            )
        return loops, tuple(every)


def _shorter_sides(ring: FloatArray) -> FloatArray:
    """The shorter of the two sides (k,) that end at each corner of a ring (k, 3)."""
    sides = np.sqrt(((np.roll(ring, -1, axis=0) - ring) ** 2).sum(axis=1))
    shorter: FloatArray = np.minimum(sides, np.roll(sides, 1))
    return shorter


def faces_with_shared_corners(
    regions: Sequence[FlatRegion], sizes: Mapping[int, float]
) -> tuple[tuple[Face, ...], tuple[Vertex, ...]]:
    """The regions as faces in their order, and the vertices, those of the first face first.

    Corners of one object within 3 sd are one vertex; `sizes` are the extents of the objects.
    """
    if not regions:
        return (), ()
    corners = _Rings.of(regions, sizes)
    labels, vertices = corners.merged()
    merged = [_without_repeats(labels[own].tolist()) for own in map(list, corners.ends)]
    # merging would fold these rings, or push a hole across its outline: they keep their own corners
    folded = {k for k, ring in enumerate(merged) if len(ring) < 3 or len(set(ring)) != len(ring)}
    loops, every = corners.with_own(merged, vertices, folded)
    unsound = set(unsound_faces(_faces_of(regions, corners, loops), every))
    if unsound:
        folded |= {k for k, owner in enumerate(corners.owners) if owner in unsound}
        loops, every = corners.with_own(merged, vertices, folded)
    return _used(_faces_of(regions, corners, loops), every)


def _faces_of(
    regions: Sequence[FlatRegion], corners: _Rings, loops: Sequence[Ring]
) -> tuple[Face, ...]:
    """The faces of the regions, with such loops as rings."""
    rings: list[list[Ring]] = [[] for _ in regions]
    for loop, owner in zip(loops, corners.owners, strict=True):
        rings[owner].append(loop)
    return tuple(
        Face(outer, region.plane, tuple(holes))
        for region, (outer, *holes) in zip(regions, rings, strict=True)
    )


def _used(
    faces: tuple[Face, ...], vertices: tuple[Vertex, ...]
) -> tuple[tuple[Face, ...], tuple[Vertex, ...]]:
    """Faces and the vertices that they use, numbered in the order of the faces."""
    new: dict[int, int] = {}
    for face in faces:
        for ring in (face.outline, *face.holes):
            for i in ring:
                new.setdefault(i, len(new))
    renamed = tuple(
        replace(
            face,
            outline=tuple(new[i] for i in face.outline),
            holes=tuple(tuple(new[i] for i in ring) for ring in face.holes),
        )
        for face in faces
    )
    return renamed, tuple(vertices[i] for i in new)


def _without_repeats(ring: Sequence[int]) -> Ring:
    """The ring without corners that repeat the one before.

    >>> _without_repeats([4, 4, 7, 9, 4])
    (7, 9, 4)
    """
    return tuple(a for a, b in zip(ring, (ring[-1], *ring[:-1]), strict=True) if a != b) or (
        ring[0],
    )
