"""The world file of the simulator (TOML, documented in default_world.toml) and its scene."""

import math
import re
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import ConfigDict, Field, FiniteFloat, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from facetlog.errors import InputError
from facetlog.robot.mount.mount import ANGLES, LENGTHS, Mount
from facetlog.robot.pioneer.packets.reports import Configuration
from facetlog.robot.pioneer.parameters import MODELS
from facetlog.robot.rendering.solids import cuboid, cylinder, placed, prism, pyramid, wedge
from facetlog.robot.rendering.world import Solid, World
from facetlog.robot.rendering.worlds import INCH, WORLDS, make_world
from facetlog.robot.simulator.body import MotionErrors
from facetlog.robot.simulator.faults import Fault, Seconds, Share
from facetlog.safe_read import read_regular_text
from facetlog.toml_text import parse_toml_fields

FORM = ConfigDict(extra="forbid")
DEFAULT_WORLD = "default_world.toml"

Length = Annotated[FiniteFloat, Field(gt=0.0)]
Error = Annotated[FiniteFloat, Field(ge=-0.5, le=0.5)]
Spread = Annotated[FiniteFloat, Field(ge=0.0, le=1.0)]
Point = tuple[FiniteFloat, FiniteFloat]

SKIDDING = ("p2at", "p2it", "p3at", "pionat")
"""How the models with four wheels or tracks begin."""


@dataclass(frozen=True, slots=True, config=FORM)
class SolidSetup:
    """A solid of the user's own: metres, degrees; it stands on the floor about `at`."""

    kind: Literal["box", "prism", "pyramid", "cylinder", "wedge"]
    size: tuple[Length, ...] = ()
    plan: tuple[Point, ...] = ()
    at: Point = (0.0, 0.0)
    yaw_deg: FiniteFloat = 0.0
    albedo: Share = 0.96


@dataclass(frozen=True, slots=True, config=FORM)
class SceneSetup:
    """The scene: a world by name, and solids besides."""

    world: str = "block"
    seed: Annotated[int, Field(ge=0)] = 0
    solid: tuple[SolidSetup, ...] = ()


@dataclass(frozen=True, slots=True, config=FORM)
class StartSetup:
    """Where the robot stands at first: metres and degrees in the world frame."""

    x: FiniteFloat = 0.0
    y: FiniteFloat = 0.0
    heading_deg: FiniteFloat = 0.0


@dataclass(frozen=True, slots=True, config=FORM)
class ErrorSetup:
    """Errors of odometry, see dynamics.MotionErrors; None is what the robot's has anyway."""

    left: Error | None = None
    right: Error | None = None
    track: Error | None = None
    slip: Spread | None = None
    encoder: Spread | None = None


@dataclass(frozen=True, slots=True, config=FORM)
class RobotSetup:
    """The robot: its model, place and errors, and fields of CONFIG that are not the defaults."""

    model: str = "p2dx"
    name: Annotated[str, Field(max_length=19, pattern=r"^[\x20-\x7e]*$")] = "Simulated"
    height: Length = 0.24
    position_bits: Literal[12, 15] = 15
    battery_v: Annotated[FiniteFloat, Field(ge=0.0, le=25.5)] = 12.8
    start: StartSetup = StartSetup()
    odometry: Literal["usual", "perfect"] = "usual"
    errors: ErrorSetup = ErrorSetup()
    config: Annotated[dict[str, int | str], Field(default_factory=dict)] = Field(
        default_factory=dict
    )

    @property
    def motion_errors(self) -> MotionErrors:
        """The stated errors of its odometry; the others are usual of its kind, or 0 if perfect."""
        others = MotionErrors()
        if self.odometry == "usual":
            others = MotionErrors.usual(skids=self.model.startswith(SKIDDING))
        stated = {key: getattr(self.errors, key) for key in ErrorSetup.__slots__}
        return replace(others, **{k: value for k, value in stated.items() if value is not None})


@dataclass(frozen=True, slots=True, config=FORM)
class HeadSetup:
    """The camera's pan-tilt head, and which port it hangs on."""

    kind: Literal["sony-evi-d30", "canon-vc-c4", "none"] = "sony-evi-d30"
    port: Literal["aux1", "aux2", "aux3", "own"] = "aux1"
    own: str = "127.0.0.1:0"


