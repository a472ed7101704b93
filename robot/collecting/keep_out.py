"""Where no part of the robot may be: circles for its middle, and the rings on which it explores."""

from collections.abc import Mapping, Sequence

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.types import FloatArray
from facetlog.robot.collecting.next_stop import Around, reach_of_mount
from facetlog.robot.collecting.plan import Reach
from facetlog.robot.collecting.request import Request
from facetlog.robot.collecting.ring_views import bearing
from facetlog.robot.collecting.route import Circle, distance_to
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.collecting.tour_file import Tour
from facetlog.robot.mount.mount import Mount

__all__ = ["CLEARANCE", "check_keep_out", "circles_for_the_middle", "rings_round_target"]

# Room between the robot on the innermost view and the default keep-out circle: twice the distance
# by which driving may miss the planned place.
ROOM = 0.05
# Routes are planned this far outside of the keep-out circles: pursuit cuts corners by a centimetre.
CLEARANCE = 0.03


def check_keep_out(request: Request) -> None:
    """InputError where a radius has no place."""
    if isinstance(request.keep_out, float) and request.tour.target is None:
        raise InputError(
            "the tour's lines of sight do not meet, so --keep-out needs a place: X,Y,RADIUS"
        )


def circles_for_the_middle(request: Request, radius: float) -> tuple[Circle, ...]:
    """Keep-out circles for the robot's middle, so that no part of it enters the given circles.

    If none are given: about the target, as large as the innermost view leaves room for.
    """
    target, closed = request.tour.target, request.keep_out
    if isinstance(closed, tuple):
        circles = closed
    elif target is None:
        return ()
    else:
        if closed is None:
            closed = _room(request.tour, target, request.mount, radius)
        circles = (Circle(float(target[0]), float(target[1]), closed),)
    grown = tuple(circle.grown(radius) for circle in circles)
    inside = distance_to(grown, (request.start.x, request.start.y))
    if inside < 0:
        raise InputError(
            f"the robot at {request.start.x:.2f}, {request.start.y:.2f} is {-inside:.2f} m within "
            "a keep-out circle: put it elsewhere (--start), or give a smaller --keep-out"
        )
    return grown


def _room(tour: Tour, target: FloatArray, mount: Mount, radius: float) -> float:
    """The radius that the innermost view leaves, whichever way the robot stands there."""
    if not tour.views:
        raise InputError("--explore needs --keep-out RADIUS: how near the robot may come")
    nearest = min(float(np.hypot(*(view.pose.centre - target)[:2])) for view in tour.views)
    room = nearest - reach_of_mount(mount) - radius - ROOM - CLEARANCE
    if room <= 0:
        raise InputError(
            f"the tour comes within {nearest:.2f} m of what it looks at, which leaves no room for "
            "a robot beside it: give --keep-out RADIUS if that is meant"
        )
    return room


def rings_round_target(
    request: Request,
    reach: Reach,
    pace: Pace,
    body: float,
    lines: Sequence[Mapping[str, object]] = (),
) -> Around:
    """The rings round the target; `reach` has its keep-out circle. InputError if none holds it.

    Their places are those of the run that is continued, if `lines` of collect.jsonl have one round
    the target.
    """
    target = request.tour.target
    if target is None:
        raise InputError("--explore needs what is looked at: give --target X,Y,Z")
    place = float(target[0]), float(target[1])
    holding = [c for c in reach.closed if c.distance(place) < c.radius]
    if not holding:
        raise InputError("no --keep-out circle holds the --target: give --keep-out RADIUS")
    # Whichever way the robot stands, its middle stays outside of the circles.
    radius = (
        max(c.distance(place) + c.radius for c in holding) + reach_of_mount(request.mount) + ROOM
    )
    first = bearing(target, (request.start.x, request.start.y))
    if any("explore" in line for line in lines):
        before = Around.recorded(lines)
        first = before.first if np.allclose(before.target, target) else first
    return Around(target, radius, first, reach, pace, request.start, body)
