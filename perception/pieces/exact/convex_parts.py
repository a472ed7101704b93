"""Parts that concave edges bound, whatever their shape: round rungs, wheels, splayed legs, rings.

A group of triangles that no concave edge crosses, and that closes with flat caps to nearly its own
convex hull, is a part; so is one that a lathe would make, and what is round and goes on flush.
"""

from dataclasses import dataclass, replace

import numpy as np

from facetlog.perception.flat_faces import cross, make_plane_axes
from facetlog.perception.pieces.exact.cut_pieces import CutPiece
from facetlog.perception.pieces.exact.regions import Regions
from facetlog.perception.pieces.exact.sheets import Sheets
from facetlog.perception.pieces.exact.wind_bodies import is_inside, run_along
from facetlog.perception.pieces.pieces import find_least_box
from facetlog.perception.ragged import Bools, Indices, iter_groups, joined, unique_rows
from facetlog.perception.types import FloatArray

# Share of its hull that a part fills: facets, dents and turned legs take some per cent.
CONVEX = 0.9
# Parts that one axis joins lie along it to this angle (radians), and have sections alike to this.
COAXIAL = np.radians(0.5)
SAME_SECTION = 0.02
# Corners of hulls that are compared with one another.
MOST_CORNERS = 150
# Places of a section at which solid is looked for.
MOST_SPOTS = 8
# Where between two ends: behind the first, in the middle, before the second.
BETWEEN = (0.01, 0.5, 0.99)
# A hull of which its least box is larger by less is a cuboid.
CUBOID = 1e-3
# A section is round from eight sides on: of an octagon the roundness is .75, of a hexagon .57.
ROUND = 0.7
# Mean sine by which sides of what was turned on a lathe face away from its axis: .2 for an octagon,
# .41 for a square.
ASKEW = 0.25
# The least share of the circle that shows of a round bar flush with another part, as of a wheel
# flush with its fork.
SEEN_ROUND = 0.55
# A chord of a twelfth of a circle is so far off it, as a share of the radius, and some.
OFF_ROUND = 0.04
# Directions that a part's least box is tried along: those of its largest faces.
DIRECTIONS = 8


@dataclass(frozen=True, eq=False, slots=True)
class Hull:
    """Corners (n, 3) of a convex hull, its planes (f, 4), outwards, its volume and its surface."""

    points: FloatArray
    planes: FloatArray
    volume: float
    area: float

    def contains(self, points: FloatArray, slack: float) -> Bools:
        """Return which points (k, 3) lie in the hull, or no farther off than the slack."""
        near: Bools = np.ones(len(points), dtype=np.bool_)
        for along, own in zip(points.T, self.points.T, strict=True):
            near &= (along >= own.min() - slack) & (along <= own.max() + slack)
        heights = points[near] @ self.planes[:, :3].T + self.planes[:, 3]
        near[near] = heights.max(axis=1) <= slack
        return near

    def measure_beyond(self, points: FloatArray) -> float:
        """Return how far the farthest of the points (k, 3) lies outside of the hull's planes."""
        beyond = (points @ self.planes[:, :3].T + self.planes[:, 3]).max(initial=0.0)
        return float(max(beyond, 0.0))

    def coarsen(self) -> "Hull":
        """Return a hull of few of the corners: those farthest out in evenly spread directions."""
        if len(self.points) <= MOST_CORNERS:
            return self
        # a Fibonacci sphere
        step = np.arange(MOST_CORNERS) + 0.5
        z, turn = 1.0 - 2.0 * step / MOST_CORNERS, np.pi * (1.0 + np.sqrt(5.0)) * step
        across = np.sqrt(1.0 - z * z)
        ways = np.stack([across * np.cos(turn), across * np.sin(turn), z])
        return find_hull(self.points[np.unique((self.points @ ways).argmax(axis=0))]) or self


@dataclass(frozen=True, eq=False, slots=True)
class ConvexPart:
    """Triangles (t,) of a part, its hull, and the volume that it fills."""

    rows: Indices
    hull: Hull
    volume: float


