"""Whether a thing on a plane can only stand there, as on a floor, or may hang, as on a wall.

A cabinet on a wall is a box on a plane, as a carton on a floor is, and a top turned over carries
its legs. A standing thing is higher than it is broad, or stands on feet below something that covers
them; a thing as thin as a leg or a panel is no evidence.
"""

from collections.abc import Sequence

import numpy as np
from scipy import ndimage
from scipy.spatial import ConvexHull, QhullError

from facetlog.perception.types import FloatArray

__all__ = ["surely_stand", "width_of"]

# A thing is on the plane if its lowest point is within this share of its height from it.
GAP_SHARE = 0.1
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


def surely_stand(things: Sequence[FloatArray], spacing: float) -> bool:
    """Whether one of the things, points (k, 3) with the height over the plane last, must stand on
    it; points on the surface are `spacing` apart.
    """
    heights = np.array([thing[:, 2].max() for thing in things])
    kinds = [_kind(thing, spacing) for thing in things]
    alike = len(things) >= LEGS and np.ptp(heights) <= SAME_HEIGHT * heights.max()
    return "on feet" in kinds or ("tall" in kinds and not alike)


def _kind(thing: FloatArray, spacing: float) -> str:
    """The evidence of a thing (k, 3): "tall", "on feet", or none."""
    plan, heights = thing[:, :2], thing[:, 2]
    high = float(heights.max())
    try:
        hull = ConvexHull(plan)
    except (QhullError, ValueError):
        return ""
    outline = plan[hull.vertices]
    if float(heights.min()) > GAP_SHARE * high or width_of(outline) < LEAST_BREADTH * high:
        return ""
    length = float(hull.volume) / max(width_of(outline), 1e-300)  # of a rectangle
    if high >= length:
        return "tall"
    cell = max(CELL_SPACINGS * spacing, length / MOST_CELLS)
    places = np.floor((plan - plan.min(axis=0)) / cell).astype(np.int64)
    covered = len(np.unique(places, axis=0)) * cell**2
    if covered < COVERED_SHARE * float(hull.volume):  # of two dimensions: the area
        return ""
    # one cell wider all round, or where points are few a wall's lower edge falls into feet
    places += 1
    low = np.zeros(places.max(axis=0) + 2, dtype=bool)
    low[tuple(places[heights < FEET_SHARE * high].T)] = True
    low = ndimage.binary_dilation(low, np.ones((3, 3), dtype=bool))
    feet = int(ndimage.label(low, np.ones((3, 3)))[1])
    return "on feet" if feet >= LEAST_FEET else ""


def width_of(hull: FloatArray) -> float:
    """Least distance between two parallel lines that hold a convex polygon (k, 2) between them."""
    span = np.roll(hull, -1, axis=0) - hull
    normals = np.column_stack([span[:, 1], -span[:, 0]])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    return float(np.ptp(hull @ normals.T, axis=0).min())
