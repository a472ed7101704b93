"""Mesh files (PLY, OBJ, OFF, STL, glTF, DAE) as one list of triangles in the file's own frame.

Headers are not trusted, nothing is fetched, and no file outside the mesh's own folder is opened.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from pkgutil import resolve_name

import numpy as np
from numpy.typing import ArrayLike

from facetlog.errors import InputError
from facetlog.perception.ragged import Indices
from facetlog.perception.reading.shape_files.coordinate_resolution import check_resolution
from facetlog.perception.reading.shape_files.meshes.mesh_checks import (
    NoTrianglesError,
    TriangleList,
)
from facetlog.perception.reading.shape_files.meshes.polygons import is_sound
from facetlog.perception.reading.shape_files.shape_file import DEFAULT_LIMITS, Limits, ShapeFile
from facetlog.perception.reading.shape_files.suffixes import MESH_READERS
from facetlog.perception.types import FloatArray

_Reader = Callable[[bytes, ShapeFile], TriangleList]


@dataclass(frozen=True, eq=False, slots=True)
class Mesh:
    """Triangles (m, 3) of indices into vertices (n, 3), as a file has them, all finite.

    `up` (3,) is the axis and `unit_metres` the length of the unit, both None where the format
    does not say. Vertices were rounded to multiples of `step`, 0 where it is not known.
    `left_out` is how many triangles were, and `warnings` say why.
    """

    vertices: FloatArray
    triangles: Indices
    up: FloatArray | None = None
    unit_metres: float | None = None
    name: str = "mesh"
    left_out: int = 0
    warnings: tuple[str, ...] = ()
    step: float = 0.0

    @classmethod
    def of(
        cls,
        vertices: ArrayLike,
        triangles: ArrayLike,
        *,
        name: str = "mesh",
        up: ArrayLike | None = None,
        unit_metres: float | None = None,
        warnings: tuple[str, ...] = (),
        step: float = 0.0,
    ) -> "Mesh":
        """Make a mesh of any arrays; triangles with corners that are not finite or missing are
        dropped.

        Raise InputError where no triangle is left.
        """
        points = np.asarray(vertices, dtype=np.float64).reshape(-1, 3)
        corners = np.asarray(triangles, dtype=np.int64).reshape(-1, 3)
        if not len(corners):
            if len(points):
                raise NoTrianglesError(f"{name}: has no faces; give a mesh, or read it as a cloud")
            raise InputError(f"{name}: holds no triangle; export the mesh again")
        sound = is_sound(points)
        there = (corners >= 0) & (corners < len(points))
        known = np.flatnonzero((there & sound[np.where(there, corners, 0)]).all(axis=1))
        lost = len(corners) - len(known)
        if lost == len(corners):
            raise InputError(f"{name}: no triangle has three finite corners; export the mesh again")
        said = (
            f"{lost} of {len(corners)} triangles left out: corners that are missing or not finite"
        )
        return cls(
            np.where(sound[:, None], points, 0.0),
            corners[known] if lost else corners,
            None if up is None else np.asarray(up, dtype=np.float64),
            unit_metres,
            name,
            lost,
            (*warnings, said) if lost else warnings,
            step,
        )


def read_mesh(path: Path, limits: Limits = DEFAULT_LIMITS) -> Mesh:
    """Return the mesh of a file, its kind by the suffix; scenes of several parts become one mesh.

    Raise NoTrianglesError where a sound file has no faces (a cloud), InputError where it is
    missing, empty, damaged, beyond the limits, or of another kind.
    """
    shape, suffix = ShapeFile(path, "mesh", limits), path.suffix.lower()
    if suffix not in MESH_READERS:
        raise shape.error(f"is no mesh file; give one of {', '.join(MESH_READERS)}")
    reader: _Reader = resolve_name(f"{__package__}.{MESH_READERS[suffix]}")
    try:
        # what is not finite is left out below
        with shape.translate_errors(), np.errstate(all="ignore"):
            shape.check_size()
            found = reader(path.read_bytes(), shape)
            mesh = Mesh.of(
                found.vertices,
                found.triangles,
                name=shape.name,
                up=found.up,
                unit_metres=found.unit_metres,
                warnings=found.warnings,
                step=found.step,
            )
    except (ArithmeticError, LookupError, TypeError, ValueError) as exc:
        raise shape.error(
            f"cannot be read as {suffix[1:].upper()} ({exc!r:.80}); it is damaged: export it again"
        ) from exc
    check_resolution(mesh.vertices, shape.name)
    return mesh
