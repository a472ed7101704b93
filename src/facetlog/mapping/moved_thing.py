"""Things that stand elsewhere by now: seen at one place before, at another later.

Two chairs of a kind look like one that was moved. What tells them apart is where the first one
stood: it is gone if the floor is free there since, wherever within its uncertainty it stood.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from facetlog.mapping.beam_counts import BeamCounts
from facetlog.mapping.floor_grid import RESOLUTION, list_shown_points
from facetlog.mapping.placed_thing import PlacedThing
from facetlog.mapping.same_thing import MOST, REACH_SDS, MappedThing, alike, compute_cov_between
from facetlog.mapping.sonar_beams import Beam
from facetlog.perception.scene import SeenLattice
from facetlog.perception.types import FloatArray

# Places where a thing may have stood: so many directions at one, two and three deviations.
DIRECTIONS = 12
# From its foot to the ground a thing leaves at most a cell.
GROUND = RESOLUTION


@dataclass(frozen=True, eq=False, slots=True)
class Looks:
    """Observed floor with times: lattices of the ground, each with the times of its views (seconds
    since 1970), and sonars' beams.
    """

    lattices: tuple[tuple[SeenLattice, tuple[float, ...]], ...] = ()
    beams: tuple[Beam, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class Moved:
    """A thing as it stood `before`, and as it stands `now`."""

    before: MappedThing
    now: MappedThing

    @property
    def off(self) -> float:
        """Distance moved, m."""
        return float(np.hypot(*(self.now.best.pose - self.before.best.pose)[:2]))


def resolve_moved_things(
    things: Sequence[MappedThing], looks: Looks
) -> tuple[tuple[MappedThing, ...], tuple[Moved, ...]]:
    """Return the things of a map where they stand now, and which of them stood elsewhere before.

    One that was moved has the sightings of where it stood, too; one that was moved often stood at
    its places in the order in which they are returned. It has the same name and size at
    both places, was seen at the second only after it was last seen at the first, and at the first
    the floor is free since.
    """
    pairs = [
        (_begin(other) - _end(one), Moved(one, other).off, a, b)
        for a, one in enumerate(things)
        for b, other in enumerate(things)
        if a != b and _may_be_moved(one, other) and _is_gone(one.best, other.best, looks, _end(one))
    ]
    # Of several that look the same it is the one that was seen next, and each is one of them.
    to: dict[int, int] = {}
    for *_, a, b in sorted(pairs):
        if a not in to and b not in to.values():
            to[a] = b
    left = [k for k in range(len(things)) if k not in to]
    found = {k: replace(things[k], name=f"m{n}") for n, k in enumerate(left, start=1)}
    moved = []
    for a, b in sorted(to.items(), key=lambda pair: _begin(things[pair[0]])):
        last = b
        while last in to:
            last = to[last]
        thing = found[last]
        found[last] = replace(thing, seen=(*thing.seen, *things[a].seen))
        moved.append(Moved(things[a], replace(things[b], name=thing.name)))
    return tuple(found.values()), tuple(moved)


def _begin(thing: MappedThing) -> float:
    return min(seen.when[0] for seen in thing.seen)


def _end(thing: MappedThing) -> float:
    return max(seen.when[1] for seen in thing.seen)


def _may_be_moved(before: MappedThing, now: MappedThing) -> bool:
    """Return whether the second may be the first, later."""
    if not before.model or before.model != now.model:
        return False
    return 0.0 < _end(before) < _begin(now) and alike(before.best, now.best)


def _is_gone(before: PlacedThing, now: PlacedThing, looks: Looks, since: float) -> bool:
    """Return whether the floor is free since then on which a thing stood, wherever by its
    uncertainty: for what was looked at since that is how the later estimate of its place is off
    against the earlier.
    """
    foot = _foot(before)
    if not len(foot):
        return False
    cov = compute_cov_between(before, now)
    reach = float(np.linalg.norm(before.outline - before.pose[:2], axis=1).max())
    values, vectors = np.linalg.eigh(cov[:2, :2] + cov[2, 2] * reach**2 * np.eye(2))
    sds = np.sqrt(np.maximum(values, 0.0))
    angles = np.arange(DIRECTIONS) * math.tau / DIRECTIONS
    ring = (np.column_stack([np.cos(angles), np.sin(angles)]) * sds) @ vectors.T
    offsets = np.vstack([np.zeros((1, 2)), *(k * ring for k in range(1, int(REACH_SDS) + 1))])
    places = foot + offsets[:, None]
    low = np.floor(places.min(axis=(0, 1)) / RESOLUTION) * RESOLUTION
    columns, rows = (
        np.floor((places.max(axis=(0, 1)) - low) / RESOLUTION).astype(int) + 1
    ).tolist()
    column, row = np.moveaxis(((places - low) / RESOLUTION).astype(int), -1, 0)
    free = np.zeros((rows, columns), np.bool_)
    for points in _shown_since(looks, since):
        u, v = np.floor((points - low) / RESOLUTION).astype(int).T
        inside = (u >= 0) & (u < columns) & (v >= 0) & (v < rows)
        free[v[inside], u[inside]] = True
    grid = (float(low[0]), float(low[1])), (rows, columns)
    then = _counted(*grid, (beam for beam in looks.beams if beam.at <= since))
    if then.echoed[row, column].any():
        # Sonars see no higher and no lower: what they met there they would meet again.
        free |= _counted(*grid, (beam for beam in looks.beams if beam.at > since)).passed
    return bool((free[row, column].mean(axis=1) > MOST).all())


def _foot(thing: PlacedThing) -> FloatArray:
    """Return points (n, 2), no farther apart than cells, of the edges on which it stands on the
    ground; none of what hangs, or whose lower part nobody saw.
    """
    if thing.low > GROUND:
        return np.zeros((0, 2))
    ends = thing.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2, 3)
    ends = ends[(ends[:, :, 2] <= thing.low + GROUND).all(axis=1)][:, :, :2]
    found = []
    for one, other in ends:
        parts = max(math.ceil(math.dist(one, other) / RESOLUTION), 1)
        found.append(one + np.linspace(0.0, 1.0, parts + 1)[:, None] * (other - one))
    return np.array(list(chain.from_iterable(found)), dtype=np.float64).reshape(-1, 2)


def _shown_since(looks: Looks, since: float) -> Iterable[FloatArray]:
    """Yield points (n, 2) of the ground that views show which were taken since then."""
    for lattice, times in looks.lattices:
        later = np.array(times) > since
        if later.any():
            views = tuple(v for v, is_later in zip(lattice.views, later, strict=True) if is_later)
            own = replace(
                lattice, origins=lattice.origins[later], shown=lattice.shown[later], views=views
            )
            yield list_shown_points(own, RESOLUTION)


def _counted(low: tuple[float, float], shape: tuple[int, int], beams: Iterable[Beam]) -> BeamCounts:
    counts = BeamCounts(low, RESOLUTION, shape)
    middle = np.array(low) + RESOLUTION * np.array(shape[::-1]) / 2
    reach = RESOLUTION * math.hypot(*shape) / 2
    for beam in beams:
        if math.dist((beam.x, beam.y), middle) <= beam.range + reach:
            counts.add(beam)
    return counts
