"""Closed sheets of a triangle mesh: welded, without doubles, wound so that normals point out.

Where more than two triangles share an edge, bodies touch there: the triangles of one body as the
mesh was given stay together, others pair so that solid lies between them.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from facetlog.perception.batch_linalg import dots
from facetlog.perception.flat_faces import cross
from facetlog.perception.pieces.exact.cap_sheets import find_caps
from facetlog.perception.pieces.exact.wind_bodies import (
    find_bodies,
    make_edge_keys,
    pair_half_edges,
    wind_triangles,
)
from facetlog.perception.ragged import (
    Bools,
    Indices,
    find_distinct,
    iter_groups,
    joined,
    number_rows,
    sum_by_group,
)
from facetlog.perception.types import FloatArray

# Single-precision coordinates are exact to 6e-8 of their size; export to text keeps 6 digits.
RESOLUTION = 1e-6
# What is narrower than so many times the slack is a sliver: its normal is not known.
SLIVER = 2.0
# Rounds in which what has a neighbour that is mended is mended.
ROUNDS = 6
# Open edges times their ends that are compared, some tenth of a second.
MOST_COMPARED = 10_000_000
# A layer without thickness is a board from this share of the surface on.
LAYER_SHARE = 0.002
# Its triangles turn less, as facets of what is flat do where exporters round the corners.
LAYER_DEG = 0.5
# The largest share of a flat sheet that may lie off its plane: edges that were rounded.
ROUNDED = 0.1
# The largest distance of a flat sheet from its plane, as a share of its extent.
LAYER_FLAT = 1e-3
# A sheet with less volume than this share of its area times size encloses nothing.
LEAST_VOLUME = 1e-6


@dataclass(frozen=True, eq=False, slots=True)
class OpenSheet:
    """A sheet that encloses nothing: its triangles (t, 3, 3), corners (c, 3) of its flat parts, its
    area, and how much of that is in no flat part.
    """

    corners: FloatArray
    layers: list[FloatArray]
    area: float
    bare: float


@dataclass(frozen=True, eq=False, slots=True)
class Sheets:
    """Triangles (m, 3) of points (n, 3) about `centre`, their normals and areas.

    `body` (m,) numbers the closed bodies, each with its cavities. `pairs` (k, 2) are triangles that
    share an edge and `edges` (k, 2) its ends. Points within `slack` are one. `volumes` are the
    bodies'. `loose` are the sheets that enclose nothing; `surface` is the area of all.
    """

    points: FloatArray
    triangles: Indices
    normals: FloatArray
    areas: FloatArray
    body: Indices
    pairs: Indices
    edges: Indices
    centre: FloatArray
    size: float
    slack: float
    volumes: FloatArray
    loose: list[OpenSheet]
    surface: float

    def corners(self, rows: Indices | Bools) -> FloatArray:
        """Return the corners (m, 3, 3) of some of the triangles."""
        return self.points[self.triangles[rows]]


def close_sheets(
    points: FloatArray, triangles: Indices, step: float = 0.0, up: FloatArray | None = None
) -> Sheets | str:
    """Return the closed sheets of a mesh of points (n, 3), rounded to multiples of `step`, and its
    flat layers, or the reason why it has neither. What stands open on the ground is closed there,
    if it is known where `up` (3,) is.
    """
    if not len(triangles):
        return "the mesh has no triangles"
    used = points[np.unique(triangles)]
    low, high = used.min(axis=0), used.max(axis=0)
    size = float(np.linalg.norm(high - low))
    slack = max(RESOLUTION * size, 4.0 * float(np.spacing(np.abs([low, high]).max())), step)
    if not size > 100.0 * slack:
        return "the mesh has no extent"
    centre = 0.5 * (low + high)
    given = joined(len(points), np.concatenate((triangles[:, :2], triangles[:, 1:])))[1]
    part = given[triangles[:, 0]]
    points, triangles = _weld(points - centre, triangles, slack)
    source = _find_three(triangles)
    source = source[_drop_doubles(points, triangles[source])]
    triangles = triangles[source]
    triangles, own = _split_at_junctions(points, triangles, slack)
    source = source[own]
    if not len(triangles):
        return "the mesh has no triangles of any area"
    joints = _join_triangles(points, triangles, part[source])
    caps, capped = _cap_sheets(points, triangles, joints, slack, up)
    if len(caps):
        triangles, source = np.concatenate([triangles, caps]), np.append(source, source[capped])
        joints = _join_triangles(points, triangles, part[source])
    one, two, edges, sheet, flip, twisted = joints
    links = np.column_stack([one // 3, two // 3])
    as_given = triangles
    triangles = np.where(flip[:, None], triangles[:, ::-1], triangles)
    count = int(sheet.max()) + 1
    paired = np.zeros(3 * len(triangles), dtype=np.bool_)
    paired[one] = paired[two] = True
    open_sheet = np.bincount(np.repeat(sheet, 3)[~paired], minlength=count) > 0
    open_sheet |= np.bincount(sheet[twisted], minlength=count) > 0
    normals, areas = measure_triangles(points, triangles)
    normals = _turn_slivers(points, as_given, normals, np.column_stack([one, two]), slack)
    area = sum_by_group(sheet, areas, count)
    volumes = sum_by_group(sheet, _signed_volumes(points[triangles]), count)
    kept_sheet = ~open_sheet & (np.abs(volumes) > LEAST_VOLUME * size * area)
    flat, bare = _find_layers(points[triangles], normals, areas, links, ~kept_sheet[sheet], sheet)
    loose = _list_open_sheets(points[triangles], sheet, areas, kept_sheet, flat, bare)
    if not kept_sheet.any() and not loose:
        return "the mesh encloses no volume"
    body, turned = find_bodies(points, triangles, sheet, volumes, kept_sheet)
    flip = turned[sheet]
    triangles = np.where(flip[:, None], triangles[:, ::-1], triangles)
    normals = np.where(flip[:, None], -normals, normals)
    kept = kept_sheet[sheet]
    number = np.cumsum(kept) - 1
    inner = kept[links[:, 0]]
    bodies = body[sheet[kept]]
    made = np.where(turned, -volumes, volumes)
    return Sheets(
        points,
        triangles[kept],
        normals[kept],
        areas[kept],
        bodies,
        number[links[inner]],
        edges[inner],
        centre,
        size,
        slack,
        sum_by_group(body[kept_sheet], made[kept_sheet], int(bodies.max(initial=-1)) + 1),
        loose,
        float(area.sum()),
    )


# Pairs of half edges (k,), (k,) that continue each other, their edges (k, 2), and of the triangles
# the sheet (m,), whether to turn it (m,), and those of one-sided sheets.
_Joints = tuple[Indices, Indices, Indices, Indices, Bools, Indices]


def _join_triangles(points: FloatArray, triangles: Indices, part: Indices) -> _Joints:
    """Return how triangles (m, 3) of parts (m,) continue each other."""
    one, two = pair_half_edges(points, triangles, part)
    starts, ends = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    links = np.column_stack([one // 3, two // 3])
    wound = wind_triangles(len(triangles), links, starts[one] == starts[two])
    return one, two, np.column_stack([starts[one], ends[one]]), *wound


def _cap_sheets(
    points: FloatArray,
    triangles: Indices,
    joints: _Joints,
    slack: float,
    up: FloatArray | None,
) -> tuple[Indices, Indices]:
    """Return the caps of open sheets, and a triangle of the sheet of each."""
    one, two, _, sheet, flip, _ = joints
    is_open = np.ones(3 * len(triangles), dtype=np.bool_)
    is_open[one] = is_open[two] = False
    if not is_open.any():
        return np.zeros((0, 3), dtype=np.int64), np.zeros(0, dtype=np.int64)
    # of a turned triangle the sides run from the last corner to the first
    sides = is_open.reshape(-1, 3)
    turned = np.where(flip[:, None], triangles[:, ::-1], triangles)
    sides = np.where(flip[:, None], sides[:, [1, 0, 2]], sides)
    return find_caps(points, turned, sheet, sides, slack, up)


def _find_layers(
    corners: FloatArray,
    normals: FloatArray,
    areas: FloatArray,
    links: Indices,
    loose: Bools,
    sheet: Indices,
) -> tuple[list[Indices], Bools]:
    """Return the triangles of `loose` (m,) sheets that are flat but for edges that were rounded,
    each once, though it may be there with both windings; and which triangles are loose and in
    none. What is folded may enclose a space: it stays open.
    """
    bare = loose & (areas > 0.0)
    if not loose.any():
        return [], bare
    one, two = links.T
    alike = (normals[one] * normals[two]).sum(axis=1) > np.cos(np.radians(LAYER_DEG))
    label = joined(len(corners), links[alike & loose[one]])[1]
    loose = loose & (np.bincount(label, areas)[label] > LAYER_SHARE * areas.sum())
    found: dict[tuple[float, ...], Indices] = {}
    for rows in iter_groups(np.where(loose, label, -1)):
        if loose[rows[0]]:
            ends = [corners[rows].min(axis=(0, 1)), corners[rows].max(axis=(0, 1))]
            size = float(np.linalg.norm(ends[1] - ends[0]))
            away = (corners[rows] - corners[rows[0], 0]) @ normals[rows[areas[rows].argmax()]]
            if np.abs(away).max() < LAYER_FLAT * size:
                place = np.round(np.concatenate(ends) / (LAYER_FLAT * size)).tolist()
                found[tuple(place)] = rows
                bare[rows] = False
    count = int(sheet.max()) + 1
    rest = np.bincount(sheet, areas * bare, minlength=count) / np.bincount(sheet, areas, count)
    first = np.array([rows[0] for rows in found.values()], dtype=np.int64)
    sides = np.bincount(sheet[first], minlength=count)
    bare |= loose & ((rest > ROUNDED) | (sides > 1))[sheet]
    return [rows for rows in found.values() if not bare[rows[0]]], bare


def _list_open_sheets(
    corners: FloatArray,
    sheet: Indices,
    areas: FloatArray,
    kept: Bools,
    flat: list[Indices],
    bare: Bools,
) -> list[OpenSheet]:
    """Return the sheets that are not kept, of triangles (m, 3, 3), with the triangles of their flat
    parts.
    """
    layers: dict[int, list[FloatArray]] = {}
    for rows in flat:
        layers.setdefault(int(sheet[rows[0]]), []).append(corners[rows].reshape(-1, 3))
    rows = np.flatnonzero(~kept[sheet] & (areas > 0.0))
    return [
        OpenSheet(
            corners[rows[own]],
            layers.get(int(sheet[rows[own[0]]]), []),
            float(areas[rows[own]].sum()),
            float((areas * bare)[rows[own]].sum()),
        )
        for own in iter_groups(sheet[rows])
    ]


def _weld(points: FloatArray, triangles: Indices, slack: float) -> tuple[FloatArray, Indices]:
    """Return points, those within the slack made one, and the triangles between them."""
    used, place = np.unique(triangles, return_inverse=True)
    points = points[used]
    # equal ones first, for speed: neighbours are searched among what is left
    first, same = find_distinct(number_rows(points))
    near = cKDTree(points[first]).query_pairs(slack, output_type="ndarray")
    label = joined(len(first), near)[1]
    _, kept = np.unique(label, return_index=True)
    return points[first[kept]], label[same][place.reshape(triangles.shape)]


def measure_triangles(points: FloatArray, triangles: Indices) -> tuple[FloatArray, FloatArray]:
    """Return unit normals (m, 3) and areas (m,) of triangles."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normals = cross(b - a, c - a)
    double = np.linalg.norm(normals, axis=1)
    return normals / np.maximum(double, 1e-300)[:, None], 0.5 * double


