"""Uncertainty of vertices as ellipsoids of two standard deviations."""

from collections.abc import Callable, Iterator
from itertools import count

import numpy as np
import trimesh
from trimesh.scene.transforms import SceneGraph

from facetlog.perception.scene import Scene
from facetlog.perception.types import FloatArray

_update: Callable[..., None] = SceneGraph.update  # trimesh leaves it without types

DEVIATIONS = 2.0
# Half of the ellipsoids are to be this long at least, half an axis as a share of the scene's
# diagonal: of a view 430 pixels high, which the diagonal fills by two thirds, that is 3 pixels.
LEAST_SHARE = 0.01
# Axes shorter than this share of the longest are drawn so long: what is flat has no inside.
FLATTEST = 1e-3
COLOUR = (200, 60, 120, 255)


def compute_ellipsoid_scale(scene: Scene) -> int | None:
    """Return the scale of all ellipsoids, 1, 2, 5, 10, …; None if there are none."""
    longest = [axes.max() for _, axes, _ in _ellipsoids(scene)]
    if not longest:
        return None
    size = float(np.linalg.norm(np.ptp(scene.points, axis=0)))
    wanted = LEAST_SHARE * size / float(np.median(longest))
    steps = (step * int(10**power) for power in count() for step in (1, 2, 5))
    return next(step for step in steps if step >= wanted)


def add_ellipsoids(graph: trimesh.Scene, scene: Scene) -> None:
    """Add nodes v1, … of all vertices that have a covariance, in the scene's frame."""
    larger = compute_ellipsoid_scale(scene)
    if larger is None:
        return
    sphere = trimesh.creation.icosphere(subdivisions=2)
    sphere.visual.face_colors = COLOUR
    graph.geometry["ellipsoid"] = sphere  # one for all, which nodes turn and stretch
    for index, axes, turned in _ellipsoids(scene):
        matrix = np.eye(4)
        matrix[:3, :3] = turned * (larger * np.maximum(axes, FLATTEST * axes.max()))
        matrix[:3, 3] = scene.vertices[index].point
        _update(graph.graph, frame_to=f"v{index + 1}", matrix=matrix, geometry="ellipsoid")


def _ellipsoids(scene: Scene) -> Iterator[tuple[int, FloatArray, FloatArray]]:
    """Yield indices of vertices, half axes (3,), and which way these run, right-handed columns (3,
    3).
    """
    size = float(np.linalg.norm(np.ptp(scene.points, axis=0))) if scene.vertices else 0.0
    for index, vertex in enumerate(scene.vertices):
        if not np.isfinite(vertex.cov).all():
            continue
        variances, turned = np.linalg.eigh(vertex.cov)
        axes = DEVIATIONS * np.sqrt(np.maximum(variances, 0.0))
        if axes.max() > np.finfo(np.float64).eps * size:  # else it is exact, but for rounding
            turned[:, 0] *= np.sign(np.linalg.det(turned))
            yield index, axes, turned
