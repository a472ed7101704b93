"""The firmware's motion control: speeds towards the commanded targets, within limits.

Translation and rotation are commanded separately, by VEL or MOVE and by RVEL or a heading; the last
command holds until the next one.
"""

import math
from dataclasses import dataclass, field

from facetlog.robot.simulator.body.dynamics import STEP

__all__ = ["Odometry", "Ramp", "Servo"]

# A way or heading is reached when less than this is left; both are below a unit of the SIP.
WAY_REACHED = 2e-4  # metres
TURN_REACHED = math.radians(0.02)


@dataclass(frozen=True, slots=True)
class Odometry:
    """The firmware's pose estimate since odometry was last reset; metres and radians."""

    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0

    def moved(self, way: float, turn: float) -> "Odometry":
        """After a small way along an arc."""
        middle = self.heading + turn / 2
        return Odometry(
            self.x + way * math.cos(middle),
            self.y + way * math.sin(middle),
            math.remainder(self.heading + turn, 2 * math.pi),
        )


@dataclass(frozen=True, slots=True)
class Ramp:
    """Limits of one speed: the largest in either direction, and how fast it grows and falls."""

    highest: float
    lowest: float
    acceleration: float
    deceleration: float

    def towards(self, speed: float, goal: float, deceleration: float | None = None) -> float:
        """The speed a step later on the way to a goal."""
        goal = min(max(goal, self.lowest), self.highest)
        falls = self.deceleration if deceleration is None else deceleration
        if speed * goal < 0.0:
            goal = 0.0  # first to a stand
        change = (falls if abs(goal) < abs(speed) else self.acceleration) * STEP
        return min(max(goal, speed - change), speed + change)

    def for_way(self, left: float) -> float:
        """The speed from which the rest of a way is just enough to stop."""
        # v² = 2 a s, less half a step's fall, for the speed changes in steps.
        speed = math.sqrt(2 * self.deceleration * abs(left)) - self.deceleration * STEP / 2
        return math.copysign(min(max(speed, 0.0), abs(left) / STEP), left)


@dataclass(slots=True)
class Servo:
    """The commanded targets: a speed or a distance ahead, a turning speed or a heading."""

    ahead: Ramp
    turn: Ramp
    hard_deceleration: float
    """m/s² of an emergency stop."""
    hard_turn_deceleration: float
    _speed: float = field(default=0.0, init=False)
    _way: float | None = field(default=None, init=False)
    _turning: float = field(default=0.0, init=False)
    _heading: float | None = field(default=None, init=False)
    _emergency: bool = field(default=False, init=False)

    @property
    def heading(self) -> float | None:
        """The commanded heading, in the frame of odometry; None if a turning speed was."""
        return self._heading

    def drive(self, speed: float) -> None:
        """VEL."""
        if not self._emergency:
            self._speed, self._way = speed, None

    def move(self, way: float) -> None:
        """MOVE."""
        if not self._emergency:
            self._speed, self._way = 0.0, way

    def rotate(self, turning: float) -> None:
        """RVEL."""
        if not self._emergency:
            self._turning, self._heading = turning, None

    def head(self, heading: float) -> None:
        """HEAD: to a heading in the frame of odometry, the shorter way round."""
        if not self._emergency:
            self._turning, self._heading = 0.0, heading

    def stop(self) -> None:
        """STOP: to a stand with the usual deceleration."""
        self._speed, self._way, self._turning, self._heading = 0.0, None, 0.0, None

    def emergency_stop(self) -> None:
        """ESTOP: to a stand as fast as it can."""
        self.stop()
        self._emergency = True

    def turn_frame(self, turn: float) -> None:
        """Odometry's headings jumped by `turn`: the commanded one stays the same direction."""
        if self._heading is not None:
            self._heading += turn

    def went(self, way: float) -> None:
        """Reduces the commanded distance by one that was driven, by odometry."""
        if self._way is not None:
            self._way -= way

    def next_speeds(
        self, speed: float, turning: float, heading: float, *, held: bool = False
    ) -> tuple[float, float]:
        """Speed and turning a step later. `held`: to a stand now, and go on with it afterwards."""
        if self._emergency:
            if speed == 0.0 and turning == 0.0:
                self._emergency = False
            return (
                self.ahead.towards(speed, 0.0, self.hard_deceleration),
                self.turn.towards(turning, 0.0, self.hard_turn_deceleration),
            )
        if held:
            return self.ahead.towards(speed, 0.0), self.turn.towards(turning, 0.0)
        return self._next_speed(speed), self._next_turning(turning, heading)

    def _next_speed(self, speed: float) -> float:
        if self._way is None:
            return self.ahead.towards(speed, self._speed)
        if abs(self._way) < WAY_REACHED and abs(speed) <= self.ahead.deceleration * STEP:
            self._way, self._speed = None, 0.0
            return 0.0
        return self.ahead.towards(speed, self.ahead.for_way(self._way))

    def _next_turning(self, turning: float, heading: float) -> float:
        if self._heading is None:
            return self.turn.towards(turning, self._turning)
        left = math.remainder(self._heading - heading, 2 * math.pi)
        if abs(left) < TURN_REACHED and abs(turning) <= self.turn.deceleration * STEP:
            return 0.0
        return self.turn.towards(turning, self.turn.for_way(left))
