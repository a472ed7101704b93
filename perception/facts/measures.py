"""Measures of one face, and of a face against its thing; each with its 1σ.

Standard deviations are first-order, from the covariances of vertices and planes, which are taken
as independent of each other. Lengths are in the scene's unit, areas in its square.

The area that a loop p1 … pk shows along a unit vector n is A = ½ n · Σ pi × pi+1, so
∂A/∂pi = ½ (pi+1 - pi-1) × n and ∂A/∂n = ½ Σ pi × pi+1.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from facetlog.perception.batch_linalg import compute_quadratic_forms, dots, project_on_axes
from facetlog.perception.facts.relations import FacePairs, offsets
from facetlog.perception.flat_faces import cross, make_plane_axes
from facetlog.perception.ragged import (
    Bools,
    Indices,
    find_row_starts,
    row_table,
    sum_padded_rows,
    sum_rows,
)
from facetlog.perception.surfaces.contacts import measure_face_distances
from facetlog.perception.surfaces.convex_hulls import (
    Hulls,
    find_least_rectangle,
    find_least_rectangles,
)
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.outline_overlap import following
from facetlog.perception.types import FloatArray

# Faces this close in area count as equally large; well below any measuring error.
AREA_TIE = 1e-6
# Faces within 15 degrees of opposed are sides of one solid (cosine), if the other has this share of
# a face's area: a notch's side has less.
OPPOSED = float(-np.cos(np.deg2rad(15.0)))
LEAST_OPPOSED = 0.2
# The side opposite lies this share of the way to the farthest vertex at least: what is nearer is
# the back of a sheet or the inside of a hollow.
LEAST_DEPTH = 0.5
# In 3-D, hulls of fewer points than this are not worth Qhull's call.
FEW_POINTS = 20

MOST_NUMBERS = 1_000_000
"""Numbers worked on in one go: some 10 MB an array."""


@dataclass(frozen=True, eq=False, slots=True)
class Estimates:
    """Values (f,) and their standard deviations (f,), in the same unit."""

    values: FloatArray
    sds: FloatArray

    @classmethod
    def of(cls, values: FloatArray, variances: FloatArray) -> "Estimates":
        """Return estimates of values and variances (f,); rounding may have left these below
        zero.
        """
        return cls(values, np.sqrt(np.maximum(variances, 0.0)))

    def pairs(self) -> Iterator[tuple[float, float]]:
        """Iterate over (value, sd)."""
        return zip(self.values.tolist(), self.sds.tolist(), strict=True)


@dataclass(frozen=True, eq=False, slots=True)
class FaceSizes:
    """Areas without holes, sides of the least rectangles round outlines, and areas over theirs.

    `ways` (f, 2, 3) are the directions of lengths and widths, unit vectors in the world.
    """

    areas: Estimates
    lengths: Estimates
    widths: Estimates
    fills: Estimates
    ways: FloatArray


def face_sizes(table: FaceTable) -> FaceSizes:
    """Return areas, lengths, widths and fills of all faces."""
    members = table.members
    own = table.covs[members.vertex]
    place, _ = row_table(members.counts)
    outer = np.arange(place.shape[1]) < table.sizes[:, None]
    direction, _, _ = find_least_rectangles(table.flat, table.there, table.convex)
    across = direction[:, ::-1] * [-1.0, 1.0]
    extents, slopes, ways = [], [], []
    for way in (direction, across):
        extent, weights = _extents(table, way)
        slope = np.zeros((len(members.vertex), 3))
        in_space = (way[:, None] @ table.axes)[:, 0]
        slope[place[outer]] = (weights[:, :, None] * in_space[:, None])[table.there]
        extents.append(extent)
        slopes.append(slope)
        ways.append(in_space)
    first, second = (
        Estimates.of(extent, _variances(slope, own, members.counts))
        for extent, slope in zip(extents, slopes, strict=True)
    )
    size = first.values * second.values
    flat = size > 0.0
    safe = np.where(flat, size, 1.0)
    fill = np.where(flat, table.areas / safe, 0.0)
    # R = A / (l w):  dR = dA / (l w) - R (dl / l + dw / w)
    of = members.face
    relative = slopes[0] / np.where(flat, first.values, 1.0)[of, None]
    relative += slopes[1] / np.where(flat, second.values, 1.0)[of, None]
    slope = members.area_slope / safe[of, None] - fill[of, None] * relative
    spread = np.where(flat, _variances(slope, own, members.counts), 1.0)
    # The longer one first; of two equally long the surer is the width.
    turned = (first.values < second.values) | (
        (first.values == second.values) & (first.sds < second.sds)
    )
    length, width = (
        Estimates(np.where(turned, b.values, a.values), np.where(turned, b.sds, a.sds))
        for a, b in ((first, second), (second, first))
    )
    both = np.stack(ways, axis=1)
    both = np.where(turned[:, None, None], both[:, ::-1], both)
    areas = Estimates.of(table.areas, _variances(members.area_slope, own, members.counts))
    return FaceSizes(areas, length, width, Estimates.of(np.minimum(fill, 1.0), spread), both)


def _extents(table: FaceTable, way: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return extents (f,) of the outlines along directions (f, 2), and the vertices' weights (f,
    k).

    They run from the mean of the lowest vertices to that of the highest, by 3 sd.
    """
    reach = dots(table.flat, way[:, None])
    weights = np.zeros(reach.shape)
    for sign in (1.0, -1.0):
        there = np.where(table.there, sign * reach, -np.inf)
        equal = table.tolerance.highest(table.outlines, there)
        weights += np.where(equal, sign, 0.0) / np.maximum(equal.sum(axis=1), 1)[:, None]
    return sum_padded_rows(weights * reach), weights


