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

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.ragged import iter_groups, joined, sum_by_group, unique_rows
from facetlog.perception.shapes.meshes.clean_mesh import RESOLUTION, Surface
from facetlog.perception.shapes.meshes.mesh_bodies import find_bodies
from facetlog.perception.shapes.meshes.mesh_regions import LargePlane, iter_planes
from facetlog.perception.shapes.regions.floor_and_walls import (
    ABOVE_SHARE,
    BEYOND,
    LEAST_ROOM,
    LEAST_WIDTH,
    POST,
)
from facetlog.perception.shapes.regions.surface_samples import Samples
from facetlog.perception.types import FloatArray

# Walls are large upright planes at the floor's rim, from the floor upwards, and nothing but their
# own thickness is beyond them. So are a crate's, and a crate may hold a bottle: only size tells a
# room from it, and without metres nothing is a room.

# Normals within 20 degrees of level are of something upright (sine).
UPRIGHT = float(np.sin(np.deg2rad(20.0)))
# A wall is so much of the floor's extent long and of everything's height high, and so much of that
# rectangle is surface: the rest are doors and windows.
WALL_SHARE = 0.5
WALL_FILL = 0.4
# It begins within this share of its height from the floor, and lies within this share of the
# floor's extent from the floor's rim.
NEAR_SHARE = 0.1
# No more than this share of its own surface is beyond it: the ends and the outside of a solid wall.
BEYOND_SHARE = 0.3
# Directions of walls, a bin each, in half a turn.
BINS = 36
# Pieces this many roughnesses from a plane are dents and bumps of it.
BUMPS = 2.0


@dataclass(frozen=True, eq=False, slots=True)
class _Space:
    """References to measure a wall by: the floor's points, and everything's height above it."""

    surface: Surface
    up: FloatArray
    level: float
    floor_points: FloatArray
    height: float

    def is_wall(self, plane: LargePlane, taken: NDArray[np.bool_]) -> bool:
        """Return whether a plane, its normal outwards, is a wall; `taken` (m,) are walls
        already.
        """
        surface = self.surface
        corners = surface.points[np.unique(surface.triangles[plane.triangles])]
        along = np.cross(self.up, plane.normal)
        along /= np.linalg.norm(along)
        low, high = float((corners @ self.up).min()), float((corners @ self.up).max())
        length, height = float(np.ptp(corners @ along)), high - low
        area = float(surface.areas[plane.triangles].sum())
        rim = plane.heights(self.floor_points)
        return (
            height >= max(LEAST_ROOM, WALL_SHARE * self.height)
            and low - self.level <= NEAR_SHARE * height
            and length >= WALL_SHARE * float(np.ptp(self.floor_points @ along))
            and area >= WALL_FILL * length * height
            and abs(float(rim.max())) <= NEAR_SHARE * float(np.ptp(rim))
            and self._measure_area_beyond(plane, taken) <= BEYOND_SHARE * area
        )

    def is_ceiling(self, plane: LargePlane, taken: NDArray[np.bool_], least: float) -> bool:
        """Return whether a level plane, its normal up, is a ceiling of this area at least."""
        area = float(self.surface.areas[plane.triangles].sum())
        middle = self.floor_points.mean(axis=0)
        return (
            area >= least
            and -float(plane.heights(middle[None])[0]) >= (1.0 - NEAR_SHARE) * self.height
            and self._measure_area_beyond(plane, taken) <= BEYOND_SHARE * area
        )

    def _measure_area_beyond(self, plane: LargePlane, taken: NDArray[np.bool_]) -> float:
        surface = self.surface
        heights = plane.heights(surface.points)[surface.triangles].mean(axis=1)
        beyond = (heights > BUMPS * plane.slack) & ~taken & ~plane.triangles
        return float(surface.areas[beyond].sum())


def find_room(
    surface: Surface, floor: NDArray[np.bool_], level: float, up: FloatArray
) -> tuple[LargePlane, ...]:
    """Return the walls and the ceiling round a floor, normals outwards; none where it is no room.

    `floor` (m,) are the floor's triangles and `level` is their height along `up` (3,), in metres.
    """
    floor_points = surface.points[np.unique(surface.triangles[floor])]
    height = float((surface.points[surface.triangles] @ up).max()) - level
    plan = floor_points @ make_plane_axes(up, np.roll(up, 1)).T
    if height < LEAST_ROOM or _measure_breadth(plan) < LEAST_ROOM:
        return ()
    space = _Space(surface, up, level, floor_points, height)
    upright = np.abs(surface.normals @ up) <= UPRIGHT
    middle = floor_points.mean(axis=0)
    taken = floor.copy()
    candidates = [
        plane if float(plane.heights(middle[None])[0]) <= 0.0 else plane.flipped()
        for way in _directions(surface, upright & ~floor, up)
        for plane in iter_planes(surface, way, upright & ~floor)
    ]
    walls: list[LargePlane] = []
    for plane in sorted(candidates, key=lambda plane: float(plane.heights(middle[None])[0])):
        if space.is_wall(plane, taken):
            walls.append(plane)
            taken |= plane.triangles
    if not walls:
        return ()
    least = WALL_SHARE * float((surface.areas * np.abs(surface.normals @ up))[floor].sum())
    ceilings = sorted(iter_planes(surface, up, ~taken), key=lambda plane: -plane.offset)
    for plane in ceilings:
        if space.is_ceiling(plane, taken, least):
            walls.append(plane)
            taken |= plane.triangles
    return tuple(walls)


