"""The Sony heads whose angles are known: counts to a degree, limits, speeds.

Positive counts are pan to the right and tilt up (EVI-D70 manual, page 51). Ours are pan to the
left, radians.
"""

import math
from dataclasses import dataclass
from typing import Final

from facetlog.robot.head.head import HeadLimits


@dataclass(frozen=True, slots=True)
class SonyModel:
    """A head: its model word in the version inquiry, and its scale in counts."""

    name: str
    word: int
    pan_per_degree: float
    tilt_per_degree: float
    pan_limit: int
    """Counts to either side."""
    tilt_lowest: int
    tilt_highest: int
    zoom_highest: int
    """The end of the optical zoom, counts."""
    pan_speeds_deg: tuple[float, ...] = ()
    """Degrees a second for the speeds 1, 2, …; empty where no source gives them."""
    tilt_speeds_deg: tuple[float, ...] = ()

    @property
    def limits(self) -> HeadLimits:
        """How far it turns, in our signs and units."""
        pan, _ = self.angles(-self.pan_limit, 0)
        return HeadLimits(
            pan_min=-pan,
            pan_max=pan,
            tilt_min=self.angles(0, self.tilt_lowest)[1],
            tilt_max=self.angles(0, self.tilt_highest)[1],
            pan_step=math.radians(1 / self.pan_per_degree),
            tilt_step=math.radians(1 / self.tilt_per_degree),
            zoom_max=self.zoom_highest,
        )

    def counts(self, pan: float, tilt: float) -> tuple[int, int]:
        """Return the nearest counts of angles in radians, pan left positive; within half a count.

        >>> import math
        >>> EVI_D30.counts(math.radians(-30), math.radians(-10))
        (264, -120)
        """
        return (
            round(-math.degrees(pan) * self.pan_per_degree),
            round(math.degrees(tilt) * self.tilt_per_degree),
        )

    def angles(self, pan: float, tilt: float) -> tuple[float, float]:
        """Convert counts to radians, pan left positive."""
        return -math.radians(pan / self.pan_per_degree), math.radians(tilt / self.tilt_per_degree)


EVI_D30: Final = SonyModel(
    # EVI-D100 manual, pages 44-45, and EVI-D70 manual, page 58: 0370h = 100°, 012Ch = 25°, and 88
    # steps of one count turn it by 10° (ARIA takes 90° and 30° for the same counts);
    # pan speeds are multiples of 3.33°/s up to 80°/s, tilt speeds of 2.5°/s up to 50°/s.
    name="EVI-D30",
    word=0x0402,
    pan_per_degree=8.8,
    tilt_per_degree=12.0,
    pan_limit=0x370,
    tilt_lowest=-0x12C,
    tilt_highest=0x12C,
    zoom_highest=0x3FF,
    pan_speeds_deg=tuple(80.0 * step / 24 for step in range(1, 25)),
    tilt_speeds_deg=tuple(2.5 * step for step in range(1, 21)),
)

D100_SPEEDS_DEG = (
    *(2.0, 2.4, 3.0, 3.7, 4.7, 6.1, 7.4, 9.1, 11.0, 14.0, 18.0, 22.0, 27.0, 34.0, 42.0, 52.0),
    *(65.0, 81.0, 100.0, 125.0, 155.0, 190.0, 240.0, 300.0),
)

EVI_D100: Final = SonyModel(
    # EVI-D100 manual, pages 44-45: 05A0h = 100°, 0168h = 25°. The zoom is that of its camera
    # block's family (4000h is the optical end; EVI-D80/D90 and EVI-D70 manuals).
    name="EVI-D100",
    word=0x040D,
    pan_per_degree=14.4,
    tilt_per_degree=14.4,
    pan_limit=0x5A0,
    tilt_lowest=-0x168,
    tilt_highest=0x168,
    zoom_highest=0x4000,
    pan_speeds_deg=D100_SPEEDS_DEG,
    tilt_speeds_deg=D100_SPEEDS_DEG[:20],
)

EVI_D70: Final = SonyModel(
    # EVI-D70 manual, page 51: a count is 0.075°, 08DBh = 170°, FE70h = -30°, 04B0h = +90°.
    name="EVI-D70",
    word=0x040E,
    pan_per_degree=1 / 0.075,
    tilt_per_degree=1 / 0.075,
    pan_limit=0x8DB,
    tilt_lowest=-0x190,
    tilt_highest=0x4B0,
    zoom_highest=0x4000,
)

SONY_MODELS: Final = {model.word: model for model in (EVI_D30, EVI_D100, EVI_D70)}
"""By the model word of the version inquiry."""