def _variances(slopes: FloatArray, covs: FloatArray, counts: Indices) -> FloatArray:
    """Return Σ gᵀ C g (f,) over rows of gradients (m, 3) at vertices of covariances (m, 3, 3)."""
    return sum_rows(compute_quadratic_forms(slopes, covs), counts)


@dataclass(frozen=True, eq=False, slots=True)
class Group:
    """Faces (g,) of one thing, all its vertices (n,), and those on its convex hull (h,)."""

    faces: Indices
    members: Indices
    outer: Indices

    @classmethod
    def of(cls, faces: Sequence[int], members: Indices, points: FloatArray) -> "Group":
        """Return a thing of these faces and vertices; `points` (n, 3) are the scene's."""
        return cls(np.array(faces, dtype=np.intp), members, find_hull_vertices(members, points))


def find_hull_vertices(members: Indices, points: FloatArray) -> Indices:
    """Return the vertices of a thing that lie on its convex hull: no silhouette needs the
    others.
    """
    if len(members) > FEW_POINTS:
        from scipy.spatial import ConvexHull, QhullError  # a quarter of a second to load

        try:
            corners: Indices = members[ConvexHull(points[members]).vertices]
        except QhullError:  # all in one plane
            return members
        return corners
    return members


def _pairs(groups: Sequence[Group], whole: bool) -> tuple[Indices, Indices, Indices]:
    """Return faces (r,) of all groups, with how many vertices (r,) of their things, and
    these (c,).
    """
    vertices = [group.members if whole else group.outer for group in groups]
    faces = np.concatenate([group.faces for group in groups])
    counts = np.repeat([len(v) for v in vertices], [len(group.faces) for group in groups])
    each = [np.tile(v, len(group.faces)) for v, group in zip(vertices, groups, strict=True)]
    return faces, counts, np.concatenate(each)


def protrusions(table: FaceTable, groups: Sequence[Group]) -> Estimates:
    """Return how far the things' vertices reach in front of their faces' planes, group by group."""
    return _reaches(table, groups, 1.0)


