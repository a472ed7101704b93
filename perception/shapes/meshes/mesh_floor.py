"""Which triangles of a mesh are the floor that its things stand on.

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
from facetlog.perception.grouped import Indices, by_group, group_sums
from facetlog.perception.shapes.meshes.clean_mesh import RESOLUTION, Surface
from facetlog.perception.shapes.meshes.mesh_bodies import find_bodies
from facetlog.perception.shapes.regions.floor_and_walls import (
    ABOVE_SHARE,
    BEYOND,
    LEAST_WIDTH,
    POST,
)
from facetlog.perception.shapes.regions.surface_samples import Samples
from facetlog.perception.types import FloatArray

__all__ = ["find_floor"]

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


def find_floor(surface: Surface, samples: Samples, up: FloatArray) -> NDArray[np.bool_] | None:
    """Which of the triangles (m,) are the floor, `up` (3,) being known; None if there is none.

    `samples` are of the whole surface.
    """
    count = int(surface.sheets.max()) + 1
    if count == 1:
        return None
    level = _level_sheets(surface, up, count)
    if level is None:
        return None
    of_floor, top = level
    floor = of_floor[surface.sheets]
    on_floor = floor[samples.triangles]
    heights = samples.points @ up - top
    areas = samples.areas * ~on_floor
    if not areas.sum() > 0.0:
        return None
    above = heights >= -RESOLUTION * surface.size
    if areas[above].sum() < ABOVE_SHARE * areas.sum():
        return None
    plan = samples.points @ plane_axes(up, np.roll(up, 1)).T
    try:
        plan = plan @ _sides_of(plan[on_floor]).T
        outline = ConvexHull(plan[on_floor])
    except (QhullError, ValueError):
        return None
    bodies = find_bodies(surface, floor)[samples.triangles]
    things = [_Object(plan[own], heights[own]) for own in _each(bodies, on_floor)]
    return floor if _carries(things, plan[on_floor], outline) else None


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


def _each(bodies: Indices, on_floor: NDArray[np.bool_]) -> Iterator[Indices]:
    """Rows of the samples of each object."""
    rows = np.flatnonzero(~on_floor)
    for own in by_group(bodies[rows]):
        yield rows[own]


def _carries(things: list[_Object], floor: FloatArray, outline: ConvexHull) -> bool:
    """Whether the things stand on it as on a floor, not as parts on a base."""
    low, high = floor.min(axis=0), floor.max(axis=0)
    standing = [thing for thing in things if thing.stands]
    if not any(thing.is_clear_of(low, high) for thing in standing):
        return False
    plan = np.concatenate([thing.plan for thing in things])
    cell = float((high - low).min()) / CELLS
    covered = len(np.unique(np.floor((plan - low) / cell).astype(np.int64), axis=0)) * cell**2
    if covered > MOST_COVERED * float(outline.volume):  # of two dimensions: the area
        return False
    if len(standing) > 1:
        return True
    try:
        beyond = float(outline.volume) >= BEYOND * float(ConvexHull(plan).volume)
    except (QhullError, ValueError):
        return False
    highest = max(float(thing.heights.max()) for thing in things)
    return beyond and float((high - low).min()) >= LEAST_WIDTH * highest
