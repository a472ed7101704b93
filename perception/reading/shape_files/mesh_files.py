"""Mesh files (PLY, OBJ, OFF, STL, glTF, DAE) as one list of triangles in the file's own frame.

Headers are not trusted: sizes are compared with the file's size before anything is allocated
(mesh_checks.py), nothing is fetched, and no file outside the mesh's own folder is opened.
"""

import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray
from trimesh.resolvers import FilePathResolver

from facetlog.errors import InputError
from facetlog.perception.grouped import Indices
from facetlog.perception.reading.shape_files.coordinate_resolution import check_resolution
from facetlog.perception.reading.shape_files.mesh_checks import (
    DEFAULT_LIMITS,
    Limits,
    NoTrianglesError,
    check_file,
)
from facetlog.perception.reading.shape_files.mesh_text import readable
from facetlog.perception.types import FloatArray

__all__ = ["Limits", "Mesh", "NoTrianglesError", "read_mesh"]

_load_scene: Callable[..., Any] = trimesh.load_scene  # trimesh leaves it half without types

# Coordinates beyond this overflow when they are multiplied three times, as a volume is.
HUGE = 1e75
# glTF 2.0, section 3.4: right-handed, +y is up, metres.
GLTF_UP = (0.0, 1.0, 0.0)
COLLADA_UP = {"X_UP": (1.0, 0.0, 0.0), "Y_UP": (0.0, 1.0, 0.0), "Z_UP": (0.0, 0.0, 1.0)}


@dataclass(frozen=True, eq=False, slots=True)
class Mesh:
    """Triangles (m, 3) of indices into vertices (n, 3), as a file has them, all finite.

    `up` (3,) is the axis and `unit_metres` the length of the unit, both None where the format
    does not say. `left_out` is how many triangles were, and `warnings` say why.
    """

    vertices: FloatArray
    triangles: Indices
    up: FloatArray | None = None
    unit_metres: float | None = None
    name: str = "mesh"
    left_out: int = 0
    warnings: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        vertices: ArrayLike,
        triangles: ArrayLike,
        *,
        name: str = "mesh",
        up: ArrayLike | None = None,
        unit_metres: float | None = None,
    ) -> "Mesh":
        """A mesh of any arrays; triangles with corners that are not finite or missing are dropped.

        Raises InputError where no triangle is left.
        """
        points = np.asarray(vertices, dtype=np.float64).reshape(-1, 3)
        corners = np.asarray(triangles, dtype=np.int64).reshape(-1, 3)
        if not len(corners):
            if len(points):
                raise NoTrianglesError(f"{name}: has no faces; give a mesh, or read it as a cloud")
            raise InputError(f"{name}: holds no triangle; export the mesh again")
        with np.errstate(invalid="ignore"):
            sound: NDArray[np.bool_] = np.all(np.abs(points) < HUGE, axis=1)
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
            (said,) if lost else (),
        )


def read_mesh(path: Path, limits: Limits = DEFAULT_LIMITS) -> Mesh:
    """The mesh of a file, its kind by the suffix; scenes of several parts become one mesh.

    Raises NoTrianglesError where a sound file has no faces (a cloud), InputError where it is
    missing, empty, damaged, beyond the limits, or of another kind.
    """
    claim = check_file(path, limits)
    kind = claim.kind
    try:
        with warnings.catch_warnings():
            # Warnings of readers are either harmless or detected below.
            warnings.simplefilter("ignore")
            if kind == "dae":
                return _read_collada(path, limits)
            mesh = _read_by_trimesh(path, kind, limits)
    except InputError:
        raise
    except MemoryError as exc:
        raise InputError(f"{path.name}: does not fit into memory; reduce the mesh") from exc
    except ImportError as exc:
        # a rare variant: the message of its reader would not help a user
        raise InputError(
            f"{path.name}: is {kind.upper()} in a form that cannot be read here; export the mesh "
            "again, perhaps as PLY"
        ) from exc
    except Exception as exc:  # readers raise any kind of error on a damaged file
        raise InputError(
            f"{path.name}: cannot be read as {kind.upper()}, it is truncated or damaged; "
            "export the mesh again"
        ) from exc
    if len(mesh.triangles) + mesh.left_out < claim.faces:
        raise InputError(
            f"{path.name}: has {len(mesh.triangles)} of {claim.faces} faces; it is truncated"
        )
    check_resolution(mesh.vertices, path.name)
    return mesh


