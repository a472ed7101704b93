"""Exact scenes by name, of sizes that are given: what the examples of models are made of.

`example "writing desk" of table(width 70 cm, length 140 cm, height 74 cm)` asks for the builder
`table`. Lengths are in metres, angles in radians, up is z.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from types import MappingProxyType
from typing import Literal, TypeAlias

from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids import exact_furniture, joined_cuboids, polyhedra
from facetlog.perception.surfaces.exact_solids.exact_furniture import RIM_SHARE

__all__ = ["BUILDERS", "Builder", "Kind", "Parameter", "build"]

Kind: TypeAlias = Literal["length", "count", "angle"]

# Vertices are exact to a millimetre (SD_M of the scenes): no face may be narrower, metres.
LEAST_LENGTH_M = 0.001
# A building; beyond it a slip of the unit is likelier than a thing.
MOST_LENGTH_M = 1000.0
LEAST_COUNT, MOST_COUNT = 2, 50
# Two walls nearer to one plane than this have no corner, radians.
LEAST_ANGLE = math.radians(5.0)


@dataclass(frozen=True, slots=True)
class Parameter:
    """A size of a builder; `default` in metres or radians, or a number of pieces."""

    name: str
    kind: Kind
    default: float


@dataclass(frozen=True, slots=True)
class Builder:
    """A kind of exact scene: what it is called, its sizes, and what it shows.

    What `is_solid` is known from all sides; of other things there is a part of the surface.
    """

    name: str
    parameters: tuple[Parameter, ...]
    meaning: str
    make: Callable[..., Scene] = field(repr=False)
    is_solid: bool = True


def build(name: str, arguments: Mapping[str, float]) -> Scene:
    """The exact scene of a builder; sizes that are not given have their default.

    Metres and radians; up is z, and the scale is known. Raises ValueError, with the names there
    are, for an unknown builder or size, and for sizes that nothing can have.

    >>> len(build("table", {"width": 0.7, "length": 1.4, "height": 0.74}).faces)
    26
    """
    try:
        builder = BUILDERS[name]
    except KeyError:
        raise ValueError(f"there is no builder {name!r}{_instead(name, BUILDERS)}") from None
    known = {parameter.name: parameter for parameter in builder.parameters}
    for given in arguments:
        if given not in known:
            raise ValueError(f"{name} has no size {given!r}{_instead(given, known)}")
    values = {
        p.name: _checked(name, p, arguments.get(p.name, p.default)) for p in builder.parameters
    }
    scene = builder.make(**values)
    return polyhedra.one_object(scene) if builder.is_solid else scene


def _instead(name: str, known: Mapping[str, object]) -> str:
    near = get_close_matches(name, known, n=1)
    hint = f"; did you mean {near[0]!r}?" if near else ";"
    return f"{hint} there are {', '.join(known)}"


def _checked(builder: str, parameter: Parameter, value: float) -> float:
    what = f"{parameter.name} of a {builder}"
    if not math.isfinite(value):
        raise ValueError(f"the {what} must be a number, not {value}")
    match parameter.kind:
        case "length":
            if not LEAST_LENGTH_M <= value <= MOST_LENGTH_M:
                raise ValueError(
                    f"the {what} is {value:g} m: give one between {LEAST_LENGTH_M:g} m and "
                    f"{MOST_LENGTH_M:g} m"
                )
        case "angle":
            if not LEAST_ANGLE <= value <= math.pi - LEAST_ANGLE:
                raise ValueError(
                    f"the {what} is {math.degrees(value):g} deg: give one between "
                    f"{math.degrees(LEAST_ANGLE):g} deg and "
                    f"{180 - math.degrees(LEAST_ANGLE):g} deg"
                )
        case "count":
            if value != int(value) or not LEAST_COUNT <= value <= MOST_COUNT:
                raise ValueError(
                    f"the {what} is {value:g}: give a whole number between {LEAST_COUNT} and "
                    f"{MOST_COUNT}"
                )
            return int(value)
    return float(value)


def _fits(what: str, size: float, into: str, room: float) -> None:
    """ValueError unless `size` is less than `room` by a length that can be seen."""
    if size > room - LEAST_LENGTH_M:
        raise ValueError(f"{what} ({size:g} m) must be less than {into} ({room:g} m)")


def _legs_fit(leg: float, length: float, width: float) -> None:
    shorter = min(length, width)
    _fits("two legs with their rims", 2 * (leg + RIM_SHARE * shorter), "the shorter side", shorter)


def _tray(width: float, depth: float, height: float, thickness: float) -> Scene:
    _fits("two walls", 2 * thickness, "the shorter side", min(width, depth))
    _fits("the thickness", thickness, "the height", height)
    return exact_furniture.tray(width, depth, height, thickness=thickness)


def _table(width: float, length: float, height: float, thickness: float, leg: float) -> Scene:
    _fits("the thickness", thickness, "the height", height)
    _legs_fit(leg, length, width)
    inset = RIM_SHARE * min(length, width)
    return polyhedra.table(length, width, height, thickness=thickness, leg=leg, inset=inset)


def _desk(
    width: float, length: float, height: float, thickness: float, panel: float, block: float
) -> Scene:
    # The panel at the rear hangs down by half the height.
    _fits("the thickness", thickness, "half the height", height / 2)
    _fits(
        "two panels, or one and a block, with their rims",
        panel + max(panel, block) + 2 * RIM_SHARE * min(width, length),
        "the length",
        length,
    )
    _fits("the panel", panel, "half the width", width / 2)
    return exact_furniture.desk(
        length, width, height, thickness=thickness, panel=panel, block=block
    )


def _chair(
    width: float, depth: float, seat: float, height: float, thickness: float, leg: float
) -> Scene:
    _fits("the thickness", thickness, "the seat's height", seat)
    _fits("the seat's height", seat, "the height", height)
    _fits("the back's thickness", thickness, "the depth", depth)
    _legs_fit(leg, width, depth)
    inset = RIM_SHARE * min(width, depth)
    return polyhedra.chair(width, depth, seat, height, thickness=thickness, leg=leg, inset=inset)


def _stool(width: float, depth: float, height: float, thickness: float, leg: float) -> Scene:
    _fits("the thickness", thickness, "the height", height)
    _legs_fit(leg, width, depth)
    return exact_furniture.stool(width, depth, height, thickness=thickness, leg=leg)


def _bench(width: float, length: float, height: float, thickness: float, panel: float) -> Scene:
    _fits("the thickness", thickness, "the height", height)
    rims = 2 * RIM_SHARE * min(width, length)
    _fits("two panels with their rims", 2 * panel + rims, "the length", length)
    return exact_furniture.bench(length, width, height, thickness=thickness, panel=panel)


def _shelf(width: float, depth: float, height: float, boards: int, thickness: float) -> Scene:
    rims = 2 * RIM_SHARE * min(width, depth)
    _fits("the two sides", 2 * thickness, "the width", width)
    # Each board but the last needs a gap above it that can be seen.
    gaps = (boards - 2) * LEAST_LENGTH_M
    _fits("the boards with their rims", boards * thickness + rims + gaps, "the height", height)
    return exact_furniture.shelf(width, depth, height, boards, thickness=thickness)


def _cabinet(width: float, depth: float, height: float, foot: float) -> Scene:
    _fits("the foot", foot, "the height", height)
    return exact_furniture.cabinet(width, depth, height, foot=foot)


def _bed(width: float, length: float, height: float, head: float) -> Scene:
    _fits("the height", height, "that of the head", head)
    return joined_cuboids.bed(width, length, height, head)


def _sofa(width: float, depth: float, seat: float, height: float, arm: float) -> Scene:
    _fits("the seat's height", seat, "the height", height)
    _fits("two arms", 2 * arm, "the width", width)
    return joined_cuboids.sofa(width, depth, seat, height, arm)


def _frame(width: float, height: float, thickness: float, rim: float) -> Scene:
    _fits("two rails", 2 * rim, "the shorter side", min(width, height))
    return joined_cuboids.frame(width, height, thickness, rim)


def _builder(
    name: str,
    make: Callable[..., Scene],
    meaning: str,
    *sizes: tuple[str, Kind, float],
    is_solid: bool = True,
) -> Builder:
    return Builder(name, tuple(Parameter(*size) for size in sizes), meaning, make, is_solid)


def _length(name: str, default: float) -> tuple[str, Kind, float]:
    return name, "length", default


_ALL = (
    _builder(
        "cuboid",
        lambda width, depth, height: polyhedra.cuboid(width, depth, height),
        "a closed block",
        _length("width", 0.254),
        _length("depth", 0.2032),
        _length("height", 0.1524),
    ),
    _builder(
        "tray",
        _tray,
        "an open box with walls of some thickness",
        _length("width", 0.4),
        _length("depth", 0.3),
        _length("height", 0.05),
        _length("thickness", 0.005),
    ),
    _builder(
        "wedge",
        lambda width, depth, height: polyhedra.wedge(width, depth, height),
        "a ramp that falls along its width",
        _length("width", 0.3),
        _length("depth", 0.2),
        _length("height", 0.15),
    ),
    _builder(
        "pyramid",
        lambda width, height: polyhedra.pyramid(width, height),
        "a square pyramid",
        _length("width", 0.3),
        _length("height", 0.25),
    ),
    _builder(
        "l_block",
        lambda width, depth, height: polyhedra.l_block(width, depth, height),
        "a block with a quarter cut away along its depth, like a step",
        _length("width", 0.4),
        _length("depth", 0.2),
        _length("height", 0.4),
    ),
    _builder(
        "room_corner",
        lambda width, height, angle: polyhedra.room_corner(width, height, angle=angle),
        "a floor and two walls of that width seen from inside, the walls at an angle",
        _length("width", 3.0),
        _length("height", 2.5),
        ("angle", "angle", math.pi / 2),
        is_solid=False,
    ),
    _builder(
        "table",
        _table,
        "a top on four square legs",
        _length("width", 0.8),
        _length("length", 1.2),
        _length("height", 0.74),
        _length("thickness", 0.04),
        _length("leg", 0.06),
    ),
    _builder(
        "desk",
        _desk,
        "a top on two side panels, one of which may be a drawer block, half closed behind",
        _length("width", 0.7),
        _length("length", 1.4),
        _length("height", 0.74),
        _length("thickness", 0.03),
        _length("panel", 0.03),
        _length("block", 0.03),
    ),
    _builder(
        "chair",
        _chair,
        "a seat at some height on four legs, with a back up to the whole height",
        _length("width", 0.45),
        _length("depth", 0.45),
        _length("seat", 0.45),
        _length("height", 0.9),
        _length("thickness", 0.04),
        _length("leg", 0.04),
    ),
    _builder(
        "stool",
        _stool,
        "a seat on four legs without a back",
        _length("width", 0.35),
        _length("depth", 0.35),
        _length("height", 0.45),
        _length("thickness", 0.03),
        _length("leg", 0.04),
    ),
    _builder(
        "bench",
        _bench,
        "a long low seat on two panels across it",
        _length("width", 0.35),
        _length("length", 1.2),
        _length("height", 0.45),
        _length("thickness", 0.04),
        _length("panel", 0.04),
    ),
    _builder(
        "bed",
        _bed,
        "a block to lie on, with a board across its head",
        _length("width", 0.9),
        _length("length", 2.0),
        _length("height", 0.45),
        _length("head", 0.85),
    ),
    _builder(
        "sofa",
        _sofa,
        "a long block to sit on, with a back and two arms",
        _length("width", 2.0),
        _length("depth", 0.9),
        _length("seat", 0.42),
        _length("height", 0.8),
        _length("arm", 0.2),
    ),
    _builder(
        "frame",
        _frame,
        "an upright frame of four rails round one opening",
        _length("width", 0.3),
        _length("height", 0.4),
        _length("thickness", 0.02),
        _length("rim", 0.04),
    ),
    _builder(
        "shelf",
        _shelf,
        "level boards between two sides, open in front and behind",
        _length("width", 0.8),
        _length("depth", 0.3),
        _length("height", 1.8),
        ("boards", "count", 5),
        _length("thickness", 0.02),
    ),
    _builder(
        "cabinet",
        _cabinet,
        "a closed block on a plinth",
        _length("width", 0.8),
        _length("depth", 0.4),
        _length("height", 1.2),
        _length("foot", 0.08),
    ),
    _builder(
        "stairs",
        exact_furniture.stairs,
        "a flight of steps with risers",
        ("steps", "count", 4),
        _length("width", 0.9),
        _length("rise", 0.18),
        _length("going", 0.28),
    ),
)

BUILDERS: Mapping[str, Builder] = MappingProxyType({builder.name: builder for builder in _ALL})
"""All builders by name."""
