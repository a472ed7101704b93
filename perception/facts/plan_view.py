"""The scene seen from above: overlap of faces in plan, and the free height below them."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely

from facetlog.perception.batch_linalg import dots, project_on_axes
from facetlog.perception.facts.relations import project_outlines
from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.ragged import Bools, Indices
from facetlog.perception.surfaces.components import components
from facetlog.perception.surfaces.contacts import SideContacts
from facetlog.perception.surfaces.convex_hulls import find_least_rectangles
from facetlog.perception.surfaces.face_table import FaceTable
from facetlog.perception.surfaces.outline_overlap import Outlines
from facetlog.perception.types import FloatArray

# A face this near to upright has a line for a plan (the vocabulary's "upright": 80° and more).
UPRIGHT = np.deg2rad(10.0)
# Free height "under most of it": 80 %, the vocabulary's figure.
MOST = 0.8
# What carries a face to the ground is not in the way, unless more than this share of it stands so.
STANDING = 0.5
# Rays a side of the grid under a face: 1 % steps of its plan.
RAYS = 10
# Less overlap than this share is not stated; two faces of one solid share a rim of rounding.
LEAST_OVERLAP = 1e-3

PAIRS_AT_ONCE = 2_000
"""Pairs of plans whose rays are followed in one go: some 20 MB."""


@dataclass(frozen=True, eq=False, slots=True)
class Plans:
    """Faces `index` (l,) that are not upright, and their plans along `axes` (2, 3).

    `meeting` (p, 2) are pairs of rows, both ways round, whose plans' boxes meet.
    """

    table: FaceTable
    up: FloatArray
    index: Indices
    outlines: Outlines
    axes: FloatArray
    meeting: Indices

    @classmethod
    def of(cls, table: FaceTable, up: FloatArray) -> "Plans | None":
        """Return the plans of faces; None where all are upright."""
        rise = np.abs(dots(table.planes.normals, up))
        index = np.flatnonzero((rise > np.sin(UPRIGHT)) & (table.areas > 0.0))
        if not len(index):
            return None
        axes = make_plane_axes(up, table.axes[index[0], 0])
        outlines = project_outlines(table, index, axes)
        seen = outlines.areas > 0.0
        index, outlines = index[seen], outlines.take(seen)
        low, high = outlines.low, outlines.high
        meet = np.all((low[:, None] <= high) & (low <= high[:, None]), axis=2)
        np.fill_diagonal(meet, val=False)
        return cls(table, up, index, outlines, axes, np.argwhere(meet))


def overlaps(plans: Plans) -> tuple[Indices, Indices, FloatArray]:
    """Return pairs i, j (p,), i < j, whose plans overlap: the intersection over the smaller
    plan.
    """
    one, two = plans.meeting[plans.meeting[:, 0] < plans.meeting[:, 1]].T
    areas = plans.outlines.areas
    shares = plans.outlines.take(one).compute_shared_areas(plans.outlines.take(two))
    shares /= np.minimum(areas[one], areas[two])
    stated = shares >= LEAST_OVERLAP
    one, two = plans.index[one[stated]], plans.index[two[stated]]
    return one, two, np.minimum(shares[stated], 1.0)


def _make_ray_grids(outlines: Outlines) -> tuple[FloatArray, Bools]:
    """Return points (l, q, 2) of grids square to the plans' least rectangles; which are in them (l,
    q).
    """
    corners, there = outlines.corners()
    direction, length, width = find_least_rectangles(corners, there, outlines.convex)
    frames = np.stack([direction, direction[:, ::-1] * [-1.0, 1.0]], axis=1)
    reach = project_on_axes(corners, frames)
    low = np.where(there[..., None], reach, np.inf).min(axis=1)
    steps = (np.arange(RAYS) + 0.5) / RAYS
    along = low[:, 0, None] + length[:, None] * steps
    across = low[:, 1, None] + width[:, None] * steps
    grid = np.empty((len(corners), RAYS, RAYS, 2))
    grid[..., 0], grid[..., 1] = along[:, :, None], across[:, None]
    flat = grid.reshape(len(corners), RAYS * RAYS, 2)
    where = project_on_axes(flat, frames.transpose(0, 2, 1))
    inside = outlines.hold(where)
    lost = np.flatnonzero(~inside.any(axis=1))
    if len(lost):  # so narrow that no ray meets it
        some = shapely.point_on_surface(outlines.take(lost).polygons())
        where[lost, 0] = shapely.get_coordinates(some)
        inside[lost, 0] = True
    return where, inside


def _find_solid_bottoms(
    table: FaceTable, contacts: SideContacts, senses: Indices, up: FloatArray
) -> FloatArray:
    """Return the height (f,) down to which the solid under each upward face is seen to reach.

    Upward faces that meet convexly or flat roof one solid. It reaches down as far as the shortest
    of the other faces that meet the roof convexly; a roof without such sides is but itself, down
    to its lowest point. (A table's slab is as deep as its rim, be there legs in the rim's plane; a
    block is as deep as its sides.)
    """
    bottoms = dots(table.points[table.outlines], up).min(axis=1)
    bent = contacts.take(contacts.against)
    upward = senses[bent.faces] > 0
    roofs = np.array(
        components(len(table), bent.faces[upward.all(axis=1) & ~bent.concave].tolist()),
        dtype=np.intp,
    )
    rim = bent.convex & (upward[:, 0] != upward[:, 1])
    roof = np.where(upward[rim, 0], bent.faces[rim, 0], bent.faces[rim, 1])
    side = np.where(upward[rim, 0], bent.faces[rim, 1], bent.faces[rim, 0])
    depths = bottoms.copy()
    for face in np.unique(side[~table.convex[side]]).tolist():
        depths[face] = max(bottoms[face], _find_usual_bottom(table, face, up))
    sides, own = np.full(len(table), -np.inf), np.full(len(table), np.inf)
    np.maximum.at(sides, roofs[roof], depths[side])
    np.minimum.at(own, roofs, bottoms)
    return np.where(np.isfinite(sides), sides, own)[roofs]


def _find_usual_bottom(table: FaceTable, face: int, up: FloatArray) -> float:
    """Return the height to which four in five columns of a face's outline reach from its upper
    sides.
    """
    ring = table.points[table.outlines[face, table.there[face]]]
    x, y = ring @ np.cross(up, table.planes.normals[face]), ring @ up
    at = x.min() + np.ptp(x) * (np.arange(RAYS) + 0.5) / RAYS
    over, after = x < at[:, None], np.roll(x, -1) < at[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (at[:, None] - x) / (np.roll(x, -1) - x)
        crossed = np.where(over != after, y + share * (np.roll(y, -1) - y), -np.inf)
    ends = np.sort(crossed, axis=1)[:, -2]
    return float(np.sort(ends)[int(np.ceil((RAYS - 1) * MOST))])


@dataclass(frozen=True, eq=False, slots=True)
class _Rays:
    """Rays (r, q) downwards from some plans, with heights at the start; and what they meet.

    A row of `hits` (p, q) is the heights at which the rays of one plan meet the face `face` (p,),
    -inf where they do not. The rows of a plan that has some begin at `starts`; it is `of` (s,).
    """

    start: FloatArray
    hits: FloatArray
    face: Indices
    starts: Indices
    of: Indices

    @classmethod
    def of_rows(cls, plans: Plans, rows: slice, where: FloatArray) -> "_Rays":
        """Return the rays from some of the plans, which are at `where` (r, q, 2)."""
        table, up, index = plans.table, plans.up, plans.index
        normals, middles = table.planes.normals[index], table.middles[index]
        # The plane of a face has the height base + slopes · x over the plan.
        slopes = -project_on_axes(normals[:, None], plans.axes)[:, 0] / dots(normals, up)[:, None]
        base = dots(middles, up) - dots(slopes, project_on_axes(middles[:, None], plans.axes)[:, 0])
        start = base[rows, None] + dots(where, slopes[rows, None])
        low, high = np.searchsorted(plans.meeting[:, 0], (rows.start, rows.start + len(where)))
        ray, hit = plans.meeting[low:high].T
        ray = ray - rows.start
        heights = base[hit, None] + dots(where[ray], slopes[hit][:, None])
        hits = np.where(plans.outlines.take(hit).hold(where[ray]), heights, -np.inf)
        starts = np.flatnonzero(np.diff(ray, prepend=-1))
        return cls(start, hits, hit, starts, ray[starts])

    def find_highest_below(self, limits: FloatArray, faces: Bools) -> FloatArray:
        """Return heights (r, q) where rays next meet one of `faces` (l,) below limits (r, q), or
        -inf.
        """
        nearest = np.full(limits.shape, -np.inf)
        if len(self.of):
            counts = np.diff(self.starts, append=len(self.face))
            below = self.hits < np.repeat(limits[self.of], counts, axis=0)
            heights = np.where(below & faces[self.face, None], self.hits, -np.inf)
            nearest[self.of] = np.maximum.reduceat(heights, self.starts, axis=0)
        return nearest


def clear_below(
    plans: Plans, ground: FloatArray, contacts: SideContacts, senses: Indices
) -> tuple[Indices, FloatArray]:
    """Return faces (c,) that are not upright, and the free height (c,) under 80 % of them, by rays.

    Where the solid under a face reaches down to the ground it carries the face, and counts neither
    way, up to half of the face: more is a block, under which nothing is free. A ray runs down, and
    from an upward face starts in the solid: it leaves it through the next downward face, or, if
    none was seen, where the sides of the solid end; at once, if it then meets a face within the
    sides that looks up, as the next board of a shelf does. From there it is free down to the next
    face of any thing, or to the level of the lowest point of its own: of a face's thing that is
    `ground` (f,), infinite where it has none. `senses` (f,) say which faces look up (1) or down
    (-1).
    """
    table, index = plans.table, plans.index
    where, inside = _make_ray_grids(plans.outlines)
    finest = table.tolerance.finest
    solid = _find_solid_bottoms(table, contacts, senses, plans.up)
    heights = np.zeros(len(index))
    pairs = np.bincount(plans.meeting[:, 0], minlength=len(index))
    for rows in _iter_portions(pairs):
        rays = _Rays.of_rows(plans, rows, where[rows])
        own = index[rows]
        free = _find_free_below(rays, senses[index], senses[own], solid[own], finest)
        floor = np.maximum(free[1], ground[own, None])
        clear = np.where(inside[rows], np.maximum(free[0] - floor, 0.0), np.inf)
        standing = inside[rows] & (free[0] - ground[own, None] <= finest)
        carried = standing.sum(axis=1) <= STANDING * inside[rows].sum(axis=1)
        clear = np.where(standing, np.where(carried[:, None], np.inf, 0.0), clear)
        # Four in five are at least as long as the one that stands a fifth of the way up.
        nth = np.floor((np.isfinite(clear).sum(axis=1) - 1) * (1.0 - MOST)).astype(np.intp)
        stated = np.sort(clear, axis=1)[np.arange(len(own)), nth]
        heights[rows] = stated
    known = np.isfinite(ground[index])
    return index[known], heights[known]


def _iter_portions(pairs: Indices) -> Iterator[slice]:
    """Yield rows in portions of some PAIRS_AT_ONCE, of which there are so many (r,) for
    each row.
    """
    begin, count = 0, 0
    for row, own in enumerate(pairs.tolist()):
        if count and count + own > PAIRS_AT_ONCE:
            yield slice(begin, row)
            begin, count = row, 0
        count += own
    if begin < len(pairs):
        yield slice(begin, len(pairs))


def _find_free_below(
    rays: _Rays, senses: Indices, own: Indices, solid: FloatArray, resolution: float
) -> tuple[FloatArray, FloatArray]:
    """Return heights (r, q) from which rays are free, and at which they next meet a face, or -inf.

    `senses` (l,) are those of all faces, `own` (r,) of the rays' own; `solid` (r,) is how far down
    the solid under these is seen to reach; what is within `resolution` is one height.
    """
    upward, every = own[:, None] > 0, np.ones(len(senses), dtype=np.bool_)
    limit = rays.start - resolution
    first = rays.find_highest_below(limit, every)
    downward = rays.find_highest_below(limit, senses < 0)
    leaves = upward & (first > -np.inf) & (downward == first)
    # What faces up within the sides of a solid shows that it is none: boards lie between them.
    hollow = (first > solid[:, None] + resolution) & ~leaves
    ends = np.where(hollow, rays.start, np.minimum(rays.start, solid[:, None]))
    solid_end = np.where(upward, ends, rays.start)
    free_from = np.where(leaves, first, solid_end)
    limit = np.where(leaves, free_from, rays.start) - resolution
    return free_from, rays.find_highest_below(limit, every)
