"""A block as a mesh, files of it, and what tests measure of the meshes that are read."""

from pathlib import Path

import numpy as np
import trimesh

from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh, read_mesh
from facetlog.perception.types import FloatArray

SIDES = (3.0, 2.0, 1.0)
AREA = 22.0


def block() -> trimesh.Trimesh:
    """A block of SIDES, of 12 triangles."""
    return trimesh.creation.box(SIDES)


def write(folder: Path, name: str, content: bytes | str) -> Path:
    """Write a file and return its path."""
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def read(folder: Path, name: str, content: bytes | str) -> Mesh:
    """Return the mesh of a file with this content."""
    return read_mesh(write(folder, name, content))


def area_vectors(mesh: Mesh) -> FloatArray:
    """Return the normals (m, 3) of the triangles, as long as their areas."""
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    return np.asarray(0.5 * np.cross(b - a, c - a))


def area(mesh: Mesh) -> float:
    """Return the total area."""
    return float(np.linalg.norm(area_vectors(mesh), axis=1).sum())


def volume(mesh: Mesh) -> float:
    """Return the volume of a closed mesh; negative where it is inside out."""
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6.0)


def extent(mesh: Mesh) -> FloatArray:
    """Return the lowest and highest coordinates (6,) of the vertices that triangles use."""
    used = mesh.vertices[np.unique(mesh.triangles)]
    return np.concatenate((used.min(axis=0), used.max(axis=0)))
