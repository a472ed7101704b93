"""Which side of a piece of surface is outside, by visibility: the share of free directions.

A closed sheet's normals point out already. For others the winding does not decide: both sides are
tested. Each object gets a grid of cubes; for every cube, in 26 directions, it is known whether the
ray out is free. A side sees the share of the directions in front of it that are free.

- The side that sees more is outside.
- Where the other sees at least a quarter as much, the piece is a sheet with two sides: a table top
  of a single layer has an upper and a lower face, the walls of a tray an inner and an outer one. A
  deep box without a bottom is open below, but its walls see little from inside, and have one side.
- A piece that sees nothing on either side is inside the object, and is no surface of it. Nor are
  the walls of gaps narrower than some 2 % of the object, which the grid does not resolve.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from facetlog.perception.ragged import Indices, iter_groups, sum_by_group
from facetlog.perception.shapes.meshes.clean_mesh import Surface
from facetlog.perception.shapes.regions.surface_samples import Samples, sample_triangles, thinned
from facetlog.perception.shapes.regions.visibility_grid import CUBES, FreeWays
from facetlog.perception.types import FloatArray

# Samples are half a cube apart, so that no cube that the surface crosses is missed.
SAMPLES_PER_CUBE = 2.0
SPACING_SHARE = 1.0 / (CUBES * SAMPLES_PER_CUBE)
"""How far apart samples lie, as a share of the object's diagonal."""
# Visibility is tested this far in front of the surface, in cubes: beyond the surface's own.
STAND_OFF = 1.5
# Both sides are outside where the lesser sees at least this share of what the greater sees. Within
# a tray a wall sees 30 %: of nine directions the three that go up over the far wall.
SHEET_SHARE = 0.25
# A side that sees less than this share of the directions is not seen; one of 13 is 8 %.
LEAST_SIGHT = 0.01
# Surfaces nearer than the stand-off, seen along the normal, that face along it by this cosine.
FACING = 0.7
# So many samples of a piece are enough to vote.
VOTES = 40
# Of nearest samples so many are looked at: its own piece's come first at the rim.
NEIGHBOURS = 8
# Samples of a surface are this near to any place of it, in their spacings: √2 and a bit.
REACH = 1.5


@dataclass(frozen=True, eq=False, slots=True)
class Sides:
    """For each piece (p,): whether to turn normals, whether both sides are faces, whether
    hidden.
    """

    turned: NDArray[np.bool_]
    sheets: NDArray[np.bool_]
    hidden: NDArray[np.bool_]


def find_sides(
    surface: Surface, samples: Samples, bodies: Indices, pieces: Indices, count: int
) -> Sides:
    """Return the outer sides of each of `count` pieces; `bodies`, `pieces` (m,) number each
    triangle.

    `samples` of the whole surface lie at most SPACING_SHARE of its size apart.
    """
    front, back = np.ones(count), np.zeros(count)
    trusted = np.ones(count, dtype=bool)
    np.logical_and.at(trusted, pieces, surface.closed)
    for own in iter_groups(bodies):
        if len(own) == 1:  # nothing stands before or behind a triangle by itself
            back[pieces[own]] = 1.0
            continue
        names, local = np.unique(pieces[own], return_inverse=True)
        one_closed = trusted[names].all() and len(np.unique(surface.sheets[own])) == 1
        if not one_closed:  # a single closed sheet hides nothing of itself
            if len(own) < len(bodies):
                corners = surface.points[surface.triangles[own]]
                low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
                extent = float(np.linalg.norm(high - low))
                near = sample_triangles(corners, SPACING_SHARE * extent)
            else:
                near, extent = samples, surface.size
            sights = _sights(near, surface.normals[own], local, len(names), extent)
            front[names], back[names] = sights
    unseen = (front < LEAST_SIGHT) & (trusted | (back < LEAST_SIGHT))
    turned = ~trusted & (back > front)
    sheets = ~trusted & ~unseen & (np.minimum(front, back) >= SHEET_SHARE * np.maximum(front, back))
    return Sides(turned, sheets, unseen)


def _sights(
    samples: Samples, normals: FloatArray, pieces: Indices, count: int, extent: float
) -> tuple[FloatArray, FloatArray]:
    """Return share of free directions (p,) in front of and behind each piece; `extent` is the
    diagonal.

    Of the triangles that the samples lie on, `normals` (m, 3) and `pieces` (m,).
    """
    cube = extent / CUBES
    free = FreeWays.of(samples.points, cube, margin=STAND_OFF)
    owner = pieces[samples.triangles]
    kept, _, areas = thinned(samples.points, samples.areas, owner, cube / SAMPLES_PER_CUBE)
    points, owner = samples.points[kept], owner[kept]
    normals = normals[samples.triangles[kept]]
    tree = cKDTree(points)
    votes = _choose_some_of_each(owner, count)
    sights = []
    for sign in (1.0, -1.0):
        ahead = sign * normals[votes]
        seen = free.share(points[votes] + STAND_OFF * cube * ahead, ahead)
        blocked = _find_faced(tree, points, normals, owner, votes, ahead, cube)
        seen = np.where(blocked, 0.0, seen)
        weight = sum_by_group(owner[votes], areas[votes], count)
        total = sum_by_group(owner[votes], areas[votes] * seen, count)
        sights.append(total / np.maximum(weight, 1e-300))
    return sights[0], sights[1]


def _choose_some_of_each(owner: Indices, count: int) -> Indices:
    """Return indices of at most VOTES samples of each piece, spread evenly over them."""
    order = np.argsort(owner, kind="stable")
    members = np.bincount(owner, minlength=count)
    starts = np.cumsum(members) - members
    nth = np.arange(len(owner)) - starts[owner[order]]
    step = np.maximum(members // VOTES, 1)[owner[order]]
    some: Indices = order[nth % step == 0]
    return some


def _find_faced(
    tree: cKDTree,
    points: FloatArray,
    normals: FloatArray,
    owner: Indices,
    votes: Indices,
    ahead: FloatArray,
    cube: float,
) -> NDArray[np.bool_]:
    """Return whether another piece faces this one, nearer than the point where visibility is
    tested.

    That is the underside of a thin board, which the cubes cannot distinguish from the upper side.
    """
    blocked = np.zeros(len(votes), dtype=bool)
    step = cube / SAMPLES_PER_CUBE
    reach = REACH * step
    for nth in range(1, int(np.ceil(STAND_OFF * SAMPLES_PER_CUBE)) + 1):
        where = points[votes] + nth * step * ahead
        gaps, found = tree.query(where, k=NEIGHBOURS, distance_upper_bound=reach)
        known = np.isfinite(gaps)
        found = np.where(known, found, 0)
        before = ((points[found] - points[votes][:, None]) * ahead[:, None]).sum(axis=2)
        facing = np.abs((normals[found] * ahead[:, None]).sum(axis=2)) > FACING
        other = owner[found] != owner[votes][:, None]
        blocked |= (known & facing & other & (before > 0.0)).any(axis=1)
    return blocked
