"""Flat surface of a mesh: regions of triangles that are joined, and large planes of any triangles.

Triangles are segmented into flat faces: first flat ones, then nearly flat ones, then the rest.

1. Triangles joined by edges that do not bend are a facet, if a plane fits all of it: a fine sphere
   does not bend at any one edge.
2. Of facets, those that go on round a bend of less than 50° into others no smaller, along half of
   their outline, are cut from a curved surface (the staves of a round leg).
3. What is left (those staves, what no plane fits, and specks) is taken apart by where its normals
   mostly point. A piece whose normals stay within 25° of their mean, and mostly near it, and which
   is flat against its breadth is a face too, an uncertain one: a cushion, a bowed seat. A piece of
   a tube turns evenly, or goes on into others like it, and is none.

Large planes lie across a known direction, whatever their triangles are joined to. A scanned floor
and what stands on it are one surface, and rough: no edge bends where the floor ends, and no two
triangles are in one plane. So a plane begins where most surface is at one height (the half-sample
mode), and grows by its own roughness.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import shapely
import trimesh
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.polygons import find_enclosed_area, triangulate
from facetlog.perception.ragged import Indices, iter_groups, joined, sum_by_group
from facetlog.perception.shapes.meshes.clean_mesh import (
    RESOLUTION,
    Surface,
    measure_part_sizes,
    rebuild_surface,
)
from facetlog.perception.shapes.meshes.flat_pieces import Fits, Moments
from facetlog.perception.types import FloatArray

# Edges that bend less are none: text with 4 digits turns a face of 1 % of the size by this much.
FLAT = np.deg2rad(1.0)
# A facet's surface stays this near to its plane, against its breadth: the rise of an arc of 4.6°.
FLAT_RMS_SHARE = 0.003
# The normals of a facet have this rms from their mean; an even bend of 5° has it.
FLAT_SPREAD = np.deg2rad(1.5)
# A bend below this continues a curved surface: eight staves to a circle have 45°.
SMOOTH = np.deg2rad(50.0)
# A stave has neighbours round the bend along this share of its outline …
STAVE_OUTLINE_SHARE = 0.5
# … each of at least this share of its own area; a chamfer is smaller than the face it ends.
STAVE_AREA_SHARE = 0.4
# A stave is narrower than this share of its object: of a drum as high as broad, cut into eight,
# a stave has 22 %, and a prism of that few sides is one of flat faces.
STAVE_BREADTH_SHARE = 0.2
# Normals of a nearly flat piece stay this near to their mean: about 25° …
NEARLY_FLAT = np.deg2rad(25.0)
# … and have this rms from it. An even bend over ± 25° has 14°, so that tubes and balls have not.
NEARLY_FLAT_SPREAD = np.deg2rad(10.0)
# The surface of such a piece departs this far (rms) from its plane, against its breadth.
NEARLY_FLAT_RMS_SHARE = 0.05
# Pieces below this share of their body's area are specks; a table's thinnest rim has 0.3 %.
LEAST_AREA_SHARE = 0.001
# Directions that a curved piece is taken apart by, at most; a ball has about twenty-five.
MOST_DIRECTIONS = 32
# Triangles smaller than this share of their object are a scanner's; their normals are averaged with
# their neighbours' so often, which leaves a third of independent noise.
FINE_SHARE = 0.05
SMOOTHINGS = 3
# A direction that fewer of a piece's normals point along starts no face.
LEAST_DIRECTION_SHARE = 0.02
# Triangles within 20 degrees of the direction lie across it (cosine).
ACROSS = float(np.cos(np.deg2rad(20.0)))
# A plane has this share of all surface that lies across the direction, ...
LEAST_SHARE = 0.1
# ... and begins with so much of it.
CORE_SHARE = 0.05
# 99.7 % of a rough plane's corners are within so many times their rms from it.
SDS = 3.0
# A plane that begins with 5 % of its surface has grown to all of it after so many steps of √3.
MOST_STEPS = 20
MOST_PLANES = 6


@dataclass(frozen=True, eq=False, slots=True)
class LargePlane:
    """The plane n · x = offset, n along the direction that was given, and how far its own surface
    departs from it (3 rms of its corners). `triangles` (m,) are those that lie in it.
    """

    normal: FloatArray
    offset: float
    slack: float
    triangles: NDArray[np.bool_]

    def flipped(self) -> "LargePlane":
        """Return the plane with the opposite normal."""
        return LargePlane(-self.normal, -self.offset, self.slack, self.triangles)

    def heights(self, points: FloatArray) -> FloatArray:
        """Return distances (n,) of points (n, 3) from the plane, along its normal."""
        heights: FloatArray = points @ self.normal - self.offset
        return heights


def iter_planes(
    surface: Surface, direction: FloatArray, within: NDArray[np.bool_] | None = None
) -> Iterator[LargePlane]:
    """Yield the large planes across a unit vector (3,), those with most surface first; of the
    triangles (m,) `within`, else of all.
    """
    across = np.abs(surface.normals @ direction) >= ACROSS
    if within is not None:
        across &= within
    rows = np.flatnonzero(across)
    total = float(surface.areas[rows].sum())
    for _ in range(MOST_PLANES):
        if not surface.areas[rows].sum() > LEAST_SHARE * total:
            return
        heights = surface.corners[rows].mean(axis=1) @ direction
        core = rows[_find_mode(heights, surface.areas[rows], CORE_SHARE * total)]
        plane = _grown(surface, rows, core, direction)
        if float(surface.areas[rows[plane.triangles[rows]]].sum()) >= LEAST_SHARE * total:
            yield plane
        taken = plane.triangles.copy()
        taken[core] = True
        rows = rows[~taken[rows]]


def _find_mode(heights: FloatArray, weights: FloatArray, least: float) -> Indices:
    """Return where heights (n,) are densest: the indices of those within the shortest interval that
    holds half of all weight, and half of that, until no more than `least` is left.
    """
    order = np.argsort(heights, kind="stable")
    while True:
        sums = np.concatenate(([0.0], np.cumsum(weights[order])))
        half = 0.5 * sums[-1]
        if half < least or len(order) < 2:
            return order.astype(np.int64)
        last = np.searchsorted(sums, sums[:-1] + half * (1.0 - 1e-9))
        fits = np.flatnonzero(last < len(sums))
        widths = heights[order[last[fits] - 1]] - heights[order[fits]]
        best = int(fits[int(np.argmin(widths))])
        if int(last[best]) - best == len(order):
            return order.astype(np.int64)
        order = order[best : int(last[best])]


def _grown(surface: Surface, rows: Indices, core: Indices, direction: FloatArray) -> LargePlane:
    """Return the plane of the core, and of all else of these rows that is within its roughness."""
    corners = surface.corners[rows]
    least = RESOLUTION * surface.size
    inside = core
    for _ in range(MOST_STEPS):
        fits = Moments.of(surface, inside, np.zeros(len(inside), dtype=np.int64), 1).fits()
        normal = fits.normals[0]
        normal = normal if float(normal @ direction) > 0.0 else -normal
        offset = float(normal @ fits.middles[0])
        # of corners: between them a rough surface is nearer to its plane
        off = surface.corners[inside] @ normal - offset
        rms = np.sqrt(np.average((off**2).mean(axis=1), weights=surface.areas[inside]))
        slack = max(SDS * float(rms), least)
        found = rows[(np.abs(corners @ normal - offset) <= slack).all(axis=1)]
        if len(found) == len(inside) or not len(found):
            break
        inside = found
    triangles = np.zeros(len(surface.triangles), dtype=bool)
    triangles[inside] = True
    return LargePlane(normal, offset, slack, triangles)


# What a scanner sees of a box on a floor is one surface, which has no bottom. Where the floor is
# taken away the box is left open; it stood on the floor, so its outline there is its bottom.

# What borders on a rough plane is within so many of its roughnesses.
NEAR_SLACKS = 3.0


def cut_off(
    surface: Surface, taken: NDArray[np.bool_], planes: tuple[LargePlane, ...]
) -> tuple[Surface, NDArray[np.bool_]]:
    """Return the surface with the triangles `taken` (m,) apart from the others, those closed in the
    planes where they were cut; and which triangles of that are taken.
    """
    cut = _cut_edges(surface, taken)
    if not len(cut):
        return surface, taken
    surface, caps = _close_cuts(surface, ~taken, cut, planes)
    # the taken ones get corners of their own
    names, place = np.unique(surface.triangles[taken], return_inverse=True)
    triangles = surface.triangles.copy()
    triangles[taken] = len(surface.points) + place.reshape(-1, 3)
    apart = replace(surface, points=np.concatenate([surface.points, surface.points[names]]))
    closed = rebuild_surface(apart, np.concatenate([triangles, caps]))
    return closed, np.concatenate([taken, np.zeros(len(caps), dtype=bool)])


def _cut_edges(surface: Surface, taken: NDArray[np.bool_]) -> Indices:
    """Return edges (k, 2) that one triangle of the others has, and one that is taken."""
    own, other = (_edges(surface.triangles[rows]) for rows in (~taken, taken))
    count = len(surface.points)
    key, uses = np.unique(own[:, 0] * count + own[:, 1], return_counts=True)
    cut = key[(uses == 1) & np.isin(key, other[:, 0] * count + other[:, 1])]
    return np.column_stack([cut // count, cut % count])


def _edges(triangles: Indices) -> Indices:
    """Return the edges (3 m, 2) of triangles, the lower end first."""
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return np.sort(pairs, axis=1)


def _close_cuts(
    surface: Surface, left: NDArray[np.bool_], cut: Indices, planes: tuple[LargePlane, ...]
) -> tuple[Surface, Indices]:
    """Return the surface with its cut edges moved onto the planes, and triangles (k, 3) that close
    each piece of what is left there.
    """
    points = surface.points.copy()
    own = surface.triangles[left]
    groups = joined(len(surface.points), np.concatenate((own[:, :2], own[:, 1:])))[1]
    found = [np.zeros((0, 3), dtype=np.int64)]
    for plane in planes:
        slack = max(NEAR_SLACKS * plane.slack, RESOLUTION * surface.size)
        on = (np.abs(plane.heights(points[cut])) <= slack).all(axis=1)
        rim = np.unique(cut[on])
        points[rim] -= np.outer(plane.heights(points[rim]), plane.normal)
        found += (
            _make_cap(points, cut[on][rows], plane.normal)
            for rows in iter_groups(groups[cut[on, 0]])
        )
    return replace(surface, points=points), np.concatenate(found)


def _make_cap(points: FloatArray, edges: Indices, normal: FloatArray) -> Indices:
    """Return triangles (k, 3) over the loops that edges (e, 2) make across a plane's normal."""
    names, place = np.unique(edges, return_inverse=True)
    place = place.reshape(-1, 2)
    # a chain that ends at two other planes is closed along the line where these meet
    ends = np.flatnonzero(np.bincount(place.ravel(), minlength=len(names)) % 2 == 1)
    if len(ends) == 2:
        place = np.concatenate([place, ends[None]])
    flat = points[names] @ make_plane_axes(normal, np.eye(3)[int(np.argmin(np.abs(normal)))]).T
    # rough loops cross themselves where they are looked at along the normal
    noded = shapely.get_parts(shapely.node(shapely.multilinestrings(flat[place])))
    area = find_enclosed_area(np.array([line.coords for line in noded]))
    if area is None or area.is_empty:
        return np.zeros((0, 3), dtype=np.int64)
    corners = triangulate(area).reshape(-1, 2)
    nearest = np.asarray(cKDTree(flat).query(corners)[1]).reshape(-1, 3)
    a, b, c = nearest.T
    triangles: Indices = names[nearest[(a != b) & (b != c) & (c != a)]].astype(np.int64)
    return triangles