def _signed_volumes(corners: FloatArray) -> FloatArray:
    """Return signed volumes (m,) between the origin and triangles (m, 3, 3)."""
    volumes: FloatArray = (corners[:, 0] * cross(corners[:, 1], corners[:, 2])).sum(axis=1) / 6.0
    return volumes


def _find_three(triangles: Indices) -> Indices:
    """Return the rows of triangles (m, 3) with three different corners."""
    a, b, c = triangles.T
    return np.flatnonzero((a != b) & (b != c) & (c != a))


def _turn_slivers(
    points: FloatArray, triangles: Indices, normals: FloatArray, links: Indices, slack: float
) -> FloatArray:
    """Return normals (m, 3), of slivers that of a neighbour: what their own is, rounding decides.

    That is the one across their longest side, for a sliver is part of that side; else any other.
    `links` (k, 2) are half edges that continue each other.
    """
    sides = points[triangles] - points[np.roll(triangles, -1, axis=1)]
    lengths = np.linalg.norm(sides, axis=2)
    double = np.linalg.norm(cross(sides[:, 0], sides[:, 1]), axis=1)
    sound = double > SLIVER * slack * lengths.max(axis=1)
    if sound.all():
        return normals
    normals = normals.copy()
    both = np.concatenate([links, links[:, ::-1]])
    both = both[~sound[both[:, 0] // 3]]
    share = lengths.ravel()[both[:, 0]] / lengths.max(axis=1)[both[:, 0] // 3]
    for least in (1.0, 0.5, 0.0):
        ways = both[share >= least]
        for _ in range(ROUNDS):
            own, other = ways[:, 0] // 3, ways[:, 1] // 3
            ready = sound[other] & ~sound[own]
            if not ready.any():
                break
            normals[own[ready]] = normals[other[ready]]
            sound[own[ready]] = True
    return normals


def _drop_doubles(points: FloatArray, triangles: Indices) -> Indices:
    """Return rows of triangles (m, 3) without those that repeat another.

    One that is there with both windings is where two bodies touch, and stays twice; where most of
    the surface is so, the mesh is two-sided, and one of each stays.
    """
    low = triangles.argmin(axis=1)
    rows = np.arange(len(triangles))
    turned = np.stack([triangles[rows, (low + k) % 3] for k in range(3)], axis=1)
    kept = np.sort(find_distinct(number_rows(turned))[0])
    unwound = number_rows(np.sort(triangles[kept], axis=1))
    _, first, uses = np.unique(unwound, return_index=True, return_counts=True)
    area = measure_triangles(points, triangles[kept])[1]
    both = float(area[first[uses == 2]].sum()) * 2.0
    return kept[np.sort(first)] if both > 0.5 * area.sum() else kept


def _split_at_junctions(
    points: FloatArray, triangles: Indices, slack: float
) -> tuple[Indices, Indices]:
    """Return triangles split where corners of others lie within an open edge, and what each is
    of.
    """
    own = np.arange(len(triangles))
    for _ in range(ROUNDS):
        key, _ = make_edge_keys(triangles, len(points))
        _, place, uses = np.unique(key, return_inverse=True, return_counts=True)
        half = np.flatnonzero(uses[place] % 2 == 1)
        ends = np.stack([triangles.ravel()[half], np.roll(triangles, -1, axis=1).ravel()[half]])
        spots = np.unique(ends)
        if not len(half) or len(half) * len(spots) > MOST_COMPARED:
            break
        split = _find_junctions(points, ends, spots, slack)
        if not split:
            break
        kept = np.ones(len(triangles), dtype=np.bool_)
        added: list[tuple[int, int, int]] = []
        origin: list[int] = []
        for edge, inside in split.items():
            row, corner = divmod(int(half[edge]), 3)
            if kept[row]:  # its other edges come in the next round
                kept[row] = False
                start, end, apex = (int(triangles[row, (corner + k) % 3]) for k in range(3))
                chain = [start, *inside, end]
                added += [(a, b, apex) for a, b in pairwise(chain)]
                origin += [int(own[row])] * (len(chain) - 1)
        triangles = np.concatenate([triangles[kept], np.array(added, dtype=np.int64)])
        own = np.concatenate([own[kept], np.array(origin, dtype=np.int64)])
        three = _find_three(triangles)
        triangles, own = triangles[three], own[three]
    return triangles, own


def _find_junctions(
    points: FloatArray, ends: Indices, spots: Indices, slack: float
) -> dict[int, list[int]]:
    """Return the spots (s,) within edges (2, e), in their order along each that has any."""
    start = points[ends[0]]
    along = points[ends[1]] - start
    length = np.linalg.norm(along, axis=1)
    along /= length[:, None]
    where = points[spots]
    found: dict[int, list[int]] = {}
    chunk = max(1, 1_000_000 // len(spots))
    for first in range(0, len(start), chunk):
        part = slice(first, first + chunk)
        place = along[part] @ where.T - dots(start[part], along[part])[:, None]
        # |s - e|² = (along the edge)² + (off it)²
        away = dots(where, where) + dots(start[part], start[part])[:, None]
        away -= 2.0 * (start[part] @ where.T)
        inside = (place > slack) & (place < length[part, None] - slack)
        inside &= away - place * place <= (4.0 * slack) ** 2
        for edge in np.flatnonzero(inside.any(axis=1)).tolist():
            own = np.flatnonzero(inside[edge])
            order = own[np.argsort(place[edge, own], kind="stable")]
            found[first + edge] = spots[order].tolist()
    return found
