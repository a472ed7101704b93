"""How two faces lie to each other: offset, opposite, coplanar; all pairs at once."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from facetlog.perception.batch_linalg import compute_quadratic_forms, dots, project_on_axes
from facetlog.perception.flat_faces import cross, make_plane_axes
from facetlog.perception.ragged import (
    Indices,
    find_entries_of_rows,
    find_row_starts,
    sum_rows,
)
from facetlog.perception.scene import Plane
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.outline_overlap import Outlines
from facetlog.perception.surfaces.tolerance import ANGLE_RESOLUTION, SDS
from facetlog.perception.types import FloatArray

# First-order propagation of the normals' covariances: calibrated for angles surer than about 7°;
# from an sd of 10-15° on "unknown" is the honest word. At 0° and 180° the first order breaks down:
# there any error of a normal makes the angle between two parallel planes larger (or smaller), none
# leaves it. `sd` is therefore the root mean square error of the measured angle about the true one,
# with the second-order part of the error across the plane of the two normals added; it tends to
# the first-order value away from 0° and 180° and to the length of the two-dimensional tilt error
# there, and in between, at one to three sd from them, it is up to a fifth on the safe side.

# Angles and sds below this are rounding (rad).
LEAST_SINE = 1e-9
# Twice the mean of |x| for a standard normal x.
MEAN_FOLD = 2.0 * np.sqrt(2.0 / np.pi)


def _angles(
    normals: FloatArray, covs: FloatArray, one: Indices, two: Indices
) -> tuple[FloatArray, FloatArray]:
    """Return angles and sds (p,) between `one` and `two` (p,) of unit normals with covariances."""
    n, m = normals[one], normals[two]
    product = cross(n, m)
    sine = np.sqrt(dots(product, product))
    cosine = dots(n, m)
    angle = np.arctan2(sine, cosine)
    # Of parallel normals every direction across them will do: the sum of both variances counts.
    axis = np.eye(3)[np.argmin(np.abs(n), axis=-1)]
    some = cross(n, axis)
    parallel = (sine < LEAST_SINE)[..., None]
    across = np.where(parallel, some, product)
    across = across / np.sqrt(dots(across, across))[:, None]
    n_way, m_way = cross(across, n), cross(m, across)

    # dθ = -n_way · dn - m_way · dm, with the ways towards the other normal.
    within = compute_quadratic_forms(n_way, covs, one) + compute_quadratic_forms(m_way, covs, two)
    # An error e across, with sd s, adds e² cot θ / 2 to the angle: with t = |tan θ| a mean square
    # of 3/4 s⁴ / t² far from 0° and 180°, and of s² - 2 √(2/π) s t close to them. Both are in
    # s⁴ / (s² + 2 √(2/π) s t + 4/3 t²), here times cos² above and below, for the right angle.
    s2 = compute_quadratic_forms(across, covs, one) + compute_quadratic_forms(across, covs, two)
    c = np.abs(cosine)
    below = s2 * c * c + MEAN_FOLD * np.sqrt(s2) * sine * c + 4.0 / 3.0 * sine * sine
    extra = np.divide(s2 * s2 * c * c, below, out=np.zeros_like(s2), where=below > 0)
    return angle, np.sqrt(within + extra)


def compute_angle_between(p: Plane, q: Plane) -> tuple[float, float]:
    """Return the angle between the normals, in [0, π] rad, and its standard deviation (rad).

    Take the errors of the two planes to be independent; planes that share vertices are not quite.
    """
    normals, covs = np.array([p.normal, q.normal]), np.array([p.cov[:3, :3], q.cov[:3, :3]])
    angle, sd = _angles(normals, covs, np.array([0]), np.array([1]))
    return float(angle[0]), float(sd[0])


def angles_between(
    normals: FloatArray, covs: FloatArray, one: Indices, two: Indices
) -> tuple[FloatArray, FloatArray]:
    """Return angles (p,) and standard deviations (p,), rad, between the normals `one` and `two`
    (p,).

    `normals` (n, 3) have covariances (n, 3, 3).
    """
    first = _angles(normals, covs, one, two)
    # The same either way round: of parallel normals the direction across is that of the first.
    second = _angles(normals, covs, two, one)
    return (first[0] + second[0]) / 2, (first[1] + second[1]) / 2


def compute_pairwise_angles(planes: Sequence[Plane]) -> tuple[FloatArray, FloatArray]:
    """Return angles (n, n) and standard deviations (n, n) between all normals, rad; 0 on the
    diagonal.
    """
    count = len(planes)
    angles, sds = np.zeros((2, count, count))
    if count:
        one, two = np.triu_indices(count, 1)
        normals = np.array([p.normal for p in planes])
        covs = np.array([p.cov[:3, :3] for p in planes])
        found = angles_between(normals, covs, one, two)
        for table, values in zip((angles, sds), found, strict=True):
            table[one, two] = table[two, one] = values
    return angles, sds


# First-order angles are calibrated up to 7° and mean little beyond 15°.
VAGUE = np.deg2rad(15.0)
# Opposite faces of a made thing are seldom out of parallel by more than this.
OPPOSITE_LEAST = np.deg2rad(5.0)
# Outlines that overlap by less of the smaller one only graze each other.
LEAST_FACING = 0.01


@dataclass(frozen=True, eq=False)
class FacePairs:
    """Every two faces `one` and `two` (p,) of a scene, in either order, by the first.

    `other` (p,) is the place of the pair in the other order.
    """

    one: Indices
    two: Indices
    other: Indices

    @classmethod
    def of(cls, table: FaceTable) -> "FacePairs":
        """Return the pairs of all faces of a table."""
        faces = len(table)
        one, two = np.nonzero(~np.eye(faces, dtype=np.bool_))
        # A face has a pair with each of the others, in their order.
        return cls(one, two, two * (faces - 1) + one - (one > two))

    @cached_property
    def ascending(self) -> Indices:
        """Places of the pairs whose first face is the earlier one."""
        return np.flatnonzero(self.one < self.two)


def angles(table: FaceTable, pairs: FacePairs) -> tuple[FloatArray, FloatArray]:
    """Return angles (p,) between the normals of pairs of faces and their 1σ, radians."""
    rows = pairs.ascending
    own = angles_between(
        table.planes.normals, table.planes.normal_covs, pairs.one[rows], pairs.two[rows]
    )
    found = np.zeros((2, len(pairs.one)))
    for both, values in zip(found, own, strict=True):
        both[rows] = both[pairs.other[rows]] = values
    return found[0], found[1]


def offsets(table: FaceTable, pairs: FacePairs) -> tuple[FloatArray, FloatArray]:
    """Return the signed distances (p,) of the middles of first faces from the planes of the second,
    and 1σ.
    """
    slopes, members = table.members.middle_slope, table.members
    # Of a middle: Σ J C Jᵀ over its vertices.
    covs = sum_rows(slopes @ table.covs[members.vertex] @ slopes.transpose(0, 2, 1), members.counts)
    return table.planes.heights(pairs.two, pairs.one, table.middles, covs)


def find_coplanar_pairs(
    table: FaceTable,
    pairs: FacePairs,
    angles: tuple[FloatArray, FloatArray],
    distances: tuple[FloatArray, FloatArray],
) -> Indices:
    """Return places (c,) of pairs, i < j, in one plane: normals parallel or opposed, middles in
    them.
    """
    off = np.minimum(angles[0], np.pi - angles[0])
    flat = off <= np.minimum(SDS * angles[1], VAGUE) + ANGLE_RESOLUTION
    near = np.abs(distances[0]) <= table.tolerance.within(distances[1])
    rows = pairs.ascending
    return rows[(flat & near & near[pairs.other])[rows]]


def project_outlines(table: FaceTable, faces: Indices, frames: FloatArray) -> Outlines:
    """Return outlines (r,) of faces (r,) in frames (r, 2, 3) of their own, or in one (2, 3) for
    all.
    """
    points = table.points
    frames = np.broadcast_to(frames, (len(faces), 2, 3))
    loops = project_on_axes(points[table.outlines[faces]], frames)

    def rings_of(rows: Indices) -> tuple[FloatArray, Indices, Indices]:
        own, sides = faces[rows], table.sides
        corners = np.bincount(sides.face, minlength=len(table))
        corner = sides.ends[find_entries_of_rows(corners, own), 0]
        turned = np.repeat(frames[rows], corners[own], axis=0)
        ring_of = sides.face[find_row_starts(sides.lengths)]
        rings = np.bincount(ring_of, minlength=len(table))
        lengths = sides.lengths[find_entries_of_rows(rings, own)]
        flat = project_on_axes(points[corner][:, None], turned)[:, 0]
        return flat, lengths, np.repeat(np.arange(len(rows)), rings[own])

    return Outlines.of(loops, table.sizes[faces], table.convex[faces], rings_of)


def find_opposite_pairs(
    table: FaceTable, every: FacePairs, angles: tuple[FloatArray, FloatArray]
) -> Indices:
    """Return pairs (p, 2), i < j, with opposed normals whose outlines overlap along the mean
    normal.
    """
    limit = np.clip(SDS * angles[1], OPPOSITE_LEAST, VAGUE)
    rows = every.ascending
    rows = rows[(np.pi - angles[0] <= limit)[rows]]
    one, two = every.one[rows], every.two[rows]
    opposed = np.column_stack([one, two])
    normals, middles = table.planes.normals, table.middles
    radii = np.sqrt((table.flat * table.flat).sum(axis=2).max(axis=1, initial=0.0))
    between = middles[two] - middles[one]
    mean = normals[one] - normals[two]
    mean /= np.sqrt(dots(mean, mean))[:, None]
    aside = between - dots(between, mean)[:, None] * mean
    close = np.sqrt(dots(aside, aside)) < radii[one] + radii[two]
    opposed, mean = opposed[close], mean[close]
    frames = make_plane_axes(mean, table.axes[opposed[:, 0], 0])
    pairs = len(opposed)
    both = project_outlines(table, opposed.T.ravel(), np.concatenate((frames, frames)))
    first, second = both.take(np.arange(pairs)), both.take(np.arange(pairs, 2 * pairs))
    least = np.minimum(first.areas, second.areas)
    facing = (least > 0.0) & (first.compute_shared_areas(second) >= LEAST_FACING * least)
    return np.asarray(opposed[facing], dtype=np.intp)
