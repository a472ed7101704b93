"""The floor that things stand on, the walls of the room round them, and up where it is not given.

A floor has everything else on one side. What stands on it is judged object by object: a point that
lies alone, or the noise of a surface, is none. A room has walls that rise from the floor's rim,
with everything on one side of them, too. A carton is that as well, with no more than a difference
in size: what makes a room is a thing that stands in it, clear of most of its floor, or in metres
its size.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import ConvexHull, QhullError

from facetlog.perception.flat_faces import make_plane_axes
from facetlog.perception.polygons import find_union
from facetlog.perception.ragged import unique_rows
from facetlog.perception.scene import Plane
from facetlog.perception.shapes.regions.point_bodies import (
    LEAST_POINTS,
    REACH_SPACINGS,
    cluster_bodies,
    group_sizes,
)
from facetlog.perception.types import FloatArray

FROM_FLOOR = "up was found from the plane on which everything stands"
FROM_CAMERAS = "up was found from the way the cameras were held"
HELD_OTHERWISE = f"{FROM_FLOOR}, but the cameras were held otherwise: if it is a wall, say up"
"""How up was found, as in a scene's warnings."""

# Of two planes that could both be the floor, as a room's wall could, one is so much larger.
CLEARLY_LARGER = 1.5
# Cameras are held upright: their mean up is known if it is this long (1: all the same).
LEAST_AGREEMENT = 0.8

# A cabinet on a wall is a box on a plane, as a carton on a floor is, and a top turned over carries
# its legs. A standing thing is higher than it is broad, or stands on feet below something that
# covers them; a thing as thin as a leg or a panel is no evidence.

# What is narrower than this share of its height is a leg, a column or a panel.
LEAST_BREADTH = 1.0 / 3.0
# Feet are looked for in this lowest part of a thing's height; a table has three at least.
FEET_SHARE = 0.25
LEAST_FEET = 3
# What is on feet covers at least this share of their outline; a stretcher between legs does not.
COVERED_SHARE = 0.5
# Cells for that are so many spacings wide, and not more than so many to the thing's length.
CELL_SPACINGS = 2.5
MOST_CELLS = 48
# So many parts of one height, within this share of it, may be the legs of a top turned over.
LEGS = 3
SAME_HEIGHT = 0.05


def is_surely_standing(things: Sequence[FloatArray], spacing: float) -> bool:
    """Return whether one of the things, points (k, 3) with the height over the plane last, must
    stand on it; points on the surface are `spacing` apart.
    """
    heights = np.array([thing[:, 2].max() for thing in things])
    kinds = [_kind(thing, spacing) for thing in things]
    alike = len(things) >= LEGS and np.ptp(heights) <= SAME_HEIGHT * heights.max()
    return "on feet" in kinds or ("tall" in kinds and not alike)


def _kind(thing: FloatArray, spacing: float) -> str:
    """Return the evidence of a thing (k, 3): "tall", "on feet", or none."""
    plan, heights = thing[:, :2], thing[:, 2]
    high = float(heights.max())
    try:
        hull = ConvexHull(plan)
    except (QhullError, ValueError):
        return ""
    outline = plan[hull.vertices]
    if (
        float(heights.min()) > GAP_SHARE * high
        or measure_hull_width(outline) < LEAST_BREADTH * high
    ):
        return ""
    length = float(hull.volume) / max(measure_hull_width(outline), 1e-300)  # of a rectangle
    if high >= length:
        return "tall"
    cell = max(CELL_SPACINGS * spacing, length / MOST_CELLS)
    places = np.floor((plan - plan.min(axis=0)) / cell).astype(np.int64)
    covered = len(unique_rows(places)) * cell**2
    if covered < COVERED_SHARE * float(hull.volume):  # of two dimensions: the area
        return ""
    # one cell wider all round, or where points are few a wall's lower edge falls into feet
    places += 1
    low = np.zeros(places.max(axis=0) + 2, dtype=bool)
    low[tuple(places[heights < FEET_SHARE * high].T)] = True
    low = ndimage.binary_dilation(low, np.ones((3, 3), dtype=bool))
    feet = int(ndimage.label(low, np.ones((3, 3)))[1])
    return "on feet" if feet >= LEAST_FEET else ""


