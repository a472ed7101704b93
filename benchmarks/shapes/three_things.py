"""A crate, a gate and a bookcase of boards and bars, each as a mesh, a scan and pictures.

Lengths are metres, z is up. The sizes were chosen before anything was measured.
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from benchmarks.pictures.recognition import in_metres, tour_views
from benchmarks.shapes.own_solids import block, joined
from benchmarks.shapes.single_view import single_view
from facetlog.perception.reading.read_views import ViewSet
from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.clouds.cloud_scene import make_cloud_scene
from facetlog.perception.shapes.meshes.mesh_scene import make_mesh_scene
from facetlog.perception.types import FloatArray
from facetlog.robot.rendering import solids
from facetlog.robot.rendering.furniture import shrunk
from facetlog.robot.rendering.world import World
from facetlog.robot.rendering.worlds import INCH, place_in_world
from facetlog.robot.tour import make_pose_looking_at, tour_camera

__all__ = ["THINGS", "by_hand", "from_mesh", "from_scan", "on_a_tour"]

UP = np.array([0.0, 0.0, 1.0])
# Pictures by hand: how many, from which heights in turn, how much of half the picture's height the
# thing takes, by which share of the distance place and aim are off, and grey levels of noise.
PICTURES, RISES_DEG, FILLED, SHAKEN, PHONE_NOISE = 24, (20.0, 40.0, 60.0), 0.8, 0.03, 2.0

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
    """Return the scene of the thing's mesh, its boards laid together."""
    return make_mesh_scene(_mesh(name), up=UP, metric=True)


def from_scan(name: str, seed: int, places: int) -> Scene:
    """Return the scene of what a depth sensor sees of it on a floor, half a metre long, from places
    by chance; no two seeds have a place in common.
    """
    seeds = range(places * seed, places * (seed + 1))
    views = [single_view(_mesh(name), UP, one, name=name, place=True) for one in seeds]
    cloud = Cloud.of(
        np.concatenate([view.points for view in views]),
        name=f"{name}-{seed}",
        seen_from=np.concatenate([view.seen_from for view in views if view.seen_from is not None]),
    )
    return make_cloud_scene(cloud, up=UP, metric=True)


def on_a_tour(name: str, seed: int) -> ViewSet:
    """24 rendered pictures of a model of it on a floor, as the demo takes them."""
    world = _world(name, seed)
    return in_metres(f"{name}-{seed}", tour_views(world, seed), world.model_scale)


def by_hand(name: str, seed: int) -> ViewSet:
    """24 rendered pictures of it as who wants to show it takes them: it nearly fills each, round it
    and into it from three heights, with the noise of a phone indoors."""
    world = _world(name, seed)
    middle, reach = _round(world.solids[0].vertices)
    camera, rng = tour_camera(), np.random.default_rng(seed)
    away = reach / np.sin(FILLED * np.arctan(camera.height / 2 / camera.fy))
    poses = []
    for k in range(PICTURES):
        rise, turn = np.radians(RISES_DEG[k % len(RISES_DEG)]), 2 * np.pi * k / PICTURES
        level = np.cos(rise)
        towards = np.array([level * np.cos(turn), level * np.sin(turn), np.sin(rise)])
        shaken = middle + SHAKEN * away * rng.uniform(-1, 1, (2, 3))
        poses.append(make_pose_looking_at(shaken[0] + away * towards, shaken[1]))
    views = tour_views(world, seed, poses=poses, noise_sd=PHONE_NOISE)
    return in_metres(f"{name}-{seed}", views, world.model_scale)


def _world(name: str, seed: int) -> World:
    corners = np.array(THINGS[name]) / INCH  # (n, 2, 3)
    corners[..., :2] -= corners[..., :2].max(axis=(0, 1)) / 2.0
    parts = (solids.slab(low, high - low) for low, high in corners)
    solid, model_scale = shrunk(solids.joined(name, parts), np.random.default_rng(seed))
    return place_in_world(name, lambda _: ((solid,), model_scale), seed)


def _round(points: FloatArray) -> tuple[FloatArray, float]:
    """Return the middle (3,) of the box round points (n, 3), and how far the farthest is from
    it.
    """
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    return middle, float(np.linalg.norm(points - middle, axis=1).max())


def _mesh(name: str) -> Mesh:
    solid = joined(*(block(low, high) for low, high in THINGS[name]))
    return Mesh.of(solid.vertices, solid.faces, name=name)