@dataclass(frozen=True, eq=False, slots=True)
class _Bends:
    """How far the surface bends at each link (k,), radians, and the edges' lengths (k,)."""

    angles: FloatArray
    lengths: FloatArray
    slack: FloatArray

    @classmethod
    def of(cls, surface: Surface, sizes: FloatArray) -> "_Bends":
        one, two = surface.normals[surface.links[:, 0]], surface.normals[surface.links[:, 1]]
        # from the chord: the arc cosine knows no angle below 1e-8
        chord = np.sqrt(((one - two) ** 2).sum(axis=1))
        ends = surface.points[surface.link_edges]
        lengths = np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1))
        # A corner that is off by the resolution tilts a triangle by that over its height.
        grain = RESOLUTION * sizes / np.maximum(np.sqrt(surface.areas), 1e-300)
        slack = grain[surface.links].sum(axis=1)
        return cls(2.0 * np.arcsin(np.minimum(0.5 * chord, 1.0)), lengths, slack)


def find_regions(surface: Surface, bodies: Indices, *, rough: bool = False) -> Indices:
    """Return the flat region (m,) of each triangle, numbered from 0; -1 where the surface is not
    flat.

    `bodies` (m,) number the object of each triangle: it is judged against the size of that.
    Of a `rough` surface, as scanners write it, normals are averaged first.
    """
    sizes = measure_part_sizes(surface.corners, bodies)
    bends = _Bends.of(surface, sizes)
    everything = np.arange(len(surface.triangles))
    whole = sum_by_group(bodies, surface.areas, int(bodies.max()) + 1)
    least = LEAST_AREA_SHARE * whole[bodies]
    flat = surface.links[bends.angles < FLAT + bends.slack]
    count, facets = joined(len(everything), flat)
    areas = sum_by_group(facets, surface.areas, count)
    # Specks are not fitted. They stay with the piece that they are part of.
    rows = everything[areas[facets] >= least]
    labels = np.full(len(everything), -1, dtype=np.int64)
    if len(rows):
        names, first, groups = np.unique(facets[rows], return_index=True, return_inverse=True)
        fits = Moments.of(surface, rows, groups, len(names)).fits()
        size = sizes[rows[first]]
        good = fits.rms <= np.maximum(FLAT_RMS_SHARE * fits.breadths, RESOLUTION * size)
        good &= fits.spreads <= FLAT_SPREAD
        staves = _find_staves(surface, bends, facets, areas)[names]
        staves &= fits.breadths < STAVE_BREADTH_SHARE * size
        labels[rows] = np.where((good & ~staves)[groups], groups, -1)
    _add_nearly_flat(surface, bends, labels, least, sizes if rough else None)
    _, dense = np.unique(labels, return_inverse=True)
    return dense.astype(np.int64) - int((labels < 0).any())


