"""Polygons of a plane: made valid, and set operations on them that never fail.

GEOS cannot overlay or triangulate a polygon that crosses itself (GEOSException); with valid ones,
its overlays are robust whatever the rounding (M. Davis, "OverlayNG", GEOS 3.9). All of perception
therefore does both here, and makes its polygons with `make_polygon`.
"""

import logging
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import shapely
from shapely.errors import GEOSException

from facetlog.perception.types import FloatArray

_LOG = logging.getLogger(__name__)

# Coordinates are rounded to this share of the extent where GEOS fails even on valid polygons: some
# 10^4 times the rounding error of a double.
GRID_SHARE = 1e-12


def make_polygon(outline: FloatArray, holes: Sequence[FloatArray] = ()) -> shapely.Geometry:
    """Return the valid polygon of an outline (k, 2) and holes, each (m, 2).

    Of a loop that crosses itself it holds all that the loop goes round, perhaps in several parts;
    of one without area nothing. Loops have three corners at least.

    >>> bow_tie = np.array([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]])
    >>> make_polygon(bow_tie).area
    0.5
    """
    return make_valid(shapely.Polygon(outline, holes))


def make_valid(shapes: Any) -> Any:
    """Return the geometries, one or an array, with the areas of those that are not valid."""
    sound = shapely.is_valid(shapes)
    if np.all(sound):
        return shapes
    mended = shapely.make_valid(shapes, method="structure", keep_collapsed=False)
    return np.where(sound, shapes, mended) if np.ndim(shapes) else mended


def find_intersection(one: Any, other: Any, grid_size: float | None = None) -> Any:
    """Return what two geometries, or two arrays of them one by one, share."""
    return _overlay_robustly(shapely.intersection, one, other, grid_size=grid_size)


def find_difference(one: Any, other: Any) -> Any:
    """Return what of the first geometries is not in the others."""
    return _overlay_robustly(shapely.difference, one, other)


def find_symmetric_difference(one: Any, other: Any) -> Any:
    """Return what is in either of two geometries, but not in both."""
    return _overlay_robustly(shapely.symmetric_difference, one, other)


def find_union(shapes: Any) -> shapely.Geometry:
    """Return the union of geometries."""
    return _overlay_robustly(shapely.union_all, np.asarray(shapes, dtype=np.object_))


def find_enclosed_area(segments: FloatArray) -> shapely.Geometry | None:
    """Return what segments (n, 2, 2) enclose; None without any, or where they cross."""
    if not len(segments):
        return None
    try:
        return shapely.build_area(shapely.multilinestrings(segments))
    except GEOSException as exc:
        _LOG.debug("segments that enclose nothing: %s", exc)
        return None


def join_triangles(triangles: FloatArray) -> shapely.Geometry:
    """Return the union of triangles (n, 3, 2) that share sides but do not overlap."""
    shapes = shapely.polygons(triangles)
    try:
        return shapely.coverage_union_all(shapes)
    except GEOSException as exc:
        _LOG.debug("triangles joined one by one: %s", exc)
        return find_union(shapes)


# GEOS sets the flags of coordinates near the least number.
@np.errstate(divide="ignore", invalid="ignore")
def triangulate(polygons: Any) -> FloatArray:
    """Return triangles (n, 3, 2) that fill polygons; either way round."""
    sound = make_valid(polygons)
    try:
        found = shapely.constrained_delaunay_triangles(sound)
    except GEOSException as exc:
        _LOG.debug("triangles of rounded polygons: %s", exc)
        grid = GRID_SHARE * float(np.nanmax(np.abs(shapely.bounds(sound)), initial=0.0))
        found = shapely.constrained_delaunay_triangles(shapely.set_precision(sound, grid))
    flat = shapely.get_parts(found)
    corners: FloatArray = shapely.get_coordinates(flat).reshape(-1, 4, 2)[:, :3]
    return corners


# GEOS sets flags of coordinates near the least number, whose areas are right all the same.
@np.errstate(all="ignore")
def _overlay_robustly(
    operation: Callable[..., Any], *sets: Any, grid_size: float | None = None
) -> Any:
    # of polygons that are not valid some results are wrong without an exception
    sets = tuple(make_valid(each) for each in sets)
    try:
        return operation(*sets, grid_size=grid_size)
    except GEOSException as exc:
        _LOG.debug("%s of rounded polygons: %s", operation.__name__, exc)
    bounds = np.concatenate([np.reshape(shapely.bounds(each), (-1, 4)) for each in sets])
    grid = max(GRID_SHARE * float(np.nanmax(np.abs(bounds), initial=0.0)), grid_size or 0.0)
    return operation(*(shapely.set_precision(each, grid) for each in sets), grid_size=grid)
