"""Flat regions and the rest of the surface as a scene: shared vertices, edges, faces, objects."""

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from facetlog.perception.flat_faces import compute_vector_area
from facetlog.perception.polygons import triangulate
from facetlog.perception.ragged import Indices, iter_groups, joined, sum_by_group
from facetlog.perception.scene import Body, Edge, Face, Patch, Scene, Vertex
from facetlog.perception.shapes.regions.flat_region import FlatRegion, Rest
from facetlog.perception.shapes.regions.surface_samples import sample_triangles
from facetlog.perception.surfaces.scene_json.scene_checks import find_unsound_faces
from facetlog.perception.surfaces.tolerance import LENGTH_RESOLUTION, SDS, WIDEST
from facetlog.perception.types import FloatArray

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
        shorter = np.concatenate([_measure_shorter_sides(ring) for _, ring in rings])
        return cls(
            np.concatenate([ring for _, ring in rings]),
            np.maximum(sds, LENGTH_RESOLUTION * size),
            np.minimum(SIDE_SHARE * shorter, WIDEST * size),
            np.array([region.body for region in regions], dtype=np.int64)[owner],
            tuple(ends),
            tuple(k for k, _ in rings),
        )

    def merged(self) -> tuple[Indices, tuple[Vertex, ...]]:
        """Return the vertex of each corner, and the vertices: corners within 3 sd are one."""
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
        total = sum_by_group(labels, weights, groups)
        means = sum_by_group(labels, weights[:, None] * self.points, groups) / total[:, None]
        off = ((self.points - means[labels]) ** 2).sum(axis=1)
        spread = sum_by_group(labels, weights * off, groups) / total
        least = np.full(groups, np.inf)
        np.minimum.at(least, labels, self.sds)
        variances = least**2 + spread
        vertices = tuple(
            Vertex(p, v * np.eye(3)) for p, v in zip(means, variances.tolist(), strict=True)
        )
        return labels, vertices

    def add_own_corners(
        self, merged: Sequence[Ring], vertices: Sequence[Vertex], apart: Collection[int]
    ) -> tuple[list[Ring], tuple[Vertex, ...]]:
        """Return the `merged` rings, but for those numbered in `apart`, which have vertices of
        their own behind the others.
        """
        loops = list(merged)
        every = list(vertices)
        for k in sorted(apart):
            loops[k] = tuple(range(len(every), len(every) + len(self.ends[k])))
            every += (
                Vertex(self.points[i], float(self.sds[i]) ** 2 * np.eye(3)) for i in self.ends[k]
            )
        return loops, tuple(every)


def _measure_shorter_sides(ring: FloatArray) -> FloatArray:
    """Return the shorter of the two sides (k,) that end at each corner of a ring (k, 3)."""
    sides = np.sqrt(((np.roll(ring, -1, axis=0) - ring) ** 2).sum(axis=1))
    shorter: FloatArray = np.minimum(sides, np.roll(sides, 1))
    return shorter


def make_faces_with_shared_corners(
    regions: Sequence[FlatRegion], sizes: Mapping[int, float]
) -> tuple[tuple[Face, ...], tuple[Vertex, ...]]:
    """Return the regions as faces in their order, and the vertices, those of the first face first.

    Corners of one object within 3 sd are one vertex; `sizes` are the extents of the objects.
    """
    if not regions:
        return (), ()
    corners = _Rings.of(regions, sizes)
    labels, vertices = corners.merged()
    merged = [_without_repeats(labels[own].tolist()) for own in map(list, corners.ends)]
    # merging would fold these rings, or push a hole across its outline: they keep their own corners
    folded = {k for k, ring in enumerate(merged) if len(ring) < 3 or len(set(ring)) != len(ring)}
    loops, every = corners.add_own_corners(merged, vertices, folded)
    unsound = set(find_unsound_faces(_faces_of(regions, corners, loops), every))
    if unsound:
        folded |= {k for k, owner in enumerate(corners.owners) if owner in unsound}
        loops, every = corners.add_own_corners(merged, vertices, folded)
    return _used(_faces_of(regions, corners, loops), every)


