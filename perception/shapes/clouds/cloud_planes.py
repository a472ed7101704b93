"""Planes of a point cloud: regions grown over neighbourhoods, then least squares on their points.

All distances are in multiples of the cloud's own noise, all sizes in neighbourhoods: a cloud in
another unit or place has the same planes.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from facetlog.perception.ragged import unique_rows
from facetlog.perception.scene import Plane
from facetlog.perception.shapes.clouds.neighbourhoods import (
    CURVED,
    LEAST_SIZE,
    WARP,
    Neighbourhoods,
    find_k_nearest,
    grow_regions,
    measure_width_along,
    neighbourhoods,
)
from facetlog.perception.types import FloatArray

# Fewer points have no meaningful neighbourhood.
LEAST_POINTS = 8
# Inliers of a plane are within so many sd: of a normal distribution one in 2,000 is left out.
GATE_SDS = 3.5
# Candidate planes of a point are those of so many of its nearest nodes.
OFFERS = 4
# Near an edge nodes are of no plane, as their neighbourhoods have points of both: points there are
# offered those of more nodes that are of one, no further than so many neighbourhoods' radii.
RIM_OFFERS = 24
RIM_REACH = 2.0
# The shortest interval that holds half of n normal residuals is so many sd long, less a share of it
# over sqrt(n) (simulated for 16 to 128, to 1 %).
HALF_LENGTH, HALF_LOSS = 1.349, 1.35
# Noise near a node is the median over its links, good to 10 %: so many times that of the cloud is
# more than chance.
CLEARLY_NOISIER = 1.5
# A plane that is so many times thicker than the noise may be two layers, if there are next to none
# between them: against the lesser, over the rms distance of all at least, in bins of a share of it.
LAYER_SDS = 3.0
LAYER_VALLEY = 0.25
LAYER_BIN = 0.2
# Two planes are one if all their points are off it by no more than this times what they are off
# their own: the two halves of a face that is bent by half its noise are.
SAME_PLANE = 1.1
# Rounds of assigning points and fitting again; the second moves planes by less than their sd.
ROUNDS = 2
# A plane is kept with so many points, twice the least neighbourhood: between two pieces of a curve
# one neighbourhood is always flat.
LEAST_MEMBERS = 2 * LEAST_SIZE
# A plane's narrow side is this many times the noise wide at least: narrower, it has no direction.
LEAST_WIDTH = 4.0
# The remaining points are searched again if they are so many neighbourhoods, and so much of the
# cloud.
LEAST_LEFT = 2
LEAST_LEFT_SHARE = 0.01
# Residuals are looked at in blocks, so many along each axis.
BLOCKS = 8
# Residuals are correlated where the blocks' means vary more than chance allows once in 700.
CHANCE_SDS = 3.0


@dataclass(frozen=True, eq=False, slots=True)
class CloudPlane:
    """A plane with its covariance, its points (rows of the cloud) and their rms distance."""

    plane: Plane
    members: NDArray[np.intp]
    rms: float


@dataclass(frozen=True, eq=False, slots=True)
class CloudPlanes:
    """Planes of a cloud of n points; `owner` (n,) numbers the plane of each point, -1: none.

    `noise` is the standard deviation of a point off its surface; `spacing` (n,) the side of the
    square that each point has to itself on the surface. Both in the unit of length.
    """

    planes: tuple[CloudPlane, ...]
    owner: NDArray[np.intp]
    noise: float
    spacing: FloatArray


def fit_least_squares_plane(points: FloatArray, least_sd: float = 0.0) -> tuple[Plane, float]:
    """Return the total-least-squares plane through points (n, 3), n > 3, with its covariance, and
    the rms.

    With middle c, in-plane axes u, v and variances λu, λv along them, the slopes have the variance
    σ² / (n λ) and the height at c has σ² / n. Where the errors of neighbouring points are
    correlated, as on a sensor that rounds depths, the effective n is smaller: the covariance is
    scaled by how much more the means over blocks vary than those of independent errors would.
    `least_sd` is rounding.
    """
    count = len(points)
    middle = points.mean(axis=0)
    local = points - middle
    variances, axes = np.linalg.eigh(local.T @ local / count)
    normal, v, u = axes.T
    height = local @ normal
    variance = max(float(height @ height) / max(count - 3, 1), least_sd**2)
    shared = _estimate_shared_error(local @ u, local @ v, height, variance)
    slopes = variance * shared / (count * np.maximum(variances[[2, 1]], 1e-300))
    columns = np.zeros((4, 3))
    for nth, axis in enumerate((u, v)):
        columns[:3, nth], columns[3, nth] = axis, -axis @ middle
    columns[3, 2] = 1.0
    cov = (columns * [*slopes, variance * shared / count]) @ columns.T
    return Plane(normal, float(-normal @ middle), cov), float(np.sqrt(variance))


def _estimate_shared_error(
    x: FloatArray, y: FloatArray, height: FloatArray, variance: float
) -> float:
    """Return how many times more the means of heights over blocks vary than independent
    errors' do.
    """
    cells = np.zeros(len(x), dtype=np.intp)
    for values in (x, y):
        low, extent = values.min(), max(float(np.ptp(values)), 1e-300)
        cells *= BLOCKS
        cells += np.minimum(((values - low) * (BLOCKS / extent)).astype(np.intp), BLOCKS - 1)
    held = np.bincount(cells, minlength=BLOCKS**2)
    sums = np.bincount(cells, height, BLOCKS**2)
    full = held > 1
    free = int(full.sum()) - 3
    if free < BLOCKS or variance <= 0.0:
        return 1.0
    ratio = float((sums[full] ** 2 / held[full]).sum()) / (variance * free)
    return ratio if ratio > 1.0 + CHANCE_SDS * np.sqrt(2.0 / free) else 1.0


def cloud_planes(points: FloatArray) -> CloudPlanes:
    """Return all planes of points (n, 3); without any where the points are too few or nowhere flat.

    The points left by the first planes are searched again on their own: neighbourhoods on a narrow
    face reach beyond it until its surroundings are removed. Then with smaller neighbourhoods.
    """
    count = len(points)
    owner = np.full(count, -1)
    if count < LEAST_POINTS:
        return CloudPlanes((), owner, 0.0, np.zeros(count))
    centre = points.mean(axis=0)
    points = points - centre  # so that coordinates far from the origin keep their digits
    first = near = neighbourhoods(points)
    nearest = find_k_nearest(first.tree, points, OFFERS)[1]
    left, closest = np.arange(count), nearest
    for size in (first.size, first.size // 2, LEAST_SIZE):
        found, curved = _find_planes_once(points[left], near, closest)
        owner[left] = np.where(found >= 0, found + int(owner.max()) + 1, -1)
        left = left[(found < 0) & ~curved]
        if size < LEAST_SIZE or len(left) < max(LEAST_LEFT * size, LEAST_LEFT_SHARE * count):
            break
        near = neighbourhoods(points[left], size=size, noise=first.noise)
        closest = find_k_nearest(near.tree, points[left], OFFERS)[1]
    owner = _joined(points, owner, first)
    return _numbered(points, centre, owner, first, nearest[:, 0])


def _find_planes_once(
    points: FloatArray, near: Neighbourhoods, nearest: NDArray[np.intp]
) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Return the number of the plane of each point (n,), -1: none, and whether it is on a curved
    surface.

    `nearest` (n, k) are the nodes nearest to each point.
    """
    labels = np.append(grow_regions(near), -1)  # the last is that of no node
    rim = np.flatnonzero((labels[nearest] < 0).any(axis=1))
    rim_nearest = _find_nodes_at_rim(points[rim], points, near, labels[:-1])
    owner = labels[nearest[:, 0]]
    for _ in range(ROUNDS):
        planes = _fitted(points, owner, near.noise, int(labels.max(initial=-1)) + 1)
        noise = _estimate_noise_at_nodes(points, near, labels, planes)
        owner = _deal_points(points, nearest, labels, planes, noise)
        owner[rim] = _deal_points(points[rim], rim_nearest, labels, planes, noise)
    return _split_layers(points, owner, near.noise), (labels[nearest] == CURVED).any(axis=1)


