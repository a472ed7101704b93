"""What the driver sets in the robot itself, so that it keeps the limits alone, and sets back."""

import math

from facetlog.robot.pioneer.commands import Command, integer_command
from facetlog.robot.pioneer.configuration import Configuration
from facetlog.robot.pioneer.limits import Limits
from facetlog.robot.pioneer.packet import Packet

__all__ = ["own_settings", "restored_settings"]

BUMPERS_STALL = 3
"""Bumpers of both ends stop the wheels without the program's help."""


def own_settings(limits: Limits) -> list[Packet]:
    """Commands that make the robot keep to the limits, and stop where a bumper is pressed."""
    return [
        integer_command(Command.BUMPSTALL, BUMPERS_STALL),
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