def find_hull(points: FloatArray) -> Hull | None:
    """Return the convex hull of points (n, 3), None if they lie in a plane."""
    from scipy.spatial import ConvexHull, QhullError  # loaded only where pieces are asked for

    if len(points) < 4:
        return None
    middle = points.mean(axis=0)
    try:
        hull = ConvexHull(points - middle)
    except QhullError:
        return None
    planes = unique_rows(np.round(hull.equations, 12))
    planes[:, 3] -= planes[:, :3] @ middle
    return Hull(points[hull.vertices], planes, float(hull.volume), float(hull.area))


def find_convex_groups(
    sheets: Sheets, regions: Regions, rows: Indices, pairs: Indices
) -> list[ConvexPart]:
    """Return the groups of a body that are convex parts.

    `rows` are the triangles of the body, `pairs` its pairs.
    """
    found = []
    concave = pairs[regions.concave[pairs]]
    groups = regions.group[sheets.pairs[concave]]
    # a concave edge within a group: it is no convex part
    broken = set(groups[groups[:, 0] == groups[:, 1], 0].tolist())
    ends = sheets.pairs[concave]
    for local in iter_groups(regions.group[rows]):
        own = rows[local]
        number = int(regions.group[own[0]])
        if number in broken:
            continue
        at = np.concatenate([concave[groups[:, 0] == number], concave[groups[:, 1] == number]])
        of = np.concatenate([ends[groups[:, 0] == number, 0], ends[groups[:, 1] == number, 1]])
        hull = find_hull(sheets.points[np.unique(sheets.triangles[own])])
        if hull is None or not hull.volume > (10.0 * sheets.slack) ** 2 * sheets.size:
            continue
        volume = _measure_volume(sheets, own, of, sheets.edges[at])
        if CONVEX * hull.volume <= volume <= (2.0 - CONVEX) * hull.volume or (
            0.0 < volume < hull.volume and is_turned(sheets, own, hull)
        ):
            found.append(ConvexPart(own, hull, volume))
    return found


def is_turned(sheets: Sheets, rows: Indices, hull: Hull) -> bool:
    """Return whether triangles are what a lathe makes: round about one axis, hollow or not."""
    normals, areas = sheets.normals[rows], sheets.areas[rows]
    middles = sheets.corners(rows).mean(axis=1)
    away = middles - np.average(middles, axis=0, weights=areas)
    for axis in np.linalg.eigh((normals * areas[:, None]).T @ normals)[1].T:
        about = cross(np.broadcast_to(axis, away.shape), away)
        about /= np.maximum(np.linalg.norm(about, axis=1, keepdims=True), 1e-300)
        steep = areas * np.linalg.norm(normals - (normals @ axis)[:, None] * axis, axis=1)
        if (areas * np.abs((normals * about).sum(axis=1))).sum() < ASKEW * steep.sum():
            return measure_section_roundness(hull.points, axis) > ROUND
    return False


def find_flush_bars(sheets: Sheets, regions: Regions, rows: Indices) -> list[ConvexPart]:
    """Return the round bars of which some sides go on in flat ones of others: a wheel beside its
    fork, of which these curved triangles are seen.
    """
    number = np.full(len(sheets.triangles), -1)
    number[rows] = np.arange(len(rows))
    smooth = (number[sheets.pairs] >= 0).all(axis=1) & ~regions.concave
    _, label = joined(len(rows), number[sheets.pairs[smooth]])
    found = []
    for local in iter_groups(label):
        own = rows[local]
        hull = _complete_bar(sheets, own)
        if hull is None:
            continue
        middle = hull.points.mean(axis=0)
        body = sheets.corners(sheets.body == sheets.body[own[0]])
        if all(is_inside(spot, body) for spot in middle + 0.9 * (hull.points - middle)):
            found.append(ConvexPart(own, hull, hull.volume))
    return found


