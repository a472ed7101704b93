"""The visible lines of a scene's edges in a view: hidden lines removed, as a line drawing.

An edge changes from seen to hidden only where it crosses the picture of another edge (A. Appel,
"The notion of quantitative invisibility and the machine rendering of solids", 1967), or meets its
border. So edges are cut there, and each piece is seen or hidden as its middle is.
"""

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from facetlog.perception.line_drawing import LineDrawing
from facetlog.perception.ragged import joined
from facetlog.perception.surfaces.drawing.frustum import NEAR_SHARE
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.types import Camera, FloatArray, Pose

# Points of a drawing nearer than this are one, px: half of what tells two pixels apart.
SAME_POINT_PX = 0.5
# So they are taken to be where they are to half of that; a uniform error has this deviation. How
# exactly vertices are known does not count: two edges look like one line only by accident.
POINT_SD_PX = SAME_POINT_PX / 2 / np.sqrt(3.0)
# A face hides an edge of which an end lies behind its plane by more than so many deviations, and by
# more than rounding leaves, as a share of the distance from the camera.
BEHIND_SDS = 3.0
ROUNDING_SHARE = 1e-9
# Which faces lie beside an edge is asked so far off it, as a share of its length.
BESIDE_SHARE = 0.01


@dataclass(frozen=True, eq=False, slots=True)
class VisibleLines:
    """The drawing of a view: `vertex` (n,) is the scene's vertex at each point, or -1 where lines
    only cross or end at the border; `edge` (m,) is the edge of which each line is a piece.
    """

    drawing: LineDrawing
    vertex: NDArray[np.intp]
    edge: NDArray[np.intp]


def visible_lines(
    table: FaceTable,
    edges: NDArray[np.intp],
    bounds: NDArray[np.intp],
    flat: NDArray[np.intp],
    camera: Camera,
    pose: Pose,
) -> VisibleLines:
    """Return what a camera sees of edges (e, 2), pairs of vertices, among the faces of the table.

    `bounds` (b, 2) are an edge and a face that has it as a side, which does not hide it. Faces hide
    whichever way they look. `flat` (k, 3) are an edge and two faces along it that go on in one
    plane: where these are on either side of it, no line is seen.
    """
    ends = (table.points[edges] - pose.centre) @ pose.rotation
    number, ends, whole = _clip_edges_to_picture(ends, camera)
    pixels = _pixels(ends, camera)
    long = np.linalg.norm(pixels[:, 1] - pixels[:, 0], axis=1) > SAME_POINT_PX
    number, ends, whole, pixels = number[long], ends[long], whole[long], pixels[long]
    owner, low, high = _pieces(pixels)
    middles = _between(ends[owner], low, high) @ pose.rotation.T + pose.centre
    seen = _seen(table, edges, bounds, pose.centre, number[owner], middles)
    owner, low, high, middles = owner[seen], low[seen], high[seen], middles[seen]
    idle = _lie_within_plane(table, edges, flat, number[owner], middles)
    spans = pixels[owner]
    along = spans[:, 1] - spans[:, 0]
    starts, stops = spans[:, 0] + low[:, None] * along, spans[:, 0] + high[:, None] * along
    # Which vertex of the scene a piece begins or ends at, and how far that is.
    at = np.full((len(owner), 2), -1)
    for side, share in ((0, low), (1, high)):
        is_end = whole[owner, side] & (share == side)
        at[is_end, side] = edges[number[owner[is_end]], side]
    point_of, points, vertex = _points(np.concatenate([starts, stops]), at.T.ravel())
    lines = point_of.reshape(2, -1).T
    # Another edge may run along one within a plane, and be drawn there in its place.
    pairs = np.sort(lines, axis=1) @ [len(points), 1]
    kept = ~np.isin(pairs, pairs[idle])
    return _make_drawing(points, vertex, lines[kept], number[owner[kept]])


def _pixels(ends: FloatArray, camera: Camera) -> FloatArray:
    """Return pixels (..., 2) of points (..., 3) of the camera's frame, which lie before it."""
    focal, middle = np.array([camera.fx, camera.fy]), np.array([camera.cx, camera.cy])
    found: FloatArray = ends[..., :2] / ends[..., 2:] * focal + middle
    return found


