"""Local geometry of a cloud at some of its points, and regions of it that lie in one plane.

A neighbourhood is the k nearest points: it has a normal, spacing, noise and links to others. Its
middle is known sqrt(k) times better than a point, so middles, not points, are what regions are
grown from. Some of these regions are pieces of a curve.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from facetlog.perception.ragged import unique_rows
from facetlog.perception.stable_order import descending
from facetlog.perception.types import FloatArray

# Sizes of a neighbourhood: each has a radius 1.4 times that of the one before.
SIZES = (16, 32, 64, 128)
LEAST_SIZE = SIZES[0]
# A neighbourhood is large enough when its normal and that of the one round its furthest point
# differ by less than this (median, radians; 8 degrees): then 4 sd of one normal are within what
# separates the regions' (SAME_WAY). It is measured by comparing, so that correlated
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
# Instead of a region's number: the node is of a curved surface.
CURVED = -2

# Normals of one region differ from its plane's by at most this (cosine of 20 degrees, 3 sd and
# more of a neighbourhood's normal).
SAME_WAY = float(np.cos(np.deg2rad(20.0)))
# The middle of a neighbourhood is within so many times the noise of its region's plane. Its own
# error is a fourth of that at most, the rest is room for planes that are a little warped.
MIDDLE_GATE = 1.5
# Sheets, and flat ones as sensors measure them, are warped by up to this share of their width: a
# Kinect shows a carton of 16 cm 5 mm off, where its local noise is a tenth of that. With 0.012 the
# faces of such cartons fall into pieces that are 3 to 9 degrees apart.
WARP = 0.03
# Growth starts where this share of the neighbours have the same normal.
SEED_AGREEMENT = 0.7
# A region has this many nodes at least, fewer fix no plane, and half of the points that make a
# neighbourhood.
LEAST_NODES = 5
LEAST_SHARE = 0.5
# A region narrower than a neighbourhood's radius and thicker than this times the noise is the
# rounded-off edge between two others: its neighbourhoods have points of both.
SLIVER_THICKNESS = 1.15
# A region is refitted whenever it has grown by this factor.
REFIT = 1.5
# Rounds of growing from all members again after the last fit. Each widens a region by half at
# least, or is the last but one: 30 take a neighbourhood to any size.
REGROWTHS = 30
# Touching regions are one if the rms of their middles is within this share of one gate, as it
# is of heights that fill the gate evenly.
MERGED_GATES = 0.6
# A region with less than this share of another's nodes is a fragment of it if it lies within so
# many gates and within 30 degrees (cosine): a fragment's own normal is uncertain.
SCRAP_SHARE = 0.2
SCRAP_GATES = 2.0
SCRAP_WAY = float(np.cos(np.deg2rad(30.0)))
# A region is a piece of a curved surface if it bulges by more than this times the noise, ...
BULGE = 0.6
# ... by more than this many sd, ...
BULGE_SDS = 5.0
# ... and its normal turns by more than this from end to end, radians (17 degrees): warped sheets
# turn by less, and a strip of a cylinder that fills the gate of WARP by 16 WARP = 0.48.
TURN = 0.3
# A region is one with a curved surface if, over this share of its rim to other regions, that goes
# on within 30 degrees (cosine); it takes so many rounds at most, one for each strip round half a
# cylinder.
SMOOTH_SHARE = 0.4
SMOOTH_WAY = float(np.cos(np.deg2rad(30.0)))
SPREADS = 16


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
    """Return middles, ascending variances and normals (m, 3), radii (m,) and rows (m, size)."""
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
    """Return the median angle (radians) between normals of neighbourhoods that half overlap."""
    furthest = np.asarray(tree.query(points[sample], k=[size])[1], dtype=np.intp)[:, 0]
    one, two = (_measure_neighbourhoods(points, tree, rows, size)[2] for rows in (sample, furthest))
    cosines = np.abs(np.einsum("ij,ij->i", one, two))
    return float(np.arccos(min(1.0, float(np.median(cosines)))))


def _noise(points: FloatArray, thickness: FloatArray, width: FloatArray) -> float:
    """Return the sd of a point off its surface: the median of where that is a surface."""
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


def grow_regions(near: Neighbourhoods) -> NDArray[np.intp]:
    """Return the number of each node's flat region, (m,); -1: none, CURVED: a curved surface."""
    growth = _Growth(near)
    growth.run()
    # pieces of a cylinder must not be joined to a sheet before they are recognised
    labels, narrow = _mark_curves(near, growth.labels)
    labels, wide = _mark_curves(near, _merged(near, labels))
    return _kept(near, _spread_curves(near, labels, [*narrow, *wide]))


