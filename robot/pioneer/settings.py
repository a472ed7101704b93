"""What the driver sets in the robot itself, so that it keeps the limits alone, and sets back.

The robot acknowledges nothing: what was set shows in its CONFIG, and what is not shown there is
sent several times.
"""

import math
from collections.abc import Callable, Sequence

from facetlog.robot.pioneer.commands import Command, argument_of, integer_command
from facetlog.robot.pioneer.configuration import Configuration
from facetlog.robot.pioneer.limits import Limits
from facetlog.robot.pioneer.packet import Packet

__all__ = ["make_arrive", "own_settings", "restored_settings"]

FRONT_BUMPERS_STALL, REAR_BUMPERS_STALL = 1, 2
"""Bumpers of that end stop the wheels without the program's help."""
SENDINGS = 3
"""Of a setting that does not show: with a packet in ten lost, one robot in a thousand misses it."""
SHOWN = {
    Command.SETV: "speed_max",
    Command.SETRV: "turning_max",
    Command.SETA: "deceleration",
    Command.SETRA: "turning_deceleration",
}
"""Where CONFIG tells what was set, accelerations by their negative values."""


def own_settings(limits: Limits, configuration: Configuration | None) -> list[Packet]:
    """Commands that make the robot keep to the limits, and stop where a bumper is pressed.

    Bumpers that CONFIG does not tell of may be inputs that nothing is connected to.
    """
    bumpers = 0
    if configuration is not None:
        bumpers |= FRONT_BUMPERS_STALL if configuration.front_bumpers else 0
        bumpers |= REAR_BUMPERS_STALL if configuration.rear_bumpers else 0
    return [
        *([integer_command(Command.BUMPSTALL, bumpers)] if bumpers else []),
        integer_command(Command.SETV, max(1, round(limits.speed * 1e3))),
        integer_command(Command.SETRV, max(1, round(math.degrees(limits.turning)))),
        integer_command(Command.SETA, -max(1, round(limits.deceleration * 1e3))),
        integer_command(Command.SETRA, -max(1, round(math.degrees(limits.turning_deceleration)))),
    ]


def restored_settings(configuration: Configuration | None) -> list[Packet]:
    """Commands that give the robot back what CONFIG said; none for what it did not say."""
    if configuration is None:
        return []
    c = configuration
    values = (
        (Command.SETV, c.speed_max, 1),
        (Command.SETRV, c.turning_max, 1),
        (Command.SETA, c.deceleration, -1),
        (Command.SETRA, c.turning_deceleration, -1),
    )
    return [integer_command(command, sign * value) for command, value, sign in values if value]


def make_arrive(
    settings: Sequence[Packet],
    send: Callable[[Sequence[Packet]], None],
    ask: Callable[[], Configuration | None],
) -> None:
    """Sends settings, and those that CONFIG does not show again, each up to three times.

    `ask` is what CONFIG says now, None where it is not answered.
    """
    for sending in range(SENDINGS):
        if not settings:
            return
        send(settings)
        if sending + 1 < SENDINGS:
            told = ask()
            settings = [each for each in settings if not _shown(each, told)]


def _shown(setting: Packet, told: Configuration | None) -> bool:
    value, name = argument_of(setting), SHOWN.get(Command(setting.kind))
    if told is None or name is None or not isinstance(value, int):
        return False
    return bool(getattr(told, name) == abs(value))
