"""Parameters of the models: units of their reports, limits, sizes, sonars.

Figures of the maker's parameter files, as two independent drivers carry them, but for the unit of
angles: 2π/4096 rad (2π/1024 on the Pioneer 1), where those files round to 0.00153.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from types import MappingProxyType


class Generation(IntEnum):
    """Firmware of the family, in the order in which it came.

    PSOS (Pioneer 1), P2OS (Pioneer 2, from 1999), AROS (their second controller, the H8 boards),
    ARCOS (the third).
    """

    PSOS = 0
    P2OS = 1
    AROS = 2
    ARCOS = 3

    @property
    def reports_motors(self) -> bool:
        """Whether its flags include motors and stop button; before, a pulse width stood there."""
        return self >= Generation.AROS


@dataclass(frozen=True, slots=True)
class SonarPlace:
    """Where a sonar sits, metres and radians in the robot's frame: x ahead, y left."""

    x: float
    y: float
    heading: float


@dataclass(frozen=True, slots=True)
class Parameters:
    """The parameters of one model: metres, radians and seconds for each of the robot's units."""

    name: str
    distance: float
    """Metres in a unit of odometry."""
    speed: float
    """m/s in a unit of wheel speed."""
    range: float
    """Metres in a unit of sonar range."""
    angle: float
    """Radians in a unit of heading."""
    turning_per_speed: float
    """rad/s of turning in a m/s of half the difference of the wheels' speeds: 2 / track."""
    speed_top: float
    """m/s; the value in the robot's CONFIG overrides it."""
    turning_top: float
    """rad/s."""
    radius: float
    """Metres, of the circle about the middle that holds the robot."""
    width: float
    position_bits: int
    """Bits of odometry; beyond them it wraps around."""
    fast_baud: int | None = 38400
    """What a serial line may be switched to."""
    sonars: tuple[SonarPlace, ...] = ()

    @property
    def generation(self) -> Generation:
        """The firmware that the model is sold with.

        >>> MODELS["p2dx"].generation.name, MODELS["p3dx-sh"].generation.name
        ('P2OS', 'ARCOS')
        """
        if self.name.endswith("-sh"):
            return Generation.ARCOS
        # The robots whose controller was exchanged for the one that AROS was written for.
        if self.name in ("p2d8", "p2at8", "p3dx", "p3at"):
            return Generation.AROS
        return Generation.P2OS if self.name.startswith("p2") else Generation.PSOS


_FRONT_MM = ((115, 130, 90), (155, 115, 50), (190, 80, 30), (210, 25, 10))


def _list_sonars(count: int) -> tuple[SonarPlace, ...]:
    front = (*_FRONT_MM, *((x, -y, -angle) for x, y, angle in reversed(_FRONT_MM)))
    rear = tuple((-x, y, math.copysign(180, angle) - angle) for x, y, angle in reversed(front))
    places = (front + rear)[:count]
    return tuple(SonarPlace(x / 1e3, y / 1e3, math.radians(angle)) for x, y, angle in places)


def _make_pioneer_2(
    name: str, mm: float, sonar_mm: float, turning: float, large: bool
) -> Parameters:
    return Parameters(
        name,
        distance=mm / 1e3,
        speed=1e-3,
        range=sonar_mm / 1e3,
        angle=2 * math.pi / 4096,
        turning_per_speed=turning * 1e3,
        speed_top=1.2 if large else 2.2,
        turning_top=math.radians(300 if large else 500),
        radius=0.5 if large else 0.25,
        width=0.505 if large else 0.425,
        position_bits=12,
        sonars=_list_sonars(16),
    )


def _make_pioneer_1(name: str, mm: float, speed_top: float, radius: float) -> Parameters:
    return Parameters(
        name,
        distance=mm / 1e3,
        speed=2.5332e-3,
        range=0.1734e-3,
        angle=2 * math.pi / 1024,
        turning_per_speed=1e3 / 300,
        speed_top=speed_top,
        turning_top=math.radians(100),
        radius=radius,
        width=0.4,
        position_bits=15,
        fast_baud=None,
    )


_LISTED = (
    _make_pioneer_2("p2dx", 0.840, 0.268, 0.0056, large=False),
    _make_pioneer_2("p2de", 0.969, 0.268, 0.0056, large=False),
    _make_pioneer_2("p2ce", 0.826, 0.268, 0.0057, large=False),
    _make_pioneer_2("p2df", 0.485, 0.268, 0.0060, large=False),
    _make_pioneer_2("p2d8", 0.485, 1.0, 0.0056, large=False),
    _make_pioneer_2("p2at", 1.32, 0.268, 0.0034, large=True),
    _make_pioneer_2("p2at8", 1.32, 1.0, 0.0034, large=True),
    _make_pioneer_2("p2it", 1.136, 0.268, 0.0032, large=True),
    _make_pioneer_2("p3dx", 0.485, 1.0, 0.0056, large=False),
    _make_pioneer_2("p3dx-sh", 1.0, 1.0, 0.0056, large=False),
    _make_pioneer_2("p3at", 0.465, 1.0, 0.0034, large=True),
    _make_pioneer_2("p3at-sh", 1.0, 1.0, 0.0034, large=True),
    _make_pioneer_1("pion1m", 0.05066, 0.4, 0.22),
    _make_pioneer_1("pion1x", 0.05066, 0.4, 0.22),
    _make_pioneer_1("psos1m", 0.05066, 0.4, 0.22),
    _make_pioneer_1("psos1x", 0.05066, 0.4, 0.22),
    _make_pioneer_1("pionat", 0.070, 0.5, 0.33),
)
MODELS: Mapping[str, Parameters] = MappingProxyType({each.name: each for each in _LISTED})


def find_parameters(subclass: str) -> Parameters:
    """Return the parameters of a model named in the answer to SYNC2; KeyError if it is unknown.

    >>> find_parameters("P3DX").width
    0.425
    """
    return MODELS[subclass.strip().lower()]