def measure_hull_width(hull: FloatArray) -> float:
    """Return the least distance between two parallel lines that hold a convex polygon (k, 2)
    between them.
    """
    span = np.roll(hull, -1, axis=0) - hull
    normals = np.column_stack([span[:, 1], -span[:, 0]])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    return float(np.ptp(hull @ normals.T, axis=0).min())


ABOVE_SHARE = 0.95
"""So much of what is not the floor is above it; the rest is noise, or seen through a gap."""
BEYOND = 1.5
"""A floor goes on beyond the things on it: it is so much larger than what they cover. A top over
four legs, or the bottom of a box, is as large as what is at it."""
LEAST_WIDTH = 1.0
"""A floor is as wide as the things on it are high; the foot of a lamp is not."""
POST = 4.0
"""A thing higher than so many times its plan is broad is a post, a part rather than an object: of
several the plan is what they enclose, as of a table's legs."""
LEAST_ROOM = 1.2
"""A room's floor is as broad and a wall as high as this, metres: more than a pallet box (1.2 × 1.0
m), less than the smallest bathroom."""

# A floor holds this share of the points.
LEAST_FLOOR = 0.1
# Things stand within the floor's outline, this share of their points.
WITHIN_SHARE = 0.9
# Points further from a plane than this many sd are not on it.
ON_PLANE_SDS = 4.0
# Planes within 20 degrees of each other are parallel (cosine), others within 20 degrees of a right
# angle upright on one another (sine).
PARALLEL = float(np.cos(np.deg2rad(20.0)))
UPRIGHT = float(np.sin(np.deg2rad(20.0)))
# A thing stands on the floor if its lowest point is within this share of its height from it; so far
# from the floor, and from its rim, against the floor's width, begins a wall.
GAP_SHARE = 0.1
# What makes a room has a flat face, or this share of the points, with too few for a face.
LEAST_THING = 0.01
# A wall or a ceiling is so large against the floor at least.
LEAST_WALL = 0.1


@dataclass(frozen=True, eq=False, slots=True)
class FacedSurface:
    """Points (n, 3) evenly on a surface, and the plane of each (`owner` (n,), -1: none).

    `noise` is their sd off the planes, `spacing` the typical distance between them;
    `solid` (n,) are the points that are not alone or too few together for a surface.
    """

    points: FloatArray
    owner: NDArray[np.intp]
    planes: tuple[Plane, ...]
    noise: float
    spacing: float
    solid: NDArray[np.bool_]

    @classmethod
    def of(
        cls,
        points: FloatArray,
        owner: NDArray[np.intp],
        planes: Sequence[Plane],
        *,
        noise: float,
        spacing: float,
    ) -> "FacedSurface":
        """Return the surface of points with their planes."""
        solid = np.ones(len(points), dtype=bool)
        free = np.flatnonzero(owner < 0)
        if len(free) and spacing > 0.0:
            solid[free] = group_sizes(points[free], REACH_SPACINGS * spacing) >= LEAST_POINTS
        return cls(points, owner, tuple(planes), noise, spacing, solid)


@dataclass(frozen=True, eq=False, slots=True)
class Floor:
    """A region as a floor, its unit normal towards the things on it, the area of its outline, and
    the other regions `around`: pieces of it, and the walls and the ceiling of its room.
    """

    region: int
    normal: FloatArray
    area: float
    around: tuple[int, ...]


@dataclass(frozen=True, eq=False, slots=True)
class _Side:
    """A region with all else on one side: its unit normal there, and the height (n,) of all points
    over it. `own` (k,) are its points' rows, `off` (n,) says which points are not on its plane.
    """

    region: int
    normal: FloatArray
    height: FloatArray
    own: NDArray[np.intp]
    off: NDArray[np.bool_]

    def outline(self, points: FloatArray) -> shapely.Geometry:
        """Return the hull of its points along its plane."""
        axes = make_plane_axes(self.normal, np.roll(self.normal, 1))
        return _hull(points[self.own] @ axes.T)


