"""Whether a robot's reports agree on their scale: positions with wheel speeds, and with sonars.

A driver that takes a robot for another model reads each unit of its odometry wrong by one factor: a
p3dx counts 0.485 mm, a p3dx-sh 1 mm. Wheel speeds are in mm/s in all of them, so both disagree by
that factor while it drives; and what stands ahead comes nearer by the true way, not the read one.
"""

import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from facetlog.robot.pioneer.parameters import MODELS, Parameters
from facetlog.robot.pioneer.state import RobotState

__all__ = ["ScaleCheck"]

SPAN, TURN_SPAN = 0.5, math.pi / 2
"""Metres and radians after which the sums are compared: positions rounded to 1.3 mm and speeds to
2.5 mm/s at 0.1 m/s are off by 3 % at most over them."""
TOLERANCE = 0.15
"""Largest relative difference of positions and wheel speeds: units of models in one generation
differ by more (0.485 against 0.84, 1.0), but for some by 2 to 15 %, whose poses are off by so
much."""
TURN_TOLERANCE = 0.35
"""The same of headings, which a robot corrects by its gyro or for wheels that skid (some 25 %)."""
LONGEST_STEP = 0.35
"""Seconds between two reports, beyond which the speed between them is not known."""
REPORT_CYCLE = 0.1
"""Seconds by which speeds may lag behind positions."""
APPROACH_TOLERANCE = 0.35
"""The same of sonars: a wall at 40° across the way comes nearer by cos 40° of the way."""
AHEAD = math.radians(15.0)
"""Sonars that look ahead: their range falls by 1 to 1.04 of the way."""
STRAIGHT = math.radians(3.0)
SONAR_NOISE = 0.03
"""Metres, rms off a line, within which ranges fall evenly: three times a sonar's resolution of
1 cm. A person who walks towards the robot may do so once; two approaches have to agree."""
STANDING_REPORTS = 5
"""Reports over which what is ahead stood still while the robot did."""


@dataclass(slots=True)
class _Sums:
    """What positions and what speeds say of one way, and how far the latter may be off."""

    read: float = 0.0
    driven: float = 0.0
    unsure: float = 0.0

    def add(self, read: float, before: float, now: float, seconds: float) -> None:
        """Add a step from one speed to the next."""
        self.read += abs(read)
        self.driven += abs(before + now) / 2 * seconds
        self.unsure += abs(now - before) * (seconds / 2 + REPORT_CYCLE)

    def factor(self, span: float, tolerance: float) -> float | None:
        """Return `read` / `driven` where they differ for sure; the sums start anew after `span`."""
        if max(self.read, self.driven) < span:
            return None
        differs = abs(self.read - self.driven)
        sure = differs > tolerance * max(self.read, self.driven) + self.unsure
        factor = self.read / self.driven if sure and self.driven else None
        self.read = self.driven = self.unsure = 0.0
        return factor