def _clip_edges_to_picture(
    ends: FloatArray, camera: Camera
) -> tuple[NDArray[np.intp], FloatArray, NDArray[np.bool_]]:
    """Find the edges (k,) that reach into the picture, their ends there (k, 2, 3), which are whole
    (k, 2).

    Liang and Barsky 1984, with planes through the camera in place of the picture's sides.
    """
    near = NEAR_SHARE * max(float(ends[..., 2].max(initial=0.0)), np.finfo(np.float64).tiny)
    left, right = -0.5 - camera.cx, camera.width - 0.5 - camera.cx
    top, bottom = -0.5 - camera.cy, camera.height - 0.5 - camera.cy
    planes = np.array(
        [
            [0.0, 0.0, 1.0, -near],
            [camera.fx, 0.0, -left, 0.0],
            [-camera.fx, 0.0, right, 0.0],
            [0.0, camera.fy, -top, 0.0],
            [0.0, -camera.fy, bottom, 0.0],
        ]
    )
    inside = ends @ planes[:, :3].T + planes[:, 3]
    first, last = inside[:, 0], inside[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        cut = first / (first - last)
    low = np.where(first < 0, cut, 0.0).max(axis=1)
    high = np.where(last < 0, cut, 1.0).min(axis=1)
    kept = np.flatnonzero(((first >= 0) | (last >= 0)).all(axis=1) & (low < high))
    along = ends[kept, 1] - ends[kept, 0]
    shares = np.stack([low[kept], high[kept]], axis=1)
    cut_ends = ends[kept, :1] + shares[:, :, None] * along[:, None]
    return kept, cut_ends, shares == [0.0, 1.0]


def _pieces(pixels: FloatArray) -> tuple[NDArray[np.intp], FloatArray, FloatArray]:
    """Cut segments (k, 2, 2) where others cross or touch them.

    Pieces as the segment's number, and where they begin and end on it, as shares of its picture.
    """
    count = len(pixels)
    start, along = pixels[:, 0], pixels[:, 1] - pixels[:, 0]
    length = np.linalg.norm(along, axis=1)
    slack = SAME_POINT_PX / np.maximum(length, SAME_POINT_PX)
    # start_i + s along_i = start_j + t along_j
    apart = start[None] - start[:, None]
    turn = along[:, None, 0] * along[None, :, 1] - along[:, None, 1] * along[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (apart[..., 0] * along[None, :, 1] - apart[..., 1] * along[None, :, 0]) / turn
    t = s.T
    crossed = (t >= -slack[None, :]) & (t <= 1 + slack[None, :])
    # Ends of others that lie on a segment cut it as well where both run along each other.
    tips = pixels.reshape(-1, 2)
    off = tips[None] - start[:, None]
    square = np.maximum(length**2, np.finfo(np.float64).tiny)[:, None]
    foot = (off * along[:, None]).sum(axis=2) / square
    across = np.abs(off[..., 0] * along[:, None, 1] - off[..., 1] * along[:, None, 0])
    touched = across <= SAME_POINT_PX * length[:, None]
    own = np.concatenate([np.nonzero(crossed)[0], np.nonzero(touched)[0]])
    share = np.concatenate([s[crossed], foot[touched]])
    inner = (share > slack[own]) & (share < 1 - slack[own])
    # and every segment begins at 0
    own = np.concatenate([np.arange(count), own[inner]])
    share = np.concatenate([np.zeros(count), share[inner]])
    order = np.lexsort((share, own))
    own, share = own[order], share[order]
    new = np.ones(len(own), dtype=np.bool_)
    new[1:] = (own[1:] != own[:-1]) | (share[1:] - share[:-1] > slack[own[1:]])
    own, share = own[new], share[new]
    following = np.append(share[1:], 1.0)
    is_last = np.append(own[1:] != own[:-1], True)[: len(own)]
    return own, share, np.where(is_last, 1.0, following)


def _between(ends: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return points (n, 3) of segments (n, 2, 3), in the picture midway between two shares of
    them.
    """
    middle = (low + high) / 2
    # Along a picture 1/z runs evenly; so the share of the way in space is that over its depth.
    inverse = 1.0 / ends[..., 2]
    share = middle * inverse[:, 1] / ((1 - middle) * inverse[:, 0] + middle * inverse[:, 1])
    found: FloatArray = ends[:, 0] + share[:, None] * (ends[:, 1] - ends[:, 0])
    return found


def _seen(
    table: FaceTable,
    edges: NDArray[np.intp],
    bounds: NDArray[np.intp],
    centre: FloatArray,
    edge: NDArray[np.intp],
    points: FloatArray,
) -> NDArray[np.bool_]:
    """Return which points (n, 3), of edges (n,), no face hides from the centre (3,)."""
    seen = np.ones(len(points), dtype=np.bool_)
    distance, height = (
        table.planes.distances(p, np.zeros((len(p), 3, 3)))[0] for p in (points, centre[None])
    )
    # An edge that begins on a face lies behind it from there on: what counts is how far it gets.
    off, sds = table.planes.distances(table.points[edges.ravel()], table.covs[edges.ravel()])
    clear = np.abs(off) > BEHIND_SDS * sds + ROUNDING_SHARE * np.abs(height)
    beyond = (clear & (np.sign(off) != np.sign(height))).reshape(len(edges), 2, -1).any(axis=1)
    behind = (np.sign(distance) != np.sign(height)) & beyond[edge]
    own = np.zeros((len(edges), len(table)), dtype=np.bool_)
    own[bounds[:, 0], bounds[:, 1]] = True
    behind &= ~own[edge]
    for face in np.flatnonzero(behind.any(axis=0)).tolist():
        asked = np.flatnonzero(behind[:, face] & seen)
        # where the sight from the centre passes the plane, as a share of the way
        share = height[0, face] / (height[0, face] - distance[asked, face])
        met = centre + share[:, None] * (points[asked] - centre)
        flat = (met - table.middles[face]) @ table.axes[face].T
        hidden = shapely.contains_xy(table.polygons[face], flat)
        seen[asked[hidden]] = False
    return seen


def _lie_within_plane(
    table: FaceTable,
    edges: NDArray[np.intp],
    flat: NDArray[np.intp],
    edge: NDArray[np.intp],
    points: FloatArray,
) -> NDArray[np.bool_]:
    """Return which points (n, 3), of edges (n,), have two faces of one plane beside them."""
    within = np.zeros(len(points), dtype=np.bool_)
    for number, one, two in flat.tolist():
        asked = np.flatnonzero(edge == number)
        start, end = table.points[edges[number]]
        across = BESIDE_SHARE * np.cross(end - start, table.planes.normals[one])
        beside = [
            [
                shapely.contains_xy(
                    table.polygons[face],
                    (points[asked] + side * across - table.middles[face]) @ table.axes[face].T,
                )
                for face in (one, two)
            ]
            for side in (-1.0, 1.0)
        ]
        (a, b), (c, d) = beside
        within[asked] |= (a & d) | (b & c)
    return within


def _points(
    ends: FloatArray, vertex: NDArray[np.intp]
) -> tuple[NDArray[np.intp], FloatArray, NDArray[np.intp]]:
    """Join ends of pieces (n, 2) that are one point, each with its vertex (n,) or -1.

    For each the number of its point; the points (p, 2); and their vertices (p,), the first of those
    that fall together.
    """
    if not len(ends):
        return np.zeros(0, dtype=np.intp), np.zeros((0, 2)), np.zeros(0, dtype=np.intp)
    near = cKDTree(ends).query_pairs(SAME_POINT_PX, output_type="ndarray")
    count, of = joined(len(ends), near)
    first = np.full(count, np.iinfo(np.intp).max)
    named = vertex >= 0
    np.minimum.at(first, of[named], vertex[named])
    found = np.where(first == np.iinfo(np.intp).max, -1, first)
    # Where a vertex is, its own place counts, else the mean of what falls together.
    weight = np.where(found[of] < 0, 1.0, (vertex == found[of]).astype(np.float64))
    total = np.zeros((count, 2))
    np.add.at(total, of, weight[:, None] * ends)
    return of.astype(np.intp), total / np.bincount(of, weight, count)[:, None], found


def _make_drawing(
    points: FloatArray, vertex: NDArray[np.intp], lines: NDArray[np.intp], edge: NDArray[np.intp]
) -> VisibleLines:
    """Return the drawing of pieces (m, 2) of edges (m,), those on each other once, without idle
    cuts.
    """
    lines, edge = _drop_repeated_lines(lines, edge)
    lines, edge = _drop_repeated_lines(*_rejoin_pieces(lines, edge, vertex))
    used, renumbered = np.unique(lines, return_inverse=True)
    lines = renumbered.reshape(-1, 2)
    points, vertex = points[used], vertex[used]
    drawn = points[lines[:, 1]] - points[lines[:, 0]]
    sds = POINT_SD_PX / np.maximum(np.linalg.norm(drawn, axis=1), SAME_POINT_PX)
    return VisibleLines(LineDrawing.between(points, lines, sds), vertex, edge)


def _drop_repeated_lines(
    lines: NDArray[np.intp], edge: NDArray[np.intp]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return lines of two different points, each pair of points once, by the first edge."""
    there = lines[:, 0] != lines[:, 1]
    lines, edge = lines[there], edge[there]
    order = np.lexsort((edge, *np.sort(lines, axis=1).T))
    _, first = np.unique(np.sort(lines[order], axis=1), axis=0, return_index=True)
    kept = order[first]
    return lines[kept], edge[kept]


def _rejoin_pieces(
    lines: NDArray[np.intp], edge: NDArray[np.intp], vertex: NDArray[np.intp]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the lines, with pieces of one edge joined where only what is hidden crosses it."""
    kept: dict[int, tuple[int, int, int]] = {
        i: (a, b, e)
        for i, ((a, b), e) in enumerate(zip(lines.tolist(), edge.tolist(), strict=True))
    }
    at: dict[int, set[int]] = {}
    for i, (a, b, _) in kept.items():
        at.setdefault(a, set()).add(i)
        at.setdefault(b, set()).add(i)
    for point, here in at.items():
        if vertex[point] >= 0 or len(here) != 2:
            continue
        i, j = sorted(here)
        if kept[i][2] != kept[j][2]:
            continue
        (p,) = {*kept[i][:2]} - {point}
        (q,) = {*kept[j][:2]} - {point}
        kept[i] = (p, q, kept[i][2])
        at[q] = (at[q] - {j}) | {i}
        del kept[j]
    rows = np.array([kept[i] for i in sorted(kept)], dtype=np.intp).reshape(-1, 3)
    return rows[:, :2], rows[:, 2]
