"""Meshes of known solids, and their scenes."""

import numpy as np
import trimesh

from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.meshes.mesh_scene import make_mesh_scene

__all__ = ["Point", "block", "scene_of", "table", "together"]

Point = tuple[float, float, float]


def block(low: Point, high: Point) -> trimesh.Trimesh:
    return trimesh.creation.box(bounds=np.array([low, high]))


def together(*parts: trimesh.Trimesh) -> trimesh.Trimesh:
    return trimesh.util.concatenate(parts)


def table(x: float = 0.0, y: float = 0.0, overlap: float = 0.0) -> trimesh.Trimesh:
    """Five boxes, 1.2 × 0.8 × 0.74 m from (x, y); the legs reach `overlap` into the top."""
    legs = [
        block((x + a, y + b, 0.0), (x + a + 0.06, y + b + 0.06, 0.7 + overlap))
        for a in (0.05, 1.09)
        for b in (0.05, 0.69)
    ]
    return together(block((x, y, 0.7), (x + 1.2, y + 0.8, 0.74)), *legs)


def scene_of(made: trimesh.Trimesh, up: object = (0, 0, 1), *, metric: bool = True) -> Scene:
    return make_mesh_scene(Mesh.of(made.vertices, made.faces), up=np.asarray(up), metric=metric)
