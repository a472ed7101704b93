"""How two faces lie to each other: offset, opposite, coplanar; all pairs at once."""

import numpy as np

from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.row_table import Indices, chosen_places, row_starts, row_sums
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.outline_overlap import Outlines
from facetlog.perception.surfaces.tolerance import ANGLE_RESOLUTION, SDS
from facetlog.perception.types import FloatArray

__all__ = ["coplanar_pairs", "offsets", "opposite_pairs", "seen_along"]

# First-order angles are calibrated up to 7° and mean little beyond 15°.
VAGUE = np.deg2rad(15.0)
# Opposite faces of a made thing are seldom out of parallel by more than this.
OPPOSITE_LEAST = np.deg2rad(5.0)
# Outlines that overlap by less of the smaller one only graze each other.
LEAST_FACING = 0.01


def offsets(table: FaceTable) -> tuple[FloatArray, FloatArray]:
    """Signed distances [i, j] of the middle of face i from the plane of face j, and their 1σ."""
    slopes, members = table.members.middle_slope, table.members
    # Of a middle: Σ J C Jᵀ over its vertices.
    covs = row_sums(slopes @ table.covs[members.vertex] @ slopes.transpose(0, 2, 1), members.counts)
    return table.planes.distances(table.middles, covs)


def coplanar_pairs(
    table: FaceTable,
    angles: tuple[FloatArray, FloatArray],
    distances: tuple[FloatArray, FloatArray],
) -> Indices:
    """Pairs (p, 2), i < j, in one plane: normals parallel or opposed, middles in the planes."""
    off = np.minimum(angles[0], np.pi - angles[0])
    flat = off <= np.minimum(SDS * angles[1], VAGUE) + ANGLE_RESOLUTION
    near = np.abs(distances[0]) <= table.tolerance.within(distances[1])
    return np.argwhere(np.triu(flat & near & near.T, 1))


def seen_along(table: FaceTable, faces: Indices, frames: FloatArray) -> Outlines:
    """Outlines (r,) of faces (r,) in frames (r, 2, 3) of their own, or in one (2, 3) for all."""
    points = table.points
    frames = np.broadcast_to(frames, (len(faces), 2, 3))
    loops = points[table.outlines[faces]] @ frames.transpose(0, 2, 1)

    def rings_of(rows: Indices) -> tuple[FloatArray, Indices, Indices]:
        own, sides = faces[rows], table.sides
        corners = np.bincount(sides.face, minlength=len(table))
        corner = sides.ends[chosen_places(corners, own), 0]
        turned = np.repeat(frames[rows].transpose(0, 2, 1), corners[own], axis=0)
        ring_of = sides.face[row_starts(sides.lengths)]
        rings = np.bincount(ring_of, minlength=len(table))
        lengths = sides.lengths[chosen_places(rings, own)]
        flat = (points[corner][:, None] @ turned)[:, 0]
        return flat, lengths, np.repeat(np.arange(len(rows)), rings[own])

    return Outlines.of(loops, table.sizes[faces], table.convex[faces], rings_of)


def opposite_pairs(table: FaceTable, angles: tuple[FloatArray, FloatArray]) -> Indices:
    """Pairs (p, 2), i < j, with opposed normals whose outlines overlap along the mean normal."""
    limit = np.clip(SDS * angles[1], OPPOSITE_LEAST, VAGUE)
    opposed = np.argwhere(np.triu(np.pi - angles[0] <= limit, 1))
    one, two = opposed.T
    normals, middles = table.planes.normals, table.middles
    radii = np.sqrt((table.flat * table.flat).sum(axis=2).max(axis=1, initial=0.0))
    between = middles[two] - middles[one]
    mean = normals[one] - normals[two]
    mean /= np.linalg.norm(mean, axis=1)[:, None]
    aside = between - (between * mean).sum(axis=1)[:, None] * mean
    close = np.linalg.norm(aside, axis=1) < radii[one] + radii[two]
    opposed, mean = opposed[close], mean[close]
    frames = plane_axes(mean, table.axes[opposed[:, 0], 0])
    pairs = len(opposed)
    both = seen_along(table, opposed.T.ravel(), np.concatenate((frames, frames)))
    first, second = both.take(np.arange(pairs)), both.take(np.arange(pairs, 2 * pairs))
    least = np.minimum(first.areas, second.areas)
    facing = (least > 0.0) & (first.shared_areas(second) >= LEAST_FACING * least)
    return np.asarray(opposed[facing], dtype=np.intp)
