"""Place of a flat thing's name: well inside its outline."""

import numpy as np
import shapely

from facetlog.perception.types import FloatArray

# A centroid this near to the outline, as a share of what the widest place has, will do: along a
# strip all places are as wide.
WIDE_ENOUGH = 0.8


def inner_point(polygon: shapely.Polygon) -> FloatArray:
    """Return the centroid (2,), if the polygon is about as wide there as anywhere; else where it
    is.

    >>> inner_point(shapely.box(0, 0, 9, 1))
    array([4.5, 0.5])
    """
    widest = shapely.maximum_inscribed_circle(polygon)
    middle = polygon.centroid
    room = polygon.boundary.distance(middle) if polygon.contains(middle) else 0.0
    chosen = middle.coords[0] if room >= WIDE_ENOUGH * widest.length else widest.coords[0]
    return np.array(chosen)
