"""Repair of meshes: welded vertices, no duplicates, consistent winding, normals outwards.

Corners within a millionth of the size are merged, if that is less than a thousandth of the sides
that end there: what is far away makes nothing coarser. Degenerate and duplicate triangles are
removed, and if the former are any share of the surface, that is said.
Sheets of triangles joined by edges that two of them share get one winding; a closed one that of
positive volume, so that its normals point out. The outside of an open one does not follow from its
winding: mesh_scene.py determines it.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from facetlog.errors import InputError
from facetlog.perception.flat_faces import cross
from facetlog.perception.ragged import Indices, find_distinct, joined, number_rows, sum_by_group
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.types import FloatArray

# Single-precision coordinates are exact to 6e-8 of their size; export to text keeps 6 digits.
RESOLUTION = 1e-6
# Cells a side that whole numbers tell apart: three of these are one of 60 bits.
MOST_CELLS = 1 << 20
# No corner is moved further than this share of the longest side of a triangle that it is of.
SIDE_SHARE = 1e-3
# Nothing is said of less than this share of the surface: a face of so much is a speck
# (mesh_regions.py).
LEAST_LOST = 0.001
# What is left is no likeness of a mesh of which more than this share is left out.
MOST_LOST = 0.5
# A closed sheet with less volume than this share of area times size is two sheets back to back.
LEAST_VOLUME = 1e-6

MEND = "merge near vertices, remesh it, or give its vertices as a cloud"
"""The way out for a mesh whose triangles make no surface."""


@dataclass(frozen=True, eq=False, slots=True)
class Surface:
    """A clean mesh: points (n, 3) about `centre` (3,), triangles (m, 3), their normals and areas.

    `size` is the diagonal. `links` (k, 2) are pairs of triangles that share an edge, wound alike;
    `link_edges` (k, 2) the ends of that edge. `sheets` (m,) number the triangles joined by such
    links, `bodies` (m,) those that share any corner; `closed` (m,) are triangles whose normal is
    known to point out. Points were rounded to multiples of `step`, 0 where it is not known.
    `warnings` say what was left out of the mesh called `name`.
    """

    points: FloatArray
    triangles: Indices
    normals: FloatArray
    areas: FloatArray
    links: Indices
    link_edges: Indices
    sheets: Indices
    bodies: Indices
    closed: NDArray[np.bool_]
    centre: FloatArray
    size: float
    name: str = "mesh"
    warnings: tuple[str, ...] = ()
    step: float = 0.0

    @property
    def lone(self) -> NDArray[np.bool_]:
        """Which triangles (m,) share no corner with another."""
        alone: NDArray[np.bool_] = np.bincount(self.bodies)[self.bodies] == 1
        return alone

    @property
    def corners(self) -> FloatArray:
        """Corners of the triangles, (m, 3, 3)."""
        return self.points[self.triangles]


def clean_mesh(mesh: Mesh) -> Surface:
    """Return the surface of a mesh, whatever its scale.

    Raise InputError where it has no area, or where most of it is narrower than the resolution.
    """
    used = np.zeros(len(mesh.vertices), dtype=bool)
    used[mesh.triangles] = True
    low, high = mesh.vertices[used].min(axis=0), mesh.vertices[used].max(axis=0)
    centre = 0.5 * low + 0.5 * high
    size = float(np.linalg.norm(high - low))
    # The resolution of the numbers themselves at this distance from the origin.
    grain = 4.0 * float(np.spacing(max(np.abs(low).max(), np.abs(high).max())))
    if not size > grain:
        raise InputError(f"{mesh.name}: all corners are in one place; export the mesh again")
    points = mesh.vertices - centre
    slack = _compute_slack(points, mesh.triangles, size, grain)
    points, triangles, slack = _weld_points(points, mesh.triangles, used, slack)
    a, b, c = triangles.T
    three = (a != b) & (b != c) & (c != a)
    rows = np.flatnonzero(three)
    rows = rows[_find_first_of_doubles(triangles[rows])]
    triangles = triangles[rows]
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normals = cross(b - a, c - a)
    double = _lengths(normals)
    longest = np.maximum.reduce([_lengths(p - q) for p, q in ((a, b), (b, c), (c, a))])
    solid = double > slack[triangles].min(axis=1) * longest
    lost = np.concatenate((np.flatnonzero(~three), rows[~solid]))
    warnings = _check_lost_triangles(mesh, lost, 0.5 * float(double[solid].sum()))
    triangles, normals, double = triangles[solid], normals[solid], double[solid]
    normals /= double[:, None]
    surface = _wind_surface(points, triangles, normals, 0.5 * double, centre, size)
    return replace(surface, name=mesh.name, warnings=warnings, step=mesh.step)


def rebuild_surface(surface: Surface, triangles: Indices) -> Surface:
    """Return the surface with these triangles (m, 3) between its points, wound anew."""
    a, b, c = (surface.points[triangles[:, k]] for k in range(3))
    normals = cross(b - a, c - a)
    double = np.maximum(_lengths(normals), 1e-300)
    made = _wind_surface(
        surface.points,
        triangles,
        normals / double[:, None],
        0.5 * double,
        surface.centre,
        surface.size,
    )
    return replace(made, name=surface.name, warnings=surface.warnings, step=surface.step)


def find_boxes_round(
    corners: FloatArray, part: Indices, count: int
) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and the highest corner (count, 3) of the box round each part; of triangles
    (m, 3, 3) `part` (m,) says which it is of.
    """
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, part, corners.min(axis=1))
    np.maximum.at(high, part, corners.max(axis=1))
    return low, high


