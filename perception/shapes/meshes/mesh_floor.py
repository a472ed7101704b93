"""Which triangles of a mesh are the floor that its things stand on, and the room round them.

A floor is a level sheet or slab, or several side by side, with everything else above it. A base, a
plinth or a platform is that too. The difference is what remains without it: for a floor several
objects that stand there, some of them clear of its rim, or one object that the floor reaches beyond
on all sides. A bed's ends stand at its platform's rim, and a pedestal's top reaches over its foot.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.ragged import by_group, group_sums
from facetlog.perception.shapes.meshes.clean_mesh import RESOLUTION, Surface
from facetlog.perception.shapes.meshes.mesh_bodies import find_bodies
from facetlog.perception.shapes.meshes.mesh_planes import LargePlane, iter_planes
from facetlog.perception.shapes.meshes.mesh_room import UPRIGHT, find_room, leftovers
from facetlog.perception.shapes.regions.floor_and_walls import (
    ABOVE_SHARE,
    BEYOND,
    LEAST_WIDTH,
    POST,
)
from facetlog.perception.shapes.regions.surface_samples import Samples
from facetlog.perception.types import FloatArray

__all__ = ["Surroundings", "find_surroundings"]

# A floor is no thicker than this share of its breadth, 10 cm of a slab 2 m broad, and no further
# from the lowest point than this share of the size of all.
THIN_SHARE = 0.05
# Of level sheets those this little smaller are as large: the two sides of one slab.
AS_LARGE = 0.99
# A sheet on the floor is a tile of it if it is so large against the largest, else a thing's sole.
TILE_SHARE = 0.1
# A thing stands on the floor if its lowest point is within this share of its height from it.
GAP_SHARE = 0.05
# An object is clear of a side of the floor's rim by this share of the floor's lesser breadth, ...
CLEAR_SHARE = 0.1
# ... on so many of four sides: with a wall behind it, or a floor that ends there.
CLEAR_SIDES = 3
# Of a floor this share is covered at most. Keys cover a keyboard, and cushions a bed.
MOST_COVERED = 0.5
# A closed solid of which less is in the planes of a floor and walls stands there, and is none of
# them: of a cube in a corner three sides of six are.
MOST_TAKEN = 0.6
# Walls go all round an empty room: two in succession are turned by no more than in a triangle, and
# by 10 degrees (radians). No more than this share of its surface is of something else.
ALL_ROUND = float(np.deg2rad(130.0))
LEAST_THING = 0.01
# Planes that are rough by so many resolutions have noise.
ROUGH = 10.0
# Cells along the floor's lesser breadth to measure how much is covered.
CELLS = 48


@dataclass(frozen=True, eq=False, slots=True)
class _Object:
    """An object's plan (k, 2) along the floor's sides, and its heights (k,) above the floor."""

    plan: FloatArray
    heights: FloatArray

    @property
    def stands(self) -> bool:
        """Whether it stands on the floor, and is more than a post."""
        low, high = float(self.heights.min()), float(self.heights.max())
        broad = float(np.linalg.norm(np.ptp(self.plan, axis=0)))
        return low <= GAP_SHARE * (high - low) and high - low <= POST * broad

    def is_clear_of(self, low: FloatArray, high: FloatArray) -> bool:
        """Whether it keeps off the rim of a floor from `low` (2,) to `high` (2,)."""
        least = CLEAR_SHARE * float((high - low).min())
        margins = [*(self.plan.min(axis=0) - low), *(high - self.plan.max(axis=0))]
        return sum(1 for margin in margins if margin >= least) >= CLEAR_SIDES


@dataclass(frozen=True, eq=False, slots=True)
class Surroundings:
    """What things stand on and in: which triangles (m,), and the planes of floor, walls and
    ceiling, their normals away from the things.
    """

    triangles: NDArray[np.bool_]
    planes: tuple[LargePlane, ...]
    size: float

    @property
    def is_rough(self) -> bool:
        """Whether a scanner's noise is in the planes, by far more than rounding."""
        return max(plane.slack for plane in self.planes) > ROUGH * RESOLUTION * self.size


def find_surroundings(
    surface: Surface, samples: Samples, up: FloatArray, *, metric: bool
) -> Surroundings | None:
    """The floor that things stand on and the room round it, `up` (3,) being known; None without.

    `samples` are of the whole surface. `metric` says that lengths are metres: without them nothing
    is a room.
    """
    for floor in _floors(surface, up):
        level = -floor.offset
        choices: list[tuple[LargePlane, ...]] = [(floor,)]
        if metric and (walls := find_room(surface, floor.triangles, level, up)):
            choices.insert(0, (floor, *walls))
        for planes in choices:
            triangles = np.any([plane.triangles for plane in planes], axis=0)
            triangles |= leftovers(surface, triangles, planes)
            triangles &= ~_solids_inside(surface, triangles)
            if _is_empty_room(samples, triangles, planes, up) or _is_floor(
                surface, samples, triangles, floor, up, room=len(planes) > 1
            ):
                return Surroundings(triangles, planes, surface.size)
    return None


def _is_empty_room(
    samples: Samples, triangles: NDArray[np.bool_], planes: tuple[LargePlane, ...], up: FloatArray
) -> bool:
    """Whether walls go all round a floor, without a ceiling, and next to nothing else is left.

    Where walls do not go all round, it is a room's corner.
    """
    walls = np.array([plane.normal for plane in planes[1:]]).reshape(-1, 3)
    if not len(walls) or (np.abs(walls @ up) > UPRIGHT).any():
        return False
    x, y = plane_axes(up, np.roll(up, 1)) @ walls.T
    turns = np.sort(np.arctan2(y, x))
    gaps = np.diff(turns, append=turns[0] + 2.0 * np.pi)
    left = float(samples.areas[~triangles[samples.triangles]].sum())
    return float(gaps.max()) <= ALL_ROUND and left <= LEAST_THING * float(samples.areas.sum())


