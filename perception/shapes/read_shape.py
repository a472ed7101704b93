"""Reads any kind of shape file as a scene: one reader for each kind."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.length_units import METRES_PER
from facetlog.perception.reading.shape_files.mesh_checks import NoTrianglesError
from facetlog.perception.reading.shape_files.suffixes import CLOUD_SUFFIXES, MESH_SUFFIXES
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.shape_options import (
    COLMAP_POINTS,
    SCENE_SUFFIX,
    SUFFIXES,
    ShapeOptions,
    says_itself,
)
from facetlog.perception.surfaces.scaled_scene import in_metres
from facetlog.perception.surfaces.scene_file import read_scene

__all__ = ["ShapeOptions", "read_shape", "read_stated", "stated"]

# What makes scenes of meshes and clouds takes half a second to load: scenes do without.


def _scene_file(path: Path, _options: ShapeOptions) -> Scene:
    return read_scene(path)  # it states its own up and unit


def _mesh_file(path: Path, options: ShapeOptions) -> Scene:
    from facetlog.perception.reading.shape_files.mesh_files import read_mesh
    from facetlog.perception.shapes.meshes.mesh_scene import scene_of_mesh

    try:
        mesh = read_mesh(path)
    except NoTrianglesError:
        if path.suffix.lower() not in CLOUD_SUFFIXES:
            raise
        return _cloud_file(path, options)  # a PLY of points alone
    unit = METRES_PER[options.unit] if options.unit else mesh.unit_metres
    if unit is not None:
        mesh = replace(mesh, vertices=mesh.vertices * unit, unit_metres=1.0)
    return scene_of_mesh(mesh, up=options.up, metric=unit is not None)


def _cloud_file(path: Path, options: ShapeOptions) -> Scene:
    from facetlog.perception.reading.shape_files.cloud_files import read_cloud
    from facetlog.perception.shapes.clouds.cloud_scene import scene_of_cloud

    cloud = read_cloud(path)
    if options.sensor is not None:
        cloud = replace(cloud, seen_from=np.tile(options.sensor, (len(cloud.points), 1)))
    if options.unit is not None:
        unit = METRES_PER[options.unit]
        cloud = replace(
            cloud,
            points=cloud.points * unit,
            seen_from=None if cloud.seen_from is None else cloud.seen_from * unit,
            errors=None if cloud.errors is None else cloud.errors * unit,
            sensor_places=None if cloud.sensor_places is None else cloud.sensor_places * unit,
        )
    return scene_of_cloud(cloud, up=options.up, metric=options.unit is not None)


_READERS: Mapping[str, Callable[[Path, ShapeOptions], Scene]] = MappingProxyType(
    {
        SCENE_SUFFIX: _scene_file,
        **dict.fromkeys(CLOUD_SUFFIXES, _cloud_file),
        **dict.fromkeys(MESH_SUFFIXES, _mesh_file),
    }
)


def read_stated(path: Path, options: ShapeOptions) -> Scene:
    """As read_shape, save that options are those of scene files, too (`stated`)."""
    scene = read_shape(path, options)
    return stated(scene, options) if says_itself(str(path)) else scene


def stated(scene: Scene, options: ShapeOptions) -> Scene:
    """The scene with the up that is given, unknown without it and without `find_floor`; in metres
    by the unit that is given where its own is unknown.

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
    """The scene in a file, or in the folder of a COLMAP model; the suffix decides the kind.

    A scene of facetlog states its own up and whether it is metric; for the others `options`
    override what a file states. Lengths are metres wherever the unit is known. Raises InputError
    for a file that cannot be read or has no shape.
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
    if options.up is None and not options.find_floor and not says_itself(str(path)):
        return replace(scene, up=None)
    return scene
