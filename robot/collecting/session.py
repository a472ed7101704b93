"""The collection: for each stop drive, stand, point, shoot, check, write.

Whatever ends it - something in the way, a frozen camera, a full disk, Ctrl-C - the robot is stopped
first, and what was collected stays and can be resumed.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from facetlog.errors import DeviceError, FacetlogError
from facetlog.perception.types import FloatArray, Image
from facetlog.robot.camera.checks import Quality, faults_of, measure_quality
from facetlog.robot.camera.optics import Optics
from facetlog.robot.camera.source import Frame, FrameSource
from facetlog.robot.collecting.drive import MobileBase, WayBlockedError
from facetlog.robot.collecting.option_words import describe_resume, worded
from facetlog.robot.collecting.plan import Reach, Skipped, Stop
from facetlog.robot.collecting.record import Record, Taken
from facetlog.robot.collecting.route import Circle, find_shortest_route
from facetlog.robot.collecting.steering import HEADING_TOLERANCE, PLACE_TOLERANCE
from facetlog.robot.head.head import PanTiltHead
from facetlog.robot.mount.kinematics import Gaze, camera_pose, compute_pose_covariance, find_gaze
from facetlog.robot.pioneer.state import RobotState
from facetlog.robot.pose2 import Pose2

# Seconds that the robot must have stood before a picture: a mast of 0.7 m swings at some 3 to 5
# times a second and is still after a few swings.
SETTLE = 0.6
# Of the head, after it says that it stands.
HEAD_SETTLE = 0.2
SHOT_TIMEOUT, HEAD_TIMEOUT = 10.0, 10.0
# The head's angles: its steps, and as much again for play in its gears (assumed).
HEAD_PLAY_SD = math.radians(0.2)


BLOCKED = "blocked"
"""What a line of collect.jsonl about a way that was blocked has as its `result`."""


class Listener(Protocol):
    """Gets the events of a collection; it may ignore all of them."""

    def view_taken(self, done: int, total: int, view: Taken) -> None:
        """Report a view that was taken and written."""

    def warn(self, message: str) -> None:
        """Report a warning."""

    def note(self, message: str) -> None:
        """Report an assumption that was made."""

    def ended_early(self, ended: "Ended", there: int, total: int) -> None:
        """It ended with so many of the views `there`; what is raised besides is the same."""


class Stops(Protocol):
    """Stops, each of which may be chosen only when the views before it are written."""

    def __iter__(self) -> Iterator[Stop]:
        """Return the stops in their order."""

    def __len__(self) -> int:
        """Return how many there are at most."""


class Guide(Protocol):
    """Knows what the way to a stop keeps out of, and what to do where it is blocked."""

    @property
    def closed(self) -> tuple[Circle, ...]:
        """The circles for the robot's middle on the way to the last stop that was given."""

    def avoid(self, fault: WayBlockedError) -> Circle | None:
        """Return the circle to keep out of from now on; None if it cannot go on."""


@dataclass(frozen=True, eq=False, slots=True)
class Rig:
    """Robot, head and camera."""

    base: MobileBase
    head: PanTiltHead
    camera: FrameSource
    optics: Optics
    reach: Reach
    epoch: float
    """Seconds since 1970 at which the monotonic clock was zero."""
    explained: Callable[[DeviceError], DeviceError] = lambda fault: fault
    """Adds to a fault what else is known about it."""


@dataclass(frozen=True, slots=True)
class Ended:
    """How a collection ended: views taken in this run, and what ended it early, if anything: a
    fault, or else, as an interrupt, in a word `why`.

    Of one that ended early `robot` is its last known place in the world; whether it `stands` there,
    or was only last heard there.
    """

    taken: int
    wanted: int
    fault: FacetlogError | None = None
    robot: Pose2 | None = None
    stands: bool = False
    why: str = ""

    def to_json(self) -> Mapping[str, object]:
        """Return it for a line of collect.jsonl, and of `--json`."""
        fault = self.why or None if self.fault is None else str(self.fault)
        line = {"result": "ended", "taken": self.taken, "wanted": self.wanted, "fault": fault}
        if self.robot is None or not self.stands:
            return line
        x, y, heading = self.robot.x, self.robot.y, math.degrees(self.robot.heading)
        return line | {"robot": [x, y, heading]}


