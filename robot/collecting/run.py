"""A whole collection: robot, head and camera are opened, the tour is planned, driven and recorded.

Everything that can be refused is checked before the motors are switched on; everything that was
opened is closed, the robot last, whatever happens.
"""

import math
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from facetlog.errors import DeviceError, FacetlogError, InputError
from facetlog.perception.types import FloatArray
from facetlog.robot.byte_line import ByteLine, PortLine
from facetlog.robot.camera.source import FileSource, FrameSource, open_camera
from facetlog.robot.collecting.drive import Body, MobileBase
from facetlog.robot.collecting.map_picture import Floor, Mapped
from facetlog.robot.collecting.next_stop import Around, ChosenStops, measure_mount_reach
from facetlog.robot.collecting.plan import Plan, Reach, Stop, plan_stops
from facetlog.robot.collecting.record import (
    WAY_FILE,
    Record,
    Taken,
    format_robot_tum,
    read_log,
    read_robot_tum,
    write_file,
)
from facetlog.robot.collecting.request import (
    TRAFFIC_FILE,
    Request,
    find_missing_views,
    read_earlier_views,
)
from facetlog.robot.collecting.ring_views import bearing
from facetlog.robot.collecting.route import Circle, measure_distance_to
from facetlog.robot.collecting.session import (
    SHOT_TIMEOUT,
    Ended,
    Listener,
    Rig,
    collect,
    record_end,
)
from facetlog.robot.collecting.simulated_robot import (
    CameraAndOptics,
    add_line_hint,
    check_start,
    choose_camera_and_optics,
    describe_coasting,
)
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.collecting.tour_file import Tour
from facetlog.robot.head.head import PanTiltHead
from facetlog.robot.head.open_head import open_head
from facetlog.robot.mount.mount import Mount
from facetlog.robot.pioneer.guard import Cause, Problem
from facetlog.robot.pioneer.limits import Limits
from facetlog.robot.pioneer.line.port import DEFAULT_BAUD, open_port
from facetlog.robot.pioneer.pioneer import Pioneer
from facetlog.robot.pose2 import Pose2


class DrivenWay:
    """Keeps the robot's poses in the world, and passes on what a listener is told after writing.

    `epoch` is when the reports' clock was zero (seconds since 1970). With `resume` the way of the
    folder's earlier runs stays before this one's.
    """

    def __init__(self, folder: Path, epoch: float, listener: Listener, *, resume: bool) -> None:
        self._path, self._epoch, self._listener = folder / WAY_FILE, epoch, listener
        self.stamped: list[tuple[float, Pose2]] = []
        """Times (seconds since 1970) and poses, those of earlier runs first."""
        if resume and self._path.is_file():
            self.stamped = read_robot_tum(self._path)

    def moved(self, at: float, place: Pose2) -> None:
        """Take the pose of a report."""
        self.stamped.append((self._epoch + at, place))

    def write(self) -> None:
        """Write the file; InputError where it cannot be written."""
        write_file(self._path, format_robot_tum(self.stamped).encode())

    def view_taken(self, done: int, total: int, view: Taken) -> None:
        self.write()
        self._listener.view_taken(done, total, view)

    def warn(self, message: str) -> None:
        self._listener.warn(message)

    def note(self, message: str) -> None:
        self._listener.note(message)

    def ended_early(self, ended: Ended, there: int, total: int) -> None:
        self._listener.ended_early(ended, there, total)


# Room between the robot on the innermost view and the default keep-out circle: twice the distance
# by which driving may miss the planned place.
ROOM = 0.05
# Routes are planned this far outside of the keep-out circles: pursuit cuts corners by a centimetre.
CLEARANCE = 0.03


def check_keep_out(request: Request) -> None:
    """Raise InputError where no circle of a radius fits."""
    if isinstance(request.keep_out, float) and request.tour.target is None:
        raise InputError(
            "the tour's lines of sight do not meet, so --keep-out needs a place: X,Y,RADIUS"
        )


def list_forbidden_circles(request: Request, radius: float) -> tuple[Circle, ...]:
    """Return keep-out circles for the robot's middle, so that no part of it enters the given
    circles.

    If none are given: about the target, as large as the innermost view leaves room for.
    """
    target, closed = request.tour.target, request.keep_out
    if isinstance(closed, tuple):
        circles = closed
    elif target is None:
        return ()
    else:
        if closed is None:
            closed = _find_free_radius(request.tour, target, request.mount, radius)
        circles = (Circle(float(target[0]), float(target[1]), closed),)
    grown = tuple(circle.grown(radius) for circle in circles)
    inside = measure_distance_to(grown, (request.start.x, request.start.y))
    if inside < 0:
        raise InputError(
            f"the robot at {request.start.x:.2f}, {request.start.y:.2f} is {-inside:.2f} m within "
            "a keep-out circle: put it elsewhere (--start), or give a smaller --keep-out"
        )
    return grown


