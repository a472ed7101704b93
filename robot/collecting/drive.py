"""Driving along a route by odometry, through leases; the robot stops whatever happens.

Each report of the robot gives the next speeds, and each command is valid only for its lease: if
this program hangs or dies, the driver stops the robot. All times are those of the robot's reports.

A sonar reports the nearest echo anywhere in its beam, so the echo counts as lying wherever in the
beam it would be in the way. Sonars see what is at their height, some 0.2 m, and no smooth wall at a
grazing angle: they make driving safer, the keep-out circles make it safe.
"""

import math
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from typing import Protocol

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.robot.collecting.route import Circle, Point, Route, measure_distance_to, measure_route
from facetlog.robot.collecting.steering import (
    SLOWEST,
    Motion,
    Pace,
    Progress,
    along,
    turn_to_heading,
)
from facetlog.robot.pioneer.state import RobotState, SonarRange
from facetlog.robot.pose2 import Pose2

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


def measure_free_way(sonars: Iterable[SonarRange], body: Body, at: float, speed: float) -> float:
    """Return metres until the robot's front reaches the nearest echo in its way; infinite without
    one.

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


def compute_safe_speed(free: float) -> float:
    """Return the speed (m/s) from which the robot stands before what is so many metres ahead.

    >>> [round(compute_safe_speed(free), 2) for free in (0.02, 0.1, 0.5)]
    [0.0, 0.12, 0.42]
    """
    # v t + v² / 2a = s
    way = max(free - ROOM, 0.0)
    return BRAKING * (math.sqrt(UNNOTICED**2 + 2 * way / BRAKING) - UNNOTICED)


# Seconds without a report after which driving ends: the driver has stopped the robot long before,
# and after 2 s it says itself that the link is lost, and what to do; after 10 s if what comes is
# damaged.
REPORT_TIMEOUT = 12.0
LEASE = 0.3
# A robot that is commanded to move and for so long moves by neither of these is held by something:
# stalled wheels are reported sooner, wheels that slip on the spot never.
BLOCKED_AFTER, BLOCKED_WAY, BLOCKED_TURN = 4.0, 0.01, 0.02
# Between two reports further apart the driver has stopped the robot: no sign that it is held.
QUIET_AFTER = 0.5
# A robot whose way is not free waits for so long: somebody may walk by.
WAITS_FOR_ITS_WAY = 5.0
# Longest time for a route, over its time at the pace: turns on the spot and slow ends are extra.
PATIENCE, PATIENCE_SECONDS = 3.0, 30.0
# Speeds below which the robot stands: less than the steps of its reports.
STANDS_SPEED, STANDS_TURNING = 0.003, 0.01
# Reports in a row in which it must stand.
STANDING_REPORTS = 3
STANDING_TIMEOUT = 10.0
# Metres that odometry may say the robot is inside a circle before that ends the drive.
INTRUSION = 0.02


class WayBlockedError(DeviceError):
    """Something stands close ahead of a robot that stands; `at` is where, (x, y) in the world."""

    at: Point | None = None


class Robot(Protocol):
    """The part of the driver that driving needs."""

    @property
    def state(self) -> RobotState:
        """The last report; DeviceError if the link is lost."""

    @property
    def halted(self) -> object | None:
        """The problem that stopped it and still blocks driving; its text is for people."""

    def drive(self, speed: float, turning: float, lease: float = LEASE) -> object:
        """Move for as long as the lease, m/s and rad/s."""

    def stop(self) -> None:
        """Stop."""

    def wait_for(self, condition: Callable[..., bool], timeout: float) -> RobotState:
        """Return the first state of which the condition is true; DeviceTimeout if none is."""


class MobileBase:
    """A robot that follows routes given in the world frame.

    `start` is the pose of odometry's origin in the world. `closed` are the keep-out circles for the
    robot's middle. `moved` is called with every report while it drives. With its `body` it goes no
    faster than its sonars see that the way is free, and waits where it is not.
    """

    def __init__(
        self,
        robot: Robot,
        start: Pose2,
        *,
        pace: Pace,
        closed: tuple[Circle, ...] = (),
        moved: Callable[[float, Pose2], None] | None = None,
        body: Body | None = None,
    ) -> None:
        self._robot, self._pace = robot, pace
        self.start = start
        """The pose of odometry's origin in the world."""
        self.driven = 0.0
        """How far it has driven by odometry, metres."""
        self._closed, self._moved, self._body = closed, moved, body
        self._last: RobotState | None = None

    @property
    def state(self) -> RobotState:
        """The last report; DeviceError if the link is lost."""
        self._last = self._robot.state
        return self._last

    @property
    def last_place(self) -> Pose2 | None:
        """Its pose in the world by the last report that was looked at, also of a lost link."""
        return None if self._last is None else self.place(self._last)

    def place(self, state: RobotState) -> Pose2:
        """Return the robot's pose in the world by a report."""
        return self.start.compose(state.pose)

    def follow(self, route: Route) -> None:
        """Drive along a route and stop at its end.

        DeviceError if something stops or holds the robot, DeviceTimeout if it takes far too long
        or its reports cease; a stop is commanded first in any case.
        """
        progress = Progress()

        def steer(here: Pose2) -> Motion | None:
            nonlocal progress
            motion, progress = along(here, route, progress, self._pace)
            return motion

        corners = max(len(route) - 1, 1)
        self._drive(steer, measure_route(route) / self._pace.speed + corners)

    def turn_to(self, heading: float) -> None:
        """Turn on the spot to a heading in the world; errors as of `follow`."""
        self._drive(lambda here: turn_to_heading(here, heading, self._pace), 0.0)

    def stand(self, settle: float) -> RobotState:
        """Return the report after the robot has stood still for `settle` seconds.

        DeviceTimeout if it does not come to stand.
        """
        self._robot.stop()
        since: float | None = None
        reports = 0
        first = self._robot.state.at
        state = self._robot.state
        while state.at - first < STANDING_TIMEOUT + settle:
            still = abs(state.speed) < STANDS_SPEED and abs(state.turning) < STANDS_TURNING
            if still:
                since = state.at if since is None else since
                reports += 1
                if reports >= STANDING_REPORTS and state.at - since >= settle:
                    return state
            else:
                since, reports = None, 0
            state = self._next(state)
        raise DeviceTimeout("the robot does not come to stand: is it on a slope, or pushed?")

    def _drive(self, steer: Callable[[Pose2], Motion | None], expected: float) -> None:
        state = self._robot.state
        first = state.at
        watch = _Watch(state)
        blocked_since: float | None = None
        try:
            while (motion := steer(self.place(state))) is not None:
                self._check(state)
                if state.at - first > PATIENCE * expected + PATIENCE_SECONDS:
                    raise DeviceTimeout("the robot takes too long for its route: is its path free?")
                motion, blocked = self._limit_to_free_way(state, motion)
                if not blocked:
                    blocked_since = None
                elif blocked_since is None:
                    blocked_since = state.at
                elif state.at - blocked_since > WAITS_FOR_ITS_WAY:
                    raise self._make_blocked_error(state)
                watch.check(state, motion)
                self._command(motion)
                state = self._next(state)
        except BaseException:
            # The first error is reported; the driver's own leases and its exit stop the robot too.
            with suppress(DeviceError):
                self._robot.stop()
            raise
        self._robot.stop()

    def _make_blocked_error(self, state: RobotState) -> WayBlockedError:
        here = self.place(state)
        fault = WayBlockedError(
            f"something is close ahead of the robot {_at(here)}, by its sonars: clear its way, or"
            " give it a --keep-out circle, then go on with --resume"
        )
        if self._body is not None:
            ahead = self._body.radius + measure_free_way(state.sonars, self._body, state.at, 0.0)
            if math.isfinite(ahead):
                there = here.compose(Pose2(ahead, 0.0))
                fault.at = there.x, there.y
        return fault

    def _limit_to_free_way(self, state: RobotState, motion: Motion) -> tuple[Motion, bool]:
        """Slow a motion down to what the free way ahead allows; return it, and whether the way
        is blocked.
        """
        if self._body is None or motion.speed <= 0:
            return motion, False
        free = measure_free_way(state.sonars, self._body, state.at, state.speed)
        safe = compute_safe_speed(free) if math.isfinite(free) else math.inf
        if safe >= motion.speed:
            return motion, False
        if safe < SLOWEST:
            return Motion(), True
        return Motion(safe, motion.turning * safe / motion.speed), False

    def _command(self, motion: Motion) -> None:
        try:
            self._robot.drive(motion.speed, motion.turning, LEASE)
        except DeviceError as exc:
            if (halted := self._robot.halted) is None:
                raise
            # The remedy in the driver's message is a call that the caller of this command cannot
            # make.
            raise DeviceError(f"{halted}, then go on with --resume") from exc

    def _next(self, state: RobotState) -> RobotState:
        try:
            later = self._robot.wait_for(lambda new: new.at > state.at, REPORT_TIMEOUT)
        except DeviceTimeout:
            # The time may have passed while this program was held up; the driver reports that.
            later = self._robot.wait_for(lambda new: new.at > state.at, REPORT_TIMEOUT)
        self._last = later
        self.driven += math.dist((state.pose.x, state.pose.y), (later.pose.x, later.pose.y))
        if self._moved is not None:
            self._moved(later.at, self.place(later))
        return later

    def _check(self, state: RobotState) -> None:
        """Raise DeviceError if a report says that the robot must not go on."""
        here = self.place(state)
        for said, pressed in (("front", state.front_bumpers), ("rear", state.rear_bumpers)):
            if any(pressed):
                numbers = ", ".join(str(i) for i, hit in enumerate(pressed, start=1) if hit)
                raise DeviceError(
                    f"the robot touched something at its {said} (bumper {numbers}) {_at(here)}: "
                    "free it, then go on with --resume"
                )
        if any(state.stalled):
            raise DeviceError(
                f"the robot's wheels are stalled {_at(here)}: free it, then go on with --resume"
            )
        if state.stop_button:
            raise DeviceError("the robot's stop button is pressed: release it, then --resume")
        if state.motors_on is False:
            raise DeviceError("the robot's motors are off: press its MOTORS button, then --resume")
        if measure_distance_to(self._closed, (here.x, here.y)) < -INTRUSION:
            raise DeviceError(
                f"the robot is within the keep-out circle {_at(here)}: move it away, then go on "
                "with --resume"
            )


def _at(here: Pose2) -> str:
    return f"at x {here.x:.2f} m, y {here.y:.2f} m"


class _Watch:
    """Notices that a robot does not move though it is commanded to."""

    def __init__(self, state: RobotState) -> None:
        self._pose, self._last = state.pose, state.at
        self._held = 0.0

    def check(self, state: RobotState, motion: Motion) -> None:
        """Raise DeviceError if nothing has moved for too long although `motion` was commanded."""
        off = self._pose.between(state.pose)
        moved = max(abs(off.x), abs(off.y)) > BLOCKED_WAY or abs(off.heading) > BLOCKED_TURN
        since, self._last = state.at - self._last, state.at
        if moved or motion == Motion():
            self._pose, self._held = state.pose, 0.0
        elif since <= QUIET_AFTER:
            self._held += since
        if self._held > BLOCKED_AFTER:
            raise DeviceError(
                "the robot does not move though it is commanded to: is it held, are its motors on?"
            )
