"""How fast the robot may go, how hard it brakes, and how empty its battery may be."""

import math
from dataclasses import dataclass, replace

from facetlog.robot.pioneer.packets.configuration import Configuration
from facetlog.robot.pioneer.parameters import Parameters

__all__ = ["BRAKING_TIME", "Limits"]

BRAKING_TIME = 0.25
"""Seconds from full speed to standing: with a lease of 0.3 s the robot then stands 0.6 s after its
program died."""
LOW_BATTERY_V = 11.0
"""Of a 12 V lead battery, under load: close to empty (10.8 V is its end)."""


@dataclass(frozen=True, slots=True)
class Limits:
    """Metres, radians and seconds; ValueError for an impossible limit."""

    speed: float = 0.3
    """m/s: a slow walk; a robot of 9 kg is stopped by a foot."""
    turning: float = math.radians(30)
    deceleration: float = 1.2
    """m/s², of the default speed in `BRAKING_TIME`."""
    turning_deceleration: float = math.radians(120)
    battery_v: float | None = None
    """The robot stops below it; None: the robot's own figure, or 11.0 V if it has none."""

    def __post_init__(self) -> None:
        named = (
            ("speed", self.speed),
            ("turning", self.turning),
            ("deceleration", self.deceleration),
            ("turning_deceleration", self.turning_deceleration),
        )
        for name, value in named:
            if not (math.isfinite(value) and value > 0):
                raise ValueError(f"a limit of {name} is positive, not {value}")
        if self.battery_v is not None and not (
            math.isfinite(self.battery_v) and self.battery_v >= 0
        ):
            raise ValueError(f"a battery's limit is a voltage, not {self.battery_v}")

    def of_robot(self, parameters: Parameters, configuration: Configuration | None) -> "Limits":
        """The same, no higher than what the model and the robot itself allow."""
        speed, turning = parameters.speed_top, parameters.turning_top
        deceleration, turning_deceleration = self.deceleration, self.turning_deceleration
        battery = self.battery_v
        if configuration is not None:
            c = configuration
            # A figure of 0 is one that the robot, or a simulator, does not have.
            speed = min(speed, (c.speed_top or math.inf) / 1e3)
            turning = min(turning, math.radians(c.turning_top or math.inf))
            deceleration = min(deceleration, (c.acceleration_top or math.inf) / 1e3)
            turning_deceleration = min(
                turning_deceleration, math.radians(c.turning_acceleration_top or math.inf)
            )
            if battery is None and c.low_battery:
                battery = c.low_battery / 10
        return replace(
            self,
            speed=min(self.speed, speed),
            turning=min(self.turning, turning),
            deceleration=deceleration,
            turning_deceleration=turning_deceleration,
            battery_v=LOW_BATTERY_V if battery is None else battery,
        )

    def clip(self, speed: float, turning: float) -> tuple[float, float]:
        """Both speeds, scaled down by one factor to within the limits: the curve stays the same.

        ValueError if they are no numbers.

        >>> Limits(speed=0.25).clip(-1.0, 0.5)
        (-0.25, 0.125)
        """
        if not (math.isfinite(speed) and math.isfinite(turning)):
            raise ValueError(f"a robot cannot drive at {speed} m/s and {turning} rad/s")
        share = max(1.0, abs(speed) / self.speed, abs(turning) / self.turning)
        return speed / share, turning / share

    def brakes_in_time(self, speed: float, turning: float) -> bool:
        """Whether the robot stands within `BRAKING_TIME` by its ordinary deceleration."""
        slack = 1 + 1e-9
        return (
            abs(speed) <= self.deceleration * BRAKING_TIME * slack
            and abs(turning) <= self.turning_deceleration * BRAKING_TIME * slack
        )