def leftovers(
    surface: Surface, taken: NDArray[np.bool_], planes: tuple[LargePlane, ...]
) -> NDArray[np.bool_]:
    """Return which other triangles are part of these planes, normals outwards, the floor first:
    bumps of one of them, and pieces just beyond it, as a wall's ends.
    """
    floor = surface.points[np.unique(surface.triangles[planes[0].triangles])]
    reach = NEAR_SHARE * float(np.linalg.norm(np.ptp(floor, axis=0)))
    left = ~taken
    count, piece = joined(len(taken), surface.links[left[surface.links].all(axis=1)])
    part, bumps = np.zeros(count, dtype=bool), np.zeros(len(taken), dtype=bool)
    for plane in planes:
        heights = plane.heights(surface.points)
        bumps |= (np.abs(heights) <= BUMPS * plane.slack)[surface.triangles].all(axis=1)
        apart = (heights < -BUMPS * plane.slack) | (heights > reach)
        part |= sum_by_group(piece, apart[surface.triangles].any(axis=1), count) == 0.0
    return (part[piece] | bumps) & left


def _directions(
    surface: Surface, upright: NDArray[np.bool_], up: FloatArray
) -> Iterator[FloatArray]:
    """Yield level directions (3,) along which most upright surface points, either way."""
    axes = make_plane_axes(up, np.roll(up, 1))
    flat = surface.normals[upright] @ axes.T
    areas = surface.areas[upright]
    turn = np.arctan2(flat[:, 1], flat[:, 0]) % np.pi
    bins = np.bincount((turn * (BINS / np.pi)).astype(np.int64) % BINS, areas, minlength=BINS)
    # a direction at the limit of two bins counts in both
    smooth = bins + np.roll(bins, 1)
    for _ in range(4):
        best = int(np.argmax(smooth))
        if not smooth[best] > NEAR_SHARE * areas.sum():
            return
        centre = best * np.pi / BINS
        near = np.abs(np.sin(turn - centre)) <= UPRIGHT
        # the mean of directions without a sign: of twice the angle
        doubled = float(
            np.arctan2(
                (areas[near] * np.sin(2.0 * turn[near])).sum(),
                (areas[near] * np.cos(2.0 * turn[near])).sum(),
            )
        )
        yield np.array([np.cos(0.5 * doubled), np.sin(0.5 * doubled)]) @ axes
        smooth[np.abs(np.sin((np.arange(BINS) - best) * np.pi / BINS)) <= UPRIGHT] = 0.0


def _measure_breadth(plan: FloatArray) -> float:
    """Return the least breadth of points (n, 2) over a quarter of 32 directions."""
    turns = np.arange(32) * np.pi / 32
    ways = np.column_stack([np.cos(turns), np.sin(turns)])
    return float(np.ptp(plan @ ways.T, axis=0).min())


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
        """Return whether it keeps off the rim of a floor from `low` (2,) to `high` (2,)."""
        least = CLEAR_SHARE * float((high - low).min())
        margins = [*(self.plan.min(axis=0) - low), *(high - self.plan.max(axis=0))]
        return sum(1 for margin in margins if margin >= least) >= CLEAR_SIDES