def _complete_bar(sheets: Sheets, rows: Indices) -> Hull | None:
    """Return the hull of the round bar of which triangles show more than half the sides, if any."""
    normals, areas = sheets.normals[rows], sheets.areas[rows]
    axis = np.linalg.eigh((normals * areas[:, None]).T @ normals)[1][:, 0]
    if np.abs(normals @ axis).max() > np.sin(COAXIAL):
        return None
    across = make_plane_axes(axis[None], np.eye(3)[[np.abs(axis).argmin()]])[0]
    corners = sheets.corners(rows)
    flat, along = (corners @ across.T).reshape(-1, 2), corners @ axis
    # x² + y² = 2 (x, y) · centre + r² - centre²
    system = np.column_stack([2.0 * flat, np.ones(len(flat))])
    *centre, rest = np.linalg.lstsq(system, (flat**2).sum(axis=1), rcond=None)[0]
    radius = float(np.sqrt(max(rest + np.dot(centre, centre), 0.0)))
    off = np.linalg.norm(flat - centre, axis=1)
    outwards = ((corners.mean(axis=1) @ across.T - centre) * (normals @ across.T)).sum(axis=1)
    height = float(np.ptp(along))
    seen = float(areas.sum()) > SEEN_ROUND * 2.0 * np.pi * radius * height
    if not seen or (outwards <= 0.0).any() or np.abs(off - radius).max() > OFF_ROUND * radius:
        return None
    turns = np.arange(0.0, 2.0 * np.pi, np.radians(15.0))
    ring = np.array(centre) + radius * np.column_stack([np.cos(turns), np.sin(turns)])
    ends = [ring @ across + end * axis for end in (along.min(), along.max())]
    return find_hull(np.concatenate(ends))


def _measure_volume(sheets: Sheets, rows: Indices, of: Indices, edges: Indices) -> float:
    """Return the volume of triangles whose open edges (k, 2), of the triangles (k,), are closed by
    a fan from the middle of each loop.
    """
    corners = sheets.corners(rows)
    middle = corners.mean(axis=(0, 1))
    parts = [corners]
    if len(edges):
        start, end = run_along(sheets.triangles[of], edges)
        used, number = np.unique(edges, return_inverse=True)
        _, loop = joined(len(used), number.reshape(-1, 2))
        own = loop[number.reshape(-1, 2)[:, 0]]
        sums = np.stack([np.bincount(loop, column) for column in sheets.points[used].T], axis=1)
        centres = sums / np.bincount(loop)[:, None]
        parts.append(np.stack([sheets.points[end], sheets.points[start], centres[own]], axis=1))
    a, b, c = np.moveaxis(np.concatenate(parts) - middle, 1, 0)
    return float((a * cross(b, c)).sum() / 6.0)


def join_through(
    sheets: Sheets, rows: Indices, pieces: list[CutPiece], hulls: list[Hull]
) -> tuple[list[CutPiece], list[Hull]]:
    """Return the pieces of a body and their hulls, those made one that go on behind what they pass
    through: a rung whose ends show beyond the rails, a round post above and below a shelf.

    They have one section, one axis, and solid between them.
    """
    if len(pieces) < 2:
        return pieces, hulls
    axes = np.array([piece.axes for piece in pieces])
    middles = np.array([piece.middle for piece in pieces]) - sheets.centre
    away = middles[:, None] - middles
    away /= np.maximum(np.linalg.norm(away, axis=2, keepdims=True), 1e-300)
    # the way to each other is along an axis of each, and the longest of the larger: they are bars
    along = np.abs(np.einsum("aki,abi->abk", axes, away)) > np.cos(COAXIAL)
    volumes = np.array([piece.volume for piece in pieces])
    longest = np.where(volumes[:, None] >= volumes, along[..., 0], along[..., 0].T)
    near = along.any(axis=2) & along.any(axis=2).T & longest
    corners = sheets.corners(rows)
    pairs = [
        (one, two)
        for one, two in np.argwhere(np.triu(near, 1)).tolist()
        if _goes_on(hulls[one].points, hulls[two].points, away[two, one], corners)
    ]
    _, number = joined(len(pieces), pairs)
    found: list[CutPiece] = []
    wholes: list[Hull] = []
    for own in iter_groups(number):
        hull = find_hull(np.concatenate([hulls[i].points for i in own]))
        if len(own) == 1 or hull is None:
            found += [pieces[i] for i in own]
            wholes += [hulls[i] for i in own]
            continue
        largest = pieces[max(own, key=lambda i: pieces[i].volume)]
        extents, along, middle = find_least_box(hull.points, list(largest.axes), 0.0)
        found.append(
            replace(
                largest,
                hull=hull.points + sheets.centre,
                axes=along,
                middle=middle + sheets.centre,
                extents=extents,
                volume=sum(pieces[i].volume for i in own),
            )
        )
        wholes.append(hull)
    return found, wholes


