"""Conditions that stop the robot, found in its reports: bumpers, stalls, battery, wrong scale.

A driver that takes a robot for another model reads each unit of its odometry wrong by one factor: a
p3dx counts 0.485 mm, a p3dx-sh 1 mm. Wheel speeds are in mm/s in all of them, so positions and
speeds disagree by that factor, and obstacles ahead come nearer by the true distance.
"""

import math
from collections import deque
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from facetlog.robot.pioneer.parameters import MODELS, Parameters
from facetlog.robot.pioneer.state import RobotState


class Cause(StrEnum):
    """Kinds of problems."""

    BUMPER = "bumper"
    STALL = "stall"
    STOP_BUTTON = "stop button"
    MOTORS_OFF = "motors off"
    NOT_MOVING = "not moving"
    LOW_BATTERY = "low battery"
    EMERGENCY = "emergency stop"
    LEASE = "lease"
    """The lease ran out: the program did not renew it."""
    HELD_UP = "held up"
    """The program did not run for a while as the robot drove; the robot is halted."""
    QUIET = "quiet"
    """No reports for a while."""
    LINK_LOST = "link lost"
    RESET = "reset"
    REPORTS_AGAIN = "reports again"
    """Reports come again after a silence while the robot drove."""
    ODOMETRY = "odometry"
    SCALE = "scale"
    """The robot's reports disagree on their scale."""
    LOG = "log"
    CALLBACK = "callback"


@dataclass(frozen=True, slots=True)
class Problem:
    """One of them; `at` is a time of the driver's clock in seconds."""

    cause: Cause
    text: str
    """The problem and the way out, if there is one, in one line."""
    at: float
    stopped: bool = False
    """Whether the robot was stopped for it."""

    def __str__(self) -> str:
        return self.text


SPAN, TURN_SPAN = 0.5, math.pi / 2
"""Metres and radians after which the sums are compared: positions rounded to 1.3 mm and speeds to
2.5 mm/s at 0.1 m/s are off by 3 % at most over them."""
TOLERANCE = 0.15
"""Largest relative difference of positions and wheel speeds: units of models in one generation
differ by more (0.485 against 0.84, 1.0), but for some by 2 to 15 %, whose poses are off by so
much."""
TURN_TOLERANCE = 0.35
"""Such a tolerance for headings, corrected by a gyro or for skidding wheels (some 25 %)."""
LONGEST_STEP = 0.35
"""Seconds between two reports, beyond which the speed between them is not known."""
REPORT_CYCLE = 0.1
"""Seconds by which speeds may lag behind positions."""
APPROACH_TOLERANCE = 0.35
"""Such a tolerance for sonars: a wall at 40° across the way comes nearer by cos 40° of the way."""
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
    """One way by positions (`read`) and by speeds (`driven`), and the latter's possible error."""

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
            return self._describe_wrong_scale(factor, "its wheel speeds")
        if (factor := self._turn.factor(TURN_SPAN, TURN_TOLERANCE)) is not None:
            return (
                f"its heading changes by {factor:.2f} times what its wheel speeds turn it: its"
                f" scale is not that of a {self._parameters.name}; {self._suggest_models(None)}"
            )
        if (factor := self._approach.factor()) is not None:
            self._approach = _Approach()  # the next begins when it stood again
            first, self._suspected = self._suspected, factor
            if first is not None and abs(factor / first - 1.0) <= TOLERANCE:
                return self._describe_wrong_scale(factor, "its sonars' ranges ahead")
        return None

    def _turning(self, state: RobotState) -> float:
        difference = (state.right_speed - state.left_speed) / 2
        return difference * self._parameters.turning_per_speed

    def _describe_wrong_scale(self, factor: float, what: str) -> str:
        unit = 1e3 * self._parameters.distance
        return (
            f"its positions change by {factor:.2f} times the way that {what} give: it does"
            f" not count the {unit:.3g} mm of a {self._parameters.name}; "
            f"{self._suggest_models(factor)}"
        )

    def _suggest_models(self, factor: float | None) -> str:
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


BATTERY_TIME = 1.0
"""Seconds of low voltage: starting motors make it dip for some tenths."""
START_TIME = 1.5
"""Seconds within which a commanded robot has begun to move (it gains 0.3 m/s in one)."""
CERTAIN_SPEED, CERTAIN_TURNING = 0.03, 0.09
"""m/s and rad/s (5 degrees) below which motors may lack the torque to start at all."""
MOTORS_OFF_TEXT = "motors are off: press the MOTORS button or call enable_motors()"