class _Sheet(NamedTuple):
    """A region's plane: a point and the unit normal (3,), and how far off it its middles may be."""

    centre: FloatArray
    normal: FloatArray
    gate: float

    @classmethod
    def through(cls, near: Neighbourhoods, rows: NDArray[np.intp]) -> "_Sheet":
        """Return the plane of the middles of nodes (n,) by least squares.

        Middles that are all but one, as of a few points far from all others, whose neighbourhoods
        are the same, span none: it is turned as their normals are.
        """
        middles, normals = near.middles[rows], near.normals[rows]
        centre = middles.mean(axis=0)
        local = middles - centre
        variances, axes = np.linalg.eigh(local.T @ local / len(local))
        width = float(np.sqrt(12.0 * max(variances[1], 0.0)))
        normal = axes[:, 0]
        if width < near.noise:
            normal = np.linalg.eigh(normals.T @ normals)[1][:, 2]
        return cls(centre, normal, max(MIDDLE_GATE * near.noise, WARP * width))

    def height(self, middles: FloatArray) -> FloatArray:
        """Return distances (n,) of middles (n, 3), of either sign."""
        height: FloatArray = (middles - self.centre) @ self.normal
        return height


class _Growth:
    """Regions grown one after the other, from the flattest places outwards."""

    def __init__(self, near: Neighbourhoods) -> None:
        self.near = near
        self.labels = np.full(len(near.nodes), -1)
        self.count = 0

    def run(self) -> None:
        """Grow from every seed that is not in a region yet."""
        near = self.near
        cosines = np.abs(np.einsum("ijk,ik->ij", near.normals[near.links], near.normals))
        seeds = np.flatnonzero((cosines >= SAME_WAY).mean(axis=1) >= SEED_AGREEMENT)
        fresh = np.ones(len(near.nodes), dtype=bool)
        for seed in seeds[descending(cosines[seeds].mean(axis=1))].tolist():
            if self.labels[seed] >= 0 or not fresh[seed]:
                continue
            region = self._grown(seed)
            # What could not grow from here could not from its members either.
            fresh[region] = False
            fresh[seed] = False
            if len(region) >= LEAST_NODES:
                self.labels[region] = self.count
                self.count += 1

    def _fits(self, rows: NDArray[np.intp], sheet: _Sheet) -> NDArray[np.bool_]:
        close = np.abs(sheet.height(self.near.middles[rows])) <= sheet.gate
        fits: NDArray[np.bool_] = close & (
            np.abs(self.near.normals[rows] @ sheet.normal) >= SAME_WAY
        )
        return fits

    def _grown(self, seed: int) -> NDArray[np.intp]:
        """Return nodes of the region round a seed; those of other regions are left alone."""
        near = self.near
        sheet = _Sheet(near.middles[seed], near.normals[seed], MIDDLE_GATE * near.noise)
        inside = np.zeros(len(near.nodes), dtype=bool)
        inside[seed] = True
        members = np.array([seed])
        for _ in range(REGROWTHS):
            frontier = members
            fitted = before = len(members)
            while len(frontier):
                reached = near.links[frontier].ravel()
                reached = np.unique(reached[~inside[reached] & (self.labels[reached] < 0)])
                frontier = reached[self._fits(reached, sheet)]
                inside[frontier] = True
                members = np.concatenate([members, frontier])
                if len(members) >= max(REFIT * fitted, LEAST_NODES):
                    sheet = _Sheet.through(near, members)
                    fitted = len(members)
            if len(members) < LEAST_NODES:
                break
            sheet = _Sheet.through(near, members)
            stays = self._fits(members, sheet)
            inside[members[~stays]] = False
            members = members[stays]
            if len(members) <= before:
                break
        return members


