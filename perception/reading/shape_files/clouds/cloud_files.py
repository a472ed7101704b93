"""Point cloud files (PLY, PCD, LAS/LAZ, text) and COLMAP models as clouds.

Headers are not trusted: their counts are compared with the file's size before allocating anything.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.clouds.colmap_model import (
    find_colmap_model,
    read_colmap,
)
from facetlog.perception.reading.shape_files.clouds.las_points import las_points
from facetlog.perception.reading.shape_files.clouds.pcd_points import read_pcd_points
from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.reading.shape_files.clouds.point_table import NORMALS, PLACE
from facetlog.perception.reading.shape_files.clouds.text_points import points_from_text
from facetlog.perception.reading.shape_files.coordinate_resolution import (
    check_degrees,
    check_resolution,
)
from facetlog.perception.reading.shape_files.ply_rows import parse_ply_header, read_ply_rows
from facetlog.perception.reading.shape_files.suffixes import CLOUD_SUFFIXES

__all__ = ["DEFAULT_LIMITS", "CloudLimits", "read_cloud"]

# A laser scan of a building; the arrays of so many points take 2.4 GB.
MOST_POINTS = 50_000_000
MOST_BYTES = 4 << 30


@dataclass(frozen=True, slots=True)
class CloudLimits:
    """What is refused: files of more `size_bytes`, clouds of more `points`."""

    size_bytes: int = MOST_BYTES
    points: int = MOST_POINTS


DEFAULT_LIMITS = CloudLimits()


def read_cloud(path: Path, limits: CloudLimits = DEFAULT_LIMITS) -> Cloud:
    """The cloud of a file, its kind by the suffix, or of a folder with a COLMAP model.

    Raises InputError where it is missing, empty, damaged, beyond the limits, or of another kind.
    """
    try:
        if path.is_dir():
            model = find_colmap_model(path)
            if model is None:
                raise InputError(
                    f"{path}: has no points3D.bin or points3D.txt of a COLMAP model; "
                    "of pictures facetlog recognize makes a scene"
                )
            return read_colmap(model, limits.points)
        kind = path.suffix.lower()
        if path.name in ("points3D.bin", "points3D.txt"):
            return read_colmap(path.parent, limits.points)
        if kind not in _READERS:
            raise InputError(
                f"{path.name}: is no point cloud; give one of {', '.join(CLOUD_SUFFIXES)}, "
                "or the folder of a COLMAP model"
            )
        size = path.stat().st_size
        if not path.is_file():
            raise InputError(f"{path.name}: is no file; give a point cloud")
        if size == 0:
            raise InputError(f"{path.name}: is empty; export the cloud again")
        if size > limits.size_bytes:
            raise InputError(
                f"{path.name}: has {size} bytes, more than {limits.size_bytes}; thin the cloud"
            )
        cloud = _READERS[kind](path, limits)
    except MemoryError as exc:
        raise InputError(f"{path.name}: does not fit into memory; thin the cloud") from exc
    except OSError as exc:
        raise InputError(f"{path.name}: cannot be read ({exc.strerror}); check the path") from exc
    check_resolution(cloud.points, path.name)
    check_degrees(cloud.points, path.name)
    return cloud


def _read_ply(path: Path, limits: CloudLimits) -> Cloud:
    name = path.name
    header = parse_ply_header(path.read_bytes(), name)
    count = header.count("vertex")
    if count > limits.points:
        raise InputError(f"{name}: has {count} points, more than {limits.points}; thin the cloud")
    rows, said = read_ply_rows(header, name)
    if "vertex" not in rows:
        raise InputError(f"{name}: has no vertices; export the cloud again")
    points = rows["vertex"].stack_numbers(PLACE)
    if points is None:
        raise InputError(f"{name}: its points have no x, y and z; export the cloud again")
    normals = (rows["vertex"].stack_numbers(names) for names in NORMALS)
    cloud = Cloud.of(points, normals=next((n for n in normals if n is not None), None), name=name)
    return replace(cloud, warnings=(*said, *cloud.warnings))


def _read_pcd(path: Path, limits: CloudLimits) -> Cloud:
    with path.open("rb") as file:
        table, viewpoint = read_pcd_points(file, path.name, limits.points)
    count = len(table.points)
    return Cloud.of(
        table.points,
        normals=table.normals,
        name=path.name,
        seen_from=None if viewpoint.camera is None else np.tile(viewpoint.camera, (count, 1)),
        sensor_places=viewpoint.places,
        world_axes=viewpoint.world_axes,
    )


def _read_las(path: Path, limits: CloudLimits) -> Cloud:
    points, said = las_points(path, limits.points)
    cloud = Cloud.of(points, name=path.name)
    return replace(cloud, warnings=(*said, *cloud.warnings))


def _read_text(path: Path, limits: CloudLimits) -> Cloud:
    table = points_from_text(path.name, path.read_bytes(), limits.points)
    cloud = Cloud.of(table.points, normals=table.normals, name=path.name)
    return replace(cloud, warnings=(*table.warnings, *cloud.warnings))


_READERS: dict[str, Callable[[Path, CloudLimits], Cloud]] = {
    ".csv": _read_text,
    ".las": _read_las,
    ".laz": _read_las,
    ".pcd": _read_pcd,
    ".ply": _read_ply,
    ".pts": _read_text,
    ".txt": _read_text,
    ".xyz": _read_text,
}
