"""Closed sheets of a triangle mesh: welded, without doubles, wound so that normals point out.

Where more than two triangles share an edge, bodies touch there: the triangles of one body as the
mesh was given stay together, others pair so that solid lies between them.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from facetlog.perception.flat_faces import cross
from facetlog.perception.pieces.exact.cap_sheets import find_caps
from facetlog.perception.ragged import Bools, Indices, iter_groups, joined, sum_by_group
from facetlog.perception.types import FloatArray

# Single-precision coordinates are exact to 6e-8 of their size; export to text keeps 6 digits.
RESOLUTION = 1e-6
# Angles about an edge nearer than this are one: what a corner moved by the resolution turns.
SAME_ANGLE = 1e-4
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
# Of a flat sheet no more than this share is not flat: edges that were rounded.
ROUNDED = 0.1
# They lie in one plane but for this share of their extent.
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

    @property
    def corners(self) -> FloatArray:
        """Corners of the triangles, (m, 3, 3)."""
        return self.points[self.triangles]


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
    one, two = _pair_half_edges(points, triangles, part[source])
    links, (starts, ends) = np.column_stack([one // 3, two // 3]), _list_half_edges(triangles)
    sheet, flip, twisted = _wind(len(triangles), links, starts[one] == starts[two])
    caps, capped = _cap_sheets(
        points, triangles, sheet, np.concatenate([one, two]), flip, slack, up
    )
    if len(caps):
        triangles, source = np.concatenate([triangles, caps]), np.append(source, source[capped])
        one, two = _pair_half_edges(points, triangles, part[source])
        links, (starts, ends) = np.column_stack([one // 3, two // 3]), _list_half_edges(triangles)
        sheet, flip, twisted = _wind(len(triangles), links, starts[one] == starts[two])
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
    body, turned = _find_bodies(points, triangles, sheet, volumes, kept_sheet)
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
        np.column_stack([starts[one], ends[one]])[inner],
        centre,
        size,
        slack,
        sum_by_group(body[kept_sheet], made[kept_sheet], int(bodies.max(initial=-1)) + 1),
        loose,
        float(area.sum()),
    )


def _list_half_edges(triangles: Indices) -> tuple[Indices, Indices]:
    """Return the first and the last corner (3 m,) of the sides of triangles (m, 3)."""
    return triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()


def _cap_sheets(
    points: FloatArray,
    triangles: Indices,
    sheet: Indices,
    paired: Indices,
    flip: Bools,
    slack: float,
    up: FloatArray | None,
) -> tuple[Indices, Indices]:
    """Return the caps of open sheets, and a triangle of the sheet of each; half edges `paired`
    have a neighbour, triangles to `flip` are wound against the others of their sheet.
    """
    is_open = np.ones(3 * len(triangles), dtype=np.bool_)
    is_open[paired] = False
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
    _, first, same = np.unique(points + 0.0, axis=0, return_index=True, return_inverse=True)
    near = cKDTree(points[first]).query_pairs(slack, output_type="ndarray")
    label = joined(len(first), near)[1]
    _, kept = np.unique(label, return_index=True)
    return points[first[kept]], label[same.ravel()][place.reshape(triangles.shape)]


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
    kept = np.sort(np.unique(turned, axis=0, return_index=True)[1])
    unwound = np.sort(triangles[kept], axis=1)
    _, first, uses = np.unique(unwound, axis=0, return_index=True, return_counts=True)
    area = measure_triangles(points, triangles[kept])[1]
    both = float(area[first[uses == 2]].sum()) * 2.0
    return kept[np.sort(first)] if both > 0.5 * area.sum() else kept


def _edge_keys(triangles: Indices, count: int) -> tuple[Indices, Bools]:
    """Return the number of each half edge's edge (3 m,), and whether it runs upwards."""
    starts, ends = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    upwards = starts < ends
    return np.where(upwards, starts * count + ends, ends * count + starts), upwards


