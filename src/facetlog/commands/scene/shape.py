"""What commands read: any shape, with the up and unit that are stated, and how these are known."""

from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.terminal import warn

if TYPE_CHECKING:
    from facetlog.perception.scene import Scene
    from facetlog.perception.shapes.shape_options import ShapeOptions

__all__ = [
    "AUTO",
    "NONE",
    "OverrideFile",
    "Scale",
    "Sensor",
    "Shape",
    "ShapeArgument",
    "Unit",
    "Up",
    "as_given",
    "options_given",
    "options_of",
    "read",
]

ShapeArgument = Annotated[
    Path,
    typer.Argument(
        metavar="SHAPE",
        help="A scene, mesh or cloud, or the folder of a scene or a COLMAP model.",
        show_default=False,
    ),
]
Up = Annotated[
    str,
    typer.Option("--up", metavar="AXIS", help="Upwards: x y z -x -y -z, auto or none."),
]
Unit = Annotated[
    str, typer.Option("--unit", metavar="U", help="Of lengths: m cm mm in ft or none.")
]
Scale = Annotated[
    str | None,
    typer.Option(
        "--scale",
        metavar="LENGTH",
        help='A known length, where no unit is: "v3 v7 = 25 cm", "e5 = 2 ft", "height = 74 cm".',
    ),
]
Sensor = Annotated[
    str,
    typer.Option(
        "--sensor", metavar="X,Y,Z", help="Of clouds: from where the points were seen, or none."
    ),
]

OverrideFile = Annotated[
    bool,
    typer.Option(
        "--override-file", help="--up and --unit go before what a file states (glTF, COLLADA)."
    ),
]

AUTO, NONE = "auto", "none"
SCENE_IN_FOLDER = "scene.json"  # as -o writes it


@dataclass(frozen=True, slots=True)
class Shape:
    """A scene and, in a few words each, how its up and its unit of length are known."""

    scene: "Scene"
    up_known: str
    unit_known: str


def read(
    path: Path, up: str, unit: str, sensor: str, scale: str | None, *, override: bool = False
) -> Shape:
    """The scene of a file or folder, with options in the words of the command line.

    Raises InputError for words that are none, and for what cannot be read.
    """
    from facetlog.perception.facts.known_length import KnownLength, with_known_length
    from facetlog.perception.shapes.read_shape import read_stated
    from facetlog.perception.shapes.shape_options import FORMATS_WITH_UP, says_itself

    known = None if scale is None else KnownLength.parse(scale)
    options = options_of(up, unit, sensor, override)
    if path.is_dir() and (path / SCENE_IN_FOLDER).is_file():
        path = path / SCENE_IN_FOLDER
    scene = read_stated(path, options)
    itself = says_itself(str(path))
    if itself and sensor != NONE:
        warn(f"{path}: a scene says from where it was seen itself; --sensor does not count")
    # formats that define an axis define a unit as well
    given = override or path.suffix.lower() not in FORMATS_WITH_UP
    how_up = _how_up(path, scene, itself=itself, given=given and options.up is not None)
    how_unit = "given" if given and options.unit else "as the file says"
    if known is not None:
        scene, found = with_known_length(scene, known)
        how_unit = f"by the known length: {found}"
    return Shape(
        scene,
        "not known" if scene.up is None else how_up,
        how_unit if scene.metric else "not known",
    )


def options_of(up: str, unit: str, sensor: str, override: bool = False) -> "ShapeOptions":
    """What these words of the command line state; InputError for words that are none."""
    from facetlog.perception.shapes.shape_options import (
        ShapeOptions,
        sensor_from,
        unit_from,
        up_from,
    )

    up, unit = up.lower(), unit.lower()
    return ShapeOptions(
        up_from(up), up == AUTO, unit_from(unit), sensor_from(sensor), override=override
    )


def options_given(up: str, unit: str, sensor: str, override: bool = False) -> "ShapeOptions | None":
    """The same, or None where none of the words states anything."""
    given = (up, unit, sensor) != (AUTO, NONE, NONE)
    return options_of(up, unit, sensor, override) if given else None


def as_given(up: str, unit: str, sensor: str, override: bool = False) -> str:
    """These options as they were given, each with a blank behind it; empty for none.

    >>> as_given("z", "none", "0,-1,2")
    '--up=z --sensor=0,-1,2 '
    """
    given = (("--up", up, AUTO), ("--unit", unit, NONE), ("--sensor", sensor, NONE))
    words = [quote(f"{name}={word}") for name, word, none in given if word != none]
    return "".join(f"{word} " for word in (*words, *(("--override-file",) if override else ())))


def _how_up(path: Path, scene: "Scene", *, itself: bool, given: bool) -> str:
    from facetlog.perception.shapes.regions.floor_and_walls import FROM_CAMERAS
    from facetlog.perception.shapes.shape_options import FORMATS_WITH_UP

    if given:
        return "given"
    if itself:
        return "as the file says"
    if path.suffix.lower() in FORMATS_WITH_UP:
        return "as the format says"
    # as cloud_scene.py says it
    by_cameras = FROM_CAMERAS in scene.warnings
    return "found from the cameras" if by_cameras else "found from the floor"