def _goes_on(one: FloatArray, two: FloatArray, axis: FloatArray, corners: FloatArray) -> bool:
    """Return whether two parts with these corners have one section along the axis from one to the
    other, and solid of the body of triangles (m, 3, 3) between them.
    """
    from scipy.spatial import ConvexHull, QhullError

    across = make_plane_axes(axis[None], np.eye(3)[[np.abs(axis).argmin()]])[0]
    try:
        sections = [ConvexHull(each @ across.T) for each in (np.concatenate([one, two]), one, two)]
    except QhullError:
        return False
    areas = [float(section.volume) for section in sections]
    if min(areas) < (1.0 - SAME_SECTION) * max(areas):
        return False
    end, start = float((one @ axis).max()), float((two @ axis).min())
    plan = (one @ across.T)[sections[1].vertices]
    plan = np.concatenate([[plan.mean(axis=0)], plan + 0.1 * (plan.mean(axis=0) - plan)])
    spots = plan[:: max(1, len(plan) // MOST_SPOTS)] @ across
    return all(
        is_inside(spot + (end + share * (start - end)) * axis, corners)
        for share in BETWEEN
        for spot in spots
    )


def make_convex_piece(sheets: Sheets, regions: Regions, part: ConvexPart) -> CutPiece:
    """Return the piece of a convex part, with its triangles on its surface."""
    rows, hull, volume = part.rows, part.hull, part.volume
    label = regions.label[rows]
    curved = regions.curved[label]
    box = None if curved.any() else _find_box(regions.normals[np.unique(label)], hull)
    if box is not None:
        extents, axes, middle = box
        return CutPiece(
            hull.points + sheets.centre,
            axes,
            middle + sheets.centre,
            extents,
            0.0,
            volume,
        )
    areas = np.bincount(label, sheets.areas[rows], minlength=len(regions.normals))
    flat = np.flatnonzero((areas > 0.0) & ~regions.curved)
    flat = flat[np.argsort(-areas[flat], kind="stable")][:DIRECTIONS]
    directions = list(regions.normals[flat])
    ways = np.zeros((0, 3))
    if curved.any():
        # what curves about an axis is square to it, and a ring lies across it
        own = sheets.normals[rows][curved]
        weights = sheets.areas[rows][curved]
        ways = np.linalg.eigh((own * weights[:, None]).T @ own)[1].T
        directions += list(ways)
    extents, axes, middle = find_least_box(hull.points, directions or [np.eye(3)[2]], 0.0)
    ways = ways if len(ways) else axes
    return CutPiece(
        hull.points + sheets.centre,
        axes,
        middle + sheets.centre,
        extents,
        max(measure_section_roundness(hull.points, each) for each in ways),
        volume,
    )


def _find_box(normals: FloatArray, hull: Hull) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Return extents, axes and middle of a hull that is a cuboid with these face normals (r, 3)."""
    first = normals[0]
    square = np.flatnonzero(np.abs(normals @ first) < COAXIAL)
    if not len(square):
        return None
    second = normals[square[0]] - (normals[square[0]] @ first) * first
    second /= np.linalg.norm(second)
    axes = np.stack([first, second, cross(first, second)])
    along = hull.points @ axes.T
    extents = np.ptp(along, axis=0)
    if extents.prod() > hull.volume * (1.0 + CUBOID):
        return None
    order = np.argsort(-extents, kind="stable")
    middle: FloatArray = 0.5 * (along.min(axis=0) + along.max(axis=0)) @ axes
    return extents[order], axes[order], middle


def measure_section_roundness(points: FloatArray, axis: FloatArray) -> float:
    """Return how round the shadow of points (n, 3) along an axis is: 1 a circle, 0 a square or
    anything less round.

    By the isoperimetric quotient 4 π A / P², which is π / 4 for a square.
    """
    from scipy.spatial import ConvexHull, QhullError

    across = make_plane_axes(axis[None], np.eye(3)[[np.abs(axis).argmin()]])[0]
    try:
        section = ConvexHull(points @ across.T)
    except QhullError:
        return 0.0
    quotient = 4.0 * np.pi * section.volume / section.area**2
    return float(np.clip((quotient - np.pi / 4.0) / (1.0 - np.pi / 4.0), 0.0, 1.0))