@dataclass(frozen=True, eq=False, slots=True)
class Surroundings:
    """Floor, walls and ceiling round things: which triangles (m,), and the planes of floor, walls
    and ceiling, their normals away from the things.
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
    """Return the floor that things stand on and the room round it, `up` (3,) being known; None
    without.

    `samples` are of the whole surface. `metric` says that lengths are metres: without them nothing
    is a room.
    """
    for floor in _iter_floors(surface, up):
        level = -floor.offset
        choices: list[tuple[LargePlane, ...]] = [(floor,)]
        if metric and (walls := find_room(surface, floor.triangles, level, up)):
            choices.insert(0, (floor, *walls))
        for planes in choices:
            triangles = np.any([plane.triangles for plane in planes], axis=0)
            triangles |= leftovers(surface, triangles, planes)
            triangles &= ~_find_solids_inside(surface, triangles)
            if _is_empty_room(samples, triangles, planes, up) or _is_floor(
                surface, samples, triangles, floor, up, room=len(planes) > 1
            ):
                return Surroundings(triangles, planes, surface.size)
    return None


def _is_empty_room(
    samples: Samples, triangles: NDArray[np.bool_], planes: tuple[LargePlane, ...], up: FloatArray
) -> bool:
    """Return whether walls go all round a floor, without a ceiling, and next to nothing else is
    left.

    Where walls do not go all round, it is a room's corner.
    """
    walls = np.array([plane.normal for plane in planes[1:]]).reshape(-1, 3)
    if not len(walls) or (np.abs(walls @ up) > UPRIGHT).any():
        return False
    x, y = make_plane_axes(up, np.roll(up, 1)) @ walls.T
    turns = np.sort(np.arctan2(y, x))
    gaps = np.diff(turns, append=turns[0] + 2.0 * np.pi)
    left = float(samples.areas[~triangles[samples.triangles]].sum())
    return float(gaps.max()) <= ALL_ROUND and left <= LEAST_THING * float(samples.areas.sum())


def _find_solids_inside(surface: Surface, taken: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return triangles (m,) of closed sheets of which less than half is taken: those of a box that
    stands at a wall, or on a floor, lie in its plane.
    """
    count = int(surface.sheets.max()) + 1
    whole = sum_by_group(surface.sheets, surface.areas, count)
    part = sum_by_group(surface.sheets, surface.areas * taken, count)
    few = (part < MOST_TAKEN * whole)[surface.sheets]
    apart: NDArray[np.bool_] = few & surface.closed
    return apart


def _iter_floors(surface: Surface, up: FloatArray) -> Iterator[LargePlane]:
    """Yield candidates for the floor, their normals down: sheets apart from the rest, else the
    lowest of the level planes, which things may be one surface with.
    """
    count = int(surface.sheets.max()) + 1
    level = _find_level_sheets(surface, up, count) if count > 1 else None
    if level is not None:
        slack = RESOLUTION * surface.size
        yield LargePlane(-up, -level[1], slack, level[0][surface.sheets])
    planes = iter_planes(surface, up)
    for plane in sorted(planes, key=lambda plane: plane.offset):
        yield plane.flipped()


def _is_floor(
    surface: Surface,
    samples: Samples,
    triangles: NDArray[np.bool_],
    floor: LargePlane,
    up: FloatArray,
    *,
    room: bool,
) -> bool:
    """Return whether things stand on a floor, and in a room of which these are the
    triangles (m,).
    """
    left = ~triangles[samples.triangles]
    areas = samples.areas * left
    if not areas.sum() > 0.0:
        return False
    above = floor.heights(samples.points) <= floor.slack
    if areas[above].sum() < ABOVE_SHARE * areas.sum():
        return False
    axes = make_plane_axes(up, np.roll(up, 1))
    own = np.unique(surface.triangles[floor.triangles])
    try:
        axes = _find_rectangle_sides(surface.points[own] @ axes.T) @ axes
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
    corners = (np.unique(surface.triangles[rows[each]]) for each in iter_groups(bodies[rows]))
    things = [_Object(plan[each], heights[each]) for each in corners]
    return _is_carrying(things, low, high, outline, room=room)


def _covered(plan: FloatArray, low: FloatArray, high: FloatArray) -> float:
    """Return the area that points (n, 2) cover of a floor from `low` to `high` (2,)."""
    cell = float((high - low).min()) / CELLS
    return len(unique_rows(np.floor((plan - low) / cell).astype(np.int64))) * cell**2


def _find_level_sheets(
    surface: Surface, up: FloatArray, count: int
) -> tuple[NDArray[np.bool_], float] | None:
    """Return which of the sheets could be the floor together, and the height of its upper side."""
    corners = (surface.points @ up)[surface.triangles]
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(low, surface.sheets, corners.min(axis=1))
    np.maximum.at(high, surface.sheets, corners.max(axis=1))
    plan = sum_by_group(surface.sheets, surface.areas * np.abs(surface.normals @ up), count)
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


def _find_rectangle_sides(plan: FloatArray) -> FloatArray:
    """Return unit vectors (2, 2) along the sides of the least rectangle round points (n, 2)."""
    hull = plan[ConvexHull(plan).vertices]
    rectangle = shapely.get_coordinates(shapely.minimum_rotated_rectangle(shapely.MultiPoint(hull)))
    if len(rectangle) < 4:
        raise ValueError("the floor has no breadth")
    side = rectangle[1] - rectangle[0]
    side /= np.linalg.norm(side)
    return np.array([side, [-side[1], side[0]]])


def _is_carrying(
    things: list[_Object], low: FloatArray, high: FloatArray, outline: ConvexHull, *, room: bool
) -> bool:
    """Return whether the things stand on it as on a floor, not as parts on a base."""
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