def measure_part_sizes(corners: FloatArray, part: Indices) -> FloatArray:
    """Return the diagonal (m,) of the box round the part that each of triangles (m, 3, 3) is of."""
    low, high = find_boxes_round(corners, part, int(part.max()) + 1)
    return _lengths(high - low)[part]


def _check_lost_triangles(mesh: Mesh, lost: Indices, left: float) -> tuple[str, ...]:
    """Return a warning of the triangles left out, by their rows, where those were any share of the
    surface of which the area `left` is left; raises InputError where they were most of it, or all.
    """
    a, b, c = (mesh.vertices[mesh.triangles[lost, k]] for k in range(3))
    area = 0.5 * float(_lengths(cross(b - a, c - a)).sum())
    if not area + left > 0.0:
        raise InputError(f"{mesh.name}: no triangle has an area; export the mesh again")
    share = area / (area + left)
    if share < LEAST_LOST:
        return ()
    said = (
        f"{len(lost):,} of {len(mesh.triangles):,} triangles, {share:.1%} of the surface, are "
        "narrower than a millionth of its size and left out"
    )
    if share > MOST_LOST:
        raise InputError(f"{mesh.name}: {said}; {MEND}")
    return (f"{said}; {MEND}",)


def _lengths(vectors: FloatArray) -> FloatArray:
    """Return lengths (n,) of vectors (n, 3); three times as fast as a sum over the short axis."""
    x, y, z = vectors.T
    lengths: FloatArray = np.sqrt(x * x + y * y + z * z)
    return lengths


def _compute_slack(points: FloatArray, triangles: Indices, size: float, grain: float) -> FloatArray:
    """Return how far each point (n,) may be from another that is the same, of a mesh of
    that size.
    """
    longest = np.zeros(len(points))
    for one, two in ((0, 1), (1, 2), (2, 0)):
        side = _lengths(points[triangles[:, one]] - points[triangles[:, two]])
        for end in (one, two):
            np.maximum.at(longest, triangles[:, end], side)
    slack: FloatArray = np.maximum(np.minimum(RESOLUTION * size, SIDE_SHARE * longest), grain)
    return slack


def _weld_points(
    points: FloatArray, triangles: Indices, used: NDArray[np.bool_], slack: FloatArray
) -> tuple[FloatArray, Indices, FloatArray]:
    """Return points that are used, those within the slack (n,) of both made one, the triangles
    between them, and what slack is left to each.
    """
    every = np.flatnonzero(used)
    where, slack = points[every], slack[every]
    # what is about as fine is compared at once: of what is finer, too many lie within a coarse one
    steps = np.floor(np.log10(slack / slack.max())).astype(np.int64)
    pairs = []
    for step in np.unique(steps).tolist():
        rows = np.flatnonzero(steps >= step)
        own = _group_within(where[rows], float(slack[steps == step].min()))
        first = np.unique(own, return_index=True)[1]
        pairs.append(np.column_stack([rows, rows[first[own]]]))
    label = joined(len(every), np.concatenate(pairs))[1]
    _, first, place = np.unique(label, return_index=True, return_inverse=True)
    number = np.zeros(len(points), dtype=np.int64)
    number[every] = place
    finest = np.full(len(first), np.inf)
    np.minimum.at(finest, place, slack)
    return where[first], number[triangles], finest