def find_floors(
    surface: FacedSurface, up: FloatArray | None = None, *, metric: bool = False
) -> Iterator[Floor]:
    """Yield the regions that may be the floor; with a known `up` (3,) only those below all else.

    Where lengths are metres (`metric`) and up is known, a room may be empty.
    """
    sides = [
        side
        for region in range(len(surface.planes))
        if (side := _side(surface, region)) is not None
    ]
    least = LEAST_FLOOR * len(surface.points)
    for side in sides:
        if len(side.own) < least or (up is not None and float(side.normal @ up) < PARALLEL):
            continue
        walls = _find_walls(surface, side, sides)
        is_room = metric and up is not None and _is_large(surface, side, walls)
        floor = _floor(surface, side, walls, up, is_room=is_room) if walls else None
        floor = floor or _floor(surface, side, [], up)
        if floor is not None:
            yield floor


def _side(surface: FacedSurface, region: int) -> _Side | None:
    """Return the region with its height below all else; None where there is much on both sides."""
    own = np.flatnonzero(surface.owner == region)
    plane = surface.planes[region]
    height = plane.distance(surface.points)
    off = np.abs(height) > ON_PLANE_SDS * surface.noise
    off[own] = False
    others = height[off & surface.solid]
    if not len(own) or not len(others):
        return None
    above = float((others > 0.0).mean())
    if max(above, 1.0 - above) < ABOVE_SHARE:
        return None
    sign = 1.0 if above >= 0.5 else -1.0
    return _Side(region, sign * plane.normal, sign * height, own, off)


def _find_walls(surface: FacedSurface, floor: _Side, sides: Sequence[_Side]) -> list[_Side]:
    """Return what may be walls round a floor, and a ceiling over it."""
    points = surface.points
    outline = floor.outline(points)
    if not outline.area > 0.0:
        return []
    gap = GAP_SHARE * measure_hull_width(shapely.get_coordinates(outline.exterior)[:-1])
    found = []
    upright = False
    for side in sides:
        along = float(side.normal @ floor.normal)
        if side is floor or side.outline(points).area < LEAST_WALL * outline.area:
            continue
        if abs(along) <= UPRIGHT:
            starts = float(np.quantile(floor.height[side.own], 0.05)) <= gap
            if not starts or float(np.quantile(side.height[floor.own], 0.01)) > gap:
                continue
            upright = True
        elif along > -PARALLEL:
            continue
        found.append(side)
    return found if upright else []


def _is_large(surface: FacedSurface, floor: _Side, walls: Sequence[_Side]) -> bool:
    """Return whether a floor and walls are too large for a carton, and have no ceiling as a closet
    has.
    """
    upright = [side for side in walls if abs(float(side.normal @ floor.normal)) <= UPRIGHT]
    if len(upright) < max(len(walls), 1):
        return False
    outline = floor.outline(surface.points)
    corners = shapely.get_coordinates(outline.exterior)[:-1]
    highest = max(float(np.quantile(floor.height[side.own], 0.99)) for side in upright)
    return min(measure_hull_width(corners), highest) >= LEAST_ROOM


def _floor(
    surface: FacedSurface,
    side: _Side,
    walls: Sequence[_Side],
    up: FloatArray | None,
    *,
    is_room: bool = False,
) -> Floor | None:
    """Return the side as a floor, in a room with `walls`; None if things do not stand there so.

    What surely `is_room` may be empty.
    """
    points, around = surface.points, [side, *walls]
    off = np.all([one.off & (one.height > 0.0) for one in around], axis=0)
    support = [one.region for one in around]
    support += _pieces(surface, around)
    off &= ~np.isin(surface.owner, support)
    rows = np.flatnonzero(off & surface.solid)
    bodies = cluster_bodies(points[rows], surface.owner[rows], surface.spacing)
    rows, bodies = rows[bodies >= 0], bodies[bodies >= 0]
    outline = side.outline(points)
    if is_room and not len(rows):
        return Floor(side.region, side.normal, float(outline.area), tuple(support[1:]))
    if not len(rows) or not outline.area > 0.0:
        return None
    over = np.column_stack(
        [points[rows] @ make_plane_axes(side.normal, np.roll(side.normal, 1)).T, side.height[rows]]
    )
    things = [over[bodies == k] for k in range(int(bodies.max()) + 1)]
    slack = ON_PLANE_SDS * surface.noise
    inside = shapely.contains_xy(outline.buffer(slack), over[:, 0], over[:, 1])
    if outline.area < BEYOND * _covered(things) or inside.mean() < WITHIN_SHARE:
        return None
    width = measure_hull_width(shapely.get_coordinates(outline.exterior)[:-1])
    if width < LEAST_WIDTH * float(over[:, 2].max()):
        return None
    if walls and not is_room:
        faced = set(bodies[surface.owner[rows] >= 0].tolist())
        least = LEAST_THING * len(points)
        if not any(_stands(t) for k, t in enumerate(things) if k in faced or len(t) >= least):
            return None
    if up is None and not is_surely_standing(things, surface.spacing):
        return None
    return Floor(side.region, side.normal, float(outline.area), tuple(support[1:]))


