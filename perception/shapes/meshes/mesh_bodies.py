"""Objects of a mesh, and the solids that they are made of.

Objects are parts whose surfaces come near each other, whether they share corners or not. A leg that
ends inside a table top, or a little below it, shares none with it. The threshold depends on the
parts alone, so that an object is the same whatever else is there.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from facetlog.errors import InputError
from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.polygons import (
    find_difference,
    find_enclosed_area,
    find_union,
    make_valid,
)
from facetlog.perception.ragged import Indices, iter_groups, joined
from facetlog.perception.shapes.meshes.clean_mesh import (
    MEND,
    Surface,
    find_boxes_round,
    measure_part_sizes,
)
from facetlog.perception.shapes.regions.flat_region import FlatRegion, PlaneFrame
from facetlog.perception.shapes.regions.surface_samples import sample_triangles, thinned
from facetlog.perception.types import FloatArray

# Parts nearer than this share of the larger one's extent, with all that is joined to it, are one
# object. Third-party models of furniture leave gaps of up to 2 % between legs and seat; chairs at
# a table keep more.
NEAR_SHARE = 0.02
# Samples of a part lie this share of its own extent apart, or of a larger one's beside it: where
# two touch, samples of both are within a spacing of the place, and two of each other.
SPACING_SHARE = 0.5 * NEAR_SHARE
# Many small triangles have more samples than that: one is kept of each cell of so many spacings.
CELL = 0.5
# Pairs that are compared at most, which takes 15 s. Third-party models of furniture have up to 500;
# surface that falls to pieces has more.
MOST_PAIRS = 200_000
# Boxes are looked up so many at a time: those that meet in plan may be far apart in height.
BOXES_AT_ONCE = 1024
# What is joined to a part is at most so many times as large before what is too far is dropped.
GROWN = 2.0

# Boards that are laid together are closed sheets that touch or reach into each other. Where one
# stands on another's face nobody sees that face, and the object has no surface there: a tread is
# as deep as what the step above leaves of it. So each region loses the sections that other closed
# sheets have just in front of its plane.

# Boards nearer than this share of the object's size touch; sections lie so far before a plane.
TOUCH_SHARE = 1e-4


@dataclass(frozen=True, eq=False, slots=True)
class _Parts:
    """Parts (p,): their boxes' corners (p, 3), extents (p,) and samples' spacings (p,).

    `pairs` (k, 2) are parts whose boxes come near each other. `points` (n, 3) are samples of these
    parts, one part after the other; `rows` says which are a part's; `trees` are kept once made.
    """

    low: FloatArray
    high: FloatArray
    extents: FloatArray
    spacings: FloatArray
    pairs: Indices
    points: FloatArray
    rows: tuple[slice, ...]
    trees: dict[int, cKDTree] = field(default_factory=dict)

    @classmethod
    def of(cls, corners: FloatArray, part: Indices, count: int, name: str) -> "_Parts":
        """Sample triangles (m, 3, 3) of the mesh called `name`, `part` (m,) of `count`."""
        low, high = find_boxes_round(corners, part, count)
        extents = np.sqrt(((high - low) ** 2).sum(axis=1))
        pairs = _find_near_boxes(low, high, GROWN * NEAR_SHARE * extents, name)
        largest = extents.copy()
        for one, two in (pairs.T, pairs.T[::-1]):
            np.maximum.at(largest, one, extents[two])
        spacings = SPACING_SHARE * largest
        # Parts that are near no other are not compared: thousands of specks would take gigabytes.
        compared = np.flatnonzero(np.isin(part, pairs))
        corners, part = corners[compared], part[compared]
        # in spacings of its own each part is sampled one apart
        own = sample_triangles(corners / spacings[part][:, None, None], 1.0)
        kept, _, _ = thinned(own.points, own.areas, part[own.triangles], CELL)
        owner = part[own.triangles[kept]]
        order = np.argsort(owner, kind="stable")
        bounds = np.searchsorted(owner[order], np.arange(count + 1))
        return cls(
            low,
            high,
            extents,
            spacings,
            pairs,
            (own.points[kept] * spacings[owner][:, None])[order],
            tuple(slice(a, b) for a, b in pairwise(bounds.tolist())),
        )

    def gap(self, one: int, two: int, reach: float) -> float:
        """Return the distance between two parts' samples; infinite where it is beyond `reach`."""
        few, many = sorted((one, two), key=lambda k: self.rows[k].stop - self.rows[k].start)
        points = self.points[self.rows[few]]
        beside = (points >= self.low[many] - reach) & (points <= self.high[many] + reach)
        points = points[beside.all(axis=1)]
        if not len(points):
            return np.inf
        tree = self.trees.get(many)
        if tree is None:
            tree = self.trees[many] = cKDTree(self.points[self.rows[many]])
        gaps = np.asarray(tree.query(points, distance_upper_bound=reach)[0])
        return float(gaps.min())


