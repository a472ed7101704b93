"""A mesh of one's own as a form: what samples are stretched and turned from."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.meshes.mesh_scene import make_mesh_scene
from facetlog.perception.shapes.read_shape import ShapeOptions, read_stated_mesh
from facetlog.perception.surfaces.exact_solids.polyhedra import UP

NAMES = ("length", "depth", "height")


@dataclass(frozen=True, eq=False, slots=True)
class MeshForm:
    """A mesh with z up, its extents free along three axes."""

    mesh: Mesh

    @property
    def grows(self) -> bool:
        """Whether more parts can be added: its parts are not known here."""
        return False

    @property
    def name(self) -> str:
        """The name of its mesh."""
        return self.mesh.name

    @property
    def sizes(self) -> Mapping[str, float]:
        """Its own extents."""
        return dict(zip(NAMES, np.ptp(self.mesh.vertices, axis=0).tolist(), strict=True))

    def scene(self, sizes: Mapping[str, float]) -> Scene:
        """Return the mesh stretched to these extents."""
        factors = np.array([sizes[name] / own for name, own in self.sizes.items()])
        mesh = replace(self.mesh, vertices=self.mesh.vertices * factors)
        return make_mesh_scene(mesh, up=UP, metric=mesh.unit_metres is not None)

    def described(self, sizes: Mapping[str, float]) -> str:
        """Return the name and the extents."""
        return f"{self.name}: {', '.join(f'{n} {100.0 * sizes[n]:.3g} cm' for n in NAMES)}"


def read_mesh_form(path: Path, options: ShapeOptions) -> MeshForm:
    """Return the mesh of a file with z up; raise InputError if its up is not known, or it is
    flat.
    """
    mesh = read_stated_mesh(path, options)
    if mesh.up is None:
        raise InputError(f"{path}: which way is up is not known: give --up, as --up z")
    up = mesh.up / np.linalg.norm(mesh.up)
    along = np.eye(3)[np.abs(up).argmin()]
    across = np.cross(up, along)
    across /= np.linalg.norm(across)
    vertices = mesh.vertices @ np.array([np.cross(across, up), across, up]).T
    if not np.ptp(vertices, axis=0).all():
        raise InputError(f"{path}: the mesh lies in a plane: samples are made of solids")
    return MeshForm(replace(mesh, vertices=vertices, up=np.array(UP)))