def _solids_inside(surface: Surface, taken: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Triangles (m,) of closed sheets of which less than half is taken: those of a box that stands
    at a wall, or on a floor, lie in its plane.
    """
    count = int(surface.sheets.max()) + 1
    whole = group_sums(surface.sheets, surface.areas, count)
    part = group_sums(surface.sheets, surface.areas * taken, count)
    few = (part < MOST_TAKEN * whole)[surface.sheets]
    apart: NDArray[np.bool_] = few & surface.closed
    return apart


def _floors(surface: Surface, up: FloatArray) -> Iterator[LargePlane]:
    """What could be the floor, its normal down: sheets apart from the rest, else the lowest of the
    level planes, which things may be one surface with.
    """
    count = int(surface.sheets.max()) + 1
    level = _level_sheets(surface, up, count) if count > 1 else None
    if level is not None:
        slack = RESOLUTION * surface.size
        yield LargePlane(-up, -level[1], slack, level[0][surface.sheets])
    planes = iter_planes(surface, up)
    for plane in sorted(planes, key=lambda plane: plane.offset):
        yield LargePlane(-plane.normal, -plane.offset, plane.slack, plane.triangles)


def _is_floor(
    surface: Surface,
    samples: Samples,
    triangles: NDArray[np.bool_],
    floor: LargePlane,
    up: FloatArray,
    *,
    room: bool,
) -> bool:
    """Whether things stand on a floor, and in a room of which these are the triangles (m,)."""
    left = ~triangles[samples.triangles]
    areas = samples.areas * left
    if not areas.sum() > 0.0:
        return False
    above = floor.heights(samples.points) <= floor.slack
    if areas[above].sum() < ABOVE_SHARE * areas.sum():
        return False
    axes = plane_axes(up, np.roll(up, 1))
    own = np.unique(surface.triangles[floor.triangles])
    try:
        axes = _sides_of(surface.points[own] @ axes.T) @ axes
        plan = surface.points @ axes.T
        outline = ConvexHull(plan[own])
    except (QhullError, ValueError):
        return False
    low, high = plan[own].min(axis=0), plan[own].max(axis=0)
    if _covered(samples.points[left] @ axes.T, low, high) > MOST_COVERED * outline.volume:
        return False
    heights = -floor.heights(surface.points)
    bodies = find_bodies(surface, triangles)
    rows = np.flatnonzero(~triangles)
    corners = (np.unique(surface.triangles[rows[each]]) for each in by_group(bodies[rows]))
    things = [_Object(plan[each], heights[each]) for each in corners]
    return _carries(things, low, high, outline, room=room)


def _covered(plan: FloatArray, low: FloatArray, high: FloatArray) -> float:
    """The area that points (n, 2) cover of a floor from `low` to `high` (2,)."""
    cell = float((high - low).min()) / CELLS
    return len(np.unique(np.floor((plan - low) / cell).astype(np.int64), axis=0)) * cell**2


def _level_sheets(
    surface: Surface, up: FloatArray, count: int
) -> tuple[NDArray[np.bool_], float] | None:
    """Which of the sheets could be the floor together, and the height of its upper side."""
    corners = (surface.points @ up)[surface.triangles]
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(low, surface.sheets, corners.min(axis=1))
    np.maximum.at(high, surface.sheets, corners.max(axis=1))
    plan = group_sums(surface.sheets, surface.areas * np.abs(surface.normals @ up), count)
    breadth = np.sqrt(plan)
    # a table's top is thin and may be larger than a tile, but is not at the bottom
    thin = (high - low <= THIN_SHARE * breadth) & (low - low.min() <= THIN_SHARE * surface.size)
    if not thin.any():
        return None
    large = np.flatnonzero(thin & (plan >= AS_LARGE * plan[thin].max()))
    # of the two sides of a slab the upper one
    first = int(large[high[large].argmax()])
    slack = RESOLUTION * surface.size
    floor = high <= high[first] + slack
    floor &= low >= low[first] - THIN_SHARE * breadth[first]
    soles = (low >= high[first] - slack) & (plan < TILE_SHARE * plan[first])
    floor &= ~soles
    floor[first] = True
    return floor, float(high[first])


def _sides_of(plan: FloatArray) -> FloatArray:
    """Unit vectors (2, 2) along the sides of the least rectangle round points (n, 2)."""
    hull = plan[ConvexHull(plan).vertices]
    rectangle = shapely.get_coordinates(shapely.minimum_rotated_rectangle(shapely.MultiPoint(hull)))
    if len(rectangle) < 4:
        raise ValueError("the floor has no breadth")
    side = rectangle[1] - rectangle[0]
    side /= np.linalg.norm(side)
    return np.array([side, [-side[1], side[0]]])


def _carries(
    things: list[_Object], low: FloatArray, high: FloatArray, outline: ConvexHull, *, room: bool
) -> bool:
    """Whether the things stand on it as on a floor, not as parts on a base."""
    standing = [thing for thing in things if thing.stands]
    if room:
        return bool(standing)
    if not any(thing.is_clear_of(low, high) for thing in standing):
        return False
    if len(standing) > 1:
        return True
    try:
        plan = ConvexHull(np.concatenate([thing.plan for thing in things]))
    except (QhullError, ValueError):
        return False
    # of two dimensions the volume is the area
    beyond = float(outline.volume) >= BEYOND * float(plan.volume)
    highest = max(float(thing.heights.max()) for thing in things)
    return beyond and float((high - low).min()) >= LEAST_WIDTH * highest