def _split_layers(points: FloatArray, owner: NDArray[np.intp], noise: float) -> NDArray[np.intp]:
    """Return the owners (n,) with a plane through both sides of a board as two.

    Where neighbourhoods are wider than a board is thick, its sides are one thick plane. Points
    between the layers, of the board's rim, are of neither.
    """
    owner = owner.copy()
    todo = list(range(int(owner.max(initial=-1)) + 1))
    count = len(todo)
    while todo:
        label = todo.pop()
        rows = np.flatnonzero(owner == label)
        if len(rows) < 2 * LEAST_MEMBERS:
            continue
        plane, rms = fit_least_squares_plane(points[rows])
        if rms < LAYER_SDS * noise:
            continue
        height = plane.distance(points[rows])
        bounds = _find_valley(height, rms)
        if bounds is None:
            continue
        above, below = (
            _select_layer(points, part, noise)
            for part in (rows[height >= bounds[1]], rows[height <= bounds[0]])
        )
        if min(len(above), len(below)) < LEAST_MEMBERS:
            continue
        owner[rows] = -1
        owner[above], owner[below] = label, count
        todo += [label, count]
        count += 1
    return owner


def _select_layer(points: FloatArray, rows: NDArray[np.intp], noise: float) -> NDArray[np.intp]:
    """Return the rows without those of a rim that ends at the layer."""
    for _ in range(ROUNDS):
        if len(rows) < LEAST_MEMBERS:
            return rows
        height = fit_least_squares_plane(points[rows])[0].distance(points[rows])
        sd = max(_estimate_half_sample_sd(height[None])[0], noise)
        rows = rows[np.abs(height - np.median(height)) <= GATE_SDS * sd]
    return rows


