"""Clustering of points into objects: points near to one another once the floor is removed."""

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from facetlog.perception.ragged import find_distinct, number_rows
from facetlog.perception.types import FloatArray

# Points at random on one surface are within so many spacings of the next: the chance is e^-28.
REACH_SPACINGS = 3.0
# What is nearer than this share of the whole's diagonal is one thing: a scan has gaps at edges
# where a ray met neither side well.
REACH_SHARE = 0.01
# Points are gathered in cells of this share of the reach; a cell's first point stands for it, and
# is off by a cell's diagonal at most.
CELL_SHARE = 1.0 / 3.0
# A group with less than this share of the largest one's points is scatter, not an object.
SCATTER_SHARE = 0.005
# ... and so is one of fewer points.
LEAST_POINTS = 8


def cluster_bodies(
    points: FloatArray,
    owner: NDArray[np.intp],
    spacing: float,
    *,
    support: Collection[int] = (),
) -> NDArray[np.intp]:
    """Return the number of the object of each of points (n, 3), the one with most points first; -1:
    none.

    `owner` (n,) is the flat region of a point, -1 for none: a region is of one object. Regions
    named in `support`, as a floor is, are of none, and join nothing. `spacing` is the typical
    distance between points on the surface. Single-linkage clustering, within 3 spacings or 1 % of
    the diagonal of the clustered points.
    """
    bodies = np.full(len(points), -1)
    rows = np.flatnonzero(~np.isin(owner, list(support)))
    if not len(rows):
        return bodies
    own = points[rows]
    diagonal = float(np.linalg.norm(np.ptp(own, axis=0)))
    reach = max(REACH_SPACINGS * spacing, REACH_SHARE * diagonal)
    if reach <= 0.0:
        bodies[rows] = 0
        return bodies
    groups = _linked(own, owner[rows], reach)
    sizes = np.bincount(groups)
    order = np.argsort(-sizes, kind="stable")
    kept = sizes[order] >= max(LEAST_POINTS, SCATTER_SHARE * sizes[order[0]])
    names = np.full(len(sizes), -1)
    names[order[kept]] = np.arange(int(kept.sum()))
    bodies[rows] = names[groups]
    return bodies


def _linked(points: FloatArray, owner: NDArray[np.intp], reach: float) -> NDArray[np.intp]:
    """Return the group of each of points (n, 3): what chains within `reach`, or one region,
    joins.
    """
    cells = np.floor((points - points.min(axis=0)) / (CELL_SHARE * reach)).astype(np.int64)
    first, cell_of = find_distinct(number_rows(cells))
    pairs = KDTree(points[first]).query_pairs(reach * (1.0 + CELL_SHARE), output_type="ndarray")
    # a region is a node of its own, after the cells', joined to all cells of its points
    held = owner >= 0
    hubs = len(first) + owner[held]
    one = np.concatenate([pairs[:, 0], cell_of[held]])
    two = np.concatenate([pairs[:, 1], hubs])
    nodes = len(first) + int(owner.max(initial=-1)) + 1
    graph = coo_array((np.ones(len(one)), (one, two)), shape=(nodes, nodes))
    groups = connected_components(graph, directed=False)[1][cell_of]
    return np.asarray(groups, dtype=np.intp)


def group_sizes(points: FloatArray, reach: float) -> NDArray[np.intp]:
    """Return the size of the group of each of points (n, 3), chained within `reach`, (n,)."""
    groups = _linked(points, np.full(len(points), -1), reach)
    sizes: NDArray[np.intp] = np.bincount(groups)[groups]
    return sizes


def is_scatter(
    points: FloatArray, bodies: NDArray[np.intp], free: NDArray[np.bool_], spacing: float
) -> NDArray[np.bool_]:
    """Return which of points (n, 3), those `free` of any flat region, are too few together for a
    surface.

    `bodies` (n,) is the object of each. A sensor puts some flying points beside an edge: they must
    not extend an object.
    """
    rows = np.flatnonzero(free)
    scatter = np.zeros(len(points), dtype=bool)
    if not len(rows) or spacing <= 0.0:
        return scatter
    sizes = group_sizes(points[rows], REACH_SPACINGS * spacing)
    of_object = np.bincount(bodies[bodies >= 0], minlength=int(bodies.max(initial=0)) + 1)
    whole = of_object[np.maximum(bodies[rows], 0)]
    scatter[rows] = sizes < np.maximum(LEAST_POINTS, SCATTER_SHARE * whole)
    return scatter


def majority(values: NDArray[np.intp]) -> int:
    """Return the commonest of numbers from -1 on, the least of equals; -1 where there are none.

    >>> majority(np.array([2, -1, 2, 0]))
    2
    """
    return int(np.bincount(values + 1).argmax()) - 1 if len(values) else -1