def _members(labels: NDArray[np.intp]) -> dict[int, NDArray[np.intp]]:
    """Return the nodes (n,) of each region by its label; those of none are left out."""
    order = np.argsort(labels, kind="stable")
    order = order[np.searchsorted(labels[order], 0) :]
    found, starts = np.unique(labels[order], return_index=True)
    return dict(zip(found.tolist(), np.split(order, starts[1:]), strict=True)) if len(order) else {}


def _touching(near: Neighbourhoods, labels: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return pairs (p, 2) of different regions that some link joins, each once."""
    first, second = np.repeat(labels, near.links.shape[1]), labels[near.links].ravel()
    joined = (first >= 0) & (second >= 0) & (first != second)
    pairs = np.sort(np.column_stack([first[joined], second[joined]]), axis=1)
    return unique_rows(pairs)


def _merged(near: Neighbourhoods, labels: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return labels in which regions that touch and have one plane, within its warp, are one."""
    labels = labels.copy()
    groups = _members(labels)
    sheets = {k: _Sheet.through(near, rows) for k, rows in groups.items()}
    apart: set[tuple[int, int]] = set()  # pairs that were tried, of regions as they still are
    while True:
        pairs = _touching(near, labels).tolist()
        cosines = np.array([abs(sheets[one].normal @ sheets[two].normal) for one, two in pairs])
        changed: set[int] = set()
        for place in descending(cosines).tolist():
            (one, two), cosine = pairs[place], float(cosines[place])
            if cosine < SCRAP_WAY:
                break
            if one in changed or two in changed or (one, two) in apart:
                continue
            rows = np.concatenate([groups[one], groups[two]])
            sheet = _Sheet.through(near, rows)
            height = np.abs(sheet.height(near.middles[rows]))
            sizes = sorted((len(groups[one]), len(groups[two])))
            if sizes[0] <= SCRAP_SHARE * sizes[1]:
                same = float(height.max()) <= SCRAP_GATES * sheet.gate
            else:
                rms = float(np.sqrt(np.mean(height**2)))
                same = cosine >= SAME_WAY and rms <= MERGED_GATES * sheet.gate
            if same:
                labels[groups.pop(two)] = one
                groups[one], sheets[one] = rows, sheet
                changed |= {one, two}
            else:
                apart.add((one, two))
        apart = {pair for pair in apart if changed.isdisjoint(pair)}
        if not changed:
            return labels


def _is_curved(places: FloatArray, noise: float) -> bool:
    """Return whether points (n, 3) lie on a curved surface: h = a + bx + cy + dx² + exy + fy² fits
    them.

    Middles are not used: at the rim of a flat face they are biased towards its neighbours.
    """
    if len(places) <= 2 * LEAST_NODES:
        return False
    local = places - places.mean(axis=0)
    variances, axes = np.linalg.eigh(local.T @ local / len(local))
    extent = np.sqrt(12.0 * np.maximum(variances[[2, 1]], 1e-300))
    height, (y, x) = local @ axes[:, 0], (local @ axes[:, 1:]).T
    x, y = x / extent[0], y / extent[1]
    terms = np.column_stack([np.ones_like(x), x, y, x * x, x * y, y * y])
    inverse = np.linalg.pinv(terms.T @ terms)
    bend = inverse @ (terms.T @ height)
    left = height - terms @ bend
    sds = np.sqrt(np.diag(inverse) * float(left @ left) / (len(left) - 6))
    for term, size in ((3, extent[0]), (5, extent[1])):
        bulge = abs(bend[term]) / 4.0  # from the middle to the ends at ± 1/2
        turn = 2.0 * abs(bend[term]) / size
        if bulge > BULGE * noise and abs(bend[term]) > BULGE_SDS * sds[term] and turn > TURN:
            return True
    return False


def measure_width_along(places: FloatArray) -> float:
    """Return the narrower extent of points (n, 3) along their plane, as of an even rectangle."""
    return float(np.sqrt(12.0 * max(float(np.linalg.eigvalsh(np.cov(places.T))[1]), 0.0)))


def _is_sliver(near: Neighbourhoods, rows: NDArray[np.intp]) -> bool:
    """Return whether nodes are only the rounded-off edge between two faces."""
    width = measure_width_along(near.middles[rows])
    thick = float(np.median(near.thickness[rows])) > SLIVER_THICKNESS * near.noise
    return thick and width < float(np.median(near.radius[rows]))


def _mark_curves(
    near: Neighbourhoods, labels: NDArray[np.intp]
) -> tuple[NDArray[np.intp], list[NDArray[np.intp]]]:
    """Return labels in which pieces of a curved surface are CURVED, and the nodes of each piece."""
    groups = _members(labels).values()
    strips = [rows for rows in groups if _is_curved(near.places[rows], near.noise)]
    flat = labels.copy()
    for rows in strips:
        flat[rows] = CURVED
    return flat, strips


def _spread_curves(
    near: Neighbourhoods, labels: NDArray[np.intp], strips: Sequence[NDArray[np.intp]]
) -> NDArray[np.intp]:
    """Return labels in which smooth continuations of a larger curved surface are CURVED as well.

    `strips` are the regions that are curved by themselves, as rows of nodes.

    Strips of a cylinder are grown one after the other: the last ones have only a gap to fill, and
    are too narrow to be curved by themselves. What is wider than the widest strip that is curved
    by itself would have been curved by itself as well: a face next to a rounded edge is not.
    """
    widest = max((measure_width_along(near.places[rows]) for rows in strips), default=0.0)
    labels = labels.copy()
    narrow = {
        label: (rows, _Sheet.through(near, rows).normal)
        for label, rows in _members(labels).items()
        if measure_width_along(near.places[rows]) <= widest
    }
    for _ in range(SPREADS):
        curved = labels == CURVED
        if not curved.any():
            break
        before = labels.copy()
        count = curved.sum()
        for label, (rows, normal) in list(narrow.items()):
            if len(rows) > count:
                continue
            beyond = near.links[rows].ravel()
            # what is of no region says nothing: on a curve regions of one normal leave gaps
            beyond = beyond[(labels[beyond] != label) & (labels[beyond] != -1)]
            smooth = curved[beyond] & (np.abs(near.normals[beyond] @ normal) >= SMOOTH_WAY)
            if len(beyond) and smooth.mean() >= SMOOTH_SHARE:
                labels[rows] = CURVED
                del narrow[label]
        # nodes of no region amid a curved surface
        free = np.flatnonzero(labels == -1)
        labels[free[(labels[near.links[free]] == CURVED).mean(axis=1) >= SMOOTH_SHARE]] = CURVED
        if (labels == before).all():
            break
    return labels


def _kept(near: Neighbourhoods, labels: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return labels from 0 on of the regions that are large enough and no slivers."""
    found = np.where(labels == CURVED, CURVED, -1)
    count = 0
    least = max(LEAST_NODES, round(LEAST_SHARE * near.size * near.share))
    for rows in _members(labels).values():
        if len(rows) >= least and not _is_sliver(near, rows):
            found[rows] = count
            count += 1
    return found
