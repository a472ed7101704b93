"""Point cloud files (PLY, PCD, LAS/LAZ, text) and COLMAP models as clouds.

Headers are not trusted: their counts are compared with the file's size before allocating anything.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from pkgutil import resolve_name

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.clouds.colmap_model import (
    find_colmap_model,
    read_colmap,
)
from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.reading.shape_files.clouds.point_table import NORMALS, PLACE
from facetlog.perception.reading.shape_files.coordinate_resolution import (
    check_degrees,
    check_resolution,
)
from facetlog.perception.reading.shape_files.ply_rows import parse_ply_header, read_ply_rows
from facetlog.perception.reading.shape_files.shape_file import DEFAULT_LIMITS, Limits, ShapeFile
from facetlog.perception.reading.shape_files.suffixes import CLOUD_READERS

_Reader = Callable[[ShapeFile], Cloud]


def read_cloud(path: Path, limits: Limits = DEFAULT_LIMITS) -> Cloud:
    """Return the cloud of a file, its kind by the suffix, or of a folder with a COLMAP model.

    Raise InputError where it is missing, empty, damaged, beyond the limits, or of another kind.
    """
    shape = ShapeFile(path, "cloud", limits)
    suffix = path.suffix.lower()
    with shape.translate_errors():
        if path.is_dir():
            model = find_colmap_model(path)
            if model is None:
                raise InputError(
                    f"{path}: has no points3D.bin or points3D.txt of a COLMAP model; "
                    "of pictures facetlog recognize makes a scene"
                )
            return read_colmap(model, limits.points)
        if path.name in ("points3D.bin", "points3D.txt"):
            return read_colmap(path.parent, limits.points)
        if suffix not in CLOUD_READERS:
            raise shape.error(
                f"is no point cloud; give one of {', '.join(CLOUD_READERS)}, "
                "or the folder of a COLMAP model"
            )
        shape.check_size()
        reader: _Reader = resolve_name(f"{__package__}.{CLOUD_READERS[suffix]}")
        cloud = reader(shape)
    check_resolution(cloud.points, path.name)
    check_degrees(cloud.points, path.name)
    return cloud


def read_ply(shape: ShapeFile) -> Cloud:
    """Return the cloud of a PLY file."""
    header = parse_ply_header(shape.path.read_bytes(), shape)
    shape.check_points(header.count("vertex"))
    rows, said = read_ply_rows(header, shape)
    if "vertex" not in rows:
        raise shape.error("has no vertices; export the cloud again")
    points = rows["vertex"].stack_numbers(PLACE)
    if points is None:
        raise shape.error("its points have no x, y and z; export the cloud again")
    found = (rows["vertex"].stack_numbers(names) for names in NORMALS)
    normals = next((n for n in found if n is not None), None)
    cloud = Cloud.of(points, normals=normals, name=shape.name)
    return replace(cloud, warnings=(*said, *cloud.warnings))