class Guard:
    """Compares each report with the one before and with the commanded speeds."""

    def __init__(self, battery_v: float) -> None:
        self._battery_v = battery_v
        self._before: RobotState | None = None
        self._low_since: float | None = None
        self._battery_said = False
        self._told_since: float | None = None

    def look(
        self, state: RobotState, commanded: tuple[float, float], motors_wanted: bool
    ) -> list[Problem]:
        """Return the new problems in a report; `commanded` are the last speed and turning sent."""
        before, self._before = self._before, state
        found = [
            *_find_bumps(state, before),
            *_find_stalls(state, before),
            *_find_switched_off(state, before, motors_wanted),
            *self._find_low_battery(state),
            *self._idle(state, commanded),
        ]
        return [Problem(cause, text, state.at, stopped=True) for cause, text in found]

    def refusal(self, state: RobotState, speed: float) -> str | None:
        """Return why the robot may not be driven so as it is now; None if it may."""
        if state.stop_button:
            return "the STOP button is pressed: pull it out, then call enable_motors()"
        if state.motors_on is False:
            return MOTORS_OFF_TEXT
        if self._low_since is not None and state.at - self._low_since >= BATTERY_TIME:
            return self._describe_battery(state)
        if speed > 0 and any(state.front_bumpers):
            return "a front bumper is pressed: drive backward, or free the robot"
        if speed < 0 and any(state.rear_bumpers):
            return "a rear bumper is pressed: drive forward, or free the robot"
        return None

    def _describe_battery(self, state: RobotState) -> str:
        volts = f"{state.battery_v:.1f} V, limit {self._battery_v:.1f} V"
        return f"the battery is low ({volts}): charge it"

    def _find_low_battery(self, state: RobotState) -> list[tuple[Cause, str]]:
        if not 0 < state.battery_v < self._battery_v:
            self._low_since = None
            return []
        if self._low_since is None:
            self._low_since = state.at
        if self._battery_said or state.at - self._low_since < BATTERY_TIME:
            return []
        self._battery_said = True
        return [(Cause.LOW_BATTERY, self._describe_battery(state))]

    def _idle(self, state: RobotState, commanded: tuple[float, float]) -> list[tuple[Cause, str]]:
        certain = abs(commanded[0]) >= CERTAIN_SPEED or abs(commanded[1]) >= CERTAIN_TURNING
        if not certain or not state.standing or any(state.stalled):
            self._told_since = None
            return []
        if self._told_since is None:
            self._told_since = state.at
        if state.at - self._told_since < START_TIME:
            return []
        self._told_since = None
        return [
            (
                Cause.NOT_MOVING,
                f"commanded to move for {START_TIME} s, the robot stands: if its motors are off,"
                " press the MOTORS button or call enable_motors(); see that the STOP button is out",
            )
        ]


def _find_bumps(state: RobotState, before: RobotState | None) -> list[tuple[Cause, str]]:
    found = []
    for side, now, then in (
        ("front", state.front_bumpers, before.front_bumpers if before else ()),
        ("rear", state.rear_bumpers, before.rear_bumpers if before else ()),
    ):
        new = [i for i, pressed in enumerate(now) if pressed and not (i < len(then) and then[i])]
        if new:
            numbers = ", ".join(str(i + 1) for i in new)
            found.append((Cause.BUMPER, f"bumper pressed ({side} {numbers}): free the robot"))
    return found


def _find_stalls(state: RobotState, before: RobotState | None) -> list[tuple[Cause, str]]:
    if state.stop_button:
        return []  # the button shows as a stall of both wheels too (E_STALL)
    then = before.stalled if before else (False, False)
    new = [
        side
        for side, now, old in zip(("left", "right"), state.stalled, then, strict=True)
        if now and not old
    ]
    if not new:
        return []
    wheels = " and ".join(new)
    return [(Cause.STALL, f"{wheels} wheel stalled: something is in the way; free the robot")]


def _find_switched_off(
    state: RobotState, before: RobotState | None, motors_wanted: bool
) -> list[tuple[Cause, str]]:
    if state.stop_button and not (before and before.stop_button):
        return [(Cause.STOP_BUTTON, "STOP button pressed: pull it out, then call enable_motors()")]
    if state.stop_button is None:
        return []  # old firmware: the motors' state is inferred from problems already reported
    went_off = before is not None and before.motors_on and state.motors_on is False
    if went_off and motors_wanted:
        return [(Cause.MOTORS_OFF, MOTORS_OFF_TEXT)]
    return []
