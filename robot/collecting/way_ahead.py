"""How far the way ahead is free by the robot's sonars, and how fast it may then be driven.

A sonar reports the nearest echo anywhere in its beam, so the echo counts as lying wherever in the
beam it would be in the way. Sonars see what stands at their height, some 0.2 m, and no smooth wall
at a grazing angle: they make driving safer, the keep-out circles make it safe.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from facetlog.robot.pioneer.state import SonarRange

__all__ = ["Body", "free_ahead", "safe_speed"]

# A beam is some 30 degrees wide (Pioneer 2 manual); an arc of it is looked at in so many places.
BEAM, PLACES = math.radians(30.0), 5
# An echo this old shows the way no longer, seconds: eight sonars of an array take 0.32 in turn.
FRESH = 1.0
# Metres beside the robot's width that count as its way: driving misses its route by 2 cm.
BESIDE = 0.02
# A sonar measures from 0.1 m on (Pioneer 2 manual), right to 1 cm: what it reports to be no farther
# than this may be at any distance.
NEAREST = 0.12
# Metres that are left before what is ahead: a sonar is right to 1 cm, and as much again.
ROOM = 0.02
# Seconds until the robot begins to brake: a report's cycle of 0.1, a lease of 0.3, and 0.05 until
# the firmware looks at what came. It brakes by the maker's deceleration at least, m/s².
UNNOTICED, BRAKING = 0.45, 0.3


@dataclass(frozen=True, slots=True)
class Body:
    """Radius of the circle about the robot's middle that holds it, and its width, metres."""

    radius: float
    width: float


def free_ahead(sonars: Iterable[SonarRange], body: Body, at: float, speed: float) -> float:
    """Metres until the robot's front reaches the nearest echo in its way; infinite without one.

    `at` is the time of the report (s), `speed` the robot's ahead (m/s): it has come nearer since an
    echo was heard.
    """
    free = math.inf
    for sonar in sonars:
        age = at - sonar.at
        if sonar.place is None or age > FRESH:
            continue
        for i in range(PLACES):
            angle = sonar.place.heading + BEAM * (i / (PLACES - 1) - 0.5)
            x = sonar.place.x + sonar.range * math.cos(angle)
            y = sonar.place.y + sonar.range * math.sin(angle)
            if x > 0 and abs(y) <= body.width / 2 + BESIDE:
                left = x - body.radius - max(speed, 0.0) * age
                free = min(free, left if sonar.range > NEAREST else 0.0)
    return free


def safe_speed(free: float) -> float:
    """The speed (m/s) from which the robot stands before what is so many metres ahead.

    >>> [round(safe_speed(free), 2) for free in (0.02, 0.1, 0.5)]
    [0.0, 0.12, 0.42]
    """
    # v t + v² / 2a = s
    way = max(free - ROOM, 0.0)
    return BRAKING * (math.sqrt(UNNOTICED**2 + 2 * way / BRAKING) - UNNOTICED)