def _estimate_half_sample_sd(values: FloatArray) -> FloatArray:
    """Return the sd (m,) of each row of values (m, k) by the shortest half of it.

    What is of another face has no say. P. J. Rousseeuw, A. M. Leroy, "A robust scale estimator
    based on the shortest half", 1988.
    """
    ordered = np.sort(values, axis=1)
    count = ordered.shape[1]
    half = count // 2
    lengths = (ordered[:, half:] - ordered[:, : count - half]).min(axis=1)
    sds: FloatArray = lengths / (HALF_LENGTH - HALF_LOSS / np.sqrt(count))
    return sds


def _joined(points: FloatArray, owner: NDArray[np.intp], near: Neighbourhoods) -> NDArray[np.intp]:
    """Return the owners (n,) with planes that touch and that one plane fits as well as one."""
    count = int(owner.max(initial=-1)) + 1
    first = np.repeat(owner[near.nodes], near.size)
    second = owner[near.neighbours].ravel()
    touch = (first >= 0) & (second >= 0) & (first != second)
    pairs = np.sort(np.column_stack([first[touch], second[touch]]), axis=1)
    pairs = unique_rows(pairs)
    sums = [_Moments.of(points[rows]) for rows in _members(owner, count)]
    name = np.arange(count)
    apart: set[tuple[int, int]] = set()  # pairs that need no other look
    while len(pairs):
        joint = None
        for one, two in pairs.tolist():
            if (one, two) in apart:
                continue
            joint = sums[one] + sums[two]
            separate = sums[one].square + sums[two].square
            least = max(separate, joint.count * near.noise**2)
            if joint.square <= SAME_PLANE**2 * least:
                break
            apart.add((one, two))
        else:
            break
        sums[one] = joint
        name[name == two] = one
        apart = {pair for pair in apart if one not in pair and two not in pair}
        pairs = np.where(pairs == two, one, pairs)
        pairs = unique_rows(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1))
    return np.append(name, -1)[owner]


@dataclass(frozen=True, eq=False, slots=True)
class _Moments:
    """Count, sum (3,) and sum of outer products (3, 3) of points."""

    count: int
    total: FloatArray
    outer: FloatArray

    @classmethod
    def of(cls, points: FloatArray) -> "_Moments":
        return cls(len(points), points.sum(axis=0), points.T @ points)

    def __add__(self, other: "_Moments") -> "_Moments":
        return _Moments(
            self.count + other.count, self.total + other.total, self.outer + other.outer
        )

    @property
    def square(self) -> float:
        """Sum of squared distances from their plane of least squares."""
        spread = self.outer - np.outer(self.total, self.total) / max(self.count, 1)
        return max(float(np.linalg.eigvalsh(spread)[0]), 0.0)


def _find_valley(height: FloatArray, rms: float) -> tuple[float, float] | None:
    """Return from where to where there are next to no heights (n,), amid two layers of many."""
    step = LAYER_BIN * rms
    low = float(height.min()) - 3.0 * step
    counts = np.bincount(((height - low) / step).astype(np.intp), minlength=4).astype(np.float64)
    counts = np.append(counts, [0.0] * 3)
    peak = int(counts.argmax())
    far = np.abs(np.arange(len(counts)) - peak) * step >= rms
    if not (counts[far] > 0.0).any():
        return None
    other = int(np.where(far, counts, -1.0).argmax())
    first, last = sorted((peak, other))
    empty = counts[first : last + 1] <= LAYER_VALLEY * counts[other]
    if empty.sum() * step < rms:
        return None
    inside = np.flatnonzero(empty) + first
    return low + step * float(inside[0]), low + step * float(inside[-1] + 1)


