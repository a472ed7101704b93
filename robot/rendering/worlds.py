"""Worlds by name, in inches: the paper's block where its tour looks, and what is not a block.

Every maker takes a seed, which varies the turn of the object, a shift of up to an inch, the floor
and the light. Furniture, stairs and `boxes` vary in size too: they are models of things as large
as real ones, on the scale that the world's `model_scale` says.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from facetlog.robot.rendering.furniture import VARIED, shrunk
from facetlog.robot.rendering.solids import (
    chair,
    cuboid,
    cylinder,
    placed,
    printed,
    pyramid,
    room_corner,
    standing_wedge,
    table,
    wedge,
)
from facetlog.robot.rendering.texture import Pattern, Texture
from facetlog.robot.rendering.world import Floor, Solid, World

INCH = 0.0254  # metres
# Where the pans of the paper's tour (figure 8) cross, and the block of its section 6, inches.
BLOCK_CENTRE = (23.2, 56.1)
BLOCK_SIZE = (10.0, 8.0, 6.0)

# Keeps a world's draws apart from those of the pictures taken of it with the same seed.
WORLD_STREAM = 1
SHIFT_IN = 1.0
# Darker than the paper's threshold of 150 of 255 by far, as its ground is.
FLOOR_ALBEDO = (0.28, 0.37)
FLOOR_CONTRAST = (0.25, 0.45)
FLOOR_PERIOD_IN = (40.0, 60.0)
# Well above 45 degrees: there the top and the side that faces the sun would be equally bright.
SUN_ELEVATION_DEG = (58.0, 70.0)
# Clutter stands outside the block's own shadow and nearer than the cameras, which are 33 in away.
CLUTTER_DISTANCE_IN = (14.0, 20.0)
CLUTTER_ALBEDO = (0.1, 0.5)
CLUTTER_SIZE_IN = (2.0, 4.5)
CLUTTER_COUNT = 5

Maker = Callable[[np.random.Generator], tuple[tuple[Solid, ...], float]]
"""Solids about the origin, and how many times larger what they are models of is."""


def make_world(name: str, seed: int = 0) -> World:
    """Return the world of that name; ValueError if there is none.

    >>> make_world("block").solids[0].size
    (10.0, 8.0, 6.0)
    """
    try:
        maker = WORLDS[name]
    except KeyError:
        raise ValueError(f"no world {name!r}; there are {', '.join(WORLDS)}") from None
    return place_in_world(name, maker, seed)


def place_in_world(name: str, maker: Maker, seed: int = 0) -> World:
    """Put what a maker makes where the tour looks, on a floor in the sun."""
    rng = np.random.default_rng([seed, 0, WORLD_STREAM])
    yaw = float(rng.uniform(-np.pi, np.pi))
    x, y = np.array(BLOCK_CENTRE) + rng.uniform(-SHIFT_IN, SHIFT_IN, 2)
    pattern = (Pattern.TILES, Pattern.WOOD)[int(rng.integers(2))]
    texture = Texture(
        pattern,
        int(rng.integers(2**31)),
        float(rng.uniform(*FLOOR_PERIOD_IN)),
        float(rng.uniform(*FLOOR_CONTRAST)),
    )
    floor = Floor(float(rng.uniform(*FLOOR_ALBEDO)), texture)
    azimuth, elevation = rng.uniform(-np.pi, np.pi), np.deg2rad(rng.uniform(*SUN_ELEVATION_DEG))
    level = np.cos(elevation)
    sun = np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
    made, model_scale = maker(rng)
    solids = tuple(placed(solid, float(x), float(y), yaw=yaw) for solid in made)
    return World(solids, floor, sun, name=name, model_scale=model_scale)


def _keep_size(make: Callable[[np.random.Generator], Solid]) -> Maker:
    return lambda rng: ((make(rng),), 1.0)


def _as_model(draw: Callable[[np.random.Generator], Solid]) -> Maker:
    def maker(rng: np.random.Generator) -> tuple[tuple[Solid, ...], float]:
        solid, model_scale = shrunk(draw(rng), rng)
        return (solid,), model_scale

    return maker


def _make_scrap(rng: np.random.Generator) -> Solid:
    """Return a small dark thing that is no box."""
    albedo = float(rng.uniform(*CLUTTER_ALBEDO))
    length, width, height = (float(x) for x in rng.uniform(*CLUTTER_SIZE_IN, 3))
    match int(rng.integers(4)):
        case 0:
            return pyramid(length, width, height, albedo=albedo)
        case 1:
            return wedge(length, width, albedo=albedo)
        case 2:
            return standing_wedge(length, height, albedo=albedo)
        case _:
            return cylinder(length, height, albedo=albedo)


def add_clutter(maker: Maker) -> Maker:
    """Put small dark things beside what a maker makes."""

    def beside(rng: np.random.Generator) -> tuple[tuple[Solid, ...], float]:
        made, model_scale = maker(rng)
        return (*made, *_make_clutter(rng)), model_scale

    return beside


def _make_clutter(rng: np.random.Generator) -> tuple[Solid, ...]:
    clutter = []
    first = rng.uniform(0, 2 * np.pi)
    for i in range(CLUTTER_COUNT):
        solid = _make_scrap(rng)
        distance = rng.uniform(*CLUTTER_DISTANCE_IN)
        angle = first + 2 * np.pi * i / CLUTTER_COUNT
        x, y = distance * np.cos(angle), distance * np.sin(angle)
        clutter.append(placed(solid, float(x), float(y), yaw=float(rng.uniform(0, np.pi))))
    return tuple(clutter)


_FIXED: Mapping[str, Callable[[np.random.Generator], Solid]] = {
    "block": lambda _: cuboid(*BLOCK_SIZE, name="block"),
    "wedge": lambda rng: wedge(10.0, 8.0) if rng.random() < 0.5 else standing_wedge(9.0, 7.0),
    "pyramid": lambda _: pyramid(10.0, 9.0, 7.0),
    "cylinder": lambda _: cylinder(9.0, 7.0),
    "corner": lambda _: room_corner(14.0, 12.0, 8.0, 0.8),
    "table": lambda _: table(14.0, 10.0, 9.0, thickness=0.8, leg=0.9),
    "chair": lambda _: chair(7.0, 7.0, 6.5, 6.5, thickness=0.7, leg=0.8),
    "printed_block": lambda rng: printed(
        cuboid(*BLOCK_SIZE, name="block"), int(rng.integers(2**31))
    ),
}

WORLDS: Mapping[str, Maker] = MappingProxyType(
    {
        "block": _keep_size(_FIXED["block"]),
        "empty": lambda _: ((), 1.0),
        **{name: _keep_size(make) for name, make in _FIXED.items()},
        "clutter_block": add_clutter(_keep_size(_FIXED["block"])),
        **{name: _as_model(draw) for name, draw in VARIED.items()},
    }
)
