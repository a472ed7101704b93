"""Measures that need a known up: tilt, and heights in a thing."""

from dataclasses import dataclass

import numpy as np

from facetlog.perception.batch_linalg import compute_quadratic_forms, dots
from facetlog.perception.facts.measures import Estimates
from facetlog.perception.ragged import Indices, find_row_starts, row_table
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.plane_table import PlaneTable
from facetlog.perception.surfaces.tolerance import ANGLE_RESOLUTION
from facetlog.perception.types import FloatArray

# "Points up" needs 2 sd: 97.7 % one-sided.
SENSE_SDS = 2.0
# Heights above the ground of so much of those in the world are 0: the rest is rounding.
ROUNDING = 1e-12


def tilts(planes: PlaneTable, up: FloatArray) -> Estimates:
    """Return angles (f,) between planes and the level, radians, 0..π/2, up (3,) exact."""
    rise = dots(planes.normals, up)
    lean = up - rise[:, None] * planes.normals
    size = np.sqrt(dots(lean, lean))
    level = size < ANGLE_RESOLUTION
    along = compute_quadratic_forms(lean, planes.normal_covs)
    variance = along / np.where(level, 1.0, size) ** 2
    variance = np.where(level, planes.tilt_sds**2, variance)
    return Estimates.of(np.arctan2(size, np.abs(rise)), variance)


def find_vertical_senses(planes: PlaneTable, up: FloatArray, leaning: Estimates) -> Indices:
    """Return 1 (f,) where a normal points above the horizon by more than 2 sd, -1 if below, else 0.

    `leaning` is what `tilts` says of these planes.
    """
    sure = np.pi / 2 - leaning.values > SENSE_SDS * leaning.sds + ANGLE_RESOLUTION
    return np.where(sure, np.where(dots(planes.normals, up) > 0.0, 1, -1), 0)


@dataclass(frozen=True, eq=False, slots=True)
class Grounds:
    """The lowest of each thing's vertices, with those level with it: what heights count from.

    Vertex `vertex` (g,) is of the ground of thing `thing` (g,), `counts` (t,) a thing; `heights`
    (n,) are those of all vertices along `up` (3,). Where `floors` (t,), the heights of the ground
    that was seen, are lower, heights count from these.
    """

    thing: Indices
    vertex: Indices
    counts: Indices
    heights: FloatArray
    up: FloatArray
    floors: FloatArray

    @classmethod
    def under(
        cls,
        members: tuple[Indices, Indices],
        table: FaceTable,
        up: FloatArray,
        floors: FloatArray,
    ) -> "Grounds":
        """Return the grounds of things that have vertices: `members` are (thing, vertex), by the
        things.

        `floors` (t,) are heights of the ground, or infinite.
        """
        heights = dots(table.points, up)
        rows, vertices = members
        count = int(rows[-1]) + 1
        found = _find_highest(rows, vertices, count, table, -heights[vertices])
        return cls(*found, heights, up, floors)

    def above(
        self,
        things: Indices,
        values: FloatArray,
        rows: Indices,
        vertex: Indices,
        slope: FloatArray,
        covs: FloatArray,
    ) -> Estimates:
        """Return heights (b,) above the grounds of `things` (b,), with their 1σ.

        `values` (b,) are heights in the world; they answer to vertices (m,) of rows (m,) by
        `slope` (m, 3).
        """
        place, there = row_table(self.counts)
        own_place, own = place[things], there[things]
        ground_rows = np.nonzero(own)[0]
        ground = self.vertex[own_place[own]]
        shares = 1.0 / self.counts[things]
        base = np.bincount(
            ground_rows, self.heights[ground] * shares[ground_rows], minlength=len(things)
        )
        floors = self.floors[things]
        below = floors < base
        base = np.where(below, floors, base)
        shares = np.where(below, 0.0, shares)
        # A vertex of the ground may be one that the height answers to: there the slopes add.
        keys = np.concatenate((rows, ground_rows)) * len(covs) + np.concatenate((vertex, ground))
        down = -shares[ground_rows, None] * self.up
        every = np.concatenate((slope, down))
        known, row = np.unique(keys, return_inverse=True)
        total = np.zeros((len(known), 3))
        np.add.at(total, row, every)
        owner, at = np.divmod(known, len(covs))
        along = compute_quadratic_forms(total, covs[at])
        variances = np.bincount(owner, along, minlength=len(things)).astype(np.float64)
        above = values - base
        above[np.abs(above) <= ROUNDING * (np.abs(values) + np.abs(base))] = 0.0
        return Estimates.of(above, variances)


def _find_highest(
    rows: Indices, vertices: Indices, count: int, table: FaceTable, reach: FloatArray
) -> tuple[Indices, Indices, Indices]:
    """Return (body, vertex) (m,) of the highest vertices of bodies by 3 sd, and how many a body.

    Body `rows` (h,), ascending, has the vertex `vertices` (h,), which reaches `reach` (h,) far.
    """
    top = np.full(count, -np.inf)
    np.maximum.at(top, rows, reach)
    first = np.zeros(count, dtype=np.intp)
    highest = np.flatnonzero(reach == top[rows])[::-1]
    first[rows[highest]] = highest  # the last assignment, the first of equals, stays
    sds = table.tolerance.vertex_sds[vertices]
    limit = table.tolerance.within(np.hypot(sds, sds[first[rows]]))
    equal = reach >= top[rows] - limit
    rows, vertices = rows[equal], vertices[equal]
    order = np.lexsort((vertices, rows))  # equal bodies are to have equal sums
    return rows[order], vertices[order], np.bincount(rows, minlength=count)


def compute_extreme_heights(
    vertices: Indices, counts: Indices, things: Indices, grounds: Grounds, table: FaceTable
) -> tuple[Estimates, Estimates]:
    """Return heights (b,) of the highest and the lowest vertices of bodies above their things'
    grounds.

    The bodies have so many of the vertices (h,) as `counts` (b,) say, one after the other.
    """
    bodies = len(counts)
    rows = np.repeat(np.arange(bodies), counts)
    heights = grounds.heights[vertices]
    # The lowest are the highest of the same, upside down.
    rows, at, found = _find_highest(
        np.concatenate((rows, bodies + rows)),
        np.concatenate((vertices, vertices)),
        2 * bodies,
        table,
        np.concatenate((heights, -heights)),
    )
    shares = 1.0 / found[rows]
    values = np.bincount(rows, shares * grounds.heights[at], minlength=2 * bodies).astype(
        np.float64
    )
    slope = shares[:, None] * grounds.up
    both = grounds.above(np.tile(things, 2), values, rows, at, slope, table.covs)
    return (
        Estimates(both.values[:bodies], both.sds[:bodies]),
        Estimates(both.values[bodies:], both.sds[bodies:]),
    )


def compute_elevations(
    table: FaceTable, faces: Indices, things: Indices, grounds: Grounds
) -> Estimates:
    """Return heights (r,) of the middles of faces (r,) above the grounds of their things (r,)."""
    members = table.members
    _, there = row_table(members.counts[faces])
    own = find_row_starts(members.counts)[faces][:, None] + np.arange(there.shape[1])
    own = own[there]
    rows = np.nonzero(there)[0]
    slope = (grounds.up[None] @ members.middle_slope[own])[:, 0]
    values = dots(table.middles[faces], grounds.up)
    return grounds.above(things, values, rows, members.vertex[own], slope, table.covs)
