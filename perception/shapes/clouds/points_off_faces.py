"""Which points of a cloud belong to no face, not even as its noise."""

from collections.abc import Iterable

import numpy as np
import shapely
from numpy.typing import NDArray

from facetlog.perception.flat_faces import plane_axes
from facetlog.perception.polygons import make_polygon
from facetlog.perception.shapes.regions.flat_region import FlatRegion
from facetlog.perception.types import FloatArray

__all__ = ["off_faces"]

# A face's own points are within so many sd of its plane: none of a million is further.
NOISE_SDS = 5.0
# Its outline runs amid the noise of its rim: points beyond are within so many sd of it, and one
# spacing, since an outline is that jagged.
RIM_SDS = 4.0


def off_faces(
    points: FloatArray,
    bodies: NDArray[np.intp],
    regions: Iterable[FlatRegion],
    *,
    noise: float,
    spacing: float,
) -> NDArray[np.bool_]:
    """Whether each of points (n, 3) is off its object's faces by more than noise makes it, (n,).

    `bodies` (n,) numbers the object of each point, as regions do; `noise` is the sd of a point off
    its surface, where a region's own is not more, `spacing` the typical distance between points. A
    thing's extent is that of its faces, not of their outliers.
    """
    off = np.ones(len(points), dtype=bool)
    for region in regions:
        sd = max(noise, region.noise)
        gaps = np.abs(region.plane.distance(points))
        near = np.flatnonzero(off & (bodies == region.body) & (gaps <= NOISE_SDS * sd))
        start = region.outline[0]
        axes = plane_axes(region.plane.normal, region.outline[1] - start)
        loops = [(loop - start) @ axes.T for loop in (region.outline, *region.holes)]
        polygon = make_polygon(loops[0], loops[1:])
        wide = polygon.buffer(RIM_SDS * sd + spacing)
        shapely.prepare(wide)
        x, y = ((points[near] - start) @ axes.T).T
        off[near[shapely.contains_xy(wide, x, y)]] = False
    return off
