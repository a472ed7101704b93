"""Point clouds into scenes."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.clouds.cloud_regions import cloud_regions
from facetlog.perception.shapes.clouds.scan_sights import scan_sights
from facetlog.perception.shapes.clouds.strays import without_strays
from facetlog.perception.shapes.regions.scene_from_regions import assemble_scene

__all__ = ["scene_of_cloud"]


def scene_of_cloud(
    cloud: Cloud, *, up: ArrayLike | None = None, metric: bool = False, whole: bool | None = None
) -> Scene:
    """The scene of a cloud, in its frame and unit of length; `metric` says that this is the metre.

    `up` is any vector upwards; without one it is found from a floor or from cameras, and the
    scene's warnings say so, or it is unknown. `whole` says that the surface is known from all
    sides; without it that is judged from the cloud: wherever one looks from, some of it must be
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
        whole=found.whole if whole is None else whole,
        warnings=found.warnings,
    )
    return replace(scene, sights=scan_sights(replace(cloud, seen_from=found.seen_from)))
