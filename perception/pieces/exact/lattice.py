"""The irregular lattice that a body's own planes span, and which of its cells are solid.

A cell lies between neighbouring planes along each axis of a frame, so that no face along the frame
passes through it: it is inside or outside as a whole. Faces that lie otherwise make the cells that
they cross mixed.
"""

from dataclasses import dataclass

import numpy as np

from facetlog.perception.flat_faces import cross
from facetlog.perception.ragged import Bools, Indices
from facetlog.perception.types import FloatArray

# Cells of a lattice, and pairs of triangles and cells, worked out in a fraction of a second.
MOST_CELLS = 100_000
MOST_PAIRS = 500_000
# The sine of an angle within which lines are parallel.
PARALLEL = 1e-6
# Where in a cell its ray passes: beside the middle, where the diagonals of faces cross.
_ASIDE = np.array([0.4871, 0.5233, 0.4619])


@dataclass(frozen=True, eq=False, slots=True)
class Lattice:
    """Places along each axis of a frame (3, 3), and which cells between them are solid or mixed."""

    frame: FloatArray
    places: tuple[FloatArray, FloatArray, FloatArray]
    solid: Bools
    mixed: Bools

    @property
    def volumes(self) -> FloatArray:
        """Volumes of the cells (nx, ny, nz)."""
        x, y, z = (np.diff(place) for place in self.places)
        return np.asarray(x[:, None, None] * y[None, :, None] * z[None, None, :])

    @property
    def middles(self) -> FloatArray:
        """Middles of the cells (nx, ny, nz, 3), along the frame's axes."""
        each = [0.5 * (place[1:] + place[:-1]) for place in self.places]
        return np.stack(np.meshgrid(*each, indexing="ij"), axis=-1)

    def bounds(self, boxes: Indices) -> FloatArray:
        """Return low and high corners (n, 2, 3) along the frame of boxes (n, 2, 3) of cells."""
        return np.stack([self.places[axis][boxes[..., axis]] for axis in range(3)], axis=-1)


def cluster_places(values: FloatArray, weights: FloatArray, slack: float) -> FloatArray:
    """Return the distinct places among values (n,): those within the slack of the next are one."""
    if not len(values):
        return np.zeros(0)
    order = np.argsort(values, kind="stable")
    values, weights = values[order], np.maximum(weights[order], 1e-300)
    group = np.concatenate([[0], np.cumsum(np.diff(values) > slack)])
    return np.asarray(np.bincount(group, values * weights) / np.bincount(group, weights))


def make_lattice(
    frame: FloatArray,
    places: tuple[FloatArray, FloatArray, FloatArray],
    corners: FloatArray,
    slanted: FloatArray,
    slack: float,
) -> Lattice | None:
    """Return the lattice of a body of triangles (m, 3, 3), of which `slanted` (s, 3, 3) do not lie
    along the frame; both along the frame's axes. None where it would be too large.
    """
    shape = tuple(len(place) - 1 for place in places)
    if min(shape) < 1 or np.prod(shape) > MOST_CELLS:
        return None
    solid = _find_solid(places, corners)
    mixed = _find_mixed(places, slanted, slack)
    if solid is None or mixed is None:
        return None
    return Lattice(frame, places, solid, mixed)


def _expand(low: Indices, high: Indices) -> tuple[Indices, Indices] | None:
    """Return for ranges (n, d) of numbers, each number in them (p, d), and whose it is (p,)."""
    lengths = np.maximum(high - low, 0)
    counts = lengths.prod(axis=1)
    total = int(counts.sum())
    if total > MOST_PAIRS:
        return None
    owner = np.repeat(np.arange(len(low)), counts)
    step = np.arange(total) - np.repeat(np.cumsum(counts) - counts, counts)
    found = []
    for axis in range(low.shape[1] - 1, -1, -1):
        step, rest = np.divmod(step, np.maximum(lengths[owner, axis], 1))
        found.append(low[owner, axis] + rest)
    return np.stack(found[::-1], axis=1), owner


