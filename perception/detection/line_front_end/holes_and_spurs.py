"""Parts within an outline that are not of the face: holes, and spurs of the ground.

Through a hole each view sees another place, and the views that show the face disagree. On a surface
views disagree where it shines, and where something stands before it; but that hides from the views
beyond it what lies beside its foot, while round a hole the face is surface up to the rim, and the
rim has edges in its plane.

Where a face meets the ground outlines may go on along shadows. A shadow is as plain as a face, and
has edges of its own: seen on the plane of the face beside it, part of it agrees in all views. There
the ground explains the pixels as well as a face does, and the ground is there in any case.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.beside_segments import (
    CLEAR_PX,
    MIN_CONSISTENT,
    MIN_WEIGHT,
)
from facetlog.perception.detection.line_front_end.evidence.face_evidence import (
    MIN_COVERAGE,
    MIN_INNER,
    compute_ground_ratio,
)
from facetlog.perception.detection.line_front_end.evidence.photometric_views import PhotometricViews
from facetlog.perception.detection.line_front_end.evidence.see_through import (
    LEAST_SCORE,
    LinesBehind,
)
from facetlog.perception.detection.line_front_end.evidence.side_evidence import MOVES_PX, SideJudge
from facetlog.perception.detection.line_front_end.outlines.outline_search import find_outlines
from facetlog.perception.detection.line_front_end.outlines.plane_grid import (
    COARSE_PX,
    FINE_PX,
    MAX_CELLS,
    MIN_COARSE,
    MIN_FINE,
    PlaneGrid,
    find_connected_regions,
)
from facetlog.perception.detection.line_front_end.outlines.region_outline import (
    MAX_SIDES,
    border,
    fit_outline_polygon,
    iter_rough_polygons,
)
from facetlog.perception.detection.line_front_end.planes.ground_plane import Ground
from facetlog.perception.detection.line_front_end.planes.plane_hypotheses import PlaneHypothesis
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import LineCloud
from facetlog.perception.detection.line_front_end.segments_3d.line_extent import LineProfiles
from facetlog.perception.flat_faces import make_plane_axes, make_ring_sides
from facetlog.perception.polygons import find_difference, find_intersection, make_polygon
from facetlog.perception.stable_order import descending, largest
from facetlog.perception.types import FloatArray

# A place is not surface at odds of 20 to 1.
MIN_RATIO = float(np.log(20.0))
# How often views disagree elsewhere on the face settles in few steps.
STEPS = 10
# Penalty: each side is one of some twenty, and of its moves; less than one face in a thousand may
# have a hole by chance.
SIDE_PENALTY, CHANCE_PENALTY = float(np.log(20.0 * len(MOVES_PX))), float(np.log(1000.0))
# Fewer cells than this in a hole or beside its rim are no evidence.
MIN_CELLS = 8
# A surface shines where one number of each view leaves no more of what the views differ by: glossy
# labels leave .00 to .05, the plain walls of a shaft, each of them one grey to a view, .10 to .21.
SHINES = 0.07
# Four legs have three openings between them; when they are cut out one looks once more.
MOST_OPENINGS = 3 + 1
# Sides of a cell, px, in which an outline is looked over: edges reach 2 px to either side.
CELL_PX = 4.0
# A place is ground at odds of 20 to 1, unless the face is likelier by as much.
CLEAR_ODDS = float(np.log(20.0))


def remove_spurs(
    corners: FloatArray,
    normal: FloatArray,
    shown: NDArray[np.bool_],
    taken: Sequence[NDArray[np.uint8]],
    photos: PhotometricViews,
    ground: Ground | None,
    pixel: float,
) -> FloatArray:
    """Return an outline (k, 3), counter-clockwise about its normal, without its parts that are
    ground.

    A part is what one cut takes off that goes on along a side at a reflex corner, or from one such
    corner to another. The views `shown` (V,) show the face, `taken` are their pixels that show
    another one, `pixel` is a pixel's length at the focus. Without a ground it stays as it is.
    """
    if ground is None:
        return corners
    along = np.roll(corners, -1, axis=0) - corners
    basis = make_plane_axes(normal, along[largest(np.linalg.norm(along, axis=1))]).T
    ring = corners @ basis
    if not len(_reflex(ring)) or not shapely.Polygon(ring).is_valid:
        return corners
    cells = _cells(ring, CELL_PX * pixel)
    foot = normal * float(normal @ corners.mean(axis=0))
    points = cells @ basis.T + foot
    face, _ = photos.agree(np.nonzero(shown)[0], points, taken)
    by_ground = compute_ground_ratio(photos, ground, corners, normal, points, shown, taken)
    is_ground = by_ground > np.maximum(CLEAR_ODDS, face.ratio - CLEAR_ODDS)
    left = _without(ring, cells, is_ground)
    return corners if left is ring else left @ basis.T + foot


def _without(ring: FloatArray, cells: FloatArray, is_ground: NDArray[np.bool_]) -> FloatArray:
    # A ring (k, 2) without the parts most of whose cells (n, 2) are ground, the largest first.
    while is_ground.sum() >= MIN_CONSISTENT * MIN_INNER:
        parts = list(_cuts(ring))
        inside = [shapely.contains_xy(shapely.Polygon(part), *cells.T) for part, _ in parts]
        worth = np.array([_worth(is_ground[each]) for each in inside])
        if not (worth > 0).any():
            break
        best = int(descending(worth)[0])
        ring = parts[best][1]
        left = ~inside[best]
        cells, is_ground = cells[left], is_ground[left]
    return ring


def _worth(is_ground: NDArray[np.bool_]) -> float:
    # Cells of ground less what the others are worth, 0 where these are too many or all too few.
    count, ground = len(is_ground), int(is_ground.sum())
    if count < MIN_INNER or ground < MIN_CONSISTENT * count:
        return 0.0
    return float(ground - (count - ground) * MIN_CONSISTENT / (1 - MIN_CONSISTENT)) + 1.0


def _reflex(ring: FloatArray) -> NDArray[np.intp]:
    # The corners of a counter-clockwise ring (k, 2) at which it turns clockwise.
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    return np.nonzero(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0] < 0)[0]


def _cuts(ring: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
    # Each way to cut a ring (k, 2) in two, either part being the first once.
    polygon = shapely.Polygon(ring)
    reflex = _reflex(ring)
    count = len(ring)
    for corner in reflex.tolist():
        for beside in (-1, 1):
            hit = _hit(ring, corner, ring[corner] - ring[(corner + beside) % count])
            if hit is None:
                continue
            side, at = hit
            one = np.concatenate([_run(ring, corner, side), at[None]])
            other = np.concatenate([at[None], _run(ring, (side + 1) % count, corner)])
            yield one, other
            yield other, one
        for end in reflex[reflex > corner].tolist():
            chord = shapely.LineString(ring[[corner, end]])
            if (end - corner) % count in (1, count - 1) or not polygon.covers(chord):
                continue
            one, other = _run(ring, corner, end), _run(ring, end, corner)
            yield one, other
            yield other, one


def _run(ring: FloatArray, first: int, last: int) -> FloatArray:
    # The corners from the first to the last, both with them, counter-clockwise.
    return ring[(first + np.arange((last - first) % len(ring) + 1)) % len(ring)]


def _hit(ring: FloatArray, corner: int, along: FloatArray) -> tuple[int, FloatArray] | None:
    # Where a ray from a corner inwards meets the ring (k, 2) first: side and point.
    span = np.roll(ring, -1, axis=0) - ring
    off = ring - ring[corner]
    sine = along[0] * span[:, 1] - along[1] * span[:, 0]
    safe = np.where(np.abs(sine) > 0, sine, np.nan)
    share = (off[:, 0] * span[:, 1] - off[:, 1] * span[:, 0]) / safe
    place = (off[:, 0] * along[1] - off[:, 1] * along[0]) / safe
    meets = (share > 0) & (place >= 0) & (place <= 1)
    meets[[corner, corner - 1]] = False
    if not meets.any():
        return None
    side = int(np.where(meets, share, np.inf).argmin())
    return side, ring[corner] + share[side] * along


def _cells(ring: FloatArray, step: float) -> FloatArray:
    # The middles (n, 2) of the cells of a ring (k, 2).
    low, high = ring.min(axis=0), ring.max(axis=0)
    step = max(step, float((high - low).max()) / MAX_CELLS)
    x, y = (np.arange(a + step / 2, b, step) for a, b in zip(low, high, strict=True))
    middles = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    polygon = shapely.Polygon(ring)
    shapely.prepare(polygon)
    cells: FloatArray = middles[shapely.contains_xy(polygon, *middles.T)]
    return cells


@dataclass(frozen=True, eq=False, slots=True)
class _Cells:
    # A face in cells: its outline there, the middles (n, 2) of those within, and which (n,) of them
    # are no surface.
    grid: PlaneGrid
    outline: shapely.Geometry
    middles: FloatArray
    missing: NDArray[np.bool_]

    def regions(self, least: int) -> Iterator[NDArray[np.uint8]]:
        """Return regions (rows, columns) of cells that are no surface."""
        drawn = np.zeros(self.grid.shape, dtype=np.uint8)
        column, row = self.middles[self.missing].astype(np.intp).T
        drawn[row, column] = 1
        return find_connected_regions(drawn, least)


class HoleFinder:
    """Finds holes in faces and openings at their rims."""

    def __init__(
        self,
        photos: PhotometricViews,
        sides: SideJudge,
        cloud: LineCloud,
        profiles: LineProfiles,
        behind: LinesBehind,
    ) -> None:
        self._photos = photos
        self._sides = sides
        self._cloud = cloud
        self._profiles = profiles
        self._behind = behind
        self._pixel = cloud.pixel

    def holes(
        self,
        corners: FloatArray,
        plane: PlaneHypothesis,
        shown: NDArray[np.bool_],
        taken: Sequence[NDArray[np.uint8]],
    ) -> tuple[FloatArray, ...]:
        """Return corners (k, 3) of the holes in a face (n, 3) that views `shown` (V,) show, each
        clockwise seen from the side that the plane's normal points to.

        `taken` says of each view which of its pixels show a face that was found before.
        """
        views = np.nonzero(shown)[0]
        coarse = self._look(corners, plane, views, taken, COARSE_PX)
        if next(coarse.regions(MIN_COARSE), None) is None:
            return ()
        cells = self._look(corners, plane, views, taken, FINE_PX)
        rings = list(self._rings(cells, plane, views))
        score = np.array([self._score(ring, cells, plane.normal, views, taken) for ring in rings])
        chosen: list[shapely.Polygon] = []
        holes = []
        for k in descending(score):
            flat = shapely.Polygon(cells.grid.cells(rings[k]))
            if score[k] > 0 and not any(flat.intersects(other) for other in chosen):
                chosen.append(flat)
                holes.append(rings[k][::-1].copy())
        return tuple(holes)

    def trimmed(
        self,
        corners: FloatArray,
        plane: PlaneHypothesis,
        shown: NDArray[np.bool_],
        taken: Sequence[NDArray[np.uint8]],
    ) -> FloatArray | None:
        """Return what is left (k, 3) of a polygon (n, 3) that is seen through without the openings
        at its rim, such as those between legs; None where something else is seen through, too.
        """
        views = np.nonzero(shown)[0]
        cells = self._look(corners, plane, views, taken, FINE_PX)
        grid, left = cells.grid, _largest(cells.outline)
        rings = (grid.cells(ring) + 0.5 for ring in self._rings(cells, plane, views))
        openings = [make_polygon(ring) for ring in rings]

        def score(part: shapely.Polygon) -> float:
            ring = grid.points(shapely.get_coordinates(part.exterior)[:-1])
            return self._behind.score(ring, plane.normal, views)

        for _ in range(MOST_OPENINGS):
            if left is None or left.interiors:
                return None
            if score(left) <= LEAST_SCORE:
                ring = shapely.geometry.polygon.orient(left).exterior
                return grid.points(shapely.get_coordinates(ring)[:-1])
            cuts = [
                (_largest(find_intersection(left, each)), _largest(find_difference(left, each)))
                for each in openings
            ]
            seen = [(score(piece), rest) for piece, rest in cuts if piece and rest]
            best = max(seen, key=lambda cut: round(cut[0], 6), default=(0.0, None))
            left = best[1] if best[0] > 0 else None
        return None

    def _look(
        self,
        corners: FloatArray,
        plane: PlaneHypothesis,
        views: NDArray[np.intp],
        taken: Sequence[NDArray[np.uint8]],
        cell_px: float,
    ) -> _Cells:
        # Cells along the longest side: the world's frame plays no part.
        along = np.roll(corners, -1, axis=0) - corners
        basis = make_plane_axes(plane.normal, along[largest(np.linalg.norm(along, axis=1))]).T
        flat = (corners - plane.normal * plane.distance) @ basis
        low, high = flat.min(axis=0), flat.max(axis=0)
        step = max(cell_px * self._pixel, float((high - low).max()) / MAX_CELLS)
        grid = PlaneGrid.over(plane, basis, low, high, step)
        outline = make_polygon(grid.cells(corners) + 0.5)
        middles = np.argwhere(np.ones(grid.shape))[:, ::-1] + 0.5
        middles = middles[shapely.contains_xy(outline, middles)]
        found, seen = self._photos.agree(views, grid.points(middles), taken)
        weight = self._photos.weight[views]
        missing = find_differing_places(weight @ seen, weight @ (seen & ~found.agrees))
        return _Cells(grid, outline, middles, missing)

    def _rings(
        self, cells: _Cells, plane: PlaneHypothesis, views: NDArray[np.intp]
    ) -> Iterator[FloatArray]:
        # Outlines of lines, and those of regions of cells that are no surface.
        grid = cells.grid
        for outline in find_outlines(plane, self._cloud, self._profiles):
            flat = grid.cells(outline.corners) + 0.5
            yield grid.points(flat if shapely.is_ccw(shapely.LinearRing(flat)) else flat[::-1])
        lines = grid.cells(self._cloud.segments[plane.lines]) + 0.5
        for region in cells.regions(MIN_FINE):
            ring = border(region)
            corners = fit_outline_polygon(ring, lines)
            if corners is not None:
                yield grid.points(corners)
            for rough in iter_rough_polygons(ring, MAX_SIDES if corners is None else len(corners)):
                about = grid.points(rough)
                yield self._sides.snap_to_edges(views, about, plane.normal, self._pixel)

    def _score(
        self,
        ring: FloatArray,
        cells: _Cells,
        normal: FloatArray,
        views: NDArray[np.intp],
        taken: Sequence[NDArray[np.uint8]],
    ) -> float:
        # Evidence for a hole from its edges, 0 where its inside or rim contradicts it. A plain
        # floor behind looks the same to all views: there lines decide.
        polygon = shapely.Polygon(cells.grid.cells(ring) + 0.5)
        clear = CLEAR_PX * self._pixel / cells.grid.step
        if not (polygon.is_valid and cells.outline.buffer(-clear).contains(polygon)):
            return 0.0
        away = shapely.distance(polygon, shapely.points(cells.middles))
        within, beside = away == 0, (away > clear) & (away < 2 * clear)
        if within.sum() < MIN_CELLS or beside.sum() < MIN_CELLS:
            return 0.0
        if cells.missing[beside].mean() > 1 - MIN_CONSISTENT:
            return 0.0
        if cells.missing[within].mean() < MIN_CONSISTENT and not self._behind.seen_through(
            ring, normal, views
        ):
            return 0.0
        if self._shines(cells.grid.points(cells.middles[within]), views, taken):
            return 0.0
        sides = make_ring_sides(ring)
        edges = self._sides.evidence(views, sides)
        hit = edges.found.sum(axis=(0, 2)) / np.maximum(edges.there.sum(axis=(0, 2)), 1)
        if (hit < MIN_COVERAGE).any():
            return 0.0
        ratio = float((self._photos.weight[views] @ edges.ratio).sum())
        return max(ratio - SIDE_PENALTY * len(ring) - CHANCE_PENALTY, 0.0)

    def _shines(
        self, points: FloatArray, views: NDArray[np.intp], taken: Sequence[NDArray[np.uint8]]
    ) -> bool:
        # Whether what views differ by is mostly how bright all of it is to each: a glossy label.
        weight = self._photos.weight[views]
        found, seen = self._photos.agree(views, points, taken)
        even = self._photos.compare_evened(views, points, taken)
        apart, left = (float((weight @ (seen & ~a.agrees)).sum()) for a in (found, even))
        return left < SHINES * apart


def _largest(shape: shapely.Geometry) -> shapely.Polygon | None:
    parts = [p for p in getattr(shape, "geoms", [shape]) if p.geom_type == "Polygon" and p.area > 0]
    return max(parts, key=lambda part: part.area) if parts else None


def find_differing_places(count: FloatArray, apart: FloatArray) -> NDArray[np.bool_]:
    """Return at which places (n,) more views disagree than elsewhere, of `count` views `apart`
    many.

    How often they do elsewhere is the share of all but those places. One view alone may have met a
    reflection.
    """
    more = np.zeros(len(count), dtype=np.bool_)
    rate = 1.0 / (count.sum() + 2.0)
    share = apart / np.maximum(count, 1e-300)
    for _ in range(STEPS):
        ratio = _times_log(apart, share / rate) + _times_log(
            count - apart, (1 - share) / (1 - rate)
        )
        again = (ratio > MIN_RATIO) & (share > rate) & (apart >= MIN_WEIGHT)
        if (again == more).all():
            break
        more = again
        rate = (apart[~more].sum() + 1.0) / (count[~more].sum() + 2.0)
    return more


def _times_log(factor: FloatArray, of: FloatArray) -> FloatArray:
    # factor · log(of), 0 where the factor is.
    product: FloatArray = factor * np.log(np.where(factor > 0, of, 1.0))
    return product