def _find_staves(
    surface: Surface, bends: _Bends, facets: Indices, sizes: FloatArray
) -> NDArray[np.bool_]:
    """Return which facets are cut from a curved surface: most of their outline bends into similar
    ones.
    """
    one, two = facets[surface.links].T
    apart = one != two
    around = np.zeros(len(sizes))
    outline = np.zeros(len(sizes))
    smooth = bends.angles < SMOOTH
    for own, other in ((one, two), (two, one)):
        outline += np.bincount(own[apart], bends.lengths[apart], minlength=len(sizes))
        on = apart & smooth & (sizes[other] >= STAVE_AREA_SHARE * sizes[own])
        around += np.bincount(own[on], bends.lengths[on], minlength=len(sizes))
    return around > STAVE_OUTLINE_SHARE * outline


def _smooth_normals(surface: Surface, links: Indices, sizes: FloatArray) -> Surface:
    """Return the surface with normals averaged over links (k, 2) of triangles that are small in
    objects of `sizes` (m,): noise of a scanner turns its small triangles, and not what they lie in.
    """
    small = np.sqrt(surface.areas) < FINE_SHARE * sizes
    one, two = links[small[links].all(axis=1)].T
    normals = surface.normals
    for _ in range(SMOOTHINGS):
        weighted = surface.areas[:, None] * normals
        total = weighted.copy()
        count = len(total)
        total += sum_by_group(one, weighted[two], count) + sum_by_group(two, weighted[one], count)
        normals = total / np.maximum(np.sqrt((total**2).sum(axis=1)), 1e-300)[:, None]
    return replace(surface, normals=normals)


