"""Planes through groups of triangles, how flat each group is, and such regions as polygons.

Planes are fitted to all groups at once. Regions become polygons with holes; coplanar pieces that
touch are made one. An outline is made of the edges that one triangle of the region has; where
triangles overlap it is their union instead. Corners on straight sides go, and round outlines keep
64 corners at most.
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
# A plane is as certain as from so many independent points: a face's deviation from flatness is a
# bow or a twist, not noise, so more triangles do not make it more certain. Four bear a rectangle.
INDEPENDENT = 4.0


@dataclass(frozen=True, eq=False, slots=True)
class Fits:
    """Least-squares planes of r groups of triangles, weighted by area.

    `middles` (r, 3) of the area; `normals` (r, 3) along the mean of the triangles' own; `rms` (r,)
    distance of the surface from its plane; `variances` (r, 2) of the surface along its two
    directions `axes` (r, 2, 3), the shorter first; `spreads` (r,) rms angle of the triangles'
    normals from their mean, radians.
    """

    areas: FloatArray
    middles: FloatArray
    normals: FloatArray
    rms: FloatArray
    variances: FloatArray
    axes: FloatArray
    spreads: FloatArray

    @property
    def breadths(self) -> FloatArray:
        """The shorter side (r,) of a rectangle with the same variance, s² / 12."""
        breadths: FloatArray = np.sqrt(12.0 * self.variances[:, 0])
        return breadths


@dataclass(frozen=True, eq=False, slots=True)
class Moments:
    """Sums over r groups of triangles: areas (r,), middles (r, 3), scatter (r, 3, 3), normals (r,
    3).

    `scatter` is ∫ (x - middle)(x - middle)ᵀ over the group's surface, `normals` are ∫ n.
    """

    areas: FloatArray
    middles: FloatArray
    scatter: FloatArray
    normals: FloatArray

    @classmethod
    def of(cls, surface: Surface, rows: Indices, groups: Indices, count: int) -> "Moments":
        """Return moments of `count` groups, each with a triangle; rows[i] is of the group
        groups[i].

        A triangle with corners v and area A has ∫ x xᵀ = A / 12 (Σ v vᵀ + (Σ v)(Σ v)ᵀ).
        """
        areas, triangles = surface.areas[rows], surface.triangles[rows]
        whole = sum_by_group(groups, areas, count)
        corners = [surface.points[triangles[:, k]] for k in range(3)]
        sums = corners[0] + corners[1] + corners[2]
        middles = sum_by_group(groups, areas[:, None] * sums, count) / (3.0 * whole[:, None])
        # about each group's own middle, else small groups far out lose their digits
        about = middles[groups]
        corners = [corner - about for corner in corners]
        corners.append(sums - 3.0 * about)
        scatter = np.empty((count, 3, 3))
        for i in range(3):
            for j in range(i, 3):
                square = sum((c[:, i] * c[:, j] for c in corners), start=np.zeros(len(rows)))
                moment = sum_by_group(groups, areas * square, count) / 12.0
                scatter[:, i, j] = scatter[:, j, i] = moment
        normals = sum_by_group(groups, areas[:, None] * surface.normals[rows], count)
        return cls(whole, middles, scatter, normals)

    def joined(self, groups: Indices, count: int) -> "Moments":
        """Return moments of `count` groups of these groups; groups[i] is that of i, or -1:
        of none.
        """
        used = np.flatnonzero(groups >= 0)
        groups, areas = groups[used], self.areas[used]
        whole = sum_by_group(groups, areas, count)
        middles = sum_by_group(groups, areas[:, None] * self.middles[used], count) / whole[:, None]
        off = self.middles[used] - middles[groups]
        # ∫ about the common middle = ∫ about the own one + A (m - M)(m - M)ᵀ
        scatter = self.scatter[used] + areas[:, None, None] * off[:, :, None] * off[:, None]
        flat = sum_by_group(groups, scatter.reshape(-1, 9), count).reshape(-1, 3, 3)
        return Moments(whole, middles, flat, sum_by_group(groups, self.normals[used], count))

    def fits(self) -> Fits:
        """Return the plane of each group."""
        values, vectors = np.linalg.eigh(self.scatter / self.areas[:, None, None])
        values = np.maximum(values, 0.0)
        mean = self.normals / self.areas[:, None]
        length = np.sqrt((mean * mean).sum(axis=1))
        normals = vectors[:, :, 0]
        against = (normals * mean).sum(axis=1) < 0.0
        return Fits(
            self.areas,
            self.middles,
            np.where(against[:, None], -normals, normals),
            np.sqrt(values[:, 0]),
            values[:, 1:],
            np.swapaxes(vectors[:, :, 1:], 1, 2),
            # mean cosine 1 - σ² / 2
            np.sqrt(2.0 * np.maximum(1.0 - length, 0.0)),
        )


def make_fitted_plane(fits: Fits, group: int, size: float, step: float = 0.0) -> Plane:
    """Return the plane of one group with its covariance, about the surface's own middle.

    With sd the rms distance, not less than the resolution of `size`, nor than step / √12 where
    coordinates were rounded to multiples of `step`: tilt about the in-plane axis
    e has variance sd² / (n λ), λ the variance of the surface across e; the offset at the middle
    has sd² / n; n = 4. Along an axis all corners are rounded alike: then the offset has step² / 12.
    """
    rounding = step / np.sqrt(12.0)
    sd = max(float(fits.rms[group]), RESOLUTION * size, rounding)
    middle, normal = fits.middles[group], fits.normals[group]
    tilt = np.zeros((3, 3))
    for variance, axis in zip(fits.variances[group], fits.axes[group], strict=True):
        # a piece narrower than the resolution has no meaningful tilt
        floor = (RESOLUTION * size) ** 2
        tilt += sd**2 / (INDEPENDENT * max(float(variance), floor)) * np.outer(axis, axis)
    lever = np.vstack([np.eye(3), -middle])
    cov = lever @ tilt @ lever.T
    cov[3, 3] += max(sd**2 / INDEPENDENT, rounding**2)
    return Plane(normal, float(-normal @ middle), cov)


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
