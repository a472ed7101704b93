"""Point clouds into scenes."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree

from facetlog.perception.reading.shape_files.clouds.point_cloud import LEAST_POINTS, Cloud
from facetlog.perception.scene import Scene, SightLines
from facetlog.perception.shapes.clouds.cloud_regions import cloud_regions
from facetlog.perception.shapes.clouds.neighbourhoods import k_nearest
from facetlog.perception.shapes.regions.point_bodies import group_sizes
from facetlog.perception.shapes.regions.scene_from_regions import assemble_scene
from facetlog.perception.types import FloatArray

# Lines of sight to a radian at least, as many as a picture has (surfaces/seeing/eyes.py).
PER_RADIAN = 40.0
# Across what was seen from a place there are so many where points are dense: three for each cell of
# the space of a thing that fills it. A direction has so many points then, or more.
ACROSS = 128
POINTS_OF_LINE = 4


def scan_sights(cloud: Cloud) -> tuple[SightLines, ...]:
    """Return the lines of sight from each place that the cloud's points were seen from.

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
    """Return how many lines of sight to a radian there are among the directions (n, 3) of
    points.
    """
    if not len(ways):
        return PER_RADIAN
    extent = float(np.ptp(ways, axis=0).max())
    across = min(ACROSS, float(np.sqrt(len(ways) / POINTS_OF_LINE)))
    return max(PER_RADIAN, across / max(extent, 1.0 / PER_RADIAN))


# One such point among thousands widens what is measured by a hull or by the farthest point, and
# its line of sight ends in the air. Radius outlier removal: R. B. Rusu, "Semantic 3D Object Maps",
# 2009.

# Fewer points than this together are no surface; a point's density is that of so many neighbours.
GROUP = 8
# Points on one surface are within so many spacings of the next, even where the surface is seen at a
# glance, or four times as far away as most.
REACH_SPACINGS = 12.0
# Points from which the spacing is judged: the median of so many is good to 3 %.
SAMPLE = 500


def without_strays(cloud: Cloud) -> Cloud:
    """Return the cloud without the points that lie alone, and with a warning that counts them."""
    stray = find_strays(cloud.points)
    count = int(stray.sum())
    if not count or len(stray) - count < LEAST_POINTS:
        return cloud
    rows = np.flatnonzero(~stray)
    normals, seen_from, errors = (
        None if values is None else values[rows]
        for values in (cloud.normals, cloud.seen_from, cloud.errors)
    )
    said = f"{count} of {len(stray)} points left out: they lie alone, far from any surface"
    return replace(
        cloud,
        points=cloud.points[rows],
        normals=normals,
        seen_from=seen_from,
        errors=errors,
        warnings=(*cloud.warnings, said),
    )


def find_strays(points: FloatArray) -> NDArray[np.bool_]:
    """Return which of points (n, 3) are in groups of fewer than 8, far from all others, (n,)."""
    if len(points) <= GROUP:
        return np.zeros(len(points), dtype=bool)
    sample = np.random.default_rng(0).permutation(len(points))[:SAMPLE]
    far = k_nearest(KDTree(points), points[sample], GROUP + 1)[0][:, -1]
    spacing = float(np.median(far)) * np.sqrt(np.pi / GROUP)
    if not spacing > 0.0:
        return np.zeros(len(points), dtype=bool)
    alone: NDArray[np.bool_] = group_sizes(points, REACH_SPACINGS * spacing) < GROUP
    return alone


def scene_of_cloud(cloud: Cloud, *, up: ArrayLike | None = None, metric: bool = False) -> Scene:
    """Return the scene of a cloud, in its frame and unit of length; `metric` says that this is the
    metre.

    `up` is any vector upwards; without one it is found from a floor or from cameras, and the
    scene's warnings say so, or it is unknown. Whether the surface
    is known from all sides is judged from the cloud: wherever one looks from, some of it must be
    hidden behind other surface, as of points all over a solid, but not of a view from one side.
    Where it is known from where points were seen, the scene has lines of sight. Points that lie
    alone are left out, and counted in a warning.
    """
    direction = None
    if up is not None:
        direction = np.array(up, dtype=np.float64)
        direction = direction / np.linalg.norm(direction)
    cloud = without_strays(cloud)
    found = cloud_regions(cloud, up=direction, metric=metric)
    scene = assemble_scene(
        cloud.name,
        found.regions,
        found.rest,
        up=found.up,
        metric=metric,
        whole=found.whole,
        warnings=found.warnings,
    )
    return replace(scene, sights=scan_sights(replace(cloud, seen_from=found.seen_from)))