def _add_nearly_flat(
    surface: Surface, bends: _Bends, labels: Indices, least: FloatArray, sizes: FloatArray | None
) -> None:
    """Number the nearly flat pieces of what has no label yet, in place."""
    left = labels < 0
    if not left.any():
        return
    inner = left[surface.links].all(axis=1)
    smooth = surface.links[inner & (bends.angles < SMOOTH)]
    if sizes is not None:
        surface = _smooth_normals(surface, smooth, sizes)
    count, pieces = joined(len(labels), smooth)
    sizes = sum_by_group(pieces, surface.areas, count)
    worth = left & (sizes[pieces] >= least)
    if not worth.any():
        return
    ways = _find_ways(surface, pieces, worth)
    kept = (ways[smooth[:, 0]] == ways[smooth[:, 1]]) & (ways[smooth[:, 0]] >= 0)
    count, parts = joined(len(labels), smooth[kept])
    sizes = sum_by_group(parts, surface.areas, count)
    rows = np.flatnonzero(worth & (ways >= 0) & (sizes[parts] >= least))
    if not len(rows):
        return
    names, groups = np.unique(parts[rows], return_inverse=True)
    fits = Moments.of(surface, rows, groups, len(names)).fits()
    good = _find_nearly_flat(surface, fits, rows, groups)
    # what is left between two directions of a tube is narrow, and seems flat
    good &= ~_find_staves(surface, bends, parts, sizes)[names]
    labels[rows] = np.where(good[groups], int(labels.max()) + 1 + groups, -1)


