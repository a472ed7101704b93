"""Flat regions and the rest of the surface as a scene: shared vertices, edges, faces, objects."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from facetlog.perception.flat_faces import plane_axes, vector_area
from facetlog.perception.grouped import Indices, group_sums, joined
from facetlog.perception.scene import Body, Edge, Face, Patch, Scene, Vertex
from facetlog.perception.shapes.regions.flat_region import FlatRegion, Rest
from facetlog.perception.shapes.regions.outermost_points import outermost
from facetlog.perception.shapes.regions.surface_samples import sample_triangles
from facetlog.perception.surfaces.tolerance import LENGTH_RESOLUTION, SDS, WIDEST
from facetlog.perception.types import FloatArray

__all__ = ["MOST_FACES", "assemble_scene", "unit_vector"]

# Facts are quadratic in the faces: 300 make some 200,000. What is smaller is kept as a patch.
MOST_FACES = 300
# Corners are not merged over more than this share of a side that ends there: a thin board keeps its
# rim.
SIDE_SHARE = 0.25
# A face that becomes a patch is sampled at this share of its object's diagonal.
PATCH_SPACING_SHARE = 1 / 128

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
    def of(cls, regions: Sequence[FlatRegion], size: float) -> "_Rings":
        rings = [
            (k, r) for k, region in enumerate(regions) for r in (region.outline, *region.holes)
        ]
        ends, start = [], 0
        for _, ring in rings:
            ends.append(range(start, start + len(ring)))
            start += len(ring)
        owner = np.repeat([k for k, _ in rings], [len(ring) for _, ring in rings])
        sds = np.array([max(r.corner_sd, LENGTH_RESOLUTION * size) for r in regions])[owner]
        shorter = np.concatenate([_shorter_sides(ring) for _, ring in rings])
        return cls(
            np.concatenate([ring for _, ring in rings]),
            sds,
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


def _shorter_sides(ring: FloatArray) -> FloatArray:
    """The shorter of the two sides (k,) that end at each corner of a ring (k, 3)."""
    sides = np.sqrt(((np.roll(ring, -1, axis=0) - ring) ** 2).sum(axis=1))
    shorter: FloatArray = np.minimum(sides, np.roll(sides, 1))
    return shorter


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
    """The scene of flat regions and the rest of the surface, objects as their numbers say.

    Faces come by object and then by area, largest first; corners of an object's faces that lie
    within 3 sd are one vertex. Of each object the 300 largest regions become faces. `whole` says
    that the surface is known from all sides. An object without faces is no body, only a patch: no
    model is judged on it.
    """
    kept, left, said = _largest(list(regions))
    rest = _with_regions(rest, left)
    everything = np.concatenate([*(r.outline for r in kept), rest.points.reshape(-1, 3)])
    size = float(np.linalg.norm(np.ptp(everything, axis=0))) if len(everything) else 0.0
    faces, vertices = _faces(kept, size)
    sides = dict.fromkeys(
        (min(a, b), max(a, b))
        for face in faces
        for ring in (face.outline, *face.holes)
        for a, b in zip(ring, (*ring[1:], ring[0]), strict=True)
    )
    patches, patch_bodies, reaching = _patches(rest, len(vertices), size, up)
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
    return Scene(
        name,
        vertices=(*vertices, *reaching),
        edges=tuple(Edge(a, b) for a, b in sides),
        faces=faces,
        up=None if up is None else unit_vector(up),
        metric=metric,
        warnings=(*warnings, *said),
        patches=patches,
        bodies=bodies,
    )


def unit_vector(up: ArrayLike) -> FloatArray:
    """Up (3,) as a unit vector; ValueError where it has no direction."""
    vector = np.asarray(up, dtype=np.float64)
    length = float(np.linalg.norm(vector))
    if not (np.isfinite(length) and length > 0.0):
        raise ValueError("the up axis has no direction")
    unit: FloatArray = vector / length
    return unit


def _area(region: FlatRegion) -> float:
    rings = (region.outline, *region.holes)
    return float(sum(vector_area(ring) @ region.plane.normal for ring in rings))


def _largest(
    regions: list[FlatRegion],
) -> tuple[list[FlatRegion], list[FlatRegion], tuple[str, ...]]:
    """Regions by body and area, those that are too many, and a warning of these."""
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


def _faces(
    regions: Sequence[FlatRegion], size: float
) -> tuple[tuple[Face, ...], tuple[Vertex, ...]]:
    if not regions:
        return (), ()
    corners = _Rings.of(regions, size)
    labels, vertices = corners.merged()
    rings: list[list[Ring]] = [[] for _ in regions]
    extra: list[Vertex] = []
    for own, owner in zip(corners.ends, corners.owners, strict=True):
        ring = _without_repeats([int(labels[i]) for i in own])
        if len(ring) < 3 or len(set(ring)) != len(ring):
            # merging would fold it: it keeps corners of its own
            ring = tuple(len(vertices) + len(extra) + i for i in range(len(own)))
            extra += (
                Vertex(corners.points[i], float(corners.sds[i]) ** 2 * np.eye(3)) for i in own
            )
        rings[owner].append(ring)
    faces = tuple(
        Face(outer, region.plane, tuple(holes))
        for region, (outer, *holes) in zip(regions, rings, strict=True)
    )
    return _used(faces, (*vertices, *extra))


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


def _patches(
    rest: Rest, count: int, size: float, up: ArrayLike | None
) -> tuple[tuple[Patch, ...], tuple[int, ...], tuple[Vertex, ...]]:
    """One patch for each object that has any rest, the objects' numbers, and the extreme vertices
    of the patches, numbered from `count`.
    """
    numbers = np.unique(rest.bodies).astype(int).tolist() if len(rest.points) else []
    exactly = () if up is None else (np.asarray(up, dtype=np.float64),)
    cov = (LENGTH_RESOLUTION * size) ** 2 * np.eye(3)
    patches: list[Patch] = []
    reaching: list[Vertex] = []
    for number in numbers:
        own = rest.bodies == number
        points = rest.points[own]
        # points of no area are the noise of faces, and do not extend them
        far = points[rest.areas[own] > 0.0]
        outer = [Vertex(far[i], cov) for i in outermost(far, *exactly)] if len(far) else []
        hull = tuple(range(count + len(reaching), count + len(reaching) + len(outer)))
        patches.append(Patch(points, rest.normals[own], rest.areas[own], hull))
        reaching += outer
    return tuple(patches), tuple(numbers), tuple(reaching)


def _with_regions(rest: Rest, regions: Sequence[FlatRegion]) -> Rest:
    """The rest, and points on the regions as well."""
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
    """Triangles (m, 3, 3) that fill a region, its holes left open."""
    start = region.outline[0]
    axes = plane_axes(region.plane.normal, region.outline[1] - start)
    rings = [(ring - start) @ axes.T for ring in (region.outline, *region.holes)]
    polygon = shapely.make_valid(shapely.Polygon(rings[0], rings[1:]))
    flat = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    corners = shapely.get_coordinates(flat).reshape(-1, 4, 2)[:, :3]
    lifted: FloatArray = start + corners @ axes
    return lifted
