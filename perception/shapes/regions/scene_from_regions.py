"""Flat regions and the rest of the surface as a scene: shared vertices, edges, faces, objects."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from facetlog.perception.flat_faces import plane_axes, vector_area
from facetlog.perception.polygons import make_polygon, triangulate
from facetlog.perception.ragged import by_group
from facetlog.perception.scene import Body, Edge, Patch, Scene, Vertex
from facetlog.perception.shapes.regions.flat_region import FlatRegion, Rest
from facetlog.perception.shapes.regions.outermost_points import outermost
from facetlog.perception.shapes.regions.shared_corners import faces_with_shared_corners
from facetlog.perception.shapes.regions.surface_samples import sample_triangles
from facetlog.perception.surfaces.tolerance import LENGTH_RESOLUTION
from facetlog.perception.types import FloatArray

__all__ = ["MOST_FACES", "assemble_scene", "unit_vector"]

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
    """The scene of flat regions and the rest of the surface, objects as their numbers say.

    Faces come by object and then by area, largest first; corners of an object's faces that lie
    within 3 sd are one vertex. Of each object the 300 largest regions become faces. `whole` says
    that the surface is known from all sides. An object without faces is no body, only a patch: no
    model is judged on it.
    """
    kept, left, said = _largest(list(regions))
    rest = _with_regions(rest, left)
    sizes = _extents(kept, rest)
    faces, vertices = faces_with_shared_corners(kept, sizes)
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
        up=None if up is None else unit_vector(up),
        metric=metric,
        warnings=(*warnings, *said),
        patches=patches,
        bodies=bodies,
    )


def _extents(regions: Sequence[FlatRegion], rest: Rest) -> dict[int, float]:
    """The diagonal of the box round each object, by its number; -1 is what is of none."""
    points: dict[int, list[FloatArray]] = defaultdict(list)
    for region in regions:
        points[region.body].append(region.outline)
    for own in by_group(rest.bodies.astype(np.int64)):
        points[int(rest.bodies[own[0]])].append(rest.points[own])
    return {
        number: float(np.linalg.norm(np.ptp(np.concatenate(parts), axis=0)))
        for number, parts in points.items()
    }


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


def _patches(
    rest: Rest, count: int, sizes: Mapping[int, float], up: ArrayLike | None
) -> tuple[tuple[Patch, ...], tuple[int, ...], tuple[Vertex, ...]]:
    """One patch for each object that has any rest, the objects' numbers, and the extreme vertices
    of the patches, numbered from `count`.
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
    corners = triangulate(make_polygon(rings[0], rings[1:]))
    lifted: FloatArray = start + corners @ axes
    return lifted
