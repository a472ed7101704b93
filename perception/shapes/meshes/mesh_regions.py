"""Flat regions of a mesh's triangles, and their outlines.

Triangles are segmented into flat faces: first flat ones, then nearly flat ones, then the rest.

1. Triangles joined by edges that do not bend are a facet, if a plane fits all of it: a fine sphere
   does not bend at any one edge.
2. Of facets, those that go on round a bend of less than 50° into others no smaller, along half of
   their outline, are cut from a curved surface (the staves of a round leg).
3. What is left (those staves, what no plane fits, and specks) is taken apart by where its normals
   mostly point. A piece whose normals stay within 25° of their mean, and mostly near it, and which
   is flat against its breadth is a face too, an uncertain one: a cushion, a bowed seat. A piece of
   a tube turns evenly, or goes on into others like it, and is none.

Regions become polygons with holes; coplanar pieces that touch become one. An outline is made of the
edges that one triangle of the region has; where triangles overlap it is their union instead.
Corners on straight sides go, and round outlines keep 64 corners at most.
"""

from dataclasses import dataclass, replace

import numpy as np
import shapely
import trimesh
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.polygons import find_enclosed_area, find_union
from facetlog.perception.ragged import Indices, iter_groups, joined, sum_by_group
from facetlog.perception.scene import Plane
from facetlog.perception.shapes.meshes.clean_mesh import RESOLUTION, Surface, measure_part_sizes
from facetlog.perception.shapes.meshes.surface_fit import Fits, Moments, make_fitted_plane
from facetlog.perception.shapes.regions.flat_region import FlatRegion, PlaneFrame
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
# A round table top of 64 corners departs from the circle by 0.12 % of its radius.
MOST_CORNERS = 64
# Corners that depart from the side between their neighbours by less than this share of the
# region's extent are none; a circle of 64 corners has the least departure that is meant.
STRAIGHT_SHARE = 0.001
# Holes below this share of the face are gaps of the model, not openings.
LEAST_HOLE_SHARE = 0.0005
# Two pieces are in one plane within this angle and this share of the object's size.
COPLANAR = np.deg2rad(1.0)
COPLANAR_SHARE = 0.001
# Pieces in one plane nearer than this share of the size touch.
TOUCH_SHARE = 1e-4
# An outline that misses its triangles' area by more than this crosses itself.
AREA_ERROR = 0.005


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """A flat region, and the triangles' pieces (numbers) that it was made of."""

    region: FlatRegion
    pieces: tuple[int, ...]


def find_flat_pieces(
    surface: Surface, labels: Indices, owners: Indices, sizes: FloatArray
) -> tuple[Piece, ...]:
    """Return regions of the triangles with a label (m,) of 0 or more; `owners` (m,) is what may be
    one.

    Pieces of one owner that lie in one plane, face one way and touch become one region, of body 0,
    by the size (m,) of the object that each triangle is of.
    """
    rows = np.flatnonzero(labels >= 0)
    if not len(rows):
        return ()
    names, dense = np.unique(labels[rows], return_inverse=True)
    labels = np.full(len(labels), -1, dtype=np.int64)
    labels[rows] = dense
    count = len(names)
    moments = Moments.of(surface, rows, labels[rows], count)
    fits = moments.fits()
    owner, size = np.zeros(count, dtype=np.int64), np.zeros(count)
    owner[labels[rows]], size[labels[rows]] = owners[rows], sizes[rows]
    planes = _join_coplanar(fits, owner, size)
    frames = moments.joined(planes, int(planes.max()) + 1).fits()
    loops = _Outlines.of(surface, labels, count)
    found: list[tuple[shapely.Polygon, PlaneFrame, tuple[int, ...]]] = []
    for own in iter_groups(planes):
        nth = int(planes[own[0]])
        axes = make_plane_axes(frames.normals[nth], frames.axes[nth, 1])
        frame = PlaneFrame(frames.middles[nth], axes)
        polygons = [loops.polygon(int(piece), frame) for piece in own]
        merged = _merged(polygons, own, float(size[own[0]]))
        found += ((polygon, frame, members) for polygon, members in merged)
    if not found:
        return ()
    return _regions(moments, found, names, size, surface.step)


def _regions(
    moments: Moments,
    found: list[tuple[shapely.Polygon, PlaneFrame, tuple[int, ...]]],
    names: Indices,
    sizes: FloatArray,
    step: float,
) -> tuple[Piece, ...]:
    """Return pieces with planes of their own, fitted to what they were made of, in objects of
    `sizes`.
    """
    region_of = np.full(len(moments.areas), -1, dtype=np.int64)
    for nth, (_, _, members) in enumerate(found):
        region_of[list(members)] = nth
    fits = moments.joined(region_of, len(found)).fits()
    pieces = []
    for nth, (polygon, frame, members) in enumerate(found):
        size = float(sizes[members[0]])
        plane = make_fitted_plane(fits, nth, size, step)
        corner_sd = float(max(fits.rms[nth], step / np.sqrt(12.0)))
        region = _region(polygon, frame, plane, corner_sd, size)
        if region is not None:
            pieces.append(Piece(region, tuple(names[list(members)].tolist())))
    return tuple(pieces)


def _join_coplanar(fits: Fits, owner: Indices, sizes: FloatArray) -> Indices:
    """Return the plane (r,) that each piece lies in, together with others of its owner, as large as
    it.
    """
    # offsets about the middle of each owner's, where the tilt matters least
    group = np.unique(owner, return_inverse=True)[1]
    count = int(group.max()) + 1
    middles = sum_by_group(group, fits.areas[:, None] * fits.middles, count)
    middles /= sum_by_group(group, fits.areas, count)[:, None]
    offsets = (fits.normals * (fits.middles - middles[group])).sum(axis=1)
    flat = np.flatnonzero(fits.rms <= COPLANAR_SHARE * sizes)
    # owners lie further apart than what is in one plane
    place = np.column_stack(
        [
            fits.normals[flat] / COPLANAR,
            offsets[flat] / (COPLANAR_SHARE * sizes[flat]),
            2.0 * owner[flat],
        ]
    )
    near = flat[cKDTree(place).query_pairs(1.0, output_type="ndarray")]
    return joined(len(offsets), near)[1]


