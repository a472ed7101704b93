"""Limits of speed, braking and battery, in the driver and as settings of the robot's firmware.

The robot acknowledges nothing: some settings can be read back in its CONFIG, the others are sent
several times.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from facetlog.robot.pioneer.packets.commands import Command, make_integer_command, read_argument
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.packets.reports import Configuration
from facetlog.robot.pioneer.parameters import Parameters

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

    def restrict_to_robot(
        self, parameters: Parameters, configuration: Configuration | None
    ) -> "Limits":
        """Return the limits, no higher than the model and the robot itself allow."""
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
        """Return both speeds, scaled down by one factor to within the limits: the curve stays the
        same.

        ValueError if they are no numbers.

        >>> Limits(speed=0.25).clip(-1.0, 0.5)
        (-0.25, 0.125)
        """
        if not (math.isfinite(speed) and math.isfinite(turning)):
            raise ValueError(f"a robot cannot drive at {speed} m/s and {turning} rad/s")
        share = max(1.0, abs(speed) / self.speed, abs(turning) / self.turning)
        return speed / share, turning / share

    def can_brake_in_time(self, speed: float, turning: float) -> bool:
        """Return whether the robot stands within `BRAKING_TIME` by its ordinary deceleration."""
        slack = 1 + 1e-9
        return (
            abs(speed) <= self.deceleration * BRAKING_TIME * slack
            and abs(turning) <= self.turning_deceleration * BRAKING_TIME * slack
        )


FRONT_BUMPERS_STALL, REAR_BUMPERS_STALL = 1, 2
"""Bumpers of that end stop the wheels without the program's help."""
SENDINGS = 3
"""Times that a setting is sent which cannot be read back: with a packet in ten lost, one robot in a
thousand misses it."""
READ_BACK = {
    Command.SETV: "speed_max",
    Command.SETRV: "turning_max",
    Command.SETA: "deceleration",
    Command.SETRA: "turning_deceleration",
}
"""The field of CONFIG with each setting; decelerations are commanded as negative values."""


def make_limit_settings(limits: Limits, configuration: Configuration | None) -> list[Packet]:
    """Return commands that make the robot keep to the limits, and stop where a bumper is pressed.

    Bumpers that CONFIG does not list may be unconnected inputs.
    """
    bumpers = 0
    if configuration is not None:
        bumpers |= FRONT_BUMPERS_STALL if configuration.front_bumpers else 0
        bumpers |= REAR_BUMPERS_STALL if configuration.rear_bumpers else 0
    return [
        *([make_integer_command(Command.BUMPSTALL, bumpers)] if bumpers else []),
        make_integer_command(Command.SETV, max(1, round(limits.speed * 1e3))),
        make_integer_command(Command.SETRV, max(1, round(math.degrees(limits.turning)))),
        make_integer_command(Command.SETA, -max(1, round(limits.deceleration * 1e3))),
        make_integer_command(
            Command.SETRA, -max(1, round(math.degrees(limits.turning_deceleration)))
        ),
    ]


def make_restoring_settings(configuration: Configuration | None) -> list[Packet]:
    """Return commands that restore the settings of CONFIG; none for those that it does not have."""
    if configuration is None:
        return []
    c = configuration
    values = (
        (Command.SETV, c.speed_max, 1),
        (Command.SETRV, c.turning_max, 1),
        (Command.SETA, c.deceleration, -1),
        (Command.SETRA, c.turning_deceleration, -1),
    )
    return [make_integer_command(command, sign * value) for command, value, sign in values if value]


def send_until_confirmed(
    settings: Sequence[Packet],
    send: Callable[[Sequence[Packet]], None],
    ask: Callable[[], Configuration | None],
) -> None:
    """Send settings, and repeat those that CONFIG does not confirm, each up to three times.

    `ask` requests the present CONFIG, None where it is not answered.
    """
    for sending in range(SENDINGS):
        if not settings:
            return
        send(settings)
        if sending + 1 < SENDINGS:
            reported = ask()
            settings = [each for each in settings if not _confirmed(each, reported)]


def _confirmed(setting: Packet, reported: Configuration | None) -> bool:
    value, name = read_argument(setting), READ_BACK.get(Command(setting.kind))
    if reported is None or name is None or not isinstance(value, int):
        return False
    return bool(getattr(reported, name) == abs(value))