def _find_free_radius(tour: Tour, target: FloatArray, mount: Mount, radius: float) -> float:
    """Return the radius that the innermost view leaves, whichever way the robot stands there."""
    if not tour.views:
        raise InputError("--explore needs --keep-out RADIUS: how near the robot may come")
    nearest = min(float(np.hypot(*(view.pose.centre - target)[:2])) for view in tour.views)
    room = nearest - measure_mount_reach(mount) - radius - ROOM - CLEARANCE
    if room <= 0:
        raise InputError(
            f"the tour comes within {nearest:.2f} m of what it looks at, which leaves no room for "
            "a robot beside it: give --keep-out RADIUS if that is meant"
        )
    return room


def plan_rings(
    request: Request,
    reach: Reach,
    pace: Pace,
    lines: Sequence[Mapping[str, object]] = (),
) -> Around:
    """Return the rings round the target; `reach` has its keep-out circle. InputError if none holds
    it.

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
        max(c.distance(place) + c.radius for c in holding)
        + measure_mount_reach(request.mount)
        + ROOM
    )
    first = bearing(target, (request.start.x, request.start.y))
    if any("explore" in line for line in lines):
        before = Around.recorded(lines)
        first = before.first if np.allclose(before.target, target) else first
    return Around(target, radius, first, reach, pace, request.start)


AUX_PORTS = {"aux1": 1, "aux2": 2, "aux3": 3}


@dataclass(frozen=True, eq=False, slots=True)
class Collected:
    """The result of a request: plan, end, all views there are, metres driven, and the map.

    `reason` is why no further view was chosen, where views were chosen.
    """

    plan: Plan
    ended: Ended
    taken: tuple[Taken, ...]
    way: float
    seconds: float
    mapped: Mapped | None = None
    reason: str = ""

    def to_json(self) -> Mapping[str, object]:
        return {
            **self.ended.to_json(),
            "views": [view.name for view in self.taken],
            "skipped": {each.name: each.reason for each in self.plan.skipped},
            "remarks": list(self.plan.remarks),
            "way": self.way,
            "seconds": self.seconds,
            **({"reason": self.reason} if self.reason else {}),
        }


def run_collection(request: Request, listener: Listener) -> Collected:
    """Collect; faults during the collection end it early and are in the result.

    InputError for a request that cannot be carried out, DeviceError or DeviceTimeout if robot, head
    or camera cannot be opened.
    """
    earlier = read_earlier_views(request)
    lines = read_log(request.folder) if request.resume else ()
    missing = find_missing_views(request.tour, earlier)
    check_keep_out(request)
    began = time.monotonic()
    with ExitStack() as stack:
        robot = stack.enter_context(
            Pioneer.connect(
                request.address,
                model=request.model,
                limits=Limits(speed=request.speed),
                log=request.folder / TRAFFIC_FILE,
                baud=request.baud,
            )
        )
        robot.on_problem(partial(_warn_about_problem, listener))
        # Before the head and the camera: both may be those of another robot.
        check_start(robot, request.start, listener.warn)
        seen = choose_camera_and_optics(
            robot, request.address, request.camera, request.optics, listener.note
        )
        sees = _has_useful_sonars(robot)
        robot.switch_sonars(sees)
        if not sees:
            listener.note("the robot's sonars are off: what stands in its way is not seen")
        if coasts := describe_coasting(robot.configuration, request.speed):
            listener.note(coasts)
        head = open_robot_head(
            stack, robot, request.head, request.head_port, unheard=request.head_unheard
        )
        camera = open_checked_camera(stack, seen, latency=request.latency, noisy=request.noisy)

        radius = robot.parameters.radius
        forbidden = list_forbidden_circles(request, radius)
        reach = Reach(
            request.mount,
            head.limits,
            seen.optics.camera,
            tuple(circle.grown(CLEARANCE) for circle in forbidden),
        )
        plan = plan_stops(request.tour, request.start, reach, order=missing)
        for line in plan.remarks:
            listener.warn(line)
        for each in plan.skipped:
            listener.warn(f"{each.name} is left out: {each.reason}")
        pace = Pace(robot.limits.speed, robot.limits.turning)
        around = None
        if request.chooser is not None:
            around = plan_rings(request, reach, pace, lines)
        about = _about(request, robot.names.name, seen.camera, around)
        record = Record(request.folder, seen.optics, about, earlier, lines)
        epoch = time.time() - time.monotonic()
        way = DrivenWay(request.folder, epoch, listener, resume=request.resume)
        base = MobileBase(
            robot,
            request.start,
            pace=pace,
            closed=forbidden,
            moved=way.moved,
            body=Body(radius, robot.parameters.width) if sees else None,
        )
        rig = Rig(
            base,
            head,
            camera,
            seen.optics,
            reach,
            epoch,
            lambda fault: add_line_hint(fault, robot.problems, time.monotonic()),
        )
        inner = tuple(circle.grown(-radius) for circle in forbidden)
        stops: ChosenStops | tuple[Stop, ...] = plan.stops
        if request.chooser is not None and around is not None:
            stops = ChosenStops(
                request.chooser,
                around,
                base,
                record,
                way,
                wide=radius + CLEARANCE,
            )
        try:
            with record_end(rig, len(stops), record, way):
                if len(stops):
                    robot.enable_motors()
                guide = stops if isinstance(stops, ChosenStops) else None
                ended = collect(rig, stops, record, way, skipped=plan.skipped, guide=guide)
            robot.stop()
        except BaseException:
            # The first fault is reported, not a map that cannot be written after it.
            with suppress(FacetlogError):
                _describe_map(request, seen, record.taken, way, inner, radius).draw(request.folder)
            raise
        mapped = _describe_map(request, seen, record.taken, way, inner, radius)
        mapped.draw(request.folder)
    reason = stops.reason if isinstance(stops, ChosenStops) else ""
    return Collected(
        plan, ended, record.taken, base.driven, time.monotonic() - began, mapped, reason
    )


def _warn_about_problem(listener: Listener, problem: Problem) -> None:
    """Warn of what makes poses less certain and ends nothing; covariances say the former too."""
    if problem.cause in (Cause.ODOMETRY, Cause.REPORTS_AGAIN):
        listener.warn(str(problem))


def _has_useful_sonars(robot: Pioneer) -> bool:
    """Return whether its sonars are of use: where they sit is known, and the line takes their
    reports.

    At 9600 baud reports with 16 ranges take nine tenths of it, and the head's traffic waits.
    """
    return bool(robot.parameters.sonars) and (robot.baud is None or robot.baud > DEFAULT_BAUD)


def open_robot_head(
    stack: ExitStack, robot: Pioneer, kind: str, port: str, *, unheard: bool = False
) -> PanTiltHead:
    """Return the started head at `port`: aux1 to aux3 of the robot, or an address of its own.

    DeviceTimeout if it does not answer, unless it may be moved `unheard`.
    """
    line: ByteLine = robot.aux(AUX_PORTS[port]) if port in AUX_PORTS else PortLine(open_port(port))
    stack.callback(line.close)
    head = open_head(kind, line, unheard=unheard)
    try:
        head.start()
    except DeviceError as exc:
        raise add_line_hint(exc, robot.problems, time.monotonic()) from exc
    stack.callback(head.close)
    return head


def open_checked_camera(
    stack: ExitStack, seen: CameraAndOptics, *, latency: float | None = None, noisy: bool = True
) -> FrameSource:
    """Return the camera of `seen`, of which one picture was taken and fits its calibration.

    DeviceError, DeviceTimeout or InputError where there is none: said before the robot moves.
    """

    def opened() -> FrameSource:
        camera = open_camera(seen.camera, latency=latency, noisy=noisy)
        stack.callback(camera.close)
        return camera

    camera = opened()
    seen.optics.check(camera.shot(time.monotonic(), SHOT_TIMEOUT).image)
    # A file gives each of its pictures once: the first one must still be that of the first view.
    return opened() if isinstance(camera, FileSource) else camera


def _about(
    request: Request, robot: str, camera: str, around: Around | None
) -> Mapping[str, object]:
    start = request.start
    explored: dict[str, object] = {} if around is None else {"explore": around.to_json()}
    if request.until is not None:
        explored["until"] = request.until
    return {
        "tour": request.tour.name,
        "robot": robot,
        "address": request.address,
        "camera": camera,
        "head": request.head,
        "start": [start.x, start.y, math.degrees(start.heading)],
        "start_stated": request.start_stated,
        "began": time.time(),
        **explored,
    }


def _describe_map(
    request: Request,
    seen: CameraAndOptics,
    taken: tuple[Taken, ...],
    way: DrivenWay,
    closed: tuple[Circle, ...],
    radius: float,
) -> Mapped:
    """Write the robot's path, and return the contents of the map."""
    there = {view.name for view in taken}
    missed = tuple(
        (float(view.pose.centre[0]), float(view.pose.centre[1]))
        for view in request.tour.views
        if view.name not in there
    )
    way.write()
    path = tuple(place for _, place in way.stamped)
    return Mapped(path, taken, Floor(closed, request.tour.target, radius, missed), seen.optics)
