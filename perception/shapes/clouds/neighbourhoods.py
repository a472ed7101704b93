"""Local geometry of a cloud at some of its points: normals, spacing, noise, links to neighbours.

A neighbourhood is the k nearest points. Its middle is known sqrt(k) times better than a point, so
middles, not points, are what regions are grown from.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from facetlog.perception.types import FloatArray

# Sizes of a neighbourhood: each has a radius 1.4 times that of the one before.
SIZES = (16, 32, 64, 128)
LEAST_SIZE = SIZES[0]
# A neighbourhood is large enough when its normal and that of the one round its furthest point
# differ by less than this (median, radians; 8 degrees): then 4 sd of one normal are within what
# separates the regions' (plane_growth.SAME_WAY). It is measured by comparing, so that correlated
# errors of neighbouring points, as on a sensor that rounds depths, count.
SURE_NORMAL = 0.14
# Points from which the size and the noise are judged: the median of so many is good to 3 %.
SAMPLE = 500
# Nodes are so many that a point is in about four neighbourhoods; all points where they are few.
OVERLAP = 4
FEW_POINTS = 10_000
# Each node is linked to so many others: in a plane the six around it, and some further out, so
# that the gaps of an uneven cloud are bridged.
LINKS = 10
# A neighbourhood's thickness over its width beyond which it is no piece of a surface.
FLAT_ENOUGH = 0.3
# Coordinates of single-precision files are rounded to this share of the cloud's diagonal.
ROUNDING = 3e-7
# Gaps between coordinates are those of a grid if nearly all are whole multiples of the least of
# them, to within this share: of gaps at random a fifth are. Strays may lie off it. Fewer gaps, or
# finer ones than so many roundings, show no grid.
GRID_SHARE, ON_GRID, STEP_QUANTILE = 0.9, 0.1, 0.1
LEAST_GAPS, GRID_ROUNDINGS = 16, 4.0


@dataclass(frozen=True, eq=False, slots=True)
class Neighbourhoods:
    """m nodes (rows of the cloud) with what is around each of them.

    `places` (m, 3) are the nodes themselves, `middles` and unit `normals` (m, 3), of either sign,
    those of their neighbours; `thickness` (m,) is the root mean square distance of the neighbours
    from their plane, `radius` (m,) how far the furthest is; `neighbours` (m, size) are their rows,
    `links` (m, 10) are nodes next to each node. `size` points are in a neighbourhood; `share` of
    the points are nodes. `noise` is the cloud's: the standard deviation of a point off its surface,
    in the unit of length.
    """

    nodes: NDArray[np.intp]
    places: FloatArray
    middles: FloatArray
    normals: FloatArray
    thickness: FloatArray
    radius: FloatArray
    neighbours: NDArray[np.int32]
    links: NDArray[np.intp]
    size: int
    share: float
    noise: float
    tree: KDTree

    @property
    def spacing(self) -> FloatArray:
        """Side of the square that a point has to itself on the surface, near each node, (m,)."""
        spacing: FloatArray = self.radius * np.sqrt(np.pi / self.size)
        return spacing


def find_k_nearest(
    tree: KDTree, points: FloatArray, count: int, *, within: float = np.inf
) -> tuple[FloatArray, NDArray[np.intp]]:
    """Return distances and rows (n, k) of the k = `count` points of a tree that are nearest to each
    point.

    k is smaller where the tree has fewer. Where none is near enough, the row is the tree's size.
    """
    places = list(range(1, min(count, tree.n) + 1))
    far, near = tree.query(points, k=places, distance_upper_bound=within)
    return np.asarray(far, dtype=np.float64), np.asarray(near, dtype=np.intp)


def _measure_neighbourhoods(
    points: FloatArray, tree: KDTree, rows: NDArray[np.intp], size: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, NDArray[np.int32]]:
    """Return middles (m, 3), variances (m, 3) ascending, normals (m, 3), radii (m,), rows (m,
    size).
    """
    far, near = find_k_nearest(tree, points[rows], size)
    cluster = points[near]
    middles = cluster.mean(axis=1)
    cluster -= middles[:, None]
    covs = cluster.transpose(0, 2, 1) @ cluster / (size - 3)  # three are spent on the plane
    variances, axes = np.linalg.eigh(covs)
    return middles, np.maximum(variances, 0.0), axes[:, :, 0], far[:, -1], near.astype(np.int32)


def _choose_size(points: FloatArray, tree: KDTree, sample: NDArray[np.intp]) -> int:
    """Return the least size with certain enough normals, else the one with the most certain."""
    allowed = [size for size in SIZES if size <= len(points) // 4] or [max(4, len(points) // 4)]
    turns = []
    for size in allowed:
        turns.append(_measure_normal_turn(points, tree, sample, size))
        if turns[-1] <= SURE_NORMAL:
            break
    return allowed[int(np.argmin(turns))]


def _measure_normal_turn(
    points: FloatArray, tree: KDTree, sample: NDArray[np.intp], size: int
) -> float:
    """Return the median angle (radians) between normals of neighbourhoods that overlap by about
    half.
    """
    furthest = np.asarray(tree.query(points[sample], k=[size])[1], dtype=np.intp)[:, 0]
    one, two = (_measure_neighbourhoods(points, tree, rows, size)[2] for rows in (sample, furthest))
    cosines = np.abs(np.einsum("ij,ij->i", one, two))
    return float(np.arccos(min(1.0, float(np.median(cosines)))))


def _noise(points: FloatArray, thickness: FloatArray, width: FloatArray) -> float:
    """Return the standard deviation of a point off its surface: the median of where that is a
    surface.
    """
    flat = thickness <= FLAT_ENOUGH * width
    rounding = ROUNDING * float(np.linalg.norm(np.ptp(points, axis=0)))
    grid = float(_find_grid_steps(points, rounding).max() / np.sqrt(12.0))
    return max(float(np.median(thickness[flat] if flat.any() else thickness)), rounding, grid)


def _find_grid_steps(points: FloatArray, rounding: float) -> FloatArray:
    """Return steps (3,) of the grid that coordinates of points (n, 3) lie on; 0 where they lie on
    none.

    A face along the grid has no thickness at all, but others are rounded to it: the sd of what is
    rounded to steps of s is s / sqrt(12).
    """
    steps = np.zeros(3)
    for axis, values in enumerate(points.T):
        gaps = np.diff(np.sort(values))
        gaps = gaps[gaps > GRID_ROUNDINGS * rounding]
        if len(gaps) < LEAST_GAPS:
            continue
        step = float(np.quantile(gaps, STEP_QUANTILE))
        off = np.abs(gaps / step - np.round(gaps / step))
        if (off <= ON_GRID).mean() >= GRID_SHARE:
            steps[axis] = step
    return steps


def neighbourhoods(
    points: FloatArray, *, size: int | None = None, noise: float | None = None
) -> Neighbourhoods:
    """Return neighbourhoods of points (n, 3), n ≥ 8; of a size that suits their noise if none is
    given.

    `noise` is that of the cloud that the points are a part of. The same cloud has the same nodes,
    in whichever place and unit it is.
    """
    count = len(points)
    tree = KDTree(points, balanced_tree=False, compact_nodes=count < FEW_POINTS)
    shuffled = np.random.default_rng(0).permutation(count)
    sample = shuffled[:SAMPLE]
    if size is None:
        size = _choose_size(points, tree, sample)
    kept = min(count, max(FEW_POINTS, OVERLAP * count // size))
    nodes = np.sort(shuffled[:kept]) if kept < count else np.arange(count)
    middles, variances, normals, radius, neighbours = _measure_neighbourhoods(
        points, tree, nodes, size
    )
    thickness = np.sqrt(variances[:, 0])
    if noise is None:
        noise = _noise(points, thickness, np.sqrt(variances[:, 1]))
    own = points[nodes]
    node_tree = tree if kept == count else KDTree(own)
    links = find_k_nearest(node_tree, own, LINKS + 1)[1][:, 1:]
    return Neighbourhoods(
        nodes,
        own,
        middles,
        normals,
        thickness,
        radius,
        neighbours,
        links,
        size,
        kept / count,
        noise,
        node_tree,
    )
