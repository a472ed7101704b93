"""A crate, a gate and a bookcase of boards and bars, each as a mesh, a scan and pictures.

Lengths are metres, z is up. The sizes were chosen before anything was measured.
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from benchmarks.own_solids import block, joined
from benchmarks.recognition import in_metres, tour_views
from benchmarks.single_view import single_view
from facetlog.perception.reading.read_views import ViewSet
from facetlog.perception.reading.shape_files.mesh_files import Mesh
from facetlog.perception.reading.shape_files.point_cloud import Cloud
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.clouds.cloud_scene import scene_of_cloud
from facetlog.perception.shapes.meshes.mesh_scene import scene_of_mesh
from facetlog.robot.rendering import solids
from facetlog.robot.rendering.varied import shrunk
from facetlog.robot.rendering.worlds import INCH, world_of

__all__ = ["THINGS", "from_mesh", "from_scan", "pictures"]

UP = np.array([0.0, 0.0, 1.0])

Corners = tuple[tuple[float, float, float], tuple[float, float, float]]

THINGS: Mapping[str, tuple[Corners, ...]] = MappingProxyType(
    {
        "crate": (
            ((0.0, 0.0, 0.0), (0.6, 0.4, 0.02)),
            ((0.0, 0.0, 0.02), (0.6, 0.02, 0.3)),
            ((0.0, 0.38, 0.02), (0.6, 0.4, 0.3)),
            ((0.0, 0.02, 0.02), (0.02, 0.38, 0.3)),
            ((0.58, 0.02, 0.02), (0.6, 0.38, 0.3)),
        ),
        "gate": (
            ((0.2, 0.02, 0.0), (0.34, 0.16, 2.0)),
            ((1.26, 0.02, 0.0), (1.4, 0.16, 2.0)),
            ((0.0, 0.0, 2.0), (1.6, 0.18, 2.18)),
        ),
        "bookcase": (
            ((0.0, 0.0, 0.0), (0.025, 0.3, 1.8)),
            ((0.775, 0.0, 0.0), (0.8, 0.3, 1.8)),
            ((0.025, 0.28, 0.0), (0.775, 0.3, 1.8)),
            *(
                ((0.025, 0.0, z), (0.775, 0.28, z + 0.025))
                for z in (0.05, 0.4, 0.75, 1.1, 1.45, 1.775)
            ),
        ),
    }
)
"""The cuboids of each thing, from their lowest to their highest corners."""


def from_mesh(name: str) -> Scene:
    """The scene of the thing's mesh, its boards laid together."""
    return scene_of_mesh(_mesh(name), up=UP, metric=True)


def from_scan(name: str, seed: int, places: int) -> Scene:
    """The scene of what a depth sensor sees of it on a floor, half a metre long, from places by
    chance; no two seeds have a place in common."""
    seeds = range(places * seed, places * (seed + 1))
    views = [single_view(_mesh(name), UP, one, name=name, place=True) for one in seeds]
    cloud = Cloud.of(
        np.concatenate([view.points for view in views]),
        name=f"{name}-{seed}",
        seen_from=np.concatenate([view.seen_from for view in views if view.seen_from is not None]),
    )
    return scene_of_cloud(cloud, up=UP, metric=True)


def pictures(name: str, seed: int) -> ViewSet:
    """24 rendered pictures of a model of it on a floor, as the demo takes them."""
    corners = np.array(THINGS[name]) / INCH  # (n, 2, 3)
    corners[..., :2] -= corners[..., :2].max(axis=(0, 1)) / 2.0
    parts = (solids.slab(low, high - low) for low, high in corners)
    solid, model_scale = shrunk(solids.joined(name, parts), np.random.default_rng(seed))
    world = world_of(name, lambda _: ((solid,), model_scale), seed)
    return in_metres(f"{name}-{seed}", tour_views(world, seed), model_scale)


def _mesh(name: str) -> Mesh:
    solid = joined(*(block(low, high) for low, high in THINGS[name]))
    return Mesh.of(solid.vertices, solid.faces, name=name)