def _group_within(points: FloatArray, slack: float) -> Indices:
    """Return the group (n,), numbered from 0, of each of points (n, 3) of which those within the
    slack are one.
    """
    extent = float(np.ptp(points, axis=0).max())
    if extent < MOST_CELLS * slack:
        key = number_rows(((points - points.min(axis=0)) / slack).astype(np.int64))
    else:
        key = number_rows(points)
    first, place = find_distinct(key)
    # neighbours that fell into two cells
    near = cKDTree(points[first], balanced_tree=False, compact_nodes=False).query_pairs(
        slack, output_type="ndarray"
    )
    groups: Indices = joined(len(first), near)[1][place]
    return groups


def _find_first_of_doubles(triangles: Indices) -> Indices:
    """Return the rows of triangles (m, 3), the first one for each set of corners."""
    if not len(triangles):
        return np.zeros(0, dtype=np.int64)
    a, b, c = triangles.T
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    middle = a + b + c - low - high
    return np.sort(find_distinct(number_rows(np.array([low, middle, high]).T))[0])


def _wind_surface(
    points: FloatArray,
    triangles: Indices,
    normals: FloatArray,
    areas: FloatArray,
    centre: FloatArray,
    size: float,
) -> Surface:
    m = len(triangles)
    starts, ends = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    forward = starts < ends
    key = np.where(forward, starts * len(points) + ends, ends * len(points) + starts)
    first, edge = find_distinct(key)
    uses = np.bincount(edge)
    last = np.empty(len(first), dtype=np.int64)
    last[edge] = np.arange(len(edge))
    one, two = first[uses == 2], last[uses == 2]
    links = np.column_stack([one // 3, two // 3])
    alike = forward[one] != forward[two]
    sheets, flip = _turns(m, links, alike)
    triangles = np.where(flip[:, None], triangles[:, ::-1], triangles)
    normals = np.where(flip[:, None], -normals, normals)
    closed = _closed(sheets, edge)
    # 6 V = Σ a · (b × c), about the middle of each sheet
    count = len(closed)
    low, high = find_boxes_round(points[triangles], sheets, count)
    middles = (0.5 * (low + high))[sheets]
    a, b, c = (points[triangles[:, k]] - middles for k in range(3))
    volumes = sum_by_group(sheets, np.einsum("ij,ij->i", a, cross(b, c)), count) / 6.0
    sizes = _lengths(high - low)
    sure = np.abs(volumes) > LEAST_VOLUME * sizes * sum_by_group(sheets, areas, count)
    outside_in = (closed & sure & (volumes < 0.0))[sheets]
    _, corner_groups = joined(len(points), np.concatenate((triangles[:, :2], triangles[:, 1:])))
    return Surface(
        points,
        np.where(outside_in[:, None], triangles[:, ::-1], triangles),
        np.where(outside_in[:, None], -normals, normals),
        areas,
        links,
        np.column_stack([starts[one], ends[one]]),
        sheets,
        np.unique(corner_groups[triangles[:, 0]], return_inverse=True)[1].astype(np.int64),
        (closed & sure)[sheets],
        centre,
        size,
    )


def _turns(m: int, links: Indices, alike: NDArray[np.bool_]) -> tuple[Indices, NDArray[np.bool_]]:
    """Return the sheet of each triangle, and whether to turn it so that its sheet is wound alike.

    Every triangle is there twice, as it is and turned. Linked triangles that are wound alike join
    as they are, others each with the other's turned copy; the two copies of a sheet then are two
    groups, and of each triangle the copy in the first group is taken. On a sheet with one side
    only (a Möbius strip) they are one group, and all stay as they are.
    """
    count, sheets = joined(m, links)
    if alike.all():
        return sheets, np.zeros(m, dtype=bool)
    shift = np.where(alike, 0, m)
    there = np.column_stack([links[:, 0], links[:, 1] + shift])
    back = np.column_stack([links[:, 0] + m, links[:, 1] + m - shift])
    copies, group = joined(2 * m, np.concatenate((there, back)))
    # of a sheet's two groups that with most triangles as they are, so that few are turned
    unturned = np.bincount(group[:m], minlength=copies)
    asis, turned = unturned[group[:m]], unturned[group[m:]]
    tie = (asis == turned) & (group[:m] > group[m:])
    return sheets, (asis < turned) | tie if count else np.zeros(m, dtype=bool)


def _closed(sheets: Indices, edges: Indices) -> NDArray[np.bool_]:
    """Return which sheets have every edge an even number of times; `edges` (3 m,) numbers them."""
    count = int(sheets.max()) + 1
    first, place = find_distinct(edges * count + np.repeat(sheets, 3))
    odd = first[np.bincount(place) % 2 == 1]
    closed = np.ones(count, dtype=bool)
    closed[sheets[odd // 3]] = False
    return closed
