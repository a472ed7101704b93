"""A block on a floor from a ring of small clean pictures: quick to render, its truth known."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.edge_maps import EdgeMap, edge_map
from facetlog.perception.types import Camera, FloatArray, View
from facetlog.robot.rendering.solids import cuboid, placed
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.world import Floor, SolidTruth, World
from facetlog.robot.tour import make_ring_poses
from tests.rendered import get_solid_truth, sides

CAMERA = Camera(320, 240, 300.0, 300.0, 159.5, 119.5)
VIEWS = 10
# Two edges of a face seen more edge-on than this run into one.
FACING_SINE = 0.2
DISTANCE = 26.0  # inches over the ground, as those of the block


@dataclass(frozen=True, eq=False)
class Rig:
    """Views of one convex solid, and what of it they show."""

    solid: SolidTruth
    views: tuple[View, ...]

    @cached_property
    def maps(self) -> tuple[EdgeMap, ...]:
        return tuple(edge_map(v.image) for v in self.views)

    @cached_property
    def points(self) -> FloatArray:
        return np.array(self.solid.vertices)

    @cached_property
    def edges(self) -> FloatArray:
        """True edges (n, 2, 3)."""
        return self.points[np.array(self.solid.edges)]

    @cached_property
    def pixel(self) -> float:
        """Length of a pixel at the solid."""
        away = [np.linalg.norm(v.pose.centre - self.points.mean(axis=0)) for v in self.views]
        return float(np.median(away)) / CAMERA.fx

    @cached_property
    def shown_faces(self) -> FloatArray:
        """(faces, V): which faces look towards which camera, and not almost edge-on."""
        seen = np.zeros((len(self.solid.faces), len(self.views)), np.bool_)
        for f, face in enumerate(self.solid.faces):
            a, b, c = self.points[list(face[:3])]
            normal = np.cross(b - a, c - b) / np.linalg.norm(np.cross(b - a, c - b))
            for k, view in enumerate(self.views):
                ray = view.pose.centre - self.points[list(face)].mean(axis=0)
                seen[f, k] = normal @ ray > FACING_SINE * np.linalg.norm(ray)
        return seen

    @cached_property
    def shown_edges(self) -> FloatArray:
        """(edges, V): which edges bound a face that looks towards which camera."""
        seen = np.zeros((len(self.solid.edges), len(self.views)), np.bool_)
        for face, views in zip(self.solid.faces, self.shown_faces, strict=True):
            for side in sides(face):
                seen[self.solid.edges.index(side)] |= views
        return seen

    def outward(self, loop: Sequence[int]) -> tuple[FloatArray, FloatArray]:
        """Corners (k, 3) of a true face and its outward normal."""
        corners = self.points[list(loop)]
        normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
        return corners, normal / np.linalg.norm(normal)

    @property
    def top(self) -> tuple[FloatArray, FloatArray]:
        """Corners (4, 3) and normal of the highest face."""
        heights = [float(self.points[list(f), 2].mean()) for f in self.solid.faces]
        return self.outward(self.solid.faces[int(np.argmax(heights))])

    @property
    def untaken(self) -> list[NDArray[np.uint8]]:
        """No pixel of any view shows a face that was found already."""
        return [np.zeros(v.image.shape, np.uint8) for v in self.views]

    def noisy(self, seed: int, sd: float) -> "Rig":
        """Return the pictures with normal noise of `sd` grey levels."""
        rng = np.random.default_rng(seed)
        views = tuple(
            replace(
                v,
                image=np.clip(np.rint(v.image + rng.normal(0, sd, v.image.shape)), 0, 255).astype(
                    np.uint8
                ),
            )
            for v in self.views
        )
        return Rig(self.solid, views)


@cache
def block_rig(arc_deg: float = 360.0) -> Rig:
    """A block of 10 x 8 x 6 in, its faces of different greys, without noise, seen all round it or
    from an arc."""
    block = placed(cuboid(10.0, 8.0, 6.0), 0.0, 0.0, yaw=0.4)
    ups = [float(np.ptp(block.vertices[list(face), 2])) for face in block.faces]
    # Level faces are brightest; upright ones take two greys in turn round the block.
    round_it = iter((0.45, 0.7) * 2)
    albedo = tuple(next(round_it) if up > 0 else 0.95 for up in ups)
    # Light from everywhere: no cast shadow beside the edges.
    world = World(
        (replace(block, albedo=albedo),),
        Floor(0.15),
        np.array([1.0, 0.6, 2.0]),
        ambient=1.0,
        sided=0.0,
        exposure=1.0,
    )
    around = round(VIEWS * 360.0 / arc_deg)
    poses = make_ring_poses([0.0, 0.0, 3.0], DISTANCE, (14.0, 20.0), around)[:VIEWS]
    views = views_of(world, poses, CAMERA, noise_sd=0.0, blur_px=1.0)
    return Rig(get_solid_truth(world), views)