@dataclass(slots=True)
class _Approach:
    """Ranges of the sonars ahead, over one straight drive that began as the robot stood."""

    way: list[float] = field(default_factory=list)
    ranges: list[dict[int, float]] = field(default_factory=list)
    standing: deque[dict[int, float]] = field(
        default_factory=lambda: deque(maxlen=STANDING_REPORTS)
    )
    heading: float = 0.0

    def add(self, state: RobotState, ahead: float) -> None:
        """Take a report, `ahead` metres on from the one before."""
        seen = {
            sonar.index: sonar.range
            for sonar in state.sonars
            if sonar.place is not None and abs(sonar.place.heading) <= AHEAD
        }
        if state.standing:
            self.way, self.ranges, self.heading = [0.0], [seen], state.pose.heading
            self.standing.append(seen)
            return
        turned = abs(math.remainder(state.pose.heading - self.heading, 2 * math.pi))
        if not self.way or ahead < 0.0 or turned > STRAIGHT:
            self.way, self.ranges = [], []
            self.standing.clear()
            return
        self.way.append(self.way[-1] + ahead)
        self.ranges.append(seen)

    def factor(self) -> float | None:
        """Return way read / way by the sonars, where all that look ahead agree that they differ."""
        if not self.way or len(self.standing) < STANDING_REPORTS:
            return None
        indices = set.intersection(*map(set, self.ranges), *map(set, self.standing))
        slopes = []
        for index in indices:
            stood = [ranges[index] for ranges in self.standing]
            fallen = np.array([ranges[index] for ranges in self.ranges])
            way = np.array(self.way)
            if max(way[-1], fallen[0] - fallen[-1]) < SPAN or np.ptp(stood) > SONAR_NOISE:
                continue
            slope = float(way @ (fallen[0] - fallen) / (way @ way))
            if math.sqrt(np.mean((fallen[0] - slope * way - fallen) ** 2)) <= SONAR_NOISE:
                slopes.append(slope)
        if len(slopes) < 2 or min(slopes) <= 0.0:
            return None
        low, high = min(slopes), max(slopes)
        if high / low > 1.0 + TOLERANCE:
            return None
        wrong = low > 1.0 + APPROACH_TOLERANCE or high < 1.0 / (1.0 + APPROACH_TOLERANCE)
        return 1.0 / float(np.mean(slopes)) if wrong else None


class ScaleCheck:
    """Compares reports, in their order, as the robot drives."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._way, self._turn = _Sums(), _Sums()
        self._approach = _Approach()
        self._suspected: float | None = None
        self._before: RobotState | None = None

    def find_fault(self, state: RobotState) -> str | None:
        """Return why the robot's scale cannot be right, by all reports so far; None if it may."""
        before, self._before = self._before, state
        if before is None:
            return None
        seconds = state.at - before.at
        step = before.pose.between(state.pose)
        if not 0.0 < seconds <= LONGEST_STEP:
            self._approach = _Approach()
            return None
        ahead = math.copysign(math.hypot(step.x, step.y), step.x)
        self._way.add(ahead, before.speed, state.speed, seconds)
        turnings = (self._turning(before), self._turning(state))
        self._turn.add(step.heading, *turnings, seconds)
        self._approach.add(state, ahead)
        if (factor := self._way.factor(SPAN, TOLERANCE)) is not None:
            return self._way_text(factor, "its wheel speeds")
        if (factor := self._turn.factor(TURN_SPAN, TURN_TOLERANCE)) is not None:
            return (
                f"its heading changes by {factor:.2f} times what its wheel speeds turn it: its"
                f" scale is not that of a {self._parameters.name}; {self._way_out(None)}"
            )
        if (factor := self._approach.factor()) is not None:
            self._approach = _Approach()  # the next begins when it stood again
            first, self._suspected = self._suspected, factor
            if first is not None and abs(factor / first - 1.0) <= TOLERANCE:
                return self._way_text(factor, "its sonars' ranges ahead")
        return None

    def _turning(self, state: RobotState) -> float:
        difference = (state.right_speed - state.left_speed) / 2
        return difference * self._parameters.turning_per_speed

    def _way_text(self, factor: float, what: str) -> str:
        unit = 1e3 * self._parameters.distance
        return (
            f"its positions change by {factor:.2f} times the way that {what} give: it does"
            f" not count the {unit:.3g} mm of a {self._parameters.name}; {self._way_out(factor)}"
        )

    def _way_out(self, factor: float | None) -> str:
        fit = () if factor is None else self._fitting(self._parameters.distance / factor)
        some = f" ({', '.join(fit)} would fit)" if fit else ""
        return f"see how far it really drove, and give its true model by --model{some}"

    def _fitting(self, distance: float) -> tuple[str, ...]:
        """Return the models of the same generation whose unit is such a `distance` (m)."""
        own = self._parameters
        return tuple(
            name
            for name, model in MODELS.items()
            if model.speed == own.speed and abs(model.distance / distance - 1.0) <= TOLERANCE / 2
        )
