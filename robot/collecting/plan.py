"""From a tour to stops: the robot's pose for each view, and the head's pan and tilt.

A view of a tour is a place of the pinhole, a height and a direction. The robot reaches the place
exactly; the height is the mast's, so the head looks from there at the point that the middle of the
picture was to show. The robot's heading is free within the range of the head's pan: the heading
with the least turning, on arriving and on leaving, is taken.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from facetlog.perception.types import Camera, FloatArray, Pose
from facetlog.robot.collecting.route import (
    Circle,
    Point,
    Route,
    find_shortest_route,
    measure_distance_to,
    measure_route,
)
from facetlog.robot.collecting.tour_file import Tour, TourView
from facetlog.robot.head.head import HeadLimits
from facetlog.robot.mount.kinematics import Gaze, camera_pose, stand_for
from facetlog.robot.mount.mount import Mount
from facetlog.robot.pose2 import Pose2, wrapped

# Kept free at both ends of the pan: by how much the robot's heading may be off where it stops.
PAN_MARGIN = math.radians(6.0)
# Headings that are tried within what the pan allows, besides those of arriving and leaving.
HEADINGS = 25
# A view whose line of sight does not come near the target is taken to show what is this far ahead.
WITHOUT_TARGET = 1.0
NO_ROUTE = (
    "no route leads there that keeps out of all keep-out circles: give smaller ones by --keep-out"
)
# Differences of height and tilt that are reported: from 1 cm, half a degree.
HEIGHT_WORTH_SAYING, TILT_WORTH_SAYING = 0.01, math.radians(0.5)
# Share of the picture's half width and height within which the target must be to be in it.
IN_PICTURE = 0.95


@dataclass(frozen=True, eq=False, slots=True)
class Stop:
    """One view that will be taken: the robot's pose, the angles, and the point looked at (3,).

    `route` is the way there where it was chosen with the view; else it is the shortest one.
    """

    number: int
    view: TourView
    robot: Pose2
    gaze: Gaze
    point: FloatArray
    route: Route | None = None


@dataclass(frozen=True, slots=True)
class Skipped:
    """A view that cannot be taken, and why."""

    number: int
    name: str
    reason: str


@dataclass(frozen=True, slots=True)
class Plan:
    """The stops in their order, the views left out, and remarks on differences from the tour."""

    stops: tuple[Stop, ...]
    skipped: tuple[Skipped, ...]
    remarks: tuple[str, ...]


@dataclass(frozen=True, eq=False, slots=True)
class Reach:
    """The reach of a robot: mount, head, camera, and the keep-out circles of its middle."""

    mount: Mount
    limits: HeadLimits
    camera: Camera
    closed: tuple[Circle, ...] = ()

    @property
    def pans(self) -> tuple[float, float]:
        """Least and largest pan that are planned with."""
        return self.limits.pan_min + PAN_MARGIN, self.limits.pan_max - PAN_MARGIN

    def within(self, gaze: Gaze) -> Gaze:
        """Return the nearest angles that the head can take."""
        return Gaze(
            min(max(gaze.pan, self.limits.pan_min), self.limits.pan_max),
            min(max(gaze.tilt, self.limits.tilt_min), self.limits.tilt_max),
        )


def shows(camera: Camera, pose: Pose, point: FloatArray) -> bool:
    """Return whether a point (3,) in the world is in the picture, not just at its rim."""
    x, y, z = pose.rotation.T @ (point - pose.centre)
    if z <= 0:
        return False
    across = abs(camera.fx * x / z) / (camera.width / 2)
    down = abs(camera.fy * y / z) / (camera.height / 2)
    return bool(max(across, down) <= IN_PICTURE)


def plan_stops(
    tour: Tour, start: Pose2, reach: Reach, *, order: Sequence[int] | None = None
) -> Plan:
    """Return the stops for a tour's views, from `start` in the world; numbers count the views from
    1.

    `order` are indices of views, else they are taken as given.
    """
    stops: list[Stop] = []
    skipped: list[Skipped] = []
    here = start
    target = tour.target
    indices = list(range(len(tour.views)) if order is None else order)
    for place, index in enumerate(indices):
        following = [_place(tour.views[i]) for i in indices[place + 1 : place + 2]]
        found = stop_for(index + 1, tour.views[index], target, here, following, reach)
        if isinstance(found, Stop):
            stops.append(found)
            here = found.robot
        else:
            skipped.append(found)
    return Plan(tuple(stops), tuple(skipped), _list_remarks(stops, reach))


def _place(view: TourView) -> Point:
    return float(view.pose.centre[0]), float(view.pose.centre[1])


def _find_point_of_view(view: TourView, target: FloatArray | None) -> FloatArray:
    """Return the point (3,) for the middle of the picture: on the line of sight, nearest to the
    target.

    The paper's views cross near the block's middle; for a view that looks away, a point ahead.
    """
    along = 0.0 if target is None else float(view.direction @ (target - view.pose.centre))
    return np.asarray(view.pose.centre + view.direction * (along if along > 0 else WITHOUT_TARGET))


def stop_for(
    number: int,
    view: TourView,
    target: FloatArray | None,
    here: Pose2,
    following: Sequence[Point],
    reach: Reach,
) -> Stop | Skipped:
    """Return the stop for a view with the least turning between `here` and the `following`
    place.
    """
    point = _find_point_of_view(view, target)
    if math.hypot(*(point - view.pose.centre)[:2]) < math.hypot(*view.pose.centre[:2]) * 1e-9:
        return Skipped(number, view.name, "it looks straight up or down, which no heading gives")
    bearings = _find_bearings(here, _place(view), following, reach)
    headings = _list_headings(view, point, bearings, reach)
    found = False
    for heading in sorted(headings, key=lambda each: _sum_turning(each, bearings)):
        stop = _find_stop(number, view, point, target, heading, reach)
        if isinstance(stop, str):
            continue
        found = True
        if (
            find_shortest_route((here.x, here.y), (stop.robot.x, stop.robot.y), reach.closed)
            is not None
        ):
            return stop
    first = _find_stop(number, view, point, target, headings[0], reach)
    return Skipped(number, view.name, NO_ROUTE if found or not isinstance(first, str) else first)


def _sum_turning(heading: float, bearings: tuple[float | None, float | None]) -> float:
    """Return how far a robot with this heading turns on arriving and on leaving."""
    arriving, leaving = bearings
    turns = [abs(wrapped(heading - arriving))] if arriving is not None else []
    if leaving is not None:
        turns.append(abs(wrapped(leaving - heading)))
    return sum(turns)


def _find_bearings(
    here: Pose2, place: Point, following: Sequence[Point], reach: Reach
) -> tuple[float | None, float | None]:
    """Return headings with which the robot arrives and leaves; None where it does not move."""
    arriving = _route((here.x, here.y), place, reach)
    leaving = _route(place, following[0], reach) if following else ()
    return _find_heading(arriving[-2:]), _find_heading(leaving[:2])


def _route(start: Point, end: Point, reach: Reach) -> Route:
    return find_shortest_route(start, end, reach.closed) or ()


def _find_heading(leg: Route) -> float | None:
    if len(leg) < 2 or measure_route(leg) == 0:
        return None
    (ax, ay), (bx, by) = leg
    return math.atan2(by - ay, bx - ax)


def _list_headings(
    view: TourView,
    point: FloatArray,
    bearings: tuple[float | None, float | None],
    reach: Reach,
) -> list[float]:
    """Return headings at which the pan can be reached, those of arriving and leaving first."""
    level = point - view.pose.centre
    sight = math.atan2(level[1], level[0]) - reach.mount.yaw
    low, high = reach.pans
    evenly = [sight - pan for pan in np.linspace(low, high, HEADINGS).tolist()]
    wanted = [h for h in bearings if h is not None and low <= wrapped(sight - h) <= high]
    return [*wanted, *evenly]


def _find_stop(
    number: int,
    view: TourView,
    point: FloatArray,
    target: FloatArray | None,
    heading: float,
    reach: Reach,
) -> Stop | str:
    """Return the stop with this heading, or why there is none."""
    robot, wanted = stand_for(_place(view), heading, reach.mount, point)
    if measure_distance_to(reach.closed, (robot.x, robot.y)) < 0:
        return "the robot would stand within the keep-out circle: give a smaller --keep-out"
    gaze = reach.within(wanted)
    pose = camera_pose(robot, reach.mount, gaze)
    seen = point if target is None else target
    # Where the tour does not show the target itself, it need not be in the picture.
    if shows(reach.camera, view.pose, seen) and not shows(reach.camera, pose, seen):
        return (
            f"the head cannot tilt to {math.degrees(wanted.tilt):.0f}°, and at "
            f"{math.degrees(gaze.tilt):.0f}° the object would leave the picture"
        )
    return Stop(number, view, robot, gaze, point)


def _list_remarks(stops: Sequence[Stop], reach: Reach) -> tuple[str, ...]:
    """Return one line for each kind of difference between the pictures and the tour."""
    higher, tilted = [], []
    for stop in stops:
        pose = camera_pose(stop.robot, reach.mount, stop.gaze)
        higher.append(float(pose.centre[2] - stop.view.pose.centre[2]))
        _, wanted = stand_for(_place(stop.view), stop.robot.heading, reach.mount, stop.point)
        tilted.append(abs(stop.gaze.tilt - wanted.tilt))
    remarks = []
    off = [h for h in higher if abs(h) > HEIGHT_WORTH_SAYING]
    if off:
        remarks.append(
            f"{len(off)} of {len(stops)} views are taken from another height than the tour's, by "
            f"{min(off):+.2f} to {max(off):+.2f} m: the mast has one height"
        )
    skewed = sum(stop.view.skewed for stop in stops)
    if skewed:
        remarks.append(
            f"{skewed} of {len(stops)} views of the tour have a skew: the head cannot turn that way"
        )
    short = [t for t in tilted if t > TILT_WORTH_SAYING]
    if short:
        remarks.append(
            f"{len(short)} of {len(stops)} views need more tilt than the head has, by up to "
            f"{math.degrees(max(short)):.1f}°: the nearest is taken"
        )
    return tuple(remarks)