def _read_by_trimesh(path: Path, kind: str, limits: Limits) -> Mesh:
    options: dict[str, object] = {"process": False}
    if kind in ("gltf", "glb", "obj"):
        options["skip_materials"] = True
    if kind == "obj":
        options["group_material"] = False
    resolver = FilePathResolver(str(path))
    resolver.file_name = "mesh"  # it becomes a part's name, which has to be text
    with path.open("rb") as file:
        scene = _load_scene(
            readable(file, path.name, kind),
            file_type=kind,
            resolver=resolver,
            allow_remote=False,
            **options,
        )
    parts = _parts(scene)
    vertices, triangles = _together(parts, path.name, limits)
    gltf = kind in ("gltf", "glb")
    return Mesh.of(
        vertices,
        triangles,
        name=path.name,
        up=GLTF_UP if gltf else None,
        unit_metres=1.0 if gltf else None,
    )


def _parts(scene: Any) -> Iterator[tuple[FloatArray, Indices]]:
    """Every mesh of a scene graph in the scene's frame, each instance by itself."""
    for node in scene.graph.nodes_geometry:
        world_from_part, name = scene.graph[node]
        part = scene.geometry[name]
        if not hasattr(part, "faces"):
            continue  # points and lines have no surface
        vertices = np.asarray(part.vertices, dtype=np.float64)
        triangles = np.asarray(part.faces, dtype=np.int64)
        if not np.array_equal(world_from_part, np.eye(4)):
            vertices = vertices @ world_from_part[:3, :3].T + world_from_part[:3, 3]
            if np.linalg.det(world_from_part[:3, :3]) < 0.0:
                triangles = triangles[:, ::-1]  # a mirror turns the winding round
        yield vertices, triangles


def _together(
    parts: Iterable[tuple[FloatArray, Indices]], name: str, limits: Limits
) -> tuple[FloatArray, Indices]:
    """One list of vertices (n, 3) and triangles (m, 3) of several; refused above the limit."""
    vertices: list[FloatArray] = [np.zeros((0, 3))]
    triangles: list[Indices] = [np.zeros((0, 3), dtype=np.int64)]
    count, start = 0, 0
    for points, corners in parts:
        count += len(corners)
        if count > limits.triangles:
            raise InputError(
                f"{name}: has more than {limits.triangles} triangles; reduce or split the mesh"
            )
        vertices.append(points)
        triangles.append(corners + start)
        start += len(points)
    if len(vertices) == 2:
        return vertices[1], triangles[1]
    return np.concatenate(vertices), np.concatenate(triangles)


def _read_collada(path: Path, limits: Limits) -> Mesh:
    try:
        collada: Any = import_module("collada")
    except ImportError as exc:
        raise InputError(
            f"{path.name}: DAE files need the package pycollada; install it, or convert to glTF"
        ) from exc
    ignored = [
        collada.common.DaeUnsupportedError,
        collada.common.DaeBrokenRefError,
        collada.common.DaeIncompleteError,
    ]
    # Of the file's bytes alone: textures and other files are never opened.
    with path.open("rb") as file:
        document = collada.Collada(file, ignore=ignored)
    if document.scene is None:
        raise NoTrianglesError(f"{path.name}: shows no object; export the mesh with its scene")
    vertices, triangles = _together(_collada_parts(document), path.name, limits)
    return Mesh.of(
        vertices,
        triangles,
        name=path.name,
        up=COLLADA_UP.get(str(document.assetInfo.upaxis)),
        unit_metres=document.assetInfo.unitmeter,
    )


def _collada_parts(document: Any) -> Iterator[tuple[FloatArray, Indices]]:
    for shown in document.scene.objects("geometry"):
        mirrored = np.linalg.det(np.asarray(shown.matrix, dtype=np.float64)[:3, :3]) < 0.0
        for primitive in shown.primitives():
            if hasattr(primitive, "triangleset"):  # polygons of any number of corners
                primitive = primitive.triangleset()
            if type(primitive).__name__ != "BoundTriangleSet" or primitive.vertex is None:
                continue
            triangles = np.asarray(primitive.vertex_index, dtype=np.int64).reshape(-1, 3)
            vertices = np.asarray(primitive.vertex, dtype=np.float64)
            yield vertices, triangles[:, ::-1] if mirrored else triangles
