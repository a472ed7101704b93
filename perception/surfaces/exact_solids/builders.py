"""Exact scenes by name, of given sizes: what the examples of models are made of.

`example "writing desk" of table(width 70 cm, length 140 cm, height 74 cm)` asks for the builder
`table`. Lengths are in metres, angles in radians, up is z. All scenes stand on the ground, and have
no face where two pieces lie against each other.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from inspect import signature
from types import MappingProxyType
from typing import Annotated, Literal, TypeAlias, get_type_hints

import numpy as np

from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids import polyhedra
from facetlog.perception.surfaces.exact_solids.cuboid_union import cuboid_union

Kind: TypeAlias = Literal["length", "count", "angle"]
Length = Annotated[float, "length"]
Count = Annotated[int, "count"]
Angle = Annotated[float, "angle"]

SD_M = 0.001
"""Vertices are exact to a millimetre."""
# So no face may be narrower.
LEAST_LENGTH_M = SD_M
# A building; beyond it a slip of the unit is likelier than a thing.
MOST_LENGTH_M = 1000.0
LEAST_COUNT, MOST_COUNT = 2, 50
# Two walls nearer to one plane than this have no corner, radians.
LEAST_ANGLE = math.radians(5.0)
# What stands under or between other pieces is in from their rim by this share of the shorter side
# of the plan, so that no two pieces have a face in one plane.
RIM_SHARE = 0.05
# A desk's rear panel hangs this share of its height, and this share of its depth from the rear.
MODESTY_SHARE = 0.5
MODESTY_INSET_SHARE = 0.15
# So many sides stand for a circle: turned by 7.5 degrees each, they bulge by 0.1 % of its diameter.
ROUND_SIDES = 48
# A bed's head board, of its length; a sofa's back, of its depth.
HEAD_SHARE = 0.03
BACK_SHARE = 0.25
# How far a sofa's arms rise from its seat to the top of its back.
ARMS_SHARE = 0.5


@dataclass(frozen=True, slots=True)
class Parameter:
    """A size of a builder; `default` in metres or radians, or a number of pieces."""

    name: str
    kind: Kind
    default: float


@dataclass(frozen=True, slots=True)
class Builder:
    """A kind of exact scene: its name, its sizes, and what it shows.

    What `is_solid` is known from all sides; of other things there is a part of the surface. The
    faces of what `is_round` are those of a prism or the like of many sides.
    """

    name: str
    parameters: tuple[Parameter, ...]
    meaning: str
    make: Callable[..., Scene] = field(repr=False)
    is_solid: bool = True
    is_round: bool = False


_BUILDERS: dict[str, Builder] = {}

BUILDERS: Mapping[str, Builder] = MappingProxyType(_BUILDERS)
"""All builders by name."""


def build(name: str, arguments: Mapping[str, float]) -> Scene:
    """Return the exact scene of a builder; sizes that are not given have their default.

    Metres and radians; up is z, and the scale is known. Raise ValueError, with the names there
    are, for an unknown builder or size, and for sizes that nothing can have.

    >>> len(build("table", {"width": 0.7, "length": 1.4, "height": 0.74}).faces)
    26
    """
    try:
        builder = BUILDERS[name]
    except KeyError:
        raise ValueError(f"there is no builder {name!r}{_suggest_name(name, BUILDERS)}") from None
    known = {parameter.name: parameter for parameter in builder.parameters}
    for given in arguments:
        if given not in known:
            raise ValueError(f"{name} has no size {given!r}{_suggest_name(given, known)}")
    values = {
        p.name: _checked(name, p, arguments.get(p.name, p.default)) for p in builder.parameters
    }
    scene = replace(builder.make(**values), name=name)
    return polyhedra.one_object(scene) if builder.is_solid else scene


def _suggest_name(name: str, known: Mapping[str, object]) -> str:
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


def _builder(
    meaning: str, *, is_solid: bool = True, is_round: bool = False
) -> Callable[[Callable[..., Scene]], Callable[..., Scene]]:
    """Register a function `_make_NAME` as builder NAME, with the sizes of its signature."""

    def register(make: Callable[..., Scene]) -> Callable[..., Scene]:
        name = make.__name__.removeprefix("_make_")
        kinds = get_type_hints(make, include_extras=True)
        sizes = tuple(
            Parameter(p.name, kinds[p.name].__metadata__[0], p.default)
            for p in signature(make).parameters.values()
        )
        _BUILDERS[name] = Builder(name, sizes, meaning, make, is_solid, is_round)
        return make

    return register


def _check_fit(what: str, size: float, into: str, room: float) -> None:
    """Raise ValueError unless `size` is less than `room` by a length that can be seen."""
    if size > room - LEAST_LENGTH_M:
        raise ValueError(f"{what} ({size:g} m) must be less than {into} ({room:g} m)")


def _check_legs(leg: float, length: float, width: float) -> None:
    shorter = min(length, width)
    legs = 2 * (leg + RIM_SHARE * shorter)
    _check_fit("two legs with their rims", legs, "the shorter side", shorter)


@dataclass(frozen=True, slots=True)
class _Piece:
    """An upright cuboid from its lowest to its highest corner; `hidden` sides have no face."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    hidden: tuple[str, ...] = ()