def find_bodies(surface: Surface, floor: NDArray[np.bool_] | None = None) -> Indices:
    """Return the object (m,) of each triangle, numbered from 0.

    The triangles of the `floor` (m,) are one object, the last, and join nothing. Raise InputError
    for a surface in so many pieces, so near to each other, that they cannot be compared.
    """
    bodies = np.zeros(len(surface.triangles), dtype=np.int64)
    rows = np.arange(len(bodies)) if floor is None else np.flatnonzero(~floor)
    if not len(rows):
        return bodies
    if floor is None:
        parts = surface.bodies
    else:
        # what shares corners with the floor alone is apart
        own = surface.triangles[rows]
        groups = joined(len(surface.points), np.concatenate((own[:, :2], own[:, 1:])))[1]
        parts = np.unique(groups[own[:, 0]], return_inverse=True)[1].astype(np.int64)
    count = int(parts.max()) + 1
    together = parts
    if count > 1:
        together = _together(_Parts.of(surface.corners[rows], parts, count, surface.name), count)[
            parts
        ]
    bodies[:] = int(together.max()) + 1
    bodies[rows] = together
    return bodies


def _find_near_boxes(low: FloatArray, high: FloatArray, reach: FloatArray, name: str) -> Indices:
    """Return pairs (k, 2) of boxes whose gap is within the longer reach of the two, those boxes
    being from `low` (p, 3) to `high` (p, 3); raises InputError, which names the mesh, for too many.
    """
    wide = np.column_stack([low - reach[:, None], high + reach[:, None]])
    plans = shapely.box(wide[:, 0], wide[:, 1], wide[:, 3], wide[:, 4])
    tree = shapely.STRtree(plans)
    found, count = [np.zeros((0, 2), dtype=np.int64)], 0
    for first in range(0, len(plans), BOXES_AT_ONCE):
        one, two = tree.query(plans[first : first + BOXES_AT_ONCE])
        one += first
        one, two = one[one < two], two[one < two]
        gaps = np.maximum(np.maximum(low[one] - high[two], low[two] - high[one]), 0.0)
        near = np.sqrt((gaps**2).sum(axis=1)) <= np.maximum(reach[one], reach[two])
        found.append(np.column_stack([one[near], two[near]]).astype(np.int64))
        count += len(found[-1])
        if count > MOST_PAIRS:
            raise InputError(
                f"{name}: falls into {len(plans):,} parts that share no corner, too many to find "
                f"out which are one thing: {MEND}"
            )
    return np.concatenate(found)


def _together(parts: _Parts, count: int) -> Indices:
    """Return the object (p,) of each of `count` parts.

    Joined parts grow, and then reach further: pairs are tested until nothing joins. The order does
    not matter, since parts that may join may do so later as well.
    """
    label = np.arange(count)
    low, high = parts.low.copy(), parts.high.copy()
    larger = parts.extents[parts.pairs].max(axis=1)
    # large parts join most, which saves testing the pairs that they have joined
    open_pairs = parts.pairs[np.argsort(-larger, kind="stable")].tolist()
    members = [[k] for k in range(count)]
    gaps: dict[tuple[int, int], float] = {}
    while True:
        left = []
        for one, two in open_pairs:
            a, b = label[one], label[two]
            if a == b:
                continue
            extent = max(_extent(low[a], high[a]), _extent(low[b], high[b]))
            touching = float(parts.spacings[one] + parts.spacings[two])
            if (one, two) not in gaps:
                most = GROWN * NEAR_SHARE * float(parts.extents[[one, two]].max())
                gaps[one, two] = parts.gap(one, two, max(most, touching))
            if gaps[one, two] > max(NEAR_SHARE * extent, touching):
                left.append((one, two))
                continue
            if len(members[a]) < len(members[b]):
                a, b = b, a
            label[members[b]] = a
            members[a] += members[b]
            low[a] = np.minimum(low[a], low[b])
            high[a] = np.maximum(high[a], high[b])
        if len(left) == len(open_pairs):
            break
        open_pairs = [pair for pair in left if np.isfinite(gaps[pair])]
    return np.unique(label, return_inverse=True)[1].astype(np.int64)