def measure_reaches_behind(
    table: FaceTable, groups: Sequence[Group], pairs: FacePairs
) -> Estimates:
    """Return how far the things reach behind their faces' planes, group by group: to the side
    opposite, where there is one, else to the farthest vertices.

    A side that was measured is surer than its corners, which ragged faces of pictures lack.
    """
    found = _reaches(table, groups, -1.0)
    faces = np.concatenate([group.faces for group in groups])
    owners = np.full(len(table), -1, dtype=np.intp)
    for nth, group in enumerate(groups):
        owners[group.faces] = nth
    one, two = pairs.one, pairs.two
    normals, areas = table.planes.normals, table.areas
    behind = (owners[one] == owners[two]) & (owners[one] >= 0)
    behind &= dots(normals[one], normals[two]) <= OPPOSED
    behind &= areas[one] >= LEAST_OPPOSED * areas[two]
    places = np.flatnonzero(behind)
    if not len(places):
        return found
    # of each two sides the surer plane, from the other's middle
    values, sds = (each[places] for each in offsets(table, pairs))
    back, back_sds = (each[pairs.other[places]] for each in offsets(table, pairs))
    far, sd = -np.where(back_sds < sds, back, values), np.minimum(back_sds, sds)
    # the farthest of each face, of several as far the surest
    farthest, least = np.zeros(len(table)), np.zeros(len(table))
    least[faces] = LEAST_DEPTH * found.values
    np.maximum.at(farthest, two[places], far)
    slack = table.tolerance.within(sd)
    deep = (far > 0.0) & (far >= least[two[places]])
    as_far = np.flatnonzero(deep & (far >= farthest[two[places]] - slack))
    order = as_far[np.lexsort((sd[as_far], two[places][as_far]))]
    first = order[np.unique(two[places][order], return_index=True)[1]]
    at = np.full(len(table), -1, dtype=np.intp)
    at[two[places[first]]] = first
    chosen = at[faces]
    opposed = chosen >= 0
    return Estimates(
        np.where(opposed, far[chosen], found.values), np.where(opposed, sd[chosen], found.sds)
    )


def _reaches(table: FaceTable, groups: Sequence[Group], sign: float) -> Estimates:
    """Return how far the things' vertices reach from their faces' planes along their normals (1) or
    against them (-1), group by group.
    """
    faces, counts, vertices = _pairs(groups, whole=True)
    planes = table.planes
    place, there = row_table(counts)
    others = vertices[place]
    there &= ~_is_member(table, faces, others)
    normals, offset = sign * planes.normals[faces], sign * planes.offsets[faces]
    reach = dots(table.points[others], normals[:, None]) + offset[:, None]
    farthest = table.tolerance.highest(others, np.where(there, reach, -np.inf))
    # Without any vertex of others the face has but its own place.
    alone = ~farthest.any(axis=1)
    weights = farthest / np.maximum(farthest.sum(axis=1), 1)[:, None]
    row, column = np.nonzero(farthest)
    vertex = others[row, column]
    middles = np.zeros((len(faces), 3))
    np.add.at(middles, row, weights[row, column, None] * table.points[vertex])
    middles[alone] = table.middles[faces[alone]]
    along = compute_quadratic_forms(normals[row], table.covs[vertex])
    own = np.bincount(row, weights[row, column] ** 2 * along, minlength=len(faces))
    levers = np.column_stack([middles, np.ones(len(faces))])
    of_plane = compute_quadratic_forms(levers, planes.covs[faces])
    signed = (middles * normals).sum(axis=1) + offset
    signed[alone] = 0.0
    return Estimates.of(np.maximum(signed, 0.0), np.maximum(of_plane, 0.0) + np.maximum(own, 0.0))


def _is_member(table: FaceTable, faces: Indices, vertices: Indices) -> Bools:
    """Return whether vertices (r, k) are members of their row's face (r,)."""
    known = np.zeros((len(table), len(table.points)), dtype=np.bool_)
    known[table.members.face, table.members.vertex] = True
    found: Bools = known[faces[:, None], vertices]
    return found