def _put_together(pieces: Sequence[_Piece]) -> Scene:
    sides = polyhedra.CUBOID_SIDES
    hidden = (
        len(sides) * index + sides.index(side)
        for index, piece in enumerate(pieces)
        for side in piece.hidden
    )
    scene = polyhedra.boxes([(p.low, p.high) for p in pieces], SD_M, "")
    return polyhedra.drop_faces(scene, hidden)


@_builder("a closed block")
def _make_cuboid(width: Length = 0.254, depth: Length = 0.2032, height: Length = 0.1524) -> Scene:
    return polyhedra.cuboid(width, depth, height)


@_builder("an open box with walls of some thickness")
def _make_tray(
    width: Length = 0.4, depth: Length = 0.3, height: Length = 0.05, thickness: Length = 0.005
) -> Scene:
    t = thickness
    _check_fit("two walls", 2 * t, "the shorter side", min(width, depth))
    _check_fit("the thickness", t, "the height", height)
    shells = (
        ((0.0, 0.0, 0.0), (width, depth, height)),
        ((t, t, t), (width - t, depth - t, height)),
    )
    points = [
        (x, y, z)
        for low, high in shells
        for z in (low[2], high[2])
        for x, y in ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1]))
    ]
    sides = [(i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i) for i in range(4)]
    outer = [(3, 2, 1, 0), *sides]
    inner = [(8, 9, 10, 11), *(tuple(8 + i for i in reversed(side)) for side in sides)]
    rim = len(outer) + len(inner)
    loops = [*outer, *inner, (4, 5, 6, 7)]
    return polyhedra.polyhedron(points, loops, holes={rim: [(15, 14, 13, 12)]})


@_builder("a ramp that falls along its width")
def _make_wedge(width: Length = 0.3, depth: Length = 0.2, height: Length = 0.15) -> Scene:
    return polyhedra.wedge(width, depth, height)


@_builder("a square pyramid")
def _make_pyramid(width: Length = 0.3, height: Length = 0.25) -> Scene:
    return polyhedra.pyramid(width, height)


@_builder("a block with a quarter cut away along its depth, like a step")
def _make_l_block(width: Length = 0.4, depth: Length = 0.2, height: Length = 0.4) -> Scene:
    return polyhedra.l_block(width, depth, height)


@_builder(
    "a floor and two walls of that width seen from inside, the walls at an angle", is_solid=False
)
def _make_room_corner(
    width: Length = 3.0, height: Length = 2.5, angle: Angle = math.pi / 2
) -> Scene:
    return polyhedra.room_corner(width, height, angle=angle)


@_builder("a top on four square legs")
def _make_table(
    width: Length = 0.8,
    length: Length = 1.2,
    height: Length = 0.74,
    thickness: Length = 0.04,
    leg: Length = 0.06,
) -> Scene:
    _check_fit("the thickness", thickness, "the height", height)
    _check_legs(leg, length, width)
    inset = RIM_SHARE * min(length, width)
    return polyhedra.table(length, width, height, thickness=thickness, leg=leg, inset=inset)


