"""Regions of triangles as polygons with holes: outlines, coplanar pieces that touch made one.

An outline is made of the edges that one triangle of the region has; where triangles overlap it is
their union instead. Corners on straight sides go, and round outlines keep 64 corners at most.
"""

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial import cKDTree

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.polygons import find_enclosed_area, find_union
from facetlog.perception.ragged import Indices, iter_groups, joined, sum_by_group
from facetlog.perception.scene import Plane
from facetlog.perception.shapes.meshes.clean_mesh import RESOLUTION, Surface
from facetlog.perception.shapes.meshes.surface_fit import Fits, Moments, make_fitted_plane
from facetlog.perception.shapes.regions.flat_region import FlatRegion, PlaneFrame
from facetlog.perception.types import FloatArray

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