def collect(
    rig: Rig,
    stops: Stops,
    record: Record,
    listener: Listener,
    *,
    skipped: tuple[Skipped, ...] = (),
    guide: Guide | None = None,
) -> Ended:
    """Take the views of all stops; a fault of a device ends this early, and is in the result.

    With a `guide` a way that is blocked does not: it goes on to the stop that comes next then.
    InputError if the folder cannot be written any more.
    """
    for each in skipped:
        record.note(
            {"view": each.number, "image": each.name, "result": "skipped", "reason": each.reason}
        )
    qualities = [view.quality for view in record.taken]
    before = len(record.taken)
    total = before + len(stops)
    ended = Ended(0, len(stops))
    for stop in stops:
        try:
            closed = rig.reach.closed if guide is None else guide.closed
            view, image = _take(rig, stop, closed, qualities)
        except WayBlockedError as exc:
            circle = None if guide is None else guide.avoid(exc)
            if circle is None:
                ended = replace(ended, fault=rig.explained(exc))
                break
            record.note(_blocked(stop, circle))
            listener.warn(
                f"the way to {stop.view.name} is blocked at x {circle.x:.2f} m, y {circle.y:.2f} m"
                " by the sonars: it keeps out of there from now on, and goes on to another view"
            )
            continue
        except DeviceError as exc:
            ended = replace(ended, fault=rig.explained(exc))
            break
        record.add(view, image)
        qualities.append(view.quality)
        ended = replace(ended, taken=ended.taken + 1)
        for note in view.notes:
            listener.warn(f"{view.name}: {note}")
        listener.view_taken(before + ended.taken, total, view)
    if ended.fault is None:
        record.note(ended.to_json())
        return ended
    return _end_early(rig, record, listener, ended, total)


def _blocked(stop: Stop, circle: Circle) -> Mapping[str, object]:
    closed = [circle.x, circle.y, circle.radius]
    return {
        "view": stop.number,
        "image": stop.view.name,
        "result": BLOCKED,
        "closed": closed,
    }


@contextmanager
def record_end(rig: Rig, wanted: int, record: Record, listener: Listener) -> Iterator[None]:
    """Provide a context in which a collection of `wanted` views runs: whatever is raised there is
    recorded.

    The robot is stopped; then the end is written, as far as the folder can be written, and how to
    resume is reported. An interrupt, a full disk and motors that cannot be switched on end like
    this.
    """
    before = len(record.taken)
    try:
        yield
    except BaseException as exc:
        ended = Ended(len(record.taken) - before, wanted)
        if isinstance(exc, FacetlogError):
            ended = replace(ended, fault=exc)
        else:
            is_asked = isinstance(exc, KeyboardInterrupt)
            ended = replace(ended, why="interrupted" if is_asked else type(exc).__name__)
        _end_early(rig, record, listener, ended, before + wanted)
        raise


def _end_early(rig: Rig, record: Record, listener: Listener, ended: Ended, total: int) -> Ended:
    """Stop, write the end and report it; return it with the robot's place, and its fault worded
    for who goes on. Raise nothing: the first fault counts.
    """
    ended = replace(ended, robot=rig.base.last_place)
    # A second Ctrl-C only cuts the wait short: the driver's exit stops the robot too.
    with suppress(FacetlogError, KeyboardInterrupt):
        robot = rig.base.place(rig.base.stand(0.0))
        ended = replace(ended, robot=robot, stands=True)
    if ended.fault is not None:
        ended = replace(ended, fault=worded(ended.fault, describe_resume(ended.robot)))
    with suppress(FacetlogError):
        record.note(ended.to_json())
    # A terminal that was closed takes no line any more.
    with suppress(OSError):
        listener.ended_early(ended, len(record.taken), total)
    return ended


