"""Reads any kind of shape file as a scene: one reader for each kind."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.length_units import METRES_PER
from facetlog.perception.reading.shape_files.suffixes import CLOUD_SUFFIXES, MESH_SUFFIXES
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.shape_options import (
    COLMAP_POINTS,
    SCENE_SUFFIX,
    SUFFIXES,
    UP_AXES,
    ShapeOptions,
    is_scene_file,
)
from facetlog.perception.surfaces.scaled_scene import in_metres
from facetlog.perception.surfaces.scene_file import read_scene
from facetlog.perception.types import FloatArray

if TYPE_CHECKING:
    from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh

__all__ = ["ShapeOptions", "read_shape", "read_stated", "read_stated_mesh", "stated"]

# Up axes whose components differ by less are the same.
UP_TIE = 1e-6
# Objects of models are cartons to buildings, in metres: what is smaller than a die or larger than a
# bus is read in another unit than it was drawn in.
LEAST_SIZE, MOST_SIZE = 0.02, 20.0

# What makes scenes of meshes and clouds takes half a second to load: scenes do without.


def _scene_file(path: Path, _options: ShapeOptions) -> Scene:
    return read_scene(path)  # it states its own up and unit


def _mesh_file(path: Path, options: ShapeOptions) -> Scene:
    from facetlog.perception.reading.shape_files.meshes.mesh_checks import NoTrianglesError
    from facetlog.perception.shapes.meshes.mesh_scene import make_mesh_scene

    try:
        mesh = read_stated_mesh(path, options)
    except NoTrianglesError:
        if path.suffix.lower() not in CLOUD_SUFFIXES:
            raise
        return _cloud_file(path, options)  # a PLY of points alone
    metric = mesh.unit_metres is not None
    return make_mesh_scene(mesh, up=mesh.up, metric=metric, solid_parts=options.solid_parts)


def read_stated_mesh(path: Path, options: ShapeOptions) -> "Mesh":
    """Return the mesh in a file with the up that it or the options state; in metres where either
    states the unit. Raise InputError as `read_shape`.
    """
    from facetlog.perception.reading.shape_files.meshes.mesh_files import read_mesh

    mesh, options = _apply_stated_options(read_mesh(path), options)
    up = mesh.up if options.up is None else np.array(options.up)
    unit = METRES_PER[options.unit] if options.unit else mesh.unit_metres
    if unit is None:
        return replace(mesh, up=up)
    vertices = mesh.vertices * unit
    return replace(mesh, up=up, vertices=vertices, unit_metres=1.0, step=mesh.step * unit)


def _apply_stated_options(mesh: "Mesh", options: ShapeOptions) -> "tuple[Mesh, ShapeOptions]":
    """Return the options without up and unit where the file states its own, and the mesh with a
    warning where these differ.
    """
    if options.override:
        return mesh, options
    ignored = []
    if options.up is not None and mesh.up is not None:
        if not np.allclose(mesh.up, options.up, atol=UP_TIE):
            ignored.append(f"up ({_axis(mesh.up)})")
        options = replace(options, up=None, find_floor=True)
    if options.unit is not None and mesh.unit_metres is not None:
        if not np.isclose(mesh.unit_metres, METRES_PER[options.unit]):
            ignored.append(f"the unit ({mesh.unit_metres:g} m)")
        options = replace(options, unit=None)
    if not ignored:
        return mesh, options
    line = (
        f"the file states {' and '.join(ignored)}, which goes before the options; with "
        "--override-file these go before what it states"
    )
    return replace(mesh, warnings=(*mesh.warnings, line)), options


def _axis(up: FloatArray) -> str:
    """Return the name of an axis, or its three numbers."""
    named = (name for name, axis in UP_AXES.items() if np.allclose(up, axis, atol=UP_TIE))
    return next(named, ",".join(f"{x:.4g}" for x in up))


def _cloud_file(path: Path, options: ShapeOptions) -> Scene:
    from facetlog.perception.reading.shape_files.clouds.cloud_files import read_cloud
    from facetlog.perception.shapes.clouds.cloud_scene import make_cloud_scene

    cloud = read_cloud(path)
    if options.sensor is not None:
        seen_from = np.tile(options.sensor, (len(cloud.points), 1))
        cloud = replace(cloud, seen_from=seen_from, sensor_places=None)
    if options.unit is not None:
        unit = METRES_PER[options.unit]
        cloud = replace(
            cloud,
            points=cloud.points * unit,
            seen_from=None if cloud.seen_from is None else cloud.seen_from * unit,
            errors=None if cloud.errors is None else cloud.errors * unit,
            sensor_places=None if cloud.sensor_places is None else cloud.sensor_places * unit,
        )
    return make_cloud_scene(cloud, up=options.up, metric=options.unit is not None)


_READERS: Mapping[str, Callable[[Path, ShapeOptions], Scene]] = MappingProxyType(
    {
        SCENE_SUFFIX: _scene_file,
        **dict.fromkeys(CLOUD_SUFFIXES, _cloud_file),
        **dict.fromkeys(MESH_SUFFIXES, _mesh_file),
    }
)


def read_stated(path: Path, options: ShapeOptions) -> Scene:
    """Read a shape as read_shape does, with the options applied to scene files, too (`stated`)."""
    scene = read_shape(path, options)
    return stated(scene, options) if is_scene_file(str(path)) else scene


def stated(scene: Scene, options: ShapeOptions) -> Scene:
    """Return the scene with the up that is given, unknown without it and without `find_floor`; in
    metres by the unit that is given where its own is unknown.

    InputError for another unit than metres where lengths are metres already.
    """
    if options.up is not None:
        scene = replace(scene, up=np.array(options.up))
    elif not options.find_floor:
        scene = replace(scene, up=None)
    if options.unit is None or (scene.metric and options.unit == "m"):
        return scene
    if scene.metric:
        raise InputError(f"{scene.name}: lengths are metres already, not {options.unit}")
    return in_metres(scene, METRES_PER[options.unit])


def read_shape(path: Path, options: ShapeOptions) -> Scene:
    """Return the scene in a file, or in the folder of a COLMAP model; the suffix decides the kind.

    A scene of facetlog states its own up and whether it is metric; for the others `options` say
    what the file does not, or override it. Lengths are metres wherever the unit is known. Raises
    InputError for a file that cannot be read or has no shape.
    """
    colmap = path.is_dir() or path.name in COLMAP_POINTS
    reader = _cloud_file if colmap else _READERS.get(path.suffix.lower())
    if reader is None:
        from facetlog.perception.reading.picture_file import PICTURE_SUFFIXES

        if path.suffix.lower() in PICTURE_SUFFIXES:
            raise InputError(
                f"{path} is a picture: facetlog recognize takes a folder of them, on a printed mat "
                "(facetlog mat), of what has texture, or with their poses"
            )
        kinds = ", ".join(SUFFIXES)
        raise InputError(
            f"{path}: {path.suffix or 'no suffix'}: files that can be read are {kinds}"
        )
    scene = reader(path, options)
    if is_scene_file(str(path)):
        return scene
    if options.up is None and not options.find_floor:
        scene = replace(scene, up=None)
    return replace(scene, warnings=(*scene.warnings, *_warn_of_unit(scene)))


def _warn_of_unit(scene: Scene) -> tuple[str, ...]:
    """Return a warning where no object is as large as furniture or a house: the unit may be
    another.
    """
    if not scene.metric or not scene.faces:
        return ()
    parts = [{i for face in body.faces for i in scene.faces[face].outline} for body in scene.bodies]
    sizes = [
        float(np.linalg.norm(np.ptp(scene.points[sorted(part)], axis=0))) for part in parts if part
    ]
    if not sizes or any(LEAST_SIZE <= size <= MOST_SIZE for size in sizes):
        return ()
    return (
        f"its largest object is {max(sizes):,.4g} m across, none is {LEAST_SIZE:g} to "
        f"{MOST_SIZE:g} m: is the unit right? State that of its numbers with --unit (and "
        "--override-file, if the file states another)",
    )