@_builder("a top on two side panels, one of which may be a drawer block, half closed behind")
def _make_desk(
    width: Length = 0.7,
    length: Length = 1.4,
    height: Length = 0.74,
    thickness: Length = 0.03,
    panel: Length = 0.03,
    block: Length = 0.03,
) -> Scene:
    # The panel at the rear (+y) hangs down by half the height; the block stands at the right (+x).
    rim = RIM_SHARE * min(length, width)
    wider = max(panel, block)
    _check_fit("the thickness", thickness, "half the height", height / 2)
    _check_fit(
        "two panels, or one and a block, with their rims",
        panel + wider + 2 * rim,
        "the length",
        length,
    )
    _check_fit("the panel", panel, "half the width", width / 2)
    under = height - thickness
    left, right = rim + panel, length - rim - wider
    rear = (1 - MODESTY_INSET_SHARE) * width
    near, far = rim, width - rim
    return _put_together(
        (
            _Piece((0.0, 0.0, under), (length, width, height)),
            _Piece((rim, near, 0.0), (left, far, under), ("top",)),
            _Piece((right, near, 0.0), (length - rim, far, under), ("top",)),
            _Piece(
                (left, rear - panel, under - MODESTY_SHARE * height),
                (right, rear, under),
                ("top", "left", "right"),
            ),
        )
    )


@_builder("a seat at some height on four legs, with a back up to the whole height")
def _make_chair(
    width: Length = 0.45,
    depth: Length = 0.45,
    seat: Length = 0.45,
    height: Length = 0.9,
    thickness: Length = 0.04,
    leg: Length = 0.04,
) -> Scene:
    _check_fit("the thickness", thickness, "the seat's height", seat)
    _check_fit("the seat's height", seat, "the height", height)
    _check_fit("the back's thickness", thickness, "the depth", depth)
    _check_legs(leg, width, depth)
    inset = RIM_SHARE * min(width, depth)
    return polyhedra.chair(width, depth, seat, height, thickness=thickness, leg=leg, inset=inset)


@_builder("a seat on four legs without a back")
def _make_stool(
    width: Length = 0.35,
    depth: Length = 0.35,
    height: Length = 0.45,
    thickness: Length = 0.03,
    leg: Length = 0.04,
) -> Scene:
    return _make_table(depth, width, height, thickness, leg)


@_builder("a long low seat on two panels across it")
def _make_bench(
    width: Length = 0.35,
    length: Length = 1.2,
    height: Length = 0.45,
    thickness: Length = 0.04,
    panel: Length = 0.04,
) -> Scene:
    rim = RIM_SHARE * min(length, width)
    _check_fit("the thickness", thickness, "the height", height)
    _check_fit("two panels with their rims", 2 * panel + 2 * rim, "the length", length)
    under = height - thickness
    supports = (
        _Piece((x, rim, 0.0), (x + panel, width - rim, under), ("top",))
        for x in (rim, length - rim - panel)
    )
    return _put_together((_Piece((0.0, 0.0, under), (length, width, height)), *supports))


@_builder("a block to lie on, with a board across its head")
def _make_bed(
    width: Length = 0.9, length: Length = 2.0, height: Length = 0.45, head: Length = 0.85
) -> Scene:
    _check_fit("the height", height, "that of the head", head)
    low = [(0.0, 0.0, 0.0), (0.0, 0.0, 0.0)]
    high = [(length, width, height), (HEAD_SHARE * length, width, head)]
    return cuboid_union(low, high, "bed")


@_builder("a long block to sit on, with a back and two arms")
def _make_sofa(
    width: Length = 2.0,
    depth: Length = 0.9,
    seat: Length = 0.42,
    height: Length = 0.8,
    arm: Length = 0.2,
) -> Scene:
    _check_fit("the seat's height", seat, "the height", height)
    _check_fit("two arms", 2 * arm, "the width", width)
    back = (1.0 - BACK_SHARE) * depth
    rest = seat + ARMS_SHARE * (height - seat)
    low = [(0.0, 0.0, 0.0), (0.0, back, 0.0), (0.0, 0.0, 0.0), (width - arm, 0.0, 0.0)]
    high = [(width, depth, seat), (width, depth, height), (arm, depth, rest), (width, depth, rest)]
    return cuboid_union(low, high, "sofa")