def _take(
    rig: Rig, stop: Stop, closed: tuple[Circle, ...], others: list[Quality]
) -> tuple[Taken, Image]:
    here = rig.base.place(rig.base.state)
    route = stop.route
    if route is None:
        route = find_shortest_route((here.x, here.y), (stop.robot.x, stop.robot.y), closed)
    if route is None:
        raise DeviceError(
            f"no route leads to view {stop.number} that keeps out of all keep-out circles: "
            "give smaller ones by --keep-out"
        )
    rig.base.follow(route)
    rig.base.turn_to(stop.robot.heading)
    state = rig.base.stand(SETTLE)
    robot = rig.base.place(state)

    notes = _describe_offset(stop.robot.between(robot))
    wanted = find_gaze(robot, rig.reach.mount, stop.point)
    gaze = rig.reach.within(wanted)
    if abs(gaze.pan - wanted.pan) > HEAD_PLAY_SD:
        notes.append(
            f"the head can pan to {math.degrees(gaze.pan):.0f}° only, "
            f"{math.degrees(wanted.pan):.0f}° were needed"
        )
    looks = rig.head.look(gaze.pan, gaze.tilt, timeout=HEAD_TIMEOUT)
    if not looks.reported:
        notes.append("the head does not report its angles: those it was commanded are recorded")
    after = max(looks.at, rig.base.state.at) + HEAD_SETTLE
    image, quality, said = _take_picture(rig.camera, rig.optics, after, others)
    notes += said

    # While it stood, the robot may have been pushed: the pose is that of the moment after.
    state = rig.base.state
    robot = rig.base.place(state)
    at = Gaze(looks.pan, looks.tilt)
    return (
        Taken(
            stop.number,
            stop.view.name,
            camera_pose(robot, rig.reach.mount, at),
            _compute_covariance(rig, state, robot, at),
            robot,
            state.pose,
            looks.pan,
            looks.tilt,
            looks.zoom,
            rig.epoch + state.at,
            quality,
            tuple(notes),
        ),
        image,
    )


def _describe_offset(off: Pose2) -> list[str]:
    """Return what to say of a robot that stands so far off the place that the tour asks for."""
    way = math.hypot(off.x, off.y)
    if way <= PLACE_TOLERANCE and abs(off.heading) <= 2 * HEADING_TOLERANCE:
        return []
    return [
        f"taken {way:.2f} m and {math.degrees(abs(off.heading)):.0f}° off the place that the tour"
        " asks for; the pose is that of where the robot stood"
    ]


def _take_picture(
    camera: FrameSource, optics: Optics, after: float, others: list[Quality]
) -> tuple[Image, Quality, list[str]]:
    """Return the picture, its quality and notes about it; a bad one is taken a second time."""
    frame = camera.shot(after, SHOT_TIMEOUT)
    optics.check(frame.image)
    quality = measure_quality(frame.image)
    faults = faults_of(quality, others)
    notes = _format_silence(frame)
    if not faults:
        return frame.image, quality, notes
    again = camera.shot(max(frame.arrived, after), SHOT_TIMEOUT)
    notes += _format_silence(again)
    second = measure_quality(again.image)
    still = faults_of(second, others)
    if not still:
        return again.image, second, [*notes, f"taken twice, the first was {'; '.join(faults)}"]
    # Neither is good: fewer faults go before more, then the sharper one.
    if (len(still), second.blur) < (len(faults), quality.blur):
        return again.image, second, [*notes, *(f"{fault}, twice; kept" for fault in still)]
    return frame.image, quality, [*notes, *(f"{fault}, twice; kept" for fault in faults)]


def _format_silence(frame: Frame) -> list[str]:
    """Return a note about a camera that gave no picture for a while."""
    if not frame.silent:
        return []
    return [f"no picture came from the camera for {frame.silent:.0f} s before this one; it goes on"]


def _compute_covariance(rig: Rig, state: RobotState, robot: Pose2, gaze: Gaze) -> FloatArray:
    """Return covariance of the camera's pose in the world; odometry's is in the frame of the
    start."""
    heading = rig.base.start.heading
    c, s = math.cos(heading), math.sin(heading)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return pose_covariance_at(robot, turn @ state.covariance @ turn.T, rig.reach, gaze)


def pose_covariance_at(robot: Pose2, odometry: FloatArray, reach: Reach, gaze: Gaze) -> FloatArray:
    """Return covariance (6, 6) of the camera's pose with the errors of a head's steps and play.

    `odometry` (3, 3) is that of the robot's x, y, heading in the world.
    """
    limits = reach.limits
    step = max(limits.pan_step, limits.tilt_step)
    # A reading rounded to steps is off evenly within one: variance step² / 12.
    head_sd = math.sqrt(HEAD_PLAY_SD**2 + step**2 / 12)
    return compute_pose_covariance(robot, odometry, reach.mount, gaze, head_sd)
