"""The options that say how scenes, meshes and clouds are read, and reading by them."""

from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.terminal import warn

if TYPE_CHECKING:
    from facetlog.perception.scene import Scene
    from facetlog.perception.shapes.shape_options import ShapeOptions

__all__ = ["AUTO", "NONE", "Scale", "Shape", "ShapeArgument", "StatedOptions", "read"]

AUTO, NONE = "auto", "none"
SCENE_IN_FOLDER = "scene.json"  # as -o writes it

ShapeArgument = Annotated[
    Path,
    typer.Argument(
        metavar="SHAPE",
        help="A scene, mesh or cloud, or the folder of a scene or a COLMAP model.",
        show_default=False,
    ),
]
Scale = Annotated[
    str | None,
    typer.Option(
        "--scale",
        metavar="LENGTH",
        help='A known length, if the unit is unknown: "v3 v7 = 25 ± 0.1 cm", "height = 74 cm".',
    ),
]
Sensor = Annotated[
    str | None,
    typer.Option(
        "--sensor",
        metavar="X,Y,Z",
        help="Position of the sensor that recorded a cloud, or none (default: none).",
    ),
]
OverrideFile = Annotated[
    bool,
    typer.Option(
        "--override-file",
        help="Let --up and --unit override what the file states (glTF, COLLADA).",
    ),
]


@dataclass(frozen=True, slots=True)
class StatedOptions:
    """Statements about files of scenes, meshes and clouds, as typed; None if not given."""

    up: Annotated[
        str | None,
        typer.Option(
            "--up",
            metavar="AXIS",
            help="Upward axis: x, y, z, -x, -y, -z, a vector x,y,z, "
            f"auto or none (default: {AUTO}).",
        ),
    ] = None
    unit: Annotated[
        str | None,
        typer.Option(
            "--unit",
            metavar="U",
            help=f"Unit of meshes and clouds: m, cm, mm, in, ft or none (default: {NONE}).",
        ),
    ] = None
    sensor: Sensor = None
    override_file: OverrideFile = False

    @property
    def up_word(self) -> str:
        """The upward axis as a word in lower case."""
        return (self.up or AUTO).lower()

    @property
    def unit_word(self) -> str:
        """The unit as a word in lower case."""
        return (self.unit or NONE).lower()

    @property
    def sensor_word(self) -> str:
        """The place of the sensor without blanks."""
        return (self.sensor or NONE).replace(" ", "")

    def to_shape_options(self) -> "ShapeOptions":
        """Return the options for reading; raise InputError for a word that is none."""
        from facetlog.perception.shapes import shape_options as by_word

        return by_word.ShapeOptions(
            by_word.parse_up(self.up_word),
            self.up_word == AUTO,
            by_word.parse_unit(self.unit_word),
            by_word.parse_sensor(self.sensor_word),
            override=self.override_file,
        )

    def find_given(self) -> "ShapeOptions | None":
        """Return the options for reading, or None where nothing is stated."""
        words = (self.up_word, self.unit_word, self.sensor_word)
        return None if words == (AUTO, NONE, NONE) else self.to_shape_options()

    def to_words(self) -> str:
        """Return the options as they are typed, each followed by a blank.

        >>> StatedOptions("z", sensor="0,-1,2").to_words()
        '--up=z --sensor=0,-1,2 '
        """
        given = (
            ("--up", self.up, AUTO),
            ("--unit", self.unit, NONE),
            ("--sensor", self.sensor, NONE),
        )
        words = [quote(f"{name}={word}") for name, word, none in given if word not in (None, none)]
        words += ["--override-file"] if self.override_file else []
        return "".join(f"{word} " for word in words)


@dataclass(frozen=True, slots=True)
class Shape:
    """A scene and, in a few words each, how its up and its unit of length are known."""

    scene: "Scene"
    up_known: str
    unit_known: str


def read(path: Path, stated: StatedOptions, scale: str | None) -> Shape:
    """Read the scene of a file or folder; raise InputError for what cannot be read."""
    from facetlog.kept_scenes import read_stated
    from facetlog.perception.facts.known_length import KnownLength, scale_by_known_length
    from facetlog.perception.reading.shape_files.suffixes import FORMATS_WITH_UP
    from facetlog.perception.shapes.shape_options import is_scene_file

    known = None if scale is None else KnownLength.parse(scale)
    options = stated.to_shape_options()
    if path.is_dir() and (path / SCENE_IN_FOLDER).is_file():
        path = path / SCENE_IN_FOLDER
    scene = read_stated(path, options)
    is_scene = is_scene_file(str(path))
    if is_scene and options.sensor is not None:
        warn(f"{path}: a scene says from where it was seen itself; --sensor does not count")
    # Formats that define an axis define a unit as well.
    counts = options.override or path.suffix.lower() not in FORMATS_WITH_UP
    up_known = _explain_up(path, scene, is_scene=is_scene, given=counts and options.up is not None)
    unit_known = "given" if counts and options.unit else "as the file says"
    if known is not None:
        scene, found = scale_by_known_length(scene, known)
        unit_known = f"by the known length: {found}"
    return Shape(
        scene,
        "not known" if scene.up is None else up_known,
        unit_known if scene.metric else "not known",
    )


def _explain_up(path: Path, scene: "Scene", *, is_scene: bool, given: bool) -> str:
    from facetlog.perception.reading.shape_files.suffixes import FORMATS_WITH_UP
    from facetlog.perception.shapes.regions.floor_and_walls import FROM_CAMERAS

    if given:
        return "given"
    if is_scene:
        return "as the file says"
    if path.suffix.lower() in FORMATS_WITH_UP:
        return "as the format says"
    # Cloud readers say by this warning that up is that of the cameras.
    by_cameras = FROM_CAMERAS in scene.warnings
    return "found from the cameras" if by_cameras else "found from the floor"
