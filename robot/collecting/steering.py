"""Path tracking: speeds along a route from the robot's pose, without a clock or a robot.

Turn on the spot towards the route, follow it by pure pursuit (Coulter 1992: the circle through the
robot and a look-ahead point on the route), turn on the spot to the wanted heading.
"""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

from facetlog.robot.collecting.route import Route
from facetlog.robot.pose2 import Pose2

# Look-ahead, metres along the route: it cuts 1 cm off a circle of 1 m (s² / 8 r), and is steady at
# 0.3 m/s with ten reports a second (a lag of 0.15 s is 5 cm).
LOOK_AHEAD = 0.25
# Angles to the point ahead at which turning on the spot begins, and at which it ends.
TURN_FROM, TURN_UNTIL = math.radians(35.0), math.radians(4.0)
# The slowest speeds at which a robot moves and turns evenly: the protocol has whole mm/s and
# degrees/s, and wheels stick below.
SLOWEST, SLOWEST_TURN = 0.03, math.radians(3.0)
# Shorter legs of a route have no direction, metres.
NO_LENGTH = 1e-6
# The end counts as reached at this distance along the route, metres: closer, the distance between
# two reports at the slowest speed decides.
ARRIVED = 0.008
# What path tracking leaves at the end of a route, metres: ahead a report's way (0.1 s) at
# Pace.speed, to the side what looking ahead cuts off a circle of 1 m, both twice over.
PLACE_TOLERANCE = 0.06
# Tolerance of a heading, radians: the rest is compensated by the head's pan.
HEADING_TOLERANCE = math.radians(1.5)


@dataclass(frozen=True, slots=True)
class Motion:
    """Speed ahead (m/s) and turning to the left (rad/s)."""

    speed: float = 0.0
    turning: float = 0.0


@dataclass(frozen=True, slots=True)
class Pace:
    """Largest speed (m/s) and turning (rad/s), and their decelerations (m/s², rad/s²)."""

    speed: float = 0.2
    turning: float = math.radians(30.0)
    slowing: float = 0.15
    turn_slowing: float = math.radians(40.0)


@dataclass(frozen=True, slots=True)
class Progress:
    """How far along a route the robot has come (m), and whether it turns on the spot."""

    done: float = 0.0
    turning: bool = False


def along(
    here: Pose2, route: Route, progress: Progress, pace: Pace
) -> tuple[Motion | None, Progress]:
    """Return the motion that follows a route, None once its end is reached; and the progress on
    it.
    """
    total = sum(math.dist(a, b) for a, b in pairwise(route))
    done = _find_nearest(here, route, progress.done)
    progress = replace(progress, done=done)
    left = max(total - done, 0.0)
    if left <= ARRIVED:
        return None, progress
    x, y = _find_point_at(route, done + LOOK_AHEAD)
    ahead = here.inverse().compose(Pose2(x, y, 0.0))
    distance = math.hypot(ahead.x, ahead.y)
    angle = math.atan2(ahead.y, ahead.x)
    if abs(angle) > (TURN_UNTIL if progress.turning else TURN_FROM):
        turning = _slow_down(angle, pace.turning, pace.turn_slowing, SLOWEST_TURN)
        return Motion(0.0, turning), replace(progress, turning=True)
    speed = _slow_down(left, pace.speed, pace.slowing, SLOWEST)
    # The circle through here, along the heading, to the point ahead has curvature 2 sin a / d.
    curvature = 2 * math.sin(angle) / distance
    if abs(speed * curvature) > pace.turning:
        speed = pace.turning / abs(curvature)
    return Motion(speed, speed * curvature), replace(progress, turning=False)


def turn_to_heading(here: Pose2, heading: float, pace: Pace) -> Motion | None:
    """Return the turn on the spot to a heading; None once it is reached."""
    off = math.remainder(heading - here.heading, 2 * math.pi)
    if abs(off) <= HEADING_TOLERANCE:
        return None
    return Motion(0.0, _slow_down(off, pace.turning, pace.turn_slowing, SLOWEST_TURN))


def _slow_down(left: float, largest: float, slowing: float, least: float) -> float:
    """Return the speed from which one can still stop in what is left, with its sign."""
    # v² = 2 a s
    return math.copysign(max(min(largest, math.sqrt(2 * slowing * abs(left))), least), left)


def _find_nearest(here: Pose2, route: Route, least: float) -> float:
    """Return metres along the route of its nearest point, from `least` to not far beyond it."""
    best, best_distance, start = least, math.inf, 0.0
    for (ax, ay), (bx, by) in pairwise(route):
        length = math.hypot(bx - ax, by - ay)
        if length > NO_LENGTH and start + length >= least and start <= least + LOOK_AHEAD:
            share = ((here.x - ax) * (bx - ax) + (here.y - ay) * (by - ay)) / length**2
            at = max(start + min(max(share, 0.0), 1.0) * length, least)
            px, py = _find_point_at(route, at)
            distance = math.hypot(here.x - px, here.y - py)
            if distance < best_distance:
                best, best_distance = at, distance
        start += length
    return best


def _find_point_at(route: Route, at: float) -> tuple[float, float]:
    """Return the point so many metres along the route, at most its end."""
    for (ax, ay), (bx, by) in pairwise(route):
        length = math.hypot(bx - ax, by - ay)
        if at <= length and length > NO_LENGTH:
            return ax + (bx - ax) * at / length, ay + (by - ay) * at / length
        at -= length
    return route[-1]