def shares(table: FaceTable, groups: Sequence[Group]) -> Estimates:
    """Return areas of faces over the silhouettes of their things along the faces' normals, 0..1.

    The silhouette is the convex hull of the thing's vertices, loose edges' ends too, projected
    along the normal. So it does not ask which faces were seen: each face of a block has 1, even
    if its back is unknown, and a table's rim has little, because the legs reach far down, whether
    they are faces or mere edges. Holes count as silhouette, and a hollow (an L's notch) as well.
    """
    faces, counts, vertices = _pairs(groups, whole=False)
    starts = find_row_starts(counts)
    longest = int(counts.max(initial=0)) + int(table.members.counts.max(initial=0))
    step = max(1, MOST_NUMBERS // max(longest * max(longest, 2 * table.flat.shape[1]), 1))
    found = [
        _shares(
            table,
            faces[some : some + step],
            counts[some : some + step],
            vertices[starts[some] : (starts + counts)[min(some + step, len(faces)) - 1]],
        )
        for some in range(0, len(faces), step)
    ]
    return Estimates(
        np.concatenate([each.values for each in found]),
        np.concatenate([each.sds for each in found]),
    )


def _beyond(table: FaceTable, faces: Indices, others: Indices, there: Bools) -> Bools:
    """Return which other vertices (r, k) of things show beyond the faces (r,), seen along their
    normals.

    What shows within 3 sd of the face does not: vertices stacked along the normal would otherwise
    each push the silhouette out by their noise.
    """
    planes, sds = table.planes, table.tolerance.vertex_sds
    normals, where = planes.normals[faces], table.points[others]
    depth = dots(where, normals[:, None]) + planes.offsets[faces, None]
    own = sds[table.outlines[faces]].max(axis=1)[:, None]
    tilt = planes.tilt_sds[faces, None] * depth
    limit = table.tolerance.within(np.hypot(np.hypot(sds[others], own), tilt))
    flat = project_on_axes(where - table.middles[faces, None], table.axes[faces])
    # What is that far from the outline's box needs no closer look.
    own_flat = table.flat[faces]
    low, high = own_flat.min(axis=1)[:, None], own_flat.max(axis=1)[:, None]
    away = np.maximum(np.maximum(low - flat, flat - high), 0.0)
    beyond: Bools = there & (np.hypot(away[..., 0], away[..., 1]) > limit)
    row, column = np.nonzero(there & ~beyond)
    outside, _ = measure_face_distances(table, faces[row], flat[row, column][:, None])
    beyond[row, column] = outside[:, 0] > limit[row, column]
    return beyond


def _shares(table: FaceTable, faces: Indices, counts: Indices, vertices: Indices) -> Estimates:
    # With A = n · S, S = ½ Σ pi × pi+1 over the silhouette's loop: ∂A/∂n = S, across the normal.
    place, there = row_table(counts)
    others = vertices[place]
    there &= ~_is_member(table, faces, others)
    beyond = _beyond(table, faces, others, there)
    sizes = table.members.counts[faces]
    rows, width = np.arange(len(faces)), int(sizes.max())
    mine = find_row_starts(table.members.counts)[faces, None] + np.minimum(
        np.arange(width), sizes[:, None] - 1
    )
    vertex = np.concatenate((table.members.vertex[mine], others), axis=1)
    candidate = np.concatenate((np.arange(width) < sizes[:, None], beyond), axis=1)
    where, normals = table.points[vertex], table.planes.normals[faces]
    flat = project_on_axes(where - table.middles[faces, None], table.axes[faces])

    finest = table.tolerance.finest
    hulls = Hulls(flat, candidate, table.convex[faces] & ~beyond.any(axis=1), finest)
    corners, after = hulls.of(flat), following(hulls.sizes, hulls.places.shape[1])
    # Vertices stacked along the normal make one corner together: their mean.
    known = np.arange(hulls.places.shape[1]) < hulls.sizes[:, None]
    beside = np.abs(corners[:, :, None, 0] - flat[:, None, :, 0]) <= finest
    row, corner, column = np.nonzero(beside & candidate[:, None] & known[..., None])
    apart = corners[row, corner] - flat[row, column]
    near = dots(apart, apart) <= finest * finest
    row, corner, column = row[near], corner[near], column[near]
    of_corner = row * known.shape[1] + corner
    weight = 1.0 / np.bincount(of_corner)[of_corner]
    loop = np.zeros((*known.shape, 3))
    np.add.at(loop, (row, corner), weight[:, None] * where[row, column])
    spokes = np.where(known[..., None], loop - loop[:, :1], 0.0)
    vectors = 0.5 * cross(spokes, spokes[rows[:, None], after]).sum(axis=1)
    silhouettes = (vectors * normals).sum(axis=1)

    seen = silhouettes > 0.0
    whole = np.where(seen, silhouettes, 1.0)
    # R = A / H:  dR = (dA - R dH) / H
    ratios = table.areas[faces] / whole
    spans = (
        spokes[rows[:, None], after] - spokes[rows[:, None], _find_preceding(hulls.sizes, after)]
    )
    gradient = cross(spans, 0.5 * normals[:, None])
    slopes = np.zeros(where.shape)
    np.add.at(slopes, (row, column), weight[:, None] * gradient[row, corner])
    slopes *= -ratios[:, None, None]
    slopes[:, :width] += np.where(candidate[:, :width, None], table.members.area_slope[mine], 0.0)
    own = slopes[candidate] / whole[np.nonzero(candidate)[0], None]
    by_vertices = _variances(own, table.covs[vertex[candidate]], candidate.sum(axis=1))
    leaning = ratios[:, None] * (vectors - silhouettes[:, None] * normals)
    normal_covs = table.planes.normal_covs[faces]
    by_normal = compute_quadratic_forms(leaning, normal_covs) / whole**2
    variances = np.maximum(by_vertices, 0.0) + np.maximum(by_normal, 0.0)
    return Estimates.of(
        np.where(seen, np.minimum(ratios, 1.0), 0.0), np.where(seen, variances, 1.0)
    )


def _find_preceding(sizes: Indices, after: Indices) -> Indices:
    """Return place (r, k) of the corner before each one of loops of some sizes (r,)."""
    steps = np.arange(after.shape[1])
    return np.where(steps == 0, np.maximum(sizes - 1, 0)[:, None], steps - 1)


def find_thing_boxes(
    table: FaceTable, groups: Sequence[Group]
) -> Iterator[tuple[float, float, float]]:
    """Return sides, longest first, of the least boxes round things, square to each one's largest
    face.

    Where several faces are the largest, the least of their boxes is taken.
    """
    faces = np.concatenate([group.faces for group in groups])
    owner = np.repeat(np.arange(len(groups)), [len(group.faces) for group in groups])
    largest = np.zeros(len(groups))
    np.maximum.at(largest, owner, table.areas[faces])
    chosen = table.areas[faces] >= largest[owner] * (1.0 - AREA_TIE)
    faces, owner = faces[chosen], owner[chosen]
    outer = np.array([len(group.outer) for group in groups], dtype=np.intp)
    place, there = row_table(outer)
    vertices = np.concatenate([group.outer for group in groups])
    points, there = table.points[vertices[place[owner]]], there[owner]
    normals = table.planes.normals[faces]
    frames = make_plane_axes(normals, table.axes[faces, 0])
    _, lengths, widths = find_least_rectangles(project_on_axes(points, frames), there)
    depths = np.ptp(dots(points, normals[:, None]), axis=1)
    boxes = np.sort(np.column_stack([lengths, widths, depths]), axis=1)[:, ::-1]
    order = np.lexsort((*boxes.T[::-1], boxes.prod(axis=1), owner))
    first = np.unique(owner[order], return_index=True)[1]
    high, middle, low = boxes[order[first]].T.tolist()
    return zip(high, middle, low, strict=True)


def find_box_of_points(points: FloatArray) -> tuple[float, float, float]:
    """Return sides, longest first, of the least box round points (n, 3), n > 1, square to the
    direction in which they vary least.
    """
    normal = np.linalg.eigh(np.cov(points.T))[1][:, 0]
    axes = make_plane_axes(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    _, length, width = find_least_rectangle(points @ axes.T)
    low, middle, high = sorted((length, width, float(np.ptp(points @ normal))))
    return high, middle, low