def _find_solid(
    places: tuple[FloatArray, FloatArray, FloatArray], corners: FloatArray
) -> Bools | None:
    """Return which cells are inside: where rays along the first axis leave more often than enter.

    Bodies that overlap, or are there twice, wind round a cell more than once.
    """
    centres = [
        place[:-1] + share * np.diff(place) for place, share in zip(places, _ASIDE, strict=True)
    ]
    normals = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facing = np.flatnonzero(np.abs(normals[:, 0]) > 1e-9 * np.linalg.norm(normals, axis=1))
    corners, normals = corners[facing], normals[facing]
    plan = corners[:, :, 1:]
    low = np.stack([np.searchsorted(centres[k + 1], plan[:, :, k].min(axis=1)) for k in (0, 1)], 1)
    high = np.stack([np.searchsorted(centres[k + 1], plan[:, :, k].max(axis=1)) for k in (0, 1)], 1)
    expanded = _expand(low, high)
    if expanded is None:
        return None
    cell, owner = expanded
    spot = np.column_stack([centres[1][cell[:, 0]], centres[2][cell[:, 1]]])
    inside = np.ones(len(owner), dtype=np.bool_)
    sign = np.sign(normals[owner, 0])
    for k in range(3):
        start, end = plan[owner, k], plan[owner, (k + 1) % 3]
        side = (end[:, 0] - start[:, 0]) * (spot[:, 1] - start[:, 1])
        side -= (end[:, 1] - start[:, 1]) * (spot[:, 0] - start[:, 0])
        inside &= side * sign > 0.0
    cell, owner, spot, sign = cell[inside], owner[inside], spot[inside], sign[inside]
    n, start = normals[owner], corners[owner, 0]
    at = start[:, 0] - ((spot - start[:, 1:]) * n[:, 1:]).sum(axis=1) / n[:, 0]
    shape = tuple(len(each) for each in centres)
    leaves = np.zeros((shape[0] + 1, *shape[1:]))
    np.add.at(leaves, (np.searchsorted(centres[0], at), cell[:, 0], cell[:, 1]), sign)
    # what is passed beyond a cell counts for it
    beyond = leaves[::-1].cumsum(axis=0)[::-1][1:]
    return np.asarray(beyond > 0.5)


def _find_mixed(
    places: tuple[FloatArray, FloatArray, FloatArray], slanted: FloatArray, slack: float
) -> Bools | None:
    """Return through the inside of which cells slanted triangles (s, 3, 3) pass."""
    mixed = np.zeros(tuple(len(place) - 1 for place in places), dtype=np.bool_)
    if not len(slanted):
        return mixed
    low = np.stack(
        [
            np.searchsorted(places[k][1:], slanted[:, :, k].min(axis=1) + slack, side="right")
            for k in range(3)
        ],
        axis=1,
    )
    high = np.stack(
        [np.searchsorted(places[k][:-1], slanted[:, :, k].max(axis=1) - slack) for k in range(3)],
        axis=1,
    )
    expanded = _expand(low, high)
    if expanded is None:
        return None
    cell, owner = expanded
    first = np.stack([places[k][cell[:, k]] for k in range(3)], axis=1)
    last = np.stack([places[k][cell[:, k] + 1] for k in range(3)], axis=1)
    middle, half = 0.5 * (first + last), np.maximum(0.5 * (last - first) - slack, 0.0)
    # by separating axes: most cells lie off the triangle's plane
    normals = cross(slanted[:, 1] - slanted[:, 0], slanted[:, 2] - slanted[:, 0])
    height = np.abs(((middle - slanted[owner, 0]) * normals[owner]).sum(axis=1))
    near = height < (half * np.abs(normals[owner])).sum(axis=1)
    near &= (half > 0.0).all(axis=1)
    cell, owner, middle, half = cell[near], owner[near], middle[near], half[near]
    away = slanted[owner] - middle[:, None]
    sides = np.roll(away, -1, axis=1) - away
    meets = np.ones(len(owner), dtype=np.bool_)
    lengths = np.linalg.norm(sides, axis=2)
    for k, along in np.ndindex(3, 3):
        # the side × an axis of the frame has two components; along that axis it separates nothing
        a, b = (along + 1) % 3, (along + 2) % 3
        one, two = sides[:, k, b], -sides[:, k, a]
        known = np.hypot(one, two) > PARALLEL * lengths[:, k]
        places_along = away[:, :, a] * one[:, None] + away[:, :, b] * two[:, None]
        reach = half[:, a] * np.abs(one) + half[:, b] * np.abs(two)
        apart = (places_along.min(axis=1) >= reach) | (places_along.max(axis=1) <= -reach)
        meets &= ~known | ~apart
    own = cell[meets]
    mixed[own[:, 0], own[:, 1], own[:, 2]] = True
    return mixed
