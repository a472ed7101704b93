"""Settings and items of a run: plain values that travel to workers as JSON."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from facetlog.batch.memory import LEAST_MB
from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.suffixes import FORMATS_WITH_UP
from facetlog.perception.shapes.shape_options import (
    FROM_THE_FLOOR,
    NOT_GIVEN,
    ShapeOptions,
    is_scene_file,
    parse_sensor,
    parse_unit,
    parse_up,
)

if TYPE_CHECKING:
    from facetlog.kept_scenes import KeptScene, SceneKeeper

CRISP = "crisp"
"""The last word of `read_as` where every measured value was taken as exact."""

SECONDS_PER_SCENE = 60.0
"""Time limit of one scene: a hundred times what a mesh of a hundred thousand triangles takes."""

CLOCK_TIMES = 5.0
"""By the clock so many times that, without the time in which it waits for a processor: a read that
hangs must end."""


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of all scenes of a run: models, and how raw shapes are read.

    `up` is x, y, z, -x, -y, -z, a vector as 0,0.1,1, auto or none; `unit` m, cm, mm, in, ft or
    none; `sensor` the place x,y,z from which the points of clouds were seen, or none. With
    `override` up and unit go before what a file states. `seconds` is the processor time that one
    scene may take; by the clock it may take five times that, without what it waits for a processor,
    and so may all judging of it. `keep` is the folder of kept scenes, that of the user's cache if
    not given.
    `memory_mb` is what one worker may take; None: its share of the memory there is. With `profile`
    workers say where their time went, with `raw` verdicts have no confidence. What cannot be
    understood is an InputError.
    """

    models: tuple[str, ...] = ()
    trusted: bool = False
    crisp: bool = False
    up: str = "auto"
    unit: str = "none"
    seconds: float = SECONDS_PER_SCENE
    memory_mb: int | None = None
    profile: bool = False
    raw: bool = False
    sensor: str = NOT_GIVEN
    override: bool = False
    keep: str | None = None

    def __post_init__(self) -> None:
        parse_up(self.up)
        parse_unit(self.unit)
        parse_sensor(self.sensor)
        if not self.seconds > 0:
            raise InputError(f"a time limit of {self.seconds:g} s: give seconds above 0")
        if self.memory_mb is not None and self.memory_mb < LEAST_MB:
            raise InputError(
                f"--memory {self.memory_mb}: give {LEAST_MB} MB or more: a worker takes half of "
                "that before its first scene"
            )

    @property
    def clock_seconds(self) -> float:
        """Wall-clock limit of one scene, seconds."""
        return CLOCK_TIMES * self.seconds

    def to_json(self) -> dict[str, Any]:
        """Return the settings as plain data."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """Return the settings of plain data that `to_json` made."""
        return cls(**{**data, "models": tuple(data["models"])})

    @property
    def judged_as(self) -> str:
        """Word for how scenes are judged: results with another one are not comparable."""
        return CRISP if self.crisp else "degrees"


@dataclass(frozen=True, slots=True)
class Item:
    """A scene to classify, by the path that its row has; `up` and `unit` go before the settings',
    and with `override` before what the file states.

    `file` is where its content is, where that is another path.
    """

    path: str
    up: str | None = None
    unit: str | None = None
    file: str | None = None
    override: bool | None = None

    @property
    def place(self) -> str:
        """The file to read."""
        return self.file or self.path

    def to_json(self) -> dict[str, Any]:
        """Return the item as plain data, what is not given left out."""
        return {key: value for key, value in asdict(self).items() if value is not None}

    def read_as(self, settings: Settings) -> str:
        """Return how it is read and judged, as a row says it; scenes say themselves where up is.

        >>> Item("a.ply", up="z").read_as(Settings())
        'up=z unit=none degrees'
        """
        if is_scene_file(self.path):
            return settings.judged_as
        up = (self.up or settings.up).replace(" ", "")  # a vector in a table may have some
        unit = self.unit or settings.unit
        seen = f" sensor={settings.sensor}" if parse_sensor(settings.sensor) else ""
        states = self.path.lower().endswith(FORMATS_WITH_UP)
        override = " override" if states and (settings.override or self.override) else ""
        return f"up={up} unit={unit}{seen}{override} {settings.judged_as}"


def parse_read_as(read_as: str) -> tuple[str | None, str | None]:
    """Return the options `up` and `unit` that a row's `read_as` states; None for those it does not.

    >>> parse_read_as("up=z unit=none degrees"), parse_read_as("degrees")
    (('z', 'none'), (None, None))
    """
    given = dict(word.split("=", 1) for word in read_as.split() if "=" in word)
    return given.get("up"), given.get("unit")


def shape_options(item: Item, settings: Settings) -> ShapeOptions:
    """Return how a shape is read that does not say itself where up is and what its lengths are."""
    up = item.up or settings.up
    unit = parse_unit(item.unit or settings.unit)
    override = settings.override or bool(item.override)
    return ShapeOptions(
        parse_up(up), up == FROM_THE_FLOOR, unit, parse_sensor(settings.sensor), override
    )


def open_scene(item: Item, settings: Settings, *, solid_parts: bool = True) -> "KeptScene":
    """Return the scene of an item, which is read when it is asked for, or was kept.

    Solid parts of meshes take long: who asks for no facts of them leaves them out.
    """
    options = replace(shape_options(item, settings), solid_parts=solid_parts)
    return _get_keeper(settings.keep).open(Path(item.place), options)


@cache
def _get_keeper(folder: str | None) -> "SceneKeeper":
    from facetlog.kept_scenes import SceneKeeper

    return SceneKeeper(None if folder is None else Path(folder))
