"""Outlines of a cloud's planes: straight sides round what points cover, or where planes meet."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import Delaunay, KDTree, QhullError

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.polygons import find_intersection, join_triangles
from facetlog.perception.shapes.clouds.cloud_planes import CloudPlane, CloudPlanes
from facetlog.perception.shapes.clouds.neighbourhoods import find_k_nearest
from facetlog.perception.shapes.regions.flat_region import PlaneFrame
from facetlog.perception.types import FloatArray

# Random points leave an empty disc of 2.2 times their spacing once in e^15 (π 2.2²).
ALPHA = 2.2
# More points than this make no better outline, only a slower one; the spacing grows with the gap.
MOST_POINTS = 6000
# Whiskers and cracks narrower than twice this, in spacings, are the triangulation's own.
CLEARED = 1.0
# Holes must be this wide, in spacings, to be holes and not chance.
HOLE = 4.0
# Pieces with less than this share of the largest one's area are scatter.
PIECE_SHARE = 0.05
# Noise of less than this many spacings moves no rim by more than its own jaggedness.
LEAST_NOISE = 0.5
# Density is smoothed by the noise, by so many spacings at least (28 points: good to a fifth), in
# bins of a share of that, and compared with its mean over twice that.
LEAST_SMOOTHING, DENSITY_BIN, AROUND = 1.5, 0.5, 2.0
# A face of more bins, a thousand widths across, is changed by noise at its rim by less than .2 %.
MOST_BINS = 4_000_000
# At a straight rim blurred by noise density is half that of the inside, and so much of the mean
# around (.5 / .8, by integration).
RIM_DENSITY = 0.62
# Points and corners are put on a grid this fine, in spacings. Without one the overlay of two areas
# can fail where sides all but touch (GEOS rounds onto the grid soundly), and the corners that it
# leaves on a side would come from the last digits of the points, which differ by processor.
GRID = 1e-6
# The jagged rim of points at random is within so many spacings of the true one.
JAG = 1.5
# A ring is a rectangle if no point of either is further than this, in spacings, from the other.
RECTANGLE_JAG = 3.0
# Sides shorter than this, in spacings, are what is left of a corner that no point fell into.
SHORTEST = 4.0
# A side's direction is uncertain by about a spacing over its length; within this multiple of that,
# and never more than 12 degrees, it is made parallel or perpendicular to the others.
SQUARE_SPACINGS = 1.5
MOST_SQUARED = np.deg2rad(12.0)
# A side this short, in spacings, is a corner cut off, if it is between two that lie where planes
# meet (of three faces' points there, the nearest to the corner are dealt to any of them), or
# between two that are so many times longer (points at random fill a corner up).
CUT = 8.0
LONGER = 3.0
# Lines that meet under less than this have no well-defined corner (15 degrees).
MEETING = np.deg2rad(15.0)
# A corner where two lines meet is within so many spacings of where the ring turns.
CORNER_REACH = 6.0
# Points at random end half a spacing before the rim of what they are on.
INSET = 0.5


@dataclass(frozen=True, eq=False, slots=True)
class SideLine:
    """A side: a point of its line and its unit direction (2,), as the ring runs; its length.

    `fixed` says that it lies where two planes meet, and `start` (2,) is where the ring turned
    into it.
    """

    point: FloatArray
    direction: FloatArray
    length: float
    start: FloatArray
    fixed: bool = False

    @property
    def outward(self) -> FloatArray:
        """Unit vector to the right of the direction: outside, where the ring runs left-handed."""
        return np.array([self.direction[1], -self.direction[0]])

    def distance(self, points: FloatArray) -> FloatArray:
        """Return distances outwards of points (n, 2) from the line."""
        distance: FloatArray = (points - self.point) @ self.outward
        return distance


def fit_side_lines(
    ring: FloatArray, spacing: float, *, inwards: bool = False
) -> tuple[SideLine, ...]:
    """Return sides of a counter-clockwise ring (n, 2); `inwards` for a hole, with points around."""
    dense = shapely.segmentize(shapely.LinearRing(ring), spacing)
    rim = shapely.get_coordinates(dense)[:-1]
    corners = _corners(ring, spacing)
    if len(corners) < 3:
        return ()
    ends = np.roll(corners, -1, axis=0)
    segments = shapely.linestrings(np.stack([corners, ends], axis=1))
    nearest = shapely.distance(shapely.points(rim)[:, None], segments[None]).argmin(axis=1)
    lines = []
    for nth, (start, end) in enumerate(zip(corners, ends, strict=True)):
        span = end - start
        length = float(np.linalg.norm(span))
        direction = span / length
        own = rim[nearest == nth]
        along = (own - start) @ direction
        # at its ends a side's rim is already round
        inner = own[(along > spacing) & (along < length - spacing)]
        point = (start + end) / 2.0
        if len(inner) > 2:
            point = inner.mean(axis=0)
            fitted = np.linalg.eigh((inner - point).T @ (inner - point))[1][:, 1]
            direction = fitted if fitted @ direction > 0.0 else -fitted
        outward = np.array([direction[1], -direction[0]])
        shift = (-INSET if inwards else INSET) * spacing
        lines.append(SideLine(point + shift * outward, direction, length, start))
    return tuple(lines)


def _corners(ring: FloatArray, spacing: float) -> FloatArray:
    """Return corners (k, 2) of the simplest ring within the jaggedness, counter-clockwise."""
    polygon = shapely.Polygon(ring)
    box = shapely.minimum_rotated_rectangle(polygon)
    if box.geom_type == "Polygon" and box.area > 0.0:
        # the rectangle round all points is moved in by half of what sticks out
        gap = shapely.hausdorff_distance(box.exterior, polygon.exterior, densify=0.05)
        if gap <= RECTANGLE_JAG * spacing:
            return _loop(box)
    simple = shapely.simplify(polygon, JAG * spacing, preserve_topology=True)
    return _drop_chamfers(_loop(simple), SHORTEST * spacing)


def _loop(polygon: shapely.Polygon) -> FloatArray:
    """Return the rim of a polygon (k, 2), counter-clockwise, without the first point repeated."""
    rim: FloatArray = shapely.get_coordinates(shapely.geometry.polygon.orient(polygon).exterior)
    return rim[:-1]


def _drop_chamfers(corners: FloatArray, shortest: float) -> FloatArray:
    """Return corners in which short sides between two that meet are one corner, or the middle of
    both.
    """
    while len(corners) > 3:
        spans = np.roll(corners, -1, axis=0) - corners
        lengths = np.linalg.norm(spans, axis=1)
        nth = int(lengths.argmin())
        if lengths[nth] >= shortest:
            break
        count = len(corners)
        before, after = spans[nth - 1], spans[(nth + 1) % count]
        meeting = _meeting(corners[nth - 1], before, corners[(nth + 1) % count], after)
        middle = (corners[nth] + corners[(nth + 1) % count]) / 2.0
        if meeting is None or np.linalg.norm(meeting - middle) > shortest:
            meeting = middle
        corners = corners.copy()
        corners[nth] = meeting
        corners = np.delete(corners, (nth + 1) % count, axis=0)
    return corners


def _meeting(p: FloatArray, d: FloatArray, q: FloatArray, e: FloatArray) -> FloatArray | None:
    """Return where the lines p + s d and q + t e meet; None within 15 degrees of parallel."""
    turn = float(d[0] * e[1] - d[1] * e[0])
    if abs(turn) < np.sin(MEETING) * float(np.linalg.norm(d) * np.linalg.norm(e)):
        return None
    gap = q - p
    met: FloatArray = p + d * float(gap[0] * e[1] - gap[1] * e[0]) / turn
    return met


def squared(lines: tuple[SideLine, ...], spacing: float) -> tuple[SideLine, ...]:
    """Return sides made parallel or perpendicular to the most certain one, within their errors.

    Sides where planes meet are most certain, then long ones; they are not rotated themselves.
    """
    if not lines:
        return ()
    surest = max(lines, key=lambda line: (line.fixed, line.length))
    reference = float(np.arctan2(surest.direction[1], surest.direction[0]))
    turned = []
    for line in lines:
        angle = float(np.arctan2(line.direction[1], line.direction[0]))
        square = reference + np.round((angle - reference) / (np.pi / 2.0)) * (np.pi / 2.0)
        slack = min(SQUARE_SPACINGS * spacing / line.length * 2.0, MOST_SQUARED)
        if not line.fixed and abs(angle - square) <= slack:
            direction = np.array([np.cos(square), np.sin(square)])
            line = SideLine(line.point, direction, line.length, line.start)
        turned.append(line)
    return tuple(turned)


def find_meeting_corners(lines: tuple[SideLine, ...], spacing: float) -> FloatArray:
    """Return corners (k, 2) of the ring whose sides lie on the lines.

    Where two in succession do not meet near the place where the ring turned, as parallel ones do
    not, both end there, and a short side joins them.
    """
    lines = _drop_cuts(lines, CUT * spacing)
    corners: list[FloatArray] = []
    for nth, line in enumerate(lines):
        before = lines[nth - 1]
        met = _meeting(before.point, before.direction, line.point, line.direction)
        if met is not None and np.linalg.norm(met - line.start) <= CORNER_REACH * spacing:
            corners.append(met)
            continue
        ends = [
            one.point + (line.start - one.point) @ one.direction * one.direction
            for one in (before, line)
        ]
        if np.linalg.norm(ends[0] - ends[1]) <= JAG * spacing:
            ends = [(ends[0] + ends[1]) / 2.0]
        corners.extend(ends)
    return _drop_straight_corners(np.array(corners), JAG * spacing)


def _drop_cuts(lines: tuple[SideLine, ...], longest: float) -> tuple[SideLine, ...]:
    """Return sides without short ones between two that are fixed, or much longer, and meet near
    them.
    """
    cuts = [_is_cut(lines, nth, longest) for nth in range(len(lines))]
    if len(lines) - sum(cuts) < 3:
        return lines
    # the side after a cut now begins where the cut did
    return tuple(
        replace(line, start=lines[nth - 1].start) if cuts[nth - 1] else line
        for nth, line in enumerate(lines)
        if not cuts[nth]
    )


def _is_cut(lines: tuple[SideLine, ...], nth: int, longest: float) -> bool:
    """Return whether a side only cuts off the corner of its neighbours."""
    before, line, after = lines[nth - 1], lines[nth], lines[(nth + 1) % len(lines)]
    longer = min(before.length, after.length) >= LONGER * line.length
    if line.fixed or line.length > longest or not ((before.fixed and after.fixed) or longer):
        return False
    met = _meeting(before.point, before.direction, after.point, after.direction)
    return met is not None and float(np.linalg.norm(met - line.start)) <= longest


def _drop_straight_corners(corners: FloatArray, jag: float) -> FloatArray:
    """Return corners but those within a tenth of `jag` of the line between their neighbours."""
    keep: NDArray[np.bool_] = np.ones(len(corners), dtype=bool)
    for nth in range(len(corners)):
        rest = np.flatnonzero(keep)
        if len(rest) <= 3:
            break
        place = int(np.searchsorted(rest, nth))
        a, b = corners[rest[place - 1]], corners[rest[(place + 1) % len(rest)]]
        span = b - a
        length = float(np.linalg.norm(span))
        gap = corners[nth] - a
        if length > 0.0 and abs(span[0] * gap[1] - span[1] * gap[0]) / length < 0.1 * jag:
            keep[nth] = False
    return corners[keep]


def find_covered_area(
    flat: FloatArray, spacing: FloatArray, noise: float = 0.0
) -> tuple[tuple[shapely.Polygon, ...], float]:
    """Return polygons that points (n, 2) cover, largest first, and the median spacing they rest on.

    `spacing` (n,) is the side of the square that each point has to itself, `noise` the sd of a
    point. There are none where the points are on one line.
    """
    if len(flat) > MOST_POINTS:
        kept = np.random.default_rng(0).permutation(len(flat))[:MOST_POINTS]
        flat, spacing = flat[kept], spacing[kept] * np.sqrt(len(flat) / MOST_POINTS)
    typical = float(np.median(spacing))
    if not typical > 0.0:
        return (), typical
    if noise > LEAST_NOISE * typical:
        dense = _is_dense(flat, max(noise, LEAST_SMOOTHING * typical))
        flat, spacing = flat[dense], spacing[dense]
    # of a power of two all multiples are exact
    step = float(np.exp2(np.floor(np.log2(GRID * typical))))
    flat, typical = np.rint(flat / step) * step, float(np.rint(typical / step)) * step
    try:
        triangles = Delaunay(flat).simplices
    except (QhullError, ValueError):
        return (), typical
    # A point that is sparse by its neighbourhood's chance must not let a real gap be bridged.
    reach = ALPHA * np.minimum(spacing, 2.0 * typical)[triangles].mean(axis=1)
    kept_triangles = flat[triangles[_compute_circumradius(flat[triangles]) <= reach]]
    if not len(kept_triangles):
        return (), typical
    whole = join_triangles(kept_triangles)
    width = CLEARED * typical
    closed = whole.buffer(width, join_style="mitre").buffer(-width, join_style="mitre")
    opened = closed.buffer(-width, join_style="mitre").buffer(width, join_style="mitre")
    both = find_intersection(opened, closed, grid_size=GRID * typical)
    pieces = [p for p in shapely.get_parts(both) if p.geom_type == "Polygon"]
    pieces = [_drop_pinholes(p, HOLE * typical) for p in pieces if p.area > 0.0]
    pieces.sort(key=lambda piece: -piece.area)
    return tuple(p for p in pieces if p.area >= PIECE_SHARE * pieces[0].area), typical


def _is_dense(flat: FloatArray, width: float) -> NDArray[np.bool_]:
    """Return whether there are as many points at each of points (n, 2) as within a blurred rim,
    (n,).

    Noise carries points 3 sd beyond a face, and along another plane that passes through it; there
    are less than half as many there as on the face. `width` is what density is smoothed by.
    """
    scaled = (flat - flat.min(axis=0)) / (DENSITY_BIN * width)
    if np.prod(scaled.max(axis=0) + 1.0) > MOST_BINS:
        return np.ones(len(flat), dtype=np.bool_)
    bins = np.floor(scaled).astype(np.intp)
    counts = np.zeros(bins.max(axis=0) + 1)
    np.add.at(counts, tuple(bins.T), 1.0)
    density = ndimage.gaussian_filter(counts, 1.0 / DENSITY_BIN, mode="constant")
    sums, squares = (
        ndimage.gaussian_filter(each, AROUND / DENSITY_BIN, mode="constant")
        for each in (density, density**2)
    )
    dense: NDArray[np.bool_] = (density * sums >= RIM_DENSITY * squares)[tuple(bins.T)]
    return dense


def _compute_circumradius(triangles: FloatArray) -> FloatArray:
    """Return radii (n,) of the circles through corners (n, 3, 2): r = abc / (4 area)."""
    sides = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2)
    (ax, ay), (bx, by) = np.moveaxis(triangles[:, 1:] - triangles[:, :1], (1, 2), (0, 1))
    twice = np.abs(ax * by - ay * bx)
    radius: FloatArray = sides.prod(axis=1) / np.maximum(2.0 * twice, 1e-300)
    return radius


def _drop_pinholes(polygon: shapely.Polygon, width: float) -> shapely.Polygon:
    holes = [r for r in polygon.interiors if not shapely.Polygon(r).buffer(-width / 2.0).is_empty]
    return shapely.Polygon(polygon.exterior, holes)


# A side lies where two planes meet if both have points within so many spacings of that line: the
# last row of points, one more, and one that was dealt to nobody.
SNAP_SPACINGS = 3.0
# ... over half of the side. Half of it may be in another thing's shadow.
SNAP_SHARE = 0.5
SNAP_PROBES = 9
# ... and if a side so many spacings long, thrice what may be cut off at a corner, is not turned by
# more than the jaggedness of the rim and one sd at its ends: it is known better than the plane of
# what is narrow, as a leg or a board's rim.
LONG_SIDE = 3.0 * CUT
# ... and if the planes meet under 20 degrees or more: the line is known to σ / sin of that.
SNAP_SINE = float(np.sin(np.deg2rad(20.0)))
# Straight sides replace the jagged area if they cover this share of it; else it is only simplified,
# to within so many spacings.
SAME_AREA = 0.8
ROUGH = 2.0
# A straight side of points at random is known to about this share of their spacing.
RIM_SD = 0.5
# A face's own points are within so many sd of its rim: one in 2,000 is further.
NOISE_SDS = 3.5


@dataclass(frozen=True, eq=False, slots=True)
class Outline:
    """A piece of a plane with its rim: loops (k, 3) in the plane, and the sd of a corner.

    `region` numbers the plane, `members` are its points within (rows of the cloud). The outline
    runs counter-clockwise about the plane's normal, the holes clockwise.
    """

    region: int
    outline: FloatArray
    holes: tuple[FloatArray, ...]
    members: NDArray[np.intp]
    corner_sd: float


@dataclass(frozen=True, eq=False, slots=True)
class _Neighbours:
    """All planes of a cloud: unit normals (m, 3), offsets, rms distances (m,), and their points."""

    normals: FloatArray
    offsets: FloatArray
    rms: FloatArray
    trees: tuple[KDTree, ...]

    @classmethod
    def of(cls, points: FloatArray, planes: Sequence[CloudPlane]) -> "_Neighbours":
        return cls(
            np.array([plane.plane.normal for plane in planes]).reshape(-1, 3),
            np.array([plane.plane.offset for plane in planes]),
            np.array([plane.rms for plane in planes]),
            tuple(KDTree(points[plane.members]) for plane in planes),
        )

    def snap_side(self, line: SideLine, own: int, frame: PlaneFrame, spacing: float) -> SideLine:
        """Return the side moved to where its plane meets another's, if it lies there; else as it
        is.
        """
        slopes = self.normals @ frame.axes.T
        sines = np.linalg.norm(slopes, axis=1)
        sines[own] = 0.0
        steep = np.flatnonzero(sines >= SNAP_SINE)
        slopes = slopes[steep] / sines[steep, None]
        levels = (self.normals[steep] @ frame.origin + self.offsets[steep]) / sines[steep]
        errors = np.hypot(self.rms[own], self.rms[steep]) / sines[steep]
        reaches = SNAP_SPACINGS * (spacing + errors)
        shares = np.linspace(-0.5, 0.5, SNAP_PROBES)[:, None]
        probes = line.point + shares * line.length * line.direction
        gaps = probes @ slopes.T + levels
        # the two ends of a side are rounder than the rest
        close = np.abs(gaps[1:-1]).max(axis=0, initial=0.0) <= reaches
        turns = np.abs(gaps[-1] - gaps[0]) / 2.0
        if line.length > LONG_SIDE * spacing:
            close &= turns <= JAG * spacing + errors
        near = np.flatnonzero(close)
        for k in near[np.argsort(np.abs(gaps[:, near]).mean(axis=0), kind="stable")].tolist():
            on_line = frame.lift(probes - gaps[:, [k]] * slopes[k])
            tree = self.trees[steep[k]]
            far = find_k_nearest(tree, on_line, 1, within=float(reaches[k]))[0]
            if np.isfinite(far).mean() < SNAP_SHARE:
                continue
            direction = np.array([-slopes[k, 1], slopes[k, 0]])
            direction = direction if direction @ line.direction > 0.0 else -direction
            point = line.point - float(line.point @ slopes[k] + levels[k]) * slopes[k]
            return replace(line, point=point, direction=direction, fixed=True)
        return line


def cloud_outlines(
    points: FloatArray, found: CloudPlanes, *, first: int = 0
) -> tuple[Outline, ...]:
    """Return outlines of all planes of a cloud of points (n, 3) from the first on, in their order.

    A plane whose points lie in several pieces has one for each; points outside all pieces, and
    planes whose points cover no area, have none.
    """
    neighbours = _Neighbours.of(points, found.planes)
    every = (_pieces(nth, points, found, neighbours) for nth in range(first, len(found.planes)))
    return tuple(outline for pieces in every for outline in pieces)


def _pieces(
    nth: int, points: FloatArray, found: CloudPlanes, neighbours: _Neighbours
) -> Iterator[Outline]:
    plane = found.planes[nth]
    own = points[plane.members]
    middle = own.mean(axis=0)
    origin = middle - plane.plane.distance(middle) * plane.plane.normal
    spread = np.linalg.eigh((own - middle).T @ (own - middle))[1][:, -1]
    frame = PlaneFrame(origin, make_plane_axes(plane.plane.normal, spread))
    flat = frame.flatten(own)
    areas, spacing = find_covered_area(flat, found.spacing[plane.members], plane.rms)
    for area in areas:
        outline = _ring(area.exterior, nth, frame, spacing, neighbours)
        holes = [
            _ring(hole, nth, frame, spacing, neighbours, is_hole=True) for hole in area.interiors
        ]
        if len(outline) < 3:
            continue
        shape = _make_sound(outline, [hole for hole in holes if len(hole) >= 3], area, spacing)
        beyond = max(spacing, NOISE_SDS * plane.rms)
        held = shapely.contains_xy(shape.buffer(beyond), flat[:, 0], flat[:, 1])
        shape = shapely.geometry.polygon.orient(shape)
        yield Outline(
            nth,
            frame.lift(shapely.get_coordinates(shape.exterior)[:-1]),
            tuple(frame.lift(shapely.get_coordinates(hole)[:-1]) for hole in shape.interiors),
            plane.members[held],
            float(np.hypot(RIM_SD * spacing, plane.rms)),
        )


def _make_sound(
    outline: FloatArray, holes: Sequence[FloatArray], area: shapely.Polygon, spacing: float
) -> shapely.Polygon:
    """Return the polygon of straight sides if it is valid and covers the area; else the simplified
    area.

    Where sides moved onto one another, those of the outline alone may still do.
    """
    for shape in (shapely.Polygon(outline, holes), shapely.Polygon(outline)):
        if shape.is_valid and find_intersection(shape, area).area >= SAME_AREA * area.area:
            return shape
    simple = shapely.simplify(area, ROUGH * spacing, preserve_topology=True)
    return simple if simple.geom_type == "Polygon" and simple.is_valid else area


def _ring(
    ring: shapely.LinearRing,
    nth: int,
    frame: PlaneFrame,
    spacing: float,
    neighbours: _Neighbours,
    *,
    is_hole: bool = False,
) -> FloatArray:
    """Return corners (k, 2) of one ring, counter-clockwise; fewer than 3 where nothing is left."""
    around = shapely.geometry.polygon.orient(shapely.Polygon(ring))
    lines = fit_side_lines(shapely.get_coordinates(around.exterior), spacing, inwards=is_hole)
    lines = tuple(neighbours.snap_side(line, nth, frame, spacing) for line in lines)
    return find_meeting_corners(squared(lines, spacing), spacing) if lines else np.zeros((0, 2))
