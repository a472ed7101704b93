"""Units of the language: what they measure, and how much they are in metres, degrees or one."""

from dataclasses import dataclass
from enum import StrEnum


class Dimension(StrEnum):
    """The dimension of a measure. Numbers, shares and counts are one kind: they need no unit."""

    NUMBER = "a number"
    LENGTH = "a length"
    AREA = "an area"
    ANGLE = "an angle"


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit: its dimension, and how many metres, square metres, degrees or ones it is."""

    name: str
    dimension: Dimension
    factor: float


def _make_units(dimension: Dimension, **factors: float) -> dict[str, Unit]:
    return {name: Unit(name, dimension, factor) for name, factor in factors.items()}


INCH = 0.0254
"""Metres; exact by definition (1959)."""

UNITS = {
    **_make_units(
        Dimension.LENGTH,
        m=1.0,
        cm=0.01,
        mm=0.001,
        km=1000.0,
        inch=INCH,
        inches=INCH,
        ft=12 * INCH,
        foot=12 * INCH,
        feet=12 * INCH,
    ),
    **_make_units(
        Dimension.AREA,
        m2=1.0,
        cm2=1e-4,
        mm2=1e-6,
        km2=1e6,
        inch2=INCH**2,
        ft2=(12 * INCH) ** 2,
    ),
    **_make_units(Dimension.ANGLE, deg=1.0, rad=57.29577951308232),
    "°": Unit("°", Dimension.ANGLE, 1.0),
    "%": Unit("%", Dimension.NUMBER, 0.01),
}