def _faces_of(
    regions: Sequence[FlatRegion], corners: _Rings, loops: Sequence[Ring]
) -> tuple[Face, ...]:
    """Return the faces of the regions, with such loops as rings."""
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
    """Return faces and the vertices that they use, numbered in the order of the faces."""
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
    """Return the ring without corners that repeat the one before.

    >>> _without_repeats([4, 4, 7, 9, 4])
    (7, 9, 4)
    """
    return tuple(a for a, b in zip(ring, (ring[-1], *ring[:-1]), strict=True) if a != b) or (
        ring[0],
    )


# Directions evenly over the sphere: the farthest point to any side is missed by less than .5 % of
# the surface's size (the nearest direction is within 6°).
DIRECTIONS = 256
# Products of points and directions that are held at a time: 2 MB. All of a depth camera's frame at
# once are 600 MB, and most of the time is the system's, which clears them.
BLOCK = 1 << 18


def _directions() -> FloatArray:
    """Return unit vectors (n, 3) along a spiral of golden angles."""
    step = np.arange(DIRECTIONS) + 0.5
    height = 1.0 - 2.0 * step / DIRECTIONS
    angle = np.pi * (3.0 - np.sqrt(5.0)) * step
    radius = np.sqrt(1.0 - height**2)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


def outermost(points: FloatArray, *exactly: FloatArray) -> list[int]:
    """Return the rows of the points (n, 3) that lie farthest out, in many directions evenly over
    the sphere and along each given vector (3,), both ways.

    >>> outermost(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.2, 0.2, 0.2]]))
    [0, 1, 2, 3]
    """
    both = [side for d in exactly for side in (d, -d)]
    sides = np.concatenate([_directions(), *(side[None] for side in both)])
    at_once = max(1, BLOCK // len(points))
    blocks = (sides[k : k + at_once] for k in range(0, len(sides), at_once))
    found: list[int] = np.unique(
        np.concatenate([(block @ points.T).argmax(axis=1) for block in blocks])
    ).tolist()
    return found


# Facts are quadratic in the faces: 300 make some 200,000. What is smaller is kept as a patch.
MOST_FACES = 300
# A face that becomes a patch is sampled at this share of its object's diagonal.
PATCH_SPACING_SHARE = 1 / 128


def assemble_scene(
    name: str,
    regions: Iterable[FlatRegion],
    rest: Rest,
    *,
    up: ArrayLike | None,
    metric: bool,
    whole: bool,
    warnings: Sequence[str] = (),
) -> Scene:
    """Return the scene of flat regions and the rest of the surface, objects as their numbers say.

    Faces come by object and then by area, largest first; corners of an object's faces that lie
    within 3 sd are one vertex. Of each object the 300 largest regions become faces. `whole` says
    that the surface is known from all sides. An object without faces is no body, only a patch: no
    model is judged on it.
    """
    kept, left, said = _largest(list(regions))
    rest = _add_regions(rest, left)
    sizes = _extents(kept, rest)
    faces, vertices = make_faces_with_shared_corners(kept, sizes)
    sides = dict.fromkeys(
        (min(a, b), max(a, b))
        for face in faces
        for ring in (face.outline, *face.holes)
        for a, b in zip(ring, (*ring[1:], ring[0]), strict=True)
    )
    patches, patch_bodies, reaching = _patches(rest, len(vertices), sizes, up)
    faces_of: dict[int, list[int]] = defaultdict(list)
    patches_of: dict[int, list[int]] = defaultdict(list)
    for i, region in enumerate(kept):
        faces_of[region.body].append(i)
    for i, number in enumerate(patch_bodies):
        patches_of[number].append(i)
    bodies = tuple(
        Body(tuple(faces_of[number]), (), tuple(patches_of[number]), whole)
        for number in sorted(faces_of.keys() | patches_of.keys())
        if number >= 0
    )
    if not bodies and kept and all(region.body < 0 for region in kept):
        bodies = (Body(whole=whole),)  # floor and walls alone are no object
    return Scene(
        name,
        vertices=(*vertices, *reaching),
        edges=tuple(Edge(a, b) for a, b in sides),
        faces=faces,
        up=None if up is None else make_unit_vector(up),
        metric=metric,
        warnings=(*warnings, *said),
        patches=patches,
        bodies=bodies,
    )


def _extents(regions: Sequence[FlatRegion], rest: Rest) -> dict[int, float]:
    """Return the diagonal of the box round each object, by its number; -1 is what is of none."""
    points: dict[int, list[FloatArray]] = defaultdict(list)
    for region in regions:
        points[region.body].append(region.outline)
    for own in iter_groups(rest.bodies.astype(np.int64)):
        points[int(rest.bodies[own[0]])].append(rest.points[own])
    return {
        number: float(np.linalg.norm(np.ptp(np.concatenate(parts), axis=0)))
        for number, parts in points.items()
    }


def make_unit_vector(up: ArrayLike) -> FloatArray:
    """Return up (3,) as a unit vector; ValueError where it has no direction."""
    vector = np.asarray(up, dtype=np.float64)
    length = float(np.linalg.norm(vector))
    if not (np.isfinite(length) and length > 0.0):
        raise ValueError("the up axis has no direction")
    unit: FloatArray = vector / length
    return unit


def _area(region: FlatRegion) -> float:
    rings = (region.outline, *region.holes)
    return float(sum(compute_vector_area(ring) @ region.plane.normal for ring in rings))


def _largest(
    regions: list[FlatRegion],
) -> tuple[list[FlatRegion], list[FlatRegion], tuple[str, ...]]:
    """Return regions by body and area, those that are too many, and a warning of these."""
    areas = {id(region): _area(region) for region in regions}
    ordered = sorted(regions, key=lambda region: (region.body, -areas[id(region)]))
    kept: list[FlatRegion] = []
    left: list[FlatRegion] = []
    count, body = 0, None
    for region in ordered:
        count = count + 1 if region.body == body else 1
        body = region.body
        (kept if count <= MOST_FACES else left).append(region)
    if not left:
        return kept, left, ()
    lost, total = sum(areas[id(r)] for r in left), sum(areas.values())
    said = (
        f"of each object the {MOST_FACES} largest faces are kept; the rest ({len(left)} of "
        f"{len(ordered)}, {lost / max(total, 1e-300):.1%} of the flat surface) counts as not flat"
    )
    return kept, left, (said,)


def _patches(
    rest: Rest, count: int, sizes: Mapping[int, float], up: ArrayLike | None
) -> tuple[tuple[Patch, ...], tuple[int, ...], tuple[Vertex, ...]]:
    """Return one patch for each object that has any rest, the objects' numbers, and the extreme
    vertices of the patches, numbered from `count`.
    """
    numbers = np.unique(rest.bodies).astype(int).tolist() if len(rest.points) else []
    exactly = () if up is None else (np.asarray(up, dtype=np.float64),)
    patches: list[Patch] = []
    reaching: list[Vertex] = []
    for number in numbers:
        own = rest.bodies == number
        cov = (LENGTH_RESOLUTION * sizes[number]) ** 2 * np.eye(3)
        points = rest.points[own]
        # points of no area are the noise of faces, and do not extend them
        far = points[rest.areas[own] > 0.0]
        outer = [Vertex(far[i], cov) for i in outermost(far, *exactly)] if len(far) else []
        hull = tuple(range(count + len(reaching), count + len(reaching) + len(outer)))
        patches.append(Patch(points, rest.normals[own], rest.areas[own], hull))
        reaching += outer
    return tuple(patches), tuple(numbers), tuple(reaching)


def _add_regions(rest: Rest, regions: Sequence[FlatRegion]) -> Rest:
    """Return the rest, and points on the regions as well."""
    if not regions:
        return rest
    points, normals, areas, bodies = [rest.points], [rest.normals], [rest.areas], [rest.bodies]
    for region in regions:
        triangles = _triangles(region)
        extent = float(np.linalg.norm(np.ptp(region.outline, axis=0)))
        samples = sample_triangles(triangles, max(PATCH_SPACING_SHARE * extent, 1e-300))
        points.append(samples.points)
        normals.append(np.tile(region.plane.normal, (len(samples.points), 1)))
        areas.append(samples.areas)
        bodies.append(np.full(len(samples.points), float(region.body)))
    return Rest(*(np.concatenate(parts) for parts in (points, normals, areas, bodies)))


def _triangles(region: FlatRegion) -> FloatArray:
    """Return triangles (m, 3, 3) that fill a region, its holes left open."""
    frame = region.frame
    return frame.lift(triangulate(frame.polygon(region.outline, region.holes)))
