"""A scan's lines of sight: from where its points were seen to the points, thinned out."""

import numpy as np

from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.scene import SightLines
from facetlog.perception.types import FloatArray

__all__ = ["scan_sights"]

# Lines of sight to a radian at least, as many as a picture has (surfaces/seeing/eyes.py).
PER_RADIAN = 40.0
# Across what was seen from a place there are so many where points are dense: three for each cell of
# the space of a thing that fills it. A direction has so many points then, or more.
ACROSS = 128
POINTS_OF_LINE = 4


def scan_sights(cloud: Cloud) -> tuple[SightLines, ...]:
    """The lines of sight from each place that the cloud's points were seen from.

    Of all points in about one direction the nearest is kept: the space in front of it is free.
    """
    if cloud.seen_from is None:
        return ()
    known = np.isfinite(cloud.seen_from).all(axis=1)
    if not known.any():
        return ()
    points = cloud.points[known]
    places, of_place = np.unique(cloud.seen_from[known], axis=0, return_inverse=True)
    order = np.argsort(of_place.ravel(), kind="stable")
    starts = np.searchsorted(of_place.ravel()[order], np.arange(1, len(places)))
    found = []
    for place, rows in zip(places, np.split(order, starts), strict=True):
        seen = points[rows]
        rays = seen - place
        away = np.linalg.norm(rays, axis=1)
        ahead = away > 0
        seen, rays, away = seen[ahead], rays[ahead], away[ahead]
        nearest_first = np.argsort(away, kind="stable")
        ways = rays / away[:, None]
        direction = np.rint(_per_radian(ways) * ways)[nearest_first]
        _, first = np.unique(direction, axis=0, return_index=True)
        if len(first):
            found.append(SightLines(place, seen[nearest_first[np.sort(first)]]))
    return tuple(found)


def _per_radian(ways: FloatArray) -> float:
    """How many lines of sight to a radian there are among the directions (n, 3) of points."""
    if not len(ways):
        return PER_RADIAN
    extent = float(np.ptp(ways, axis=0).max())
    across = min(ACROSS, float(np.sqrt(len(ways) / POINTS_OF_LINE)))
    return max(PER_RADIAN, across / max(extent, 1.0 / PER_RADIAN))
