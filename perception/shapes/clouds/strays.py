"""Points that lie alone, far from any surface: flying pixels, reflections, dust, birds.

One such point among thousands widens what is measured by a hull or by the farthest point, and its
line of sight ends in the air. Radius outlier removal: R. B. Rusu, "Semantic 3D Object Maps", 2009.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from facetlog.perception.reading.shape_files.clouds.point_cloud import LEAST_POINTS, Cloud
from facetlog.perception.shapes.clouds.neighbourhoods import k_nearest
from facetlog.perception.shapes.regions.point_bodies import group_sizes
from facetlog.perception.types import FloatArray

__all__ = ["find_strays", "without_strays"]

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