def _split_at_junctions(
    points: FloatArray, triangles: Indices, slack: float
) -> tuple[Indices, Indices]:
    """Return triangles split where corners of others lie within an open edge, and what each is
    of.
    """
    own = np.arange(len(triangles))
    for _ in range(ROUNDS):
        key, _ = _edge_keys(triangles, len(points))
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
    found: dict[int, list[int]] = {}
    chunk = max(1, 1_000_000 // len(spots))
    for first in range(0, len(start), chunk):
        part = slice(first, first + chunk)
        away = points[spots][None] - start[part, None]
        place = np.einsum("esi,ei->es", away, along[part])
        off = np.linalg.norm(away - place[..., None] * along[part, None], axis=2)
        inside = (place > slack) & (place < length[part, None] - slack) & (off <= 4.0 * slack)
        for edge in np.flatnonzero(inside.any(axis=1)).tolist():
            own = np.flatnonzero(inside[edge])
            order = own[np.argsort(place[edge, own], kind="stable")]
            found[first + edge] = spots[order].tolist()
    return found


def _pair_half_edges(
    points: FloatArray, triangles: Indices, part: Indices
) -> tuple[Indices, Indices]:
    """Return half edges (k,), (k,) of triangles (m, 3) that continue each other."""
    key, upwards = _edge_keys(triangles, len(points))
    whose = part[np.arange(len(key)) // 3]
    # of one part as given, if it has two there; else of all
    pairs: list[Indices] = []
    for by in (whose, np.zeros_like(whose)):
        free = np.ones(len(key), dtype=np.bool_)
        for pair in pairs:
            free[pair] = False
        rows = np.flatnonzero(free)
        order = rows[np.lexsort((rows, by[rows], key[rows]))]
        new = np.ones(len(order) + 1, dtype=np.bool_)
        new[1:-1] = (key[order][1:] != key[order][:-1]) | (by[order][1:] != by[order][:-1])
        first = np.flatnonzero(new)
        twice = order[first[:-1][np.diff(first) == 2]]
        other = order[first[:-1][np.diff(first) == 2] + 1]
        pairs += [twice, other]
    free[pairs[2]] = free[pairs[3]] = False
    rows = np.flatnonzero(free)
    more = _pair_by_angle(points, triangles, rows, key[rows], upwards[rows])
    return np.concatenate([pairs[0], pairs[2], more[0]]), np.concatenate(
        [pairs[1], pairs[3], more[1]]
    )


def _pair_by_angle(
    points: FloatArray, triangles: Indices, rows: Indices, key: Indices, upwards: Bools
) -> tuple[Indices, Indices]:
    """Return pairs of half edges `rows` of edges with more than two, with solid between them.

    Solid lies behind a triangle: on the side of growing angle about the edge, of one that runs
    down along it, up to the next that runs up.
    """
    row, corner = rows // 3, rows % 3
    ends = np.stack([triangles[row, corner], triangles[row, (corner + 1) % 3]])
    low, high = points[ends.min(axis=0)], points[ends.max(axis=0)]
    apex = points[triangles[row, (corner + 2) % 3]] - low
    axis = high - low
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    apex -= (apex * axis).sum(axis=1, keepdims=True) * axis
    order = np.lexsort((rows, key))
    _, first, place = np.unique(key[order], return_index=True, return_inverse=True)
    right = apex[order[first]][place]
    right = right / np.maximum(np.linalg.norm(right, axis=1, keepdims=True), 1e-300)
    apex, axis = apex[order], axis[order]
    angle = np.arctan2((apex * cross(axis, right)).sum(axis=1), (apex * right).sum(axis=1))
    angle = np.mod(angle + SAME_ANGLE, 2.0 * np.pi)
    inner = np.lexsort((angle, place))
    near = (np.diff(angle[inner]) <= SAME_ANGLE) & (np.diff(place[inner]) == 0)
    level = np.empty(len(inner), dtype=np.int64)
    level[inner] = np.cumsum(np.concatenate([[True], ~near])) if len(inner) else 0
    # of those at one angle, what ends solid comes first
    inner = np.lexsort((~upwards[order], level))
    order, place = order[inner], place[inner]
    one, two = [], []
    bounds = np.append(np.flatnonzero(np.diff(place, prepend=-1)), len(place)).tolist()
    for begin, end in pairwise(bounds):
        cycle = order[begin:end].tolist()
        waiting: list[int] = []
        for half in cycle + cycle:  # twice round: solid may lie across the first angle
            if not upwards[half]:
                if half not in waiting:
                    waiting.append(half)
            elif waiting and half in cycle:
                partner = waiting.pop()
                one.append(rows[partner])
                two.append(rows[half])
                cycle = [each for each in cycle if each not in (partner, half)]
            waiting = [each for each in waiting if each in cycle]
    return np.array(one, dtype=np.int64), np.array(two, dtype=np.int64)


def _wind(m: int, links: Indices, against: Bools) -> tuple[Indices, Bools, Indices]:
    """Return the sheet of each triangle, whether to turn it, and triangles of one-sided sheets.

    Every triangle is there twice, as it is and turned; links between triangles that are wound
    against each other join each with the other's turned copy.
    """
    count, sheet = joined(m, links)
    if not against.any():
        return sheet, np.zeros(m, dtype=np.bool_), np.zeros(0, dtype=np.int64)
    shift = np.where(against, m, 0)
    there = np.column_stack([links[:, 0], links[:, 1] + shift])
    back = np.column_stack([links[:, 0] + m, links[:, 1] + m - shift])
    copies, group = joined(2 * m, np.concatenate((there, back)))
    as_is = np.bincount(group[:m], minlength=copies)
    here, turned = as_is[group[:m]], as_is[group[m:]]
    flip = (here < turned) | ((here == turned) & (group[:m] > group[m:]))
    return sheet, flip & (count > 0), np.flatnonzero(group[:m] == group[m:])


def _find_bodies(
    points: FloatArray, triangles: Indices, sheet: Indices, volumes: FloatArray, kept: Bools
) -> tuple[Indices, Bools]:
    """Return the body of each sheet, and whether to turn it: a cavity belongs to the body round it.

    A sheet that is wound inwards is a cavity if it lies in a sheet that is wound outwards, when
    most of the mesh is; otherwise it is inside out.
    """
    turned = volumes < 0.0
    if volumes[kept].sum() < 0.0:
        volumes, everything = -volumes, ~turned
        cavities = kept & everything
    else:
        cavities = kept & turned
    body = np.arange(len(volumes))
    outside = np.flatnonzero(kept & (volumes > 0.0))
    if len(outside) and cavities.any():
        first = triangles[np.unique(sheet, return_index=True)[1], 0]
        corners = {int(s): points[triangles[sheet == s]] for s in outside}
        for cavity in np.flatnonzero(cavities).tolist():
            spot = points[first[cavity]]
            for out in outside[np.argsort(volumes[outside], kind="stable")].tolist():
                if volumes[out] > -volumes[cavity] and is_inside(spot, corners[out]):
                    body[cavity] = out
                    turned[cavity] = not turned[cavity]
                    break
    number = np.full(len(volumes), -1)
    number[kept] = np.unique(body[kept], return_inverse=True)[1]
    return number, turned


def run_along(triangles: Indices, edges: Indices) -> Indices:
    """Return the first and the last corner (2, k) of edges (k, 2) as triangles (k, 3) run along
    them.
    """
    place = (triangles == edges[:, :1]).argmax(axis=1)
    forward = triangles[np.arange(len(edges)), (place + 1) % 3] == edges[:, 1]
    return np.where(forward, edges.T, edges.T[::-1])


def is_inside(spot: FloatArray, corners: FloatArray) -> bool:
    """Return whether a closed sheet of triangles (m, 3, 3) winds round a spot, by solid angles."""
    a, b, c = (corners[:, k] - spot for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    triple = (a * cross(b, c)).sum(axis=1)
    rest = la * lb * lc + (a * b).sum(axis=1) * lc + (b * c).sum(axis=1) * la
    rest += (c * a).sum(axis=1) * lb
    return abs(float(np.arctan2(triple, rest).sum()) / (2.0 * np.pi)) > 0.5
