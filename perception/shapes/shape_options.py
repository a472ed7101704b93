"""Options for reading shape files, and which files hold shapes."""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from facetlog.errors import InputError
from facetlog.perception.length_units import METRES_PER
from facetlog.perception.reading.shape_files.suffixes import CLOUD_SUFFIXES, MESH_SUFFIXES

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
SUFFIXES = tuple(dict.fromkeys((SCENE_SUFFIX, *CLOUD_SUFFIXES, *MESH_SUFFIXES)))
"""Suffixes of the files that can be read, lower case."""

# Tables and notes have these suffixes as well: read where they are named, but not searched for.
AMBIGUOUS = (".csv", ".txt")
COLMAP_POINTS = ("points3D.bin", "points3D.txt")
# What a run of facetlog, and others, leave beside scenes.
NOT_SCENES = ("run.json", "verdicts.json", "transforms.json", "ground_truth.json")

NOT_GIVEN = "none"
"""The word for an option that says nothing."""
FROM_THE_FLOOR = "auto"


@dataclass(frozen=True, slots=True)
class ShapeOptions:
    """Up, unit and sensor for files of points or triangles.

    `up` is a unit vector in the file's axes; without it, and with `find_floor`, up is what the
    format states or what is found from the floor; without either it is unknown. `unit` is that of
    the file's coordinates, a key of METRES_PER; None: what the format states, else unknown, so that
    only ratios of lengths mean something. What a file states goes before both, unless `override`
    is set. `sensor` is the place, in the file's axes and unit, from which all points of a cloud
    were seen; without it, what the file states. Without `solid_parts` those of a mesh, which take
    as long as all else, are left out: few models ask for them.
    """

    up: tuple[float, float, float] | None = None
    find_floor: bool = False
    unit: str | None = None
    sensor: tuple[float, float, float] | None = None
    override: bool = False
    solid_parts: bool = True


def parse_up(word: str, option: str = "--up") -> tuple[float, float, float] | None:
    """Return the unit vector that a word names, or three numbers of any length; None for `auto` and
    `none`. InputError for another, which names the option.

    >>> parse_up("-z"), parse_up("0,0,2")
    ((0.0, 0.0, -1.0), (0.0, 0.0, 1.0))
    """
    if word in (NOT_GIVEN, FROM_THE_FLOOR):
        return None
    if "," in word:
        x, y, z = _three(word)
        length = math.hypot(x, y, z)
        if not 0.0 < length < math.inf:
            raise InputError(f"{option} {word!r:.40}: give three numbers x,y,z that are not all 0")
        return x / length, y / length, z / length
    if word not in UP_AXES:
        known = ", ".join((*UP_AXES, FROM_THE_FLOOR, NOT_GIVEN))
        raise InputError(f"{option} {word!r:.40}: use one of {known}")
    return UP_AXES[word]


def parse_unit(word: str, option: str = "--unit") -> str | None:
    """Return the unit that a word names; None for `none`. InputError for another."""
    if word == NOT_GIVEN:
        return None
    if word not in METRES_PER:
        known = ", ".join((*METRES_PER, NOT_GIVEN))
        raise InputError(f"{option} {word!r:.40}: use one of {known}")
    return word


def parse_sensor(word: str) -> tuple[float, float, float] | None:
    """Return the place that a word names; None for `none`. InputError for another.

    >>> parse_sensor("0, 1.5,-2")
    (0.0, 1.5, -2.0)
    """
    if word == NOT_GIVEN:
        return None
    place = _three(word)
    if not all(map(math.isfinite, place)):
        raise InputError(f"--sensor {word!r:.40}: give three numbers x,y,z, or {NOT_GIVEN}")
    return place


def _three(word: str) -> tuple[float, float, float]:
    """Return the three numbers between commas; nan where that is not what the word is."""
    try:
        x, y, z = map(float, word.split(","))
    except ValueError:
        return math.nan, math.nan, math.nan
    return x, y, z


def is_scene_file(path: str) -> bool:
    """Return whether a file states its own up and unit, so that options are ignored."""
    return path.lower().endswith(SCENE_SUFFIX)


def find_shape_files(names: Collection[str]) -> tuple[str, ...]:
    """Return the names of shape files among those of a folder, in alphabetical order.

    A COLMAP model is represented by its file of points, the binary one if there are both.

    >>> find_shape_files(["b.PLY", "a.json", "run.json", "notes.txt", "points3D.bin", "images.bin"])
    ('a.json', 'b.PLY', 'points3D.bin')
    """
    colmap = [name for name in COLMAP_POINTS if name in names][:1]
    wanted = frozenset(SUFFIXES).difference(AMBIGUOUS)
    found = (n for n in names if Path(n).suffix.lower() in wanted and n not in NOT_SCENES)
    return tuple(sorted((*found, *colmap)))