def _merged(
    polygons: list[shapely.Geometry], pieces: Indices, size: float
) -> list[tuple[shapely.Polygon, tuple[int, ...]]]:
    """Return polygons that touch made one, each with its pieces."""
    if len(polygons) == 1:
        whole = polygons[0]
    else:
        touch = TOUCH_SHARE * size
        grown = shapely.buffer(np.array(polygons), touch, join_style="mitre", cap_style="flat")
        whole = shapely.buffer(find_union(grown), -touch, join_style="mitre")
    parts = [p for p in shapely.get_parts(whole) if isinstance(p, shapely.Polygon)]
    parts = [p for p in parts if p.area > 0.0]
    if not parts:
        return []
    if len(polygons) == 1:
        # a piece of surface may fall apart at a neck without width: specks go with the largest
        largest = max(parts, key=lambda part: part.area)
        return [(largest, (int(pieces[0]),))]
    dots = shapely.point_on_surface(np.array(polygons))
    near = shapely.STRtree(parts).nearest(dots)
    return [
        (part, tuple(pieces[near == nth].tolist()))
        for nth, part in enumerate(parts)
        if (near == nth).any()
    ]


@dataclass(frozen=True, eq=False, slots=True)
class _Outlines:
    """The triangles and outer edges of each piece, sorted by piece."""

    surface: Surface
    triangles: tuple[Indices, ...]
    edges: tuple[Indices, ...]

    @classmethod
    def of(cls, surface: Surface, labels: Indices, count: int) -> "_Outlines":
        rows = np.flatnonzero(labels >= 0)
        rows = rows[np.argsort(labels[rows], kind="stable")]
        own = surface.triangles[rows]
        starts, ends = own.ravel(), np.roll(own, -1, axis=1).ravel()
        pieces = np.repeat(labels[rows], 3)
        n = len(surface.points)
        key = np.minimum(starts, ends) * n + np.maximum(starts, ends)
        order = np.lexsort((key, pieces))
        key, pieces = key[order], pieces[order]
        new = np.ones(len(key) + 1, dtype=bool)
        new[1:-1] = (key[1:] != key[:-1]) | (pieces[1:] != pieces[:-1])
        once = np.flatnonzero(new[:-1] & new[1:])
        ends_of = np.column_stack([starts, ends])[order[once]]
        return cls(
            surface,
            tuple(np.split(rows, np.searchsorted(labels[rows], np.arange(1, count)))),
            tuple(np.split(ends_of, np.searchsorted(pieces[once], np.arange(1, count)))),
        )

    def polygon(self, piece: int, frame: PlaneFrame) -> shapely.Geometry:
        """Return the piece in a plane's coordinates, valid, perhaps of several parts."""
        surface, rows = self.surface, self.triangles[piece]
        segments = frame.flatten(surface.points[self.edges[piece]])
        area = find_enclosed_area(segments)
        flat = frame.flatten(surface.points[surface.triangles[rows]])
        (ax, ay), (bx, by) = np.moveaxis(flat[:, 1:] - flat[:, :1], (1, 2), (0, 1))
        covered = 0.5 * np.abs(ax * by - ay * bx).sum()
        if area is not None and area.is_valid and abs(area.area - covered) <= AREA_ERROR * covered:
            return area
        return find_union(shapely.polygons(flat))


def _region(
    polygon: shapely.Polygon, frame: PlaneFrame, plane: Plane, corner_sd: float, size: float
) -> FlatRegion | None:
    """Return the polygon on its plane, simplified; None where nothing is left of it."""
    extent = float(np.linalg.norm(np.ptp(np.array(polygon.bounds).reshape(2, 2), axis=0)))
    holes = [
        r for r in polygon.interiors if shapely.Polygon(r).area > LEAST_HOLE_SHARE * polygon.area
    ]
    polygon = shapely.Polygon(
        _start_at_farthest(polygon.exterior), [_start_at_farthest(ring) for ring in holes]
    )
    slack = max(STRAIGHT_SHARE * extent, RESOLUTION * size)
    simple = polygon.simplify(slack)
    while isinstance(simple, shapely.Polygon) and _count_most_corners(simple) > MOST_CORNERS:
        slack *= 1.5
        simple = polygon.simplify(slack)
    if not isinstance(simple, shapely.Polygon) or simple.is_empty or not simple.area > 0.0:
        return None
    moved = shapely.hausdorff_distance(polygon.boundary, simple.boundary)
    simple = shapely.orient_polygons(simple)

    sd = float(np.sqrt(corner_sd**2 + moved**2 + (RESOLUTION * size) ** 2))
    return FlatRegion(plane, *frame.lift_rings(simple, plane), sd)


def _count_most_corners(polygon: shapely.Polygon) -> int:
    return max(len(ring.coords) - 1 for ring in (polygon.exterior, *polygon.interiors))


def _start_at_farthest(ring: shapely.LinearRing) -> FloatArray:
    """Return the ring (k, 2) from the corner that is farthest from its middle: simplifying keeps
    it.
    """
    loop = shapely.get_coordinates(ring)[:-1]
    first = int(((loop - loop.mean(axis=0)) ** 2).sum(axis=1).argmax())
    turned: FloatArray = np.roll(loop, -first, axis=0)
    return np.concatenate((turned, turned[:1]))


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
