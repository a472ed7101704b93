"""Scenes with cameras round them, and what their edges are in each view, by their faces."""

from dataclasses import replace

import numpy as np

from facetlog.perception.facts.part_facts import find_flat_edges
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.visible_lines import visible_lines
from facetlog.perception.types import Camera, FloatArray, Pose

CAMERA = Camera(640, 480, 600.0, 600.0, 319.5, 239.5)


def looking(centre: FloatArray, target: FloatArray) -> Pose:
    """Upright, with the target in the middle of the picture."""
    z = (target - centre) / np.linalg.norm(target - centre)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return Pose(np.column_stack([x, np.cross(z, x), z]), centre)


def viewed(scene: Scene, views: int, *, distance: float = 2.6, height: float = 0.83) -> Scene:
    """The scene seen from all round, at so many times its own size."""
    middle = scene.points.mean(axis=0)
    size = np.linalg.norm(scene.points - middle, axis=1).max()
    turns = 0.47 + np.arange(views) * 2 * np.pi / views
    around = [np.array([np.cos(t), np.sin(t), height]) for t in turns]
    return replace(
        scene,
        views=tuple(f"picture {i}" for i in range(views)),
        poses=tuple(looking(middle + distance * size * a, middle) for a in around),
        cameras=(CAMERA,) * views,
    )


def find_true_labels(scene: Scene) -> dict[str, dict[str, str]]:
    """Label each edge that a view shows, by the two faces that have it as a side.

    One that only one visible face has is occluding; two that both are seen are convex where each
    lies behind the other's plane.
    """
    memo = SceneMemo.of(scene)
    faces_of: dict[int, list[int]] = {}
    for edge, face in memo.bounds.tolist():
        faces_of.setdefault(edge, []).append(face)
    found: dict[str, dict[str, str]] = {}
    for i, (camera, pose) in enumerate(zip(scene.cameras, scene.poses, strict=True), 1):
        shown = visible_lines(
            memo.table, memo.edges, memo.bounds, find_flat_edges(memo), camera, pose
        )
        words = {}
        for edge in set(shown.edge.tolist()):
            seen = [
                scene.faces[f]
                for f in faces_of[edge]
                if scene.faces[f].plane.distance(pose.centre) > 0
            ]
            if len(seen) == 1:
                words[f"e{edge + 1}"] = "occluding"
                continue
            one, two = seen
            middle = scene.points[list(two.outline)].mean(axis=0)
            words[f"e{edge + 1}"] = "convex" if one.plane.distance(middle) < 0 else "concave"
        found[f"view{i}"] = words
    return found