@dataclass(frozen=True, slots=True, config=FORM)
class MountSetup:
    """Where pan and tilt axes cross in the robot's frame, how askew the head stands, the pinhole.

    The pinhole is off the axes by an offset that turns with the head.
    """

    x: FiniteFloat = 0.0
    y: FiniteFloat = 0.0
    z: Length = 0.7239
    yaw_deg: FiniteFloat = 0.0
    pitch_deg: FiniteFloat = 0.0
    roll_deg: FiniteFloat = 0.0
    tilt_zero_deg: FiniteFloat = 0.0
    skew_deg: FiniteFloat = 0.0
    pinhole_ahead: FiniteFloat = 0.0
    pinhole_left: FiniteFloat = 0.0
    pinhole_up: FiniteFloat = 0.0

    @property
    def mount(self) -> Mount:
        """The mount in metres and radians."""
        stated = {name: getattr(self, name) for name in LENGTHS}
        stated |= {name: math.radians(getattr(self, f"{name}_deg")) for name in ANGLES}
        return Mount(**stated)


@dataclass(frozen=True, slots=True, config=FORM)
class CameraSetup:
    """The pinhole camera: size in pixels, angle, noise in grey levels, blur in pixels."""

    width: Annotated[int, Field(ge=16, le=4096)] = 640
    height: Annotated[int, Field(ge=16, le=4096)] = 480
    across_deg: Annotated[float, Field(gt=1.0, lt=170.0)] = 65.0
    noise: Annotated[float, Field(ge=0.0, le=100.0)] = 3.0
    blur: Annotated[float, Field(ge=0.0, le=20.0)] = 1.0
    exposure: Annotated[float, Field(gt=0.0, le=1.0)] = 0.02
    rate: Annotated[float, Field(gt=0.0, le=60.0)] = 10.0
    quality: Annotated[int, Field(ge=1, le=100)] = 95


@dataclass(frozen=True, slots=True, config=FORM)
class TimedFault:
    """A fault that comes by itself, so many seconds after the start."""

    at: Seconds
    fault: Fault


@dataclass(frozen=True, slots=True, config=FORM)
class WorldSetup:
    """The contents of a world file."""

    scene: SceneSetup = SceneSetup()
    robot: RobotSetup = RobotSetup()
    head: HeadSetup = HeadSetup()
    mount: MountSetup = MountSetup()
    camera: CameraSetup = CameraSetup()
    faults: tuple[TimedFault, ...] = ()
    seed: Annotated[int, Field(ge=0)] = 0


def read_world(path: Path | None = None) -> WorldSetup:
    """Return the world in the file, or the default world without one.

    InputError in one line that names the file, the line and the key, and what may stand there.
    """
    if path is None:
        name, text = DEFAULT_WORLD, _read_default_text()
    else:
        name = str(path)
        try:
            text = read_regular_text(path)
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or "it is not UTF-8"
            raise InputError(f"{name}: the world file cannot be read ({reason})") from error
    content = parse_toml_fields(text, name)
    try:
        setup = TypeAdapter(WorldSetup).validate_python(content)
    except ValidationError as error:
        raise _refusal(name, text, error) from error
    _check_names(name, text, setup)
    return setup


def _read_default_text() -> str:
    return files("facetlog.robot.simulator").joinpath(DEFAULT_WORLD).read_text(encoding="utf-8")


def _refusal(name: str, text: str, error: ValidationError) -> InputError:
    first = error.errors()[0]
    place = tuple(part for part in first["loc"] if isinstance(part, str | int))
    unknown = first["type"] in ("unexpected_keyword_argument", "extra_forbidden")
    said = "there is no such key" if unknown else _lower_first_letter(str(first["msg"]))
    return _make_error(name, text, place, said)


def _lower_first_letter(message: str) -> str:
    return message[:1].lower() + message[1:]


def _make_error(name: str, text: str, place: tuple[str | int, ...], said: str) -> InputError:
    key = ".".join(str(part) for part in place)
    return InputError(f"{name}:{_find_line(text, place)}: {key}: {said}")


