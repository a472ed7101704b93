"""Simulated views, rendered once in a process: a tour of 24 pictures takes some seconds."""

from functools import lru_cache

import numpy as np

from facetlog.perception.types import FloatArray, View
from facetlog.robot.rendering.views import views_of
from facetlog.robot.rendering.world import SolidTruth, World
from facetlog.robot.rendering.worlds import make_world
from facetlog.robot.tour import tour_camera, tour_poses

# Pictures of a tour are 7 MB; the tests of one file ask for a few worlds in turn.
KEPT_TOURS = 8


@lru_cache(maxsize=KEPT_TOURS)
def tour(name: str, seed: int = 0) -> tuple[View, ...]:
    """The paper's 24 views of a world in inches, at a noise of 5 grey levels and a blur of 1 px."""
    return views_of(make_world(name, seed), tour_poses(), tour_camera(), seed=seed)


def get_solid_truth(world: World) -> SolidTruth:
    """The true shape of the world's first solid."""
    return world.truth.solids[0]


def list_visible_faces(solid: SolidTruth, view: View) -> list[int]:
    """Which faces of a convex solid look towards the camera."""
    corners = np.array(solid.vertices)
    seen = []
    for index, face in enumerate(solid.faces):
        a, b, c = corners[list(face[:3])]
        if np.cross(b - a, c - b) @ (view.pose.centre - a) > 0:
            seen.append(index)
    return seen


def sides(loop: tuple[int, ...]) -> list[tuple[int, int]]:
    """The sides of a loop of vertices as (smaller, larger) index."""
    return [(min(a, b), max(a, b)) for a, b in zip(loop, loop[1:] + loop[:1], strict=True)]


def true_edges(solid: SolidTruth) -> FloatArray:
    """All true edges (n, 2, 3)."""
    return np.array(solid.vertices)[np.array(solid.edges)]