def _find_nearly_flat(
    surface: Surface, fits: Fits, rows: Indices, groups: Indices
) -> NDArray[np.bool_]:
    cosines = (surface.normals[rows] * fits.normals[groups]).sum(axis=1)
    steep = cosines < np.cos(NEARLY_FLAT)
    share = sum_by_group(groups, surface.areas[rows] * steep, len(fits.areas))
    good: NDArray[np.bool_] = (
        (share <= LEAST_DIRECTION_SHARE * fits.areas)
        & (fits.spreads <= NEARLY_FLAT_SPREAD)
        & (fits.rms <= NEARLY_FLAT_RMS_SHARE * fits.breadths)
    )
    return good


def _find_ways(surface: Surface, pieces: Indices, worth: NDArray[np.bool_]) -> Indices:
    """Return the number (m,) of the direction that each triangle of a piece is taken to point
    along, or -1.

    In each piece the direction along which most area points, within 25°, is taken first; what it
    takes is taken away, and so on. Candidates are the 162 corners of a sphere of triangles, 9°
    from any direction at most; each direction is then moved to the mean of what it took.
    """
    candidates: FloatArray = np.asarray(trimesh.creation.icosphere(subdivisions=2).vertices)
    near = candidates @ candidates.T > np.cos(NEARLY_FLAT)
    ways = np.full(len(pieces), -1, dtype=np.int64)
    rows = np.flatnonzero(worth)
    following = 0
    for own in (rows[some] for some in iter_groups(pieces[rows])):
        nearest = _nearest(candidates, surface.normals[own])
        weights = sum_by_group(nearest, surface.areas[own], len(candidates))
        centres: list[FloatArray] = []
        enough = LEAST_DIRECTION_SHARE * weights.sum()
        for _ in range(MOST_DIRECTIONS):
            taken = near @ weights
            best = int(np.argmax(taken))
            if taken[best] <= enough:
                break
            mean = (near[best] * weights) @ candidates
            centres.append(mean / np.linalg.norm(mean))
            weights = np.where(near[best], 0.0, weights)
        if not centres:
            continue
        cosines = surface.normals[own] @ np.array(centres).T
        nearest = cosines.argmax(axis=1)
        within = cosines.max(axis=1) > np.cos(NEARLY_FLAT)
        ways[own] = np.where(within, following + nearest, -1)
        following += len(centres)
    return ways


def _nearest(candidates: FloatArray, normals: FloatArray) -> Indices:
    """Return the candidate nearest to each normal (n, 3)."""
    return np.asarray(cKDTree(candidates).query(normals)[1], dtype=np.int64)
