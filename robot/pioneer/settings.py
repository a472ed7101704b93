"""Settings in the robot itself, so that its firmware keeps to the limits, and their restoration.

The robot acknowledges nothing: some settings can be read back in its CONFIG, the others are sent
several times.
"""

import math
from collections.abc import Callable, Sequence

from facetlog.robot.pioneer.limits import Limits
from facetlog.robot.pioneer.packets.commands import Command, argument_of, integer_command
from facetlog.robot.pioneer.packets.configuration import Configuration
from facetlog.robot.pioneer.packets.packet import Packet

__all__ = ["limit_settings", "restored_settings", "send_until_confirmed"]

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


def limit_settings(limits: Limits, configuration: Configuration | None) -> list[Packet]:
    """Commands that make the robot keep to the limits, and stop where a bumper is pressed.

    Bumpers that CONFIG does not list may be unconnected inputs.
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
    """Commands that restore the settings of CONFIG; none for those that it does not have."""
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


def send_until_confirmed(
    settings: Sequence[Packet],
    send: Callable[[Sequence[Packet]], None],
    ask: Callable[[], Configuration | None],
) -> None:
    """Sends settings, and repeats those that CONFIG does not confirm, each up to three times.

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
    value, name = argument_of(setting), READ_BACK.get(Command(setting.kind))
    if reported is None or name is None or not isinstance(value, int):
        return False
    return bool(getattr(reported, name) == abs(value))
