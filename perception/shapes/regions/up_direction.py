"""Up where it is not given: from the floor or table that things stand on, or from the cameras."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.scene import Plane
from facetlog.perception.shapes.regions.point_bodies import cluster_bodies
from facetlog.perception.shapes.regions.stands_or_hangs import surely_stand, width_of
from facetlog.perception.types import FloatArray

__all__ = ["FROM_CAMERAS", "FROM_FLOOR", "HELD_OTHERWISE", "Up", "find_up", "up_from_cameras"]

FROM_FLOOR = "up was found from the plane on which everything stands"
FROM_CAMERAS = "up was found from the way the cameras were held"
HELD_OTHERWISE = f"{FROM_FLOOR}, but the cameras were held otherwise: if it is a wall, say up"
"""How up was found, as in a scene's warnings."""

# So much of what is not the floor is above it; the rest is noise, or seen through a gap.
ABOVE_SHARE = 0.95
# A floor holds this share of the points; there is another one, of things, above it.
LEAST_FLOOR = 0.1
LEAST_THINGS = 0.01
# Things stand within the floor's outline, this share of their points, ...
WITHIN_SHARE = 0.9
# ... and it goes on beyond them: its hull is so much larger than theirs. A top over four legs, or
# the bottom of a box, is as large as what is at it.
BEYOND = 1.5
# A floor is as wide as the things on it are high; the foot of a lamp is not.
LEAST_WIDTH = 1.0
# Of two planes that could both be the floor, as a room's wall could, one is so much larger.
CLEARLY_LARGER = 1.5
# Points further from a plane than this many sd are not on it.
ON_PLANE_SDS = 4.0
# Planes within 20 degrees of each other are one level (cosine).
ONE_LEVEL = float(np.cos(np.deg2rad(20.0)))
# Cameras are held upright: their mean up is known if it is this long (1: all the same).
LEAST_AGREEMENT = 0.8


@dataclass(frozen=True, eq=False, slots=True)
class Up:
    """Unit vector upwards (3,), the region that is the floor (None: none), and how it was found."""

    direction: FloatArray
    floor: int | None
    how: str


@dataclass(frozen=True, eq=False, slots=True)
class _Candidate:
    region: int
    normal: FloatArray
    area: float


def find_up(
    points: FloatArray,
    owner: NDArray[np.intp],
    planes: Sequence[Plane],
    *,
    noise: float,
    spacing: float,
    up: FloatArray | None = None,
) -> Up | None:
    """Up from the one plane on which everything else stands; None where there is none, or two.

    `points` (n, 3) lie evenly on the surface, `owner` (n,) is the plane of each, -1: none; `noise`
    is their sd off the planes, `spacing` the typical distance between them. A wall carries things
    too: there must be one that can only stand. With a known `up` only level planes are considered,
    and the result says which of them is the floor.
    """
    found = [
        candidate
        for number, plane in enumerate(planes)
        if (candidate := _candidate(number, points, owner, plane, noise, spacing, up)) is not None
    ]
    found.sort(key=lambda candidate: -candidate.area)
    if not found:
        return None
    first = found[0]
    for other in found[1:]:
        # beside a larger floor the others are walls; one that faces it, as a ceiling does, is
        # ambiguous
        facing = float(first.normal @ other.normal) < -ONE_LEVEL
        if facing or first.area < CLEARLY_LARGER * other.area:
            return None
    direction = first.normal if up is None else up
    return Up(direction, first.region, FROM_FLOOR)


def _candidate(
    region: int,
    points: FloatArray,
    owner: NDArray[np.intp],
    plane: Plane,
    noise: float,
    spacing: float,
    up: FloatArray | None,
) -> _Candidate | None:
    """The region as a floor, its normal towards the things on it; None if it cannot be one."""
    own = owner == region
    if own.sum() < LEAST_FLOOR * len(points):
        return None
    if up is not None and abs(float(plane.normal @ up)) < ONE_LEVEL:
        return None
    height = plane.distance(points)
    off = ~own & (np.abs(height) > ON_PLANE_SDS * noise)
    if off.sum() < LEAST_THINGS * len(points):
        return None
    above = float((height[off] > 0.0).mean())
    if up is not None:
        sign = 1.0 if float(plane.normal @ up) > 0.0 else -1.0
        above = above if sign > 0.0 else 1.0 - above
    else:
        sign = 1.0 if above >= 0.5 else -1.0
        above = max(above, 1.0 - above)
    if above < ABOVE_SHARE:
        return None
    flat = points @ plane_axes(plane.normal, np.roll(plane.normal, 1)).T
    things = off & (sign * height > 0.0)
    try:
        floor_hull, things_hull = ConvexHull(flat[own]), ConvexHull(flat[things])
    except (QhullError, ValueError):
        return None
    if floor_hull.volume < BEYOND * things_hull.volume:  # of two dimensions: the area
        return None
    sides = floor_hull.equations
    within = (flat[things] @ sides[:, :2].T + sides[:, 2] <= ON_PLANE_SDS * noise).all(axis=1)
    width = width_of(flat[own][floor_hull.vertices])
    if within.mean() < WITHIN_SHARE or width < LEAST_WIDTH * float(np.abs(height[things]).max()):
        return None
    if up is None:
        bodies = cluster_bodies(points, owner, spacing, support=(region,))
        over = np.column_stack([flat, sign * height])
        numbers = range(int(bodies.max()) + 1)
        # Of some bodies all points are in the plane, or below it.
        standing = (over[things & (bodies == k)] for k in numbers)
        if not surely_stand([thing for thing in standing if len(thing)], spacing):
            return None
    return _Candidate(region, sign * plane.normal, float(floor_hull.volume))


def up_from_cameras(camera_ups: FloatArray) -> Up | None:
    """Up as the cameras (n, 3) were held, unit vectors; None where they do not agree."""
    if not len(camera_ups):
        return None
    mean = camera_ups.mean(axis=0)
    length = float(np.linalg.norm(mean))
    # a tour round a thing with the camera on its side would have no agreement
    pairs = list(combinations(range(min(len(camera_ups), 2)), 2))
    if length < LEAST_AGREEMENT or not pairs:
        return None
    return Up(mean / length, None, FROM_CAMERAS)