def _extent(low: FloatArray, high: FloatArray) -> float:
    """Return the diagonal of a box."""
    return float(np.sqrt(((high - low) ** 2).sum()))


@dataclass(frozen=True, eq=False, slots=True)
class Solids:
    """The closed sheets (s,) of a surface: number, object, box from `low` to `high` (s, 3), and
    which triangles are of each. `sizes` (b,) are those of all objects.
    """

    surface: Surface
    numbers: Indices
    bodies: Indices
    low: FloatArray
    high: FloatArray
    triangles: tuple[Indices, ...]
    sizes: FloatArray

    @classmethod
    def of(cls, surface: Surface, bodies: Indices) -> "Solids":
        """Find the closed sheets of a surface whose triangles (m,) are of these objects."""
        rows = np.flatnonzero(surface.closed)
        sizes = np.zeros(int(bodies.max()) + 1)
        sizes[bodies] = measure_part_sizes(surface.corners, bodies)
        groups = tuple(rows[own] for own in iter_groups(surface.sheets[rows]))
        corners = [surface.points[surface.triangles[own].ravel()] for own in groups]
        first = np.array([own[0] for own in groups], dtype=np.intp)
        return cls(
            surface,
            surface.sheets[first],
            bodies[first],
            np.array([each.min(axis=0) for each in corners]).reshape(-1, 3),
            np.array([each.max(axis=0) for each in corners]).reshape(-1, 3),
            groups,
            sizes,
        )

    def iter_uncovered(self, region: FlatRegion, own: Indices) -> Iterator[FlatRegion]:
        """Yield the parts of a region that no solid of its object covers, but those of the sheets
        `own`.

        The region is in the surface's frame. It may fall apart, or vanish.
        """
        normal, touch = region.plane.normal, TOUCH_SHARE * float(self.sizes[region.body])
        before = region.outline + touch * normal
        near = (self.bodies == region.body) & ~np.isin(self.numbers, own)
        near &= (self.low < before.max(axis=0)).all(axis=1)
        near &= (self.high > before.min(axis=0)).all(axis=1)
        if not near.any():
            yield region
            return
        axes = make_plane_axes(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
        frame = PlaneFrame(np.zeros(3), axes)
        face = frame.polygon(region.outline, region.holes)
        distance = float(before[0] @ normal)
        sections = [
            self._section(nth, normal, distance, axes) for nth in np.flatnonzero(near).tolist()
        ]
        left = find_difference(face, find_union(sections))
        if left.area > face.area * (1.0 - TOUCH_SHARE):
            yield region
            return
        # neither slivers nor the gaps between boards that touch are anything by themselves
        left = left.buffer(-touch, join_style="mitre").buffer(touch, join_style="mitre")
        sd = float(np.hypot(region.corner_sd, touch))
        for part in shapely.get_parts(left):
            simple = part.simplify(touch)
            if isinstance(simple, shapely.Polygon) and simple.area > 0.0:
                rings = shapely.orient_polygons(simple)
                outline, holes = frame.lift_rings(rings, region.plane)
                yield replace(region, outline=outline, holes=holes, corner_sd=sd)

    def _section(
        self, nth: int, normal: FloatArray, distance: float, axes: FloatArray
    ) -> shapely.Geometry:
        """Return the section of a solid by the plane n · x = distance, in the plane's
        coordinates.
        """
        corners = self.surface.triangles[self.triangles[nth]]
        names, place = np.unique(corners, return_inverse=True)
        place = place.reshape(corners.shape)
        points = self.surface.points[names]
        heights = points @ normal - distance
        above = (heights > 0.0)[place]
        # two sides of each triangle that the plane passes through
        cut = above != np.roll(above, -1, axis=1)
        one, two = np.sort(np.stack([place[cut], np.roll(place, -1, axis=1)[cut]]), axis=0)
        # p + t (q - p), the same for both triangles at the side
        share = heights[one] / (heights[one] - heights[two])
        flat = (points[one] + share[:, None] * (points[two] - points[one])) @ axes.T
        area = find_enclosed_area(flat.reshape(-1, 2, 2))
        return shapely.Polygon() if area is None else make_valid(area)
