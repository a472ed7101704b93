"""Whatever file holds a shape as a scene: one reader for each kind of file."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

from facetlog.errors import InputError
from facetlog.perception.reading.poses_file import METRES_PER
from facetlog.perception.reading.shape_files.cloud_files import CLOUD_SUFFIXES, read_cloud
from facetlog.perception.reading.shape_files.mesh_checks import MESH_SUFFIXES, NoTrianglesError
from facetlog.perception.reading.shape_files.mesh_files import read_mesh
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.clouds.cloud_scene import scene_of_cloud
from facetlog.perception.shapes.meshes.mesh_scene import scene_of_mesh
from facetlog.perception.surfaces.scene_file import read_scene

__all__ = [
    "SUFFIXES",
    "ShapeOptions",
    "read_shape",
    "says_itself",
    "shapes_among",
    "unit_from",
    "up_from",
]

UP_AXES: Mapping[str, tuple[float, float, float]] = MappingProxyType(
    {
        "x": (1.0, 0.0, 0.0),
        "y": (0.0, 1.0, 0.0),
        "z": (0.0, 0.0, 1.0),
        "-x": (-1.0, 0.0, 0.0),
        "-y": (0.0, -1.0, 0.0),
        "-z": (0.0, 0.0, -1.0),
    }
)
SCENE_SUFFIX = ".json"
NOT_GIVEN = "none"
FROM_THE_FLOOR = "auto"


@dataclass(frozen=True, slots=True)
class ShapeOptions:
    """What a file of points or triangles does not say itself.

    `up` is a unit vector in the file's axes; without it, and with `find_floor`, up is what the
    format says or what is found from the floor; without either it is unknown. `unit` is that of the
    file's coordinates, a key of METRES_PER; None: what the format says, else unknown, so that only
    ratios of lengths mean something.
    """

    up: tuple[float, float, float] | None = None
    find_floor: bool = False
    unit: str | None = None


def up_from(word: str) -> tuple[float, float, float] | None:
    """The unit vector that a word names; None for `auto` and `none`. InputError for another.

    >>> up_from("-z")
    (0.0, 0.0, -1.0)
    """
    if word in (NOT_GIVEN, FROM_THE_FLOOR):
        return None
    if word not in UP_AXES:
        known = ", ".join((*UP_AXES, FROM_THE_FLOOR, NOT_GIVEN))
        raise InputError(f"up {word!r:.40}: use one of {known}")
    return UP_AXES[word]


def unit_from(word: str) -> str | None:
    """The unit that a word names; None for `none`. InputError for another."""
    if word == NOT_GIVEN:
        return None
    if word not in METRES_PER:
        raise InputError(f"unit {word!r:.40}: use one of {', '.join((*METRES_PER, NOT_GIVEN))}")
    return word


def says_itself(path: str) -> bool:
    """Whether a file says where up is and what its lengths are, so that options do not count."""
    return path.lower().endswith(SCENE_SUFFIX)


def _scene_file(path: Path, _options: ShapeOptions) -> Scene:
    return read_scene(path)  # it says itself where up is and what its lengths are


def _mesh_file(path: Path, options: ShapeOptions) -> Scene:
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
    cloud = read_cloud(path)
    if options.unit is not None:
        unit = METRES_PER[options.unit]
        cloud = replace(
            cloud,
            points=cloud.points * unit,
            seen_from=None if cloud.seen_from is None else cloud.seen_from * unit,
            errors=None if cloud.errors is None else cloud.errors * unit,
        )
    return scene_of_cloud(cloud, up=options.up, metric=options.unit is not None)


_READERS: Mapping[str, Callable[[Path, ShapeOptions], Scene]] = MappingProxyType(
    {
        SCENE_SUFFIX: _scene_file,
        **dict.fromkeys(CLOUD_SUFFIXES, _cloud_file),
        **dict.fromkeys(MESH_SUFFIXES, _mesh_file),
    }
)
SUFFIXES = tuple(_READERS)
"""Of the files that can be read, lower case."""

# Tables and notes are called so as well: read where they are named, but not looked for.
AMBIGUOUS = (".csv", ".txt")
COLMAP_POINTS = ("points3D.bin", "points3D.txt")
# What a run of facetlog, and others, leave beside scenes.
NOT_SCENES = ("run.json", "verdicts.json", "transforms.json", "ground_truth.json")


def shapes_among(names: Collection[str]) -> tuple[str, ...]:
    """Of the names of a folder's files those of shapes, in alphabetical order.

    Of a COLMAP model it is the file of points, the binary one if there are both.

    >>> shapes_among(["b.PLY", "a.json", "run.json", "notes.txt", "points3D.bin", "images.bin"])
    ('a.json', 'b.PLY', 'points3D.bin')
    """
    colmap = [name for name in COLMAP_POINTS if name in names][:1]
    wanted = frozenset(SUFFIXES).difference(AMBIGUOUS)
    found = (n for n in names if Path(n).suffix.lower() in wanted and n not in NOT_SCENES)
    return tuple(sorted((*found, *colmap)))


def read_shape(path: Path, options: ShapeOptions) -> Scene:
    """The scene that a file, or the folder of a COLMAP model, holds; its suffix says the kind.

    A scene of facetlog says itself where up is and whether it is metric; `options` are for the
    others, and go before what a file says. Lengths are metres wherever the unit is known. Raises
    InputError for a file that cannot be read or holds no shape.
    """
    colmap = path.is_dir() or path.name in COLMAP_POINTS
    reader = _cloud_file if colmap else _READERS.get(path.suffix.lower())
    if reader is None:
        kinds = ", ".join(SUFFIXES)
        raise InputError(
            f"{path}: {path.suffix or 'no suffix'}: files that can be read are {kinds}"
        )
    scene = reader(path, options)
    if options.up is None and not options.find_floor and not says_itself(str(path)):
        return replace(scene, up=None)
    return scene