def _pieces(surface: FacedSurface, sides: Sequence[_Side]) -> list[int]:
    """Return the regions that lie in the plane of one of the sides, and are none of them."""
    known = {side.region for side in sides}
    found = []
    for region in range(len(surface.planes)):
        own = surface.owner == region
        if (
            region not in known
            and own.any()
            and any(side.off[own].mean() <= 1.0 - ABOVE_SHARE for side in sides)
        ):
            found.append(region)
    return found


def _stands(thing: FloatArray) -> bool:
    low, high = float(thing[:, 2].min()), float(thing[:, 2].max())
    return low <= GAP_SHARE * high


def _covered(things: Sequence[FloatArray]) -> float:
    """Return the area that things, points (k, 3) with the height last, cover of a plan.

    Posts are taken together.
    """
    posts, hulls = [], []
    for thing in things:
        broad = float(np.linalg.norm(np.ptp(thing[:, :2], axis=0)))
        if float(np.ptp(thing[:, 2])) > POST * broad:
            posts.append(thing)
        else:
            hulls.append(_hull(thing[:, :2]))
    if posts:
        hulls.append(_hull(np.concatenate(posts)[:, :2]))
    return float(find_union(hulls).area)


def _hull(plan: FloatArray) -> shapely.Geometry:
    return shapely.convex_hull(shapely.MultiPoint(plan))


@dataclass(frozen=True, eq=False, slots=True)
class Up:
    """Unit vector upwards (3,), the region that is the floor (None: none), and how it was found.

    `around` are the other regions on which or within which things stand: further pieces of the
    floor, and the walls and the ceiling of a room.
    """

    direction: FloatArray
    floor: int | None
    how: str
    around: tuple[int, ...] = ()


def find_up(
    surface: FacedSurface, up: FloatArray | None = None, *, metric: bool = False
) -> Up | None:
    """Return up from the one plane on which everything else stands; None where there is none, or
    where there are two.

    A wall carries things too: there must be one that can only stand. With a known `up` only level
    planes are considered, and the result says which of them is the floor; where lengths are also
    metres (`metric`), also that of an empty room.
    """
    found: list[Floor] = sorted(
        find_floors(surface, up, metric=metric), key=lambda floor: -floor.area
    )
    if not found:
        return None
    first = found[0]
    for other in found[1:]:
        # beside a larger floor the others are walls; one that faces it, as a ceiling does, is
        # ambiguous
        facing = float(first.normal @ other.normal) < -PARALLEL
        if facing or first.area < CLEARLY_LARGER * other.area:
            return None
    direction = first.normal if up is None else up
    return Up(direction, first.region, FROM_FLOOR, first.around)


def find_up_from_cameras(camera_ups: FloatArray) -> Up | None:
    """Return up as the cameras (n, 3) were held, unit vectors; None where they do not agree."""
    if not len(camera_ups):
        return None
    mean = camera_ups.mean(axis=0)
    length = float(np.linalg.norm(mean))
    # a tour round a thing with the camera on its side would have no agreement
    pairs = list(combinations(range(min(len(camera_ups), 2)), 2))
    if length < LEAST_AGREEMENT or not pairs:
        return None
    return Up(mean / length, None, FROM_CAMERAS)
