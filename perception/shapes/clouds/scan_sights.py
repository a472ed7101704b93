"""A scan's lines of sight: from where its points were seen to the points, thinned out."""

import numpy as np

from facetlog.perception.reading.shape_files.point_cloud import Cloud
from facetlog.perception.scene import SightLines

__all__ = ["scan_sights"]

# Lines of sight to a radian, as many as a picture has (surfaces/eyes.py).
PER_RADIAN = 40.0


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
        direction = np.rint(PER_RADIAN * rays / away[:, None])[nearest_first]
        _, first = np.unique(direction, axis=0, return_index=True)
        if len(first):
            found.append(SightLines(place, seen[nearest_first[np.sort(first)]]))
    return tuple(found)
