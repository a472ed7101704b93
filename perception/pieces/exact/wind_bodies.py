"""Wind triangles into closed sheets and bodies: what continues what, and where solid lies."""

from itertools import pairwise

import numpy as np

from facetlog.perception.flat_faces import cross
from facetlog.perception.ragged import Bools, Indices, joined
from facetlog.perception.types import FloatArray

# Angles about an edge nearer than this are one: what a corner moved by the resolution turns.
SAME_ANGLE = 1e-4


def make_edge_keys(triangles: Indices, count: int) -> tuple[Indices, Bools]:
    """Return the number of each half edge's edge (3 m,), and whether it runs upwards."""
    starts, ends = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    upwards = starts < ends
    return np.where(upwards, starts * count + ends, ends * count + starts), upwards


def pair_half_edges(
    points: FloatArray, triangles: Indices, part: Indices
) -> tuple[Indices, Indices]:
    """Return half edges (k,), (k,) of triangles (m, 3) that continue each other."""
    key, upwards = make_edge_keys(triangles, len(points))
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


def wind_triangles(m: int, links: Indices, against: Bools) -> tuple[Indices, Bools, Indices]:
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


def find_bodies(
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