@_builder("an upright frame of four rails round one opening")
def _make_frame(
    width: Length = 0.3, height: Length = 0.4, thickness: Length = 0.02, rim: Length = 0.04
) -> Scene:
    _check_fit("two rails", 2 * rim, "the shorter side", min(width, height))
    low = [(0.0, 0.0, 0.0), (0.0, 0.0, height - rim), (0.0, 0.0, 0.0), (width - rim, 0.0, 0.0)]
    tops = [(width, rim), (width, height), (rim, height), (width, height)]
    return cuboid_union(low, [(x, thickness, z) for x, z in tops], "frame")


@_builder("level boards between two sides, open in front and behind")
def _make_shelf(
    width: Length = 0.8,
    depth: Length = 0.3,
    height: Length = 1.8,
    boards: Count = 5,
    thickness: Length = 0.02,
) -> Scene:
    rim = RIM_SHARE * min(width, depth)
    _check_fit("the two sides", 2 * thickness, "the width", width)
    # Each board but the last needs a gap above it that can be seen.
    needed = boards * thickness + 2 * rim + (boards - 2) * LEAST_LENGTH_M
    _check_fit("the boards with their rims", needed, "the height", height)
    left, right = thickness, width - thickness
    levels = np.linspace(rim, height - rim - thickness, boards).tolist()
    return _put_together(
        (
            _Piece((0.0, 0.0, 0.0), (left, depth, height)),
            _Piece((right, 0.0, 0.0), (width, depth, height)),
            *(
                _Piece((left, rim, z), (right, depth - rim, z + thickness), ("left", "right"))
                for z in levels
            ),
        )
    )


@_builder("a closed block on a plinth")
def _make_cabinet(
    width: Length = 0.8, depth: Length = 0.4, height: Length = 1.2, foot: Length = 0.08
) -> Scene:
    _check_fit("the foot", foot, "the height", height)
    rim = RIM_SHARE * min(width, depth)
    return _put_together(
        (
            _Piece((0.0, 0.0, foot), (width, depth, height)),
            _Piece((rim, rim, 0.0), (width - rim, depth - rim, foot), ("top",)),
        )
    )


@_builder("a flight of steps with risers")
def _make_stairs(
    steps: Count = 4, width: Length = 0.9, rise: Length = 0.18, going: Length = 0.28
) -> Scene:
    treads = [(going * i, rise * (i + k)) for i in range(steps) for k in (0, 1)]
    # Anticlockwise seen from -y, where x points to the right and z up.
    profile = [(0.0, 0.0), (going * steps, 0.0), (going * steps, rise * steps), *treads[:0:-1]]
    return polyhedra.extrude_profile(profile, width, sd=SD_M, name="stairs")


@_builder("an upright round solid", is_round=True)
def _make_cylinder(diameter: Length = 0.3, height: Length = 0.45) -> Scene:
    lying = polyhedra.extrude_profile(_circle(diameter), height, sd=SD_M, name="cylinder")
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    upright = polyhedra.moved(lying, turn, (0.0, diameter, 0.0))
    return replace(upright, up=np.array(polyhedra.UP))


@_builder("a round solid on its rim, with its axis along y", is_round=True)
def _make_wheel(diameter: Length = 0.1, thickness: Length = 0.03) -> Scene:
    return polyhedra.extrude_profile(_circle(diameter), thickness, sd=SD_M, name="wheel")


def _circle(diameter: float) -> list[tuple[float, float]]:
    """Return the corners of a circle that touches both axes, anticlockwise."""
    turns = (np.arange(ROUND_SIDES) / ROUND_SIDES * 2 * math.pi).tolist()
    radius = diameter / 2
    return [(radius + radius * math.cos(t), radius + radius * math.sin(t)) for t in turns]
