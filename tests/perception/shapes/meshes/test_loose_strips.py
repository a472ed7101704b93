"""Meshes with thousands of loose slivers: what stands among them is found, and it is said."""

import numpy as np
import pytest
import trimesh

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.meshes import mesh_scene
from facetlog.perception.shapes.meshes.clean_mesh import clean_mesh
from facetlog.perception.shapes.meshes.mesh_scene import (
    MANY_PARTS,
    drop_loose_strips,
    make_mesh_scene,
)

UP = np.array([0.0, 0.0, 1.0])
BLOCK = trimesh.creation.box((2.0, 1.0, 1.0))


def _among_slivers(count: int, width: float, length: float = 0.02) -> Mesh:
    """A block, and triangles of a length and a width at random places about it."""
    rng = np.random.default_rng(4)
    places = rng.uniform(-1.0, 1.0, (count, 3))
    along = rng.normal(size=(count, 3))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(along, rng.normal(size=(count, 3)))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    loose = np.stack(
        [places, places + length * along, places + 0.5 * length * along + width * across], axis=1
    )
    triangles = len(BLOCK.vertices) + np.arange(3 * count).reshape(-1, 3)
    return Mesh.of(
        np.concatenate((BLOCK.vertices, loose.reshape(-1, 3))),
        np.concatenate((BLOCK.faces, triangles)),
        name="dirty.ply",
    )


def _scene(mesh: Mesh) -> Scene:
    return make_mesh_scene(mesh, up=UP, metric=True)


def test_a_block_among_thousands_of_slivers_is_a_block() -> None:
    scene = _scene(_among_slivers(20_000, 1e-4))
    assert len(scene.faces) == 6
    (line,) = scene.warnings
    assert line == (
        "20,000 loose parts narrower than 0.5% of the mesh were left out, 0.2% of its surface"
    )


def test_wide_loose_triangles_are_kept_until_they_are_too_many() -> None:
    kept = drop_loose_strips(clean_mesh(_among_slivers(MANY_PARTS + 10, 0.1, 0.4)))
    assert len(kept.triangles) == MANY_PARTS + 10 + 12
    with pytest.raises(InputError, match=r"dirty.ply: falls into 10,011 parts that share no"):
        _scene(_among_slivers(10_010, 0.1, 0.4))


def test_more_long_thin_triangles_than_can_be_looked_at_are_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    angles = np.linspace(0.0, 1.0, 3_000)
    rim = np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])
    fan = [[0, k, k + 1] for k in range(1, len(rim))]
    mesh = Mesh.of(np.vstack([np.zeros(3), rim]), fan, name="fan.ply")
    assert _scene(mesh).faces
    monkeypatch.setattr(mesh_scene, "MOST_SAMPLES", 100_000)
    with pytest.raises(InputError, match=r"fan.ply: its 2,999 triangles are too long and thin"):
        _scene(mesh)
