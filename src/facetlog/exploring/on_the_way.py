"""Views on the way through an area, which look at no place."""

import math
from itertools import pairwise

import numpy as np

from facetlog.mapping.place import LOOKS_AT
from facetlog.robot.collecting.next_stop import CHOSEN, Chosen
from facetlog.robot.collecting.plan import Reach, Stop
from facetlog.robot.collecting.route import Route, route_length
from facetlog.robot.collecting.tour_file import TourView
from facetlog.robot.mount.kinematics import camera_pose, gaze_at
from facetlog.robot.pose2 import Pose2

__all__ = ["arriving", "view_on_the_way"]

# The picture shows the floor so far ahead, m.
AHEAD = 2.0


def view_on_the_way(there: Pose2, route: Route, number: int, reach: Reach, why: str) -> Chosen:
    """The view that is taken at the end of a route, as the robot stands there."""
    x, y = there.x + AHEAD * math.cos(there.heading), there.y + AHEAD * math.sin(there.heading)
    point = np.array([x, y, 0.0])
    gaze = reach.within(gaze_at(there, reach.mount, point))
    view = TourView(f"view{number:03d}.png", camera_pose(there, reach.mount, gaze))
    line = {
        "result": CHOSEN,
        "after": number - 1,
        "image": view.name,
        "robot": [there.x, there.y, math.degrees(there.heading)],
        "way": route_length(route),
        "undecided": [],
        "promise": None,
        "why": why,
        LOOKS_AT: 0,
    }
    stop = Stop(number, view, there, gaze, point, route)
    return Chosen(stop, line, (f"next {view.name}: {why}",))


def arriving(route: Route, here: Pose2) -> Pose2:
    """The pose of a robot at the end of a route, as it comes there; it stands at `here` now."""
    legs = [(a, b) for a, b in pairwise(route) if a != b]
    if not legs:
        return here
    (ax, ay), (bx, by) = legs[-1]
    return Pose2(bx, by, math.atan2(by - ay, bx - ax))
