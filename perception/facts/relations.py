"""How two faces lie to each other: offset, opposite, coplanar; all pairs at once."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from facetlog.perception.batch_linalg import along_axes, dots
from facetlog.perception.facts.angles import angles_between
from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.ragged import (
    Indices,
    chosen_places,
    pairs_in_rows,
    row_starts,
    row_sums,
)
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.outline_overlap import Outlines
from facetlog.perception.surfaces.tolerance import ANGLE_RESOLUTION, SDS
from facetlog.perception.types import FloatArray

__all__ = ["FacePairs", "angles", "coplanar_pairs", "offsets", "opposite_pairs", "seen_along"]

# First-order angles are calibrated up to 7° and mean little beyond 15°.
VAGUE = np.deg2rad(15.0)
# Opposite faces of a made thing are seldom out of parallel by more than this.
OPPOSITE_LEAST = np.deg2rad(5.0)
# Outlines that overlap by less of the smaller one only graze each other.
LEAST_FACING = 0.01


@dataclass(frozen=True, eq=False)
class FacePairs:
    """Every two faces `one` and `two` (p,) of a scene, in either order, by the first.

    `other` (p,) is the place of the pair in the other order. Scenes have `counts` (s,) pairs.
    """

    one: Indices
    two: Indices
    other: Indices
    counts: Indices

    @classmethod
    def of(cls, table: FaceTable) -> "FacePairs":
        """The pairs of all scenes of a table."""
        faces = table.face_counts
        one, two = pairs_in_rows(faces, faces)
        apart = one != two
        one, two = one[apart], two[apart]
        counts = faces * (faces - 1)
        # A face has a pair with each of the others of its scene, in their order.
        start = row_starts((faces - 1)[table.scene])
        first = row_starts(faces)[table.scene]
        other = start[two] + one - first[two] - (one > two)
        return cls(one, two, other, counts)

    @cached_property
    def ascending(self) -> Indices:
        """Places of the pairs whose first face is the earlier one."""
        return np.flatnonzero(self.one < self.two)


def angles(table: FaceTable, pairs: FacePairs) -> tuple[FloatArray, FloatArray]:
    """Angles (p,) between the normals of pairs of faces and their 1σ, radians."""
    rows = pairs.ascending
    own = angles_between(
        table.planes.normals, table.planes.normal_covs, pairs.one[rows], pairs.two[rows]
    )
    found = np.zeros((2, len(pairs.one)))
    for both, values in zip(found, own, strict=True):
        both[rows] = both[pairs.other[rows]] = values
    return found[0], found[1]


def offsets(table: FaceTable, pairs: FacePairs) -> tuple[FloatArray, FloatArray]:
    """Signed distances (p,) of the middles of first faces from the planes of the second, and 1σ."""
    slopes, members = table.members.middle_slope, table.members
    # Of a middle: Σ J C Jᵀ over its vertices.
    covs = row_sums(slopes @ table.covs[members.vertex] @ slopes.transpose(0, 2, 1), members.counts)
    return table.planes.heights(pairs.two, pairs.one, table.middles, covs)


def coplanar_pairs(
    table: FaceTable,
    pairs: FacePairs,
    angles: tuple[FloatArray, FloatArray],
    distances: tuple[FloatArray, FloatArray],
) -> Indices:
    """Places (c,) of pairs, i < j, in one plane: normals parallel or opposed, middles in them."""
    off = np.minimum(angles[0], np.pi - angles[0])
    flat = off <= np.minimum(SDS * angles[1], VAGUE) + ANGLE_RESOLUTION
    near = np.abs(distances[0]) <= table.tolerance.within(distances[1], table.scene[pairs.one])
    rows = pairs.ascending
    return rows[(flat & near & near[pairs.other])[rows]]


def seen_along(table: FaceTable, faces: Indices, frames: FloatArray) -> Outlines:
    """Outlines (r,) of faces (r,) in frames (r, 2, 3) of their own, or in one (2, 3) for all."""
    points = table.points
    frames = np.broadcast_to(frames, (len(faces), 2, 3))
    loops = along_axes(points[table.outlines[faces]], frames)

    def rings_of(rows: Indices) -> tuple[FloatArray, Indices, Indices]:
        own, sides = faces[rows], table.sides
        corners = np.bincount(sides.face, minlength=len(table))
        corner = sides.ends[chosen_places(corners, own), 0]
        turned = np.repeat(frames[rows], corners[own], axis=0)
        ring_of = sides.face[row_starts(sides.lengths)]
        rings = np.bincount(ring_of, minlength=len(table))
        lengths = sides.lengths[chosen_places(rings, own)]
        flat = along_axes(points[corner][:, None], turned)[:, 0]
        return flat, lengths, np.repeat(np.arange(len(rows)), rings[own])

    return Outlines.of(loops, table.sizes[faces], table.convex[faces], rings_of)


def opposite_pairs(
    table: FaceTable, every: FacePairs, angles: tuple[FloatArray, FloatArray]
) -> Indices:
    """Pairs (p, 2), i < j, with opposed normals whose outlines overlap along the mean normal."""
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
    frames = plane_axes(mean, table.axes[opposed[:, 0], 0])
    pairs = len(opposed)
    both = seen_along(table, opposed.T.ravel(), np.concatenate((frames, frames)))
    first, second = both.take(np.arange(pairs)), both.take(np.arange(pairs, 2 * pairs))
    least = np.minimum(first.areas, second.areas)
    facing = (least > 0.0) & (first.shared_areas(second) >= LEAST_FACING * least)
    return np.asarray(opposed[facing], dtype=np.intp)