def _check_names(name: str, text: str, setup: WorldSetup) -> None:
    """Raise InputError for names that the project does not have."""
    if setup.scene.world not in WORLDS:
        said = f"no world {setup.scene.world!r}; there are {', '.join(WORLDS)}"
        raise _make_error(name, text, ("scene", "world"), said)
    if setup.robot.model not in MODELS:
        said = f"no model {setup.robot.model!r}; there are {', '.join(MODELS)}"
        raise _make_error(name, text, ("robot", "model"), said)
    for key, value in setup.robot.config.items():
        place = ("robot", "config", key)
        if key not in Configuration.__dataclass_fields__:
            raise _make_error(name, text, place, "there is no such field in a CONFIG packet")
        wanted = str if "str" in str(Configuration.__dataclass_fields__[key].type) else int
        if not isinstance(value, wanted) or (wanted is int and not 0 <= int(value) <= 0xFFFF):
            said = "give a text" if wanted is str else "give a number from 0 to 65535"
            raise _make_error(name, text, place, said)
    for index, solid in enumerate(setup.scene.solid):
        said = _find_wrong_size(solid)
        if said:
            raise _make_error(name, text, ("scene", "solid", index, "size"), said)


SIZES = {"box": 3, "pyramid": 3, "cylinder": 2, "wedge": 2, "prism": 1}


def _find_wrong_size(solid: SolidSetup) -> str:
    if len(solid.size) != SIZES[solid.kind]:
        return f"a {solid.kind} has {SIZES[solid.kind]} lengths here, not {len(solid.size)}"
    if solid.kind == "prism" and len(solid.plan) < 3:
        return "a prism needs a plan of three points or more"
    return ""


def _find_line(text: str, place: tuple[str | int, ...]) -> int:
    """Return the line, from 1, of the key at this place, or of the nearest table round it."""
    lines: dict[tuple[str | int, ...], int] = {}
    counts: dict[tuple[str, ...], int] = {}
    table: tuple[str | int, ...] = ()
    for number, line in enumerate(text.splitlines(), 1):
        if found := re.match(r"\s*\[\[([\w.\s-]+)\]\]", line):
            names = tuple(part.strip() for part in found[1].split("."))
            counts[names] = counts.get(names, -1) + 1
            table = (*names, counts[names])
            lines.setdefault(names, number)
            lines[table] = number
        elif found := re.match(r"\s*\[([\w.\s-]+)\]", line):
            table = tuple(part.strip() for part in found[1].split("."))
            lines[table] = number
        elif found := re.match(r"\s*([\w-]+)\s*=", line):
            lines.setdefault((*table, found[1]), number)
    for length in range(len(place), 0, -1):
        if place[:length] in lines:
            return lines[place[:length]]
    return 1


def in_metres(world: World) -> World:
    """Return a world of robot/rendering/worlds.py, whose unit is the inch, with all lengths in
    metres.
    """
    solids = tuple(solid.moved(np.eye(3), np.zeros(3), INCH) for solid in world.solids)
    floor = world.floor
    if floor is not None and floor.texture is not None:
        floor = replace(floor, texture=floor.texture.scaled(INCH))
    return replace(world, solids=solids, floor=floor)


def make_scene(setup: SceneSetup) -> World:
    """Return the world that a scene names, with the solids that it adds.

    >>> [round(side, 4) for side in make_scene(SceneSetup()).solids[0].size]
    [0.254, 0.2032, 0.1524]
    """
    world = in_metres(make_world(setup.world, setup.seed))
    return replace(world, solids=world.solids + tuple(_solid(each) for each in setup.solid))


def _solid(setup: SolidSetup) -> Solid:
    match setup.kind, setup.size:
        case "box", (x, y, z):
            made = cuboid(x, y, z, albedo=setup.albedo)
        case "pyramid", (x, y, z):
            made = pyramid(x, y, z, albedo=setup.albedo)
        case "cylinder", (diameter, height):
            made = cylinder(diameter, height, albedo=setup.albedo)
        case "wedge", (length, side):
            made = wedge(length, side, albedo=setup.albedo)
        case _:
            made = prism(setup.plan, setup.size[0], name="prism", albedo=setup.albedo)
    return placed(made, *setup.at, yaw=float(np.deg2rad(setup.yaw_deg)))
