"""Views that a robot can take of a target: on rings round it, each with the way there.

They are planned as a tour's views are: the head looks at the target, the robot's middle keeps out
of the circles, and the way is the shortest one round them.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from facetlog.perception.types import FloatArray, Pose
from facetlog.robot.collecting.plan import Reach, Stop, stop_for
from facetlog.robot.collecting.route import Route, find_shortest_route, measure_route
from facetlog.robot.collecting.session import HEAD_SETTLE, SETTLE
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.collecting.tour_file import TourView
from facetlog.robot.mount.kinematics import camera_pose, stand_for
from facetlog.robot.pose2 import Pose2, wrapped

# Places on a ring. At 22.5° a face moves on by less than the 45° from which it is seen otherwise,
# and three neighbours in a row show the same two sides of a thing.
PLACES = 16
STEP = math.tau / PLACES
"""Radians between neighbours on a ring."""
# Rings, as multiples of the innermost one's radius: what is too large for the picture from there is
# half as large again in it from the next.
RINGS = (1.0, 1.5)


@dataclass(frozen=True, eq=False, slots=True)
class Candidate:
    """A view that can be taken: the stop, the camera's pose there, and the way to it.

    `way` is in metres, `turns` are radians on the spot in all, `seconds` is the time for both at
    the robot's pace, and until it has stood still.
    """

    stop: Stop
    pose: Pose
    way: float
    turns: float
    seconds: float


def bearing(target: FloatArray, place: Sequence[float] | FloatArray) -> float:
    """Return radians at which a place (x, y, ...) lies, as seen from the target."""
    return math.atan2(float(place[1] - target[1]), float(place[0] - target[0]))


def list_ring_candidates(
    target: FloatArray,
    radius: float,
    first: float,
    number: int,
    here: Pose2,
    reach: Reach,
    pace: Pace,
) -> tuple[Candidate, ...]:
    """Return the views of a target (3,) that can be taken from `here`, ring by ring from the
    inside.

    `radius` (m) is that of the pinhole on the innermost ring; on each the bearing `first` comes
    first. `number` is that of the view among all of the collection.
    """
    found = []
    for ring in RINGS:
        for place in range(PLACES):
            view = _view(target, radius * ring, first + STEP * place, number, reach)
            stop = stop_for(number, view, target, here, (), reach)
            if not isinstance(stop, Stop):
                continue
            ends = (here.x, here.y), (stop.robot.x, stop.robot.y)
            route = find_shortest_route(*ends, reach.closed)
            if route is None:
                continue
            way, turns = measure_route(route), sum_turns(route, here, stop.robot)
            seconds = way / pace.speed + turns / pace.turning + SETTLE + HEAD_SETTLE
            pose = camera_pose(stop.robot, reach.mount, stop.gaze)
            found.append(Candidate(stop, pose, way, turns, seconds))
    return tuple(found)


def _view(target: FloatArray, radius: float, angle: float, number: int, reach: Reach) -> TourView:
    x = float(target[0]) + radius * math.cos(angle)
    y = float(target[1]) + radius * math.sin(angle)
    robot, gaze = stand_for((x, y), angle + math.pi, reach.mount, target)
    return TourView(f"view{number:03d}.png", camera_pose(robot, reach.mount, gaze))


def sum_turns(route: Route, here: Pose2, there: Pose2) -> float:
    """Return radians that are turned on the spot along a route, at both ends too."""
    legs = [(a, b) for a, b in pairwise(route) if a != b]
    headings = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in legs]
    all_ = [here.heading, *headings, there.heading]
    return sum(abs(wrapped(b - a)) for a, b in pairwise(all_))