def _estimate_noise_at_nodes(
    points: FloatArray, near: Neighbourhoods, labels: NDArray[np.intp], planes: FloatArray
) -> FloatArray:
    """Return the sd of points off a node's plane near it, (m,), where it is clearly more than the
    cloud's noise; else 0.

    Of each neighbourhood the shortest half counts: another face beside it has no say.
    """
    noise = np.full(len(near.nodes), np.nan)
    for label, plane in enumerate(planes):
        own = np.flatnonzero(labels[:-1] == label)
        noise[own] = _estimate_half_sample_sd(points[near.neighbours[own]] @ plane[:3])
    linked = np.where(labels[near.links] == labels[:-1, None], noise[near.links], np.nan)
    linked = np.sort(np.column_stack([noise, linked]), axis=1)  # what is not known comes last
    known = np.isfinite(linked).sum(axis=1)
    middle = linked[np.arange(len(linked)), np.maximum(known - 1, 0) // 2]
    return np.where(middle > CLEARLY_NOISIER * near.noise, middle, 0.0)


def _find_nodes_at_rim(
    rim: FloatArray, points: FloatArray, near: Neighbourhoods, labels: NDArray[np.intp]
) -> NDArray[np.intp]:
    """Return nearest nodes (r, k) with a label, -1 where they are too far, of points (r, 3)."""
    labelled = np.flatnonzero(labels >= 0)
    if not len(labelled) or not len(rim):
        return np.full((len(rim), 1), -1)
    reach = RIM_REACH * float(np.median(near.radius[labelled]))
    tree = KDTree(points[near.nodes[labelled]])
    found = find_k_nearest(tree, rim, RIM_OFFERS, within=reach)[1]
    return np.append(labelled, -1)[found]


def _members(owner: NDArray[np.intp], count: int) -> list[NDArray[np.intp]]:
    """Return rows of each owner from 0, ascending."""
    order = np.argsort(owner, kind="stable")  # what is of none comes first
    bounds = np.searchsorted(owner[order], np.arange(count + 1))
    return [order[a:b] for a, b in pairwise(bounds.tolist())]


def _fitted(points: FloatArray, owner: NDArray[np.intp], noise: float, count: int) -> FloatArray:
    """Return (normal, offset, sd) of each owner's points, (count, 5); sd 0 where they are
    too few.
    """
    fits = np.zeros((count, 5))
    for nth, rows in enumerate(_members(owner, count)):
        if len(rows) > LEAST_MEMBERS:
            plane, rms = fit_least_squares_plane(points[rows])
            # outliers must not widen their own gate beyond that of a warped sheet
            warped = max(2.0 * noise, WARP / 2.0 * measure_width_along(points[rows]))
            fits[nth] = (*plane.normal, plane.offset, np.clip(rms, 0.5 * noise, warped))
    return fits


def _deal_points(
    points: FloatArray,
    nearest: NDArray[np.intp],
    labels: NDArray[np.intp],
    planes: FloatArray,
    noise: FloatArray,
) -> NDArray[np.intp]:
    """Return for each point the nearest, in sd, of the planes of nodes; -1 where none is in reach.

    `nearest` (n, k) are the nodes, -1 for none; `labels` number their planes, the last being -1;
    `noise` (m,) is the sd of a point off a node's plane at least.
    """
    owner = np.full(len(points), -1)
    if not len(planes):
        return owner
    best = np.full(len(points), GATE_SDS)
    for column in nearest.T:
        known = np.flatnonzero(labels[column] >= 0)
        nodes = column[known]
        plane = planes[labels[nodes]]
        height = np.abs(np.einsum("ij,ij->i", points[known], plane[:, :3]) + plane[:, 3])
        sd = np.maximum(plane[:, 4], noise[nodes])
        sds = np.where(plane[:, 4] > 0.0, height / np.maximum(sd, 1e-300), np.inf)
        nearer = sds < best[known]
        best[known[nearer]] = sds[nearer]
        owner[known[nearer]] = labels[nodes[nearer]]
    return owner


def _numbered(
    points: FloatArray,
    centre: FloatArray,
    owner: NDArray[np.intp],
    near: Neighbourhoods,
    nearest: NDArray[np.intp],
) -> CloudPlanes:
    """Return the planes with enough points, largest first, back in the cloud's own frame."""
    every = _members(owner, int(owner.max(initial=-1)) + 1)
    groups = [rows for rows in every if len(rows) >= LEAST_MEMBERS]
    rounding = near.noise * 1e-3
    kept: list[CloudPlane] = []
    numbers = np.full(len(points), -1)
    for rows in sorted(groups, key=lambda rows: (-len(rows), int(rows[0]))):
        if measure_width_along(points[rows]) < LEAST_WIDTH * near.noise:
            continue
        plane, rms = fit_least_squares_plane(points[rows] + centre, rounding)
        numbers[rows] = len(kept)
        kept.append(CloudPlane(plane, rows, rms))
    return CloudPlanes(tuple(kept), numbers, near.noise, near.spacing[nearest])
