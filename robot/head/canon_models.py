"""Canon's heads: how far they turn and how fast, in counts of 0.1125°.

The driver keeps to `REACH`, which both have; the simulated heads have what is their own.
"""

import math
from dataclasses import dataclass
from typing import Final

from facetlog.robot.head.canon import COUNTS_PER_DEGREE
from facetlog.robot.head.head import HeadLimits

__all__ = ["REACH", "VC_C4", "VC_C50I", "CanonModel", "angles_of", "counts_of"]


@dataclass(frozen=True, slots=True)
class CanonModel:
    """A head: limits in counts, the fastest speeds in counts a second."""

    name: str
    pan_limit: int
    tilt_lowest: int
    tilt_highest: int
    fastest_pan: int
    fastest_tilt: int
    tilt_highest_at_first: int
    """After switching on, until the range is set."""
    obeys_under_remote_control: bool
    """Whether it can be switched on before it was put under control of the serial line."""
    finds_its_middle: bool
    """Whether it homes by itself when it is switched on."""
    zoom_highest: int = 1960
    slowest: int = 8

    @property
    def limits(self) -> HeadLimits:
        """How far it turns, in our signs and units."""
        pan, _ = angles_of(-self.pan_limit, 0)
        step = math.radians(1 / COUNTS_PER_DEGREE)
        return HeadLimits(
            pan_min=-pan,
            pan_max=pan,
            tilt_min=angles_of(0, self.tilt_lowest)[1],
            tilt_max=angles_of(0, self.tilt_highest)[1],
            pan_step=step,
            tilt_step=step,
            zoom_max=self.zoom_highest,
        )


def counts_of(pan: float, tilt: float) -> tuple[int, int]:
    """Nearest counts of angles in radians, pan left positive; within half a count."""
    return (
        round(-math.degrees(pan) * COUNTS_PER_DEGREE),
        round(math.degrees(tilt) * COUNTS_PER_DEGREE),
    )


def angles_of(pan: float, tilt: float) -> tuple[float, float]:
    """Radians, pan left positive, of counts."""
    return -math.radians(pan / COUNTS_PER_DEGREE), math.radians(tilt / COUNTS_PER_DEGREE)


VC_C50I: Final = CanonModel(
    # VC-C50i programmer's manual, pages 20, 24-27, 56-61: a mode error to all but the control mode
    # command until that mode is set, and to moves until it has homed.
    name="VC-C50i",
    pan_limit=889,
    tilt_lowest=-267,
    tilt_highest=800,
    fastest_pan=800,
    fastest_tilt=622,
    tilt_highest_at_first=800,
    obeys_under_remote_control=False,
    finds_its_middle=False,
)

VC_C4: Final = CanonModel(
    # Limits and the first range of tilt as in ARIA (ArVCC4.h, ArVCC4.cpp). Player's driver for it
    # never commands it to home, and that of ROS (p2os) gives up if it does not obey its very first
    # command, power: so a VC-C4 does both.
    name="VC-C4",
    pan_limit=875,
    tilt_lowest=-267,
    tilt_highest=790,
    fastest_pan=800,
    fastest_tilt=662,
    tilt_highest_at_first=267,
    obeys_under_remote_control=True,
    finds_its_middle=True,
)

REACH: Final = CanonModel(
    # Tilt up to 88° is what all known drivers set a VC-C4 to (ARIA, Player, p2os); the fastest tilt
    # that they ask for is 69°/s.
    name="VC-C4 or VC-C50i",
    pan_limit=875,
    tilt_lowest=-267,
    tilt_highest=782,
    fastest_pan=800,
    fastest_tilt=613,
    tilt_highest_at_first=267,
    obeys_under_remote_control=False,
    finds_its_middle=False,
)
