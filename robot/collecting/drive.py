"""Driving along a way by odometry, through leases; the robot stops whatever happens.

Each report of the robot gives the next speeds, and each command holds only as long as its lease:
if this program hangs or dies, the driver lets the robot stand. All times are those of the robot's
reports.
"""

from collections.abc import Callable
from contextlib import suppress
from typing import Protocol

from facetlog.errors import DeviceError, DeviceTimeout
from facetlog.perception.types import FloatArray
from facetlog.robot.collecting.route import Circle, Way, distance_to, length_of
from facetlog.robot.collecting.steering import Motion, Pace, Progress, along, towards_heading
from facetlog.robot.pose2 import Pose2

__all__ = ["Robot", "RobotView", "Wheels"]

# Seconds without a report after which driving ends: the driver has stopped the robot long before,
# and after 2 s it says itself that the link is lost, and what to do; after 10 s if what comes is
# damaged.
REPORT_TIMEOUT = 12.0
LEASE = 0.3
# A robot that is told to move and does not, by either of these, for so long is held by something:
# stalled wheels say so sooner, wheels that slip on the spot never.
BLOCKED_AFTER, BLOCKED_WAY, BLOCKED_TURN = 4.0, 0.01, 0.02
# Between two reports further apart the driver has let the robot stand: that says nothing of what
# holds it.
QUIET_AFTER = 0.5
# What a way may take, of what it takes at the pace: turns on the spot and slow ends are extra.
PATIENCE, PATIENCE_SECONDS = 3.0, 30.0
# Speeds below which the robot stands: less than the steps of its reports.
STANDS_SPEED, STANDS_TURNING = 0.003, 0.01
# Reports in a row in which it must stand.
STANDING_REPORTS = 3
STANDING_TIMEOUT = 10.0
# Metres that odometry may say the robot is inside a circle before that ends the drive.
INTRUSION = 0.02


class RobotView(Protocol):
    """Of a report of the robot, what driving needs; metres, radians, seconds."""

    @property
    def at(self) -> float:
        """When it came, monotonic clock."""

    @property
    def pose(self) -> Pose2:
        """Odometry."""

    @property
    def covariance(self) -> FloatArray:
        """Of odometry's x, y, heading, (3, 3)."""

    @property
    def speed(self) -> float:
        """Ahead."""

    @property
    def turning(self) -> float:
        """To the left."""

    @property
    def motors_on(self) -> bool | None:
        """None where the robot does not tell."""

    @property
    def stop_button(self) -> bool | None:
        """None where the robot does not tell."""

    @property
    def stalled(self) -> tuple[bool, bool]:
        """Left and right wheel."""

    @property
    def front_bumpers(self) -> tuple[bool, ...]:
        """Which are pressed."""

    @property
    def rear_bumpers(self) -> tuple[bool, ...]:
        """Which are pressed."""


class Robot(Protocol):
    """Of the driver, what driving needs."""

    @property
    def state(self) -> RobotView:
        """The last report; DeviceError if the link is lost."""

    @property
    def halted(self) -> object | None:
        """What stopped it and keeps it from being driven; its text is for people."""

    def drive(self, speed: float, turning: float, lease: float = LEASE) -> object:
        """Moves for as long as the lease, m/s and rad/s."""

    def stop(self) -> None:
        """Stops."""

    def wait_for(self, condition: Callable[..., bool], timeout: float) -> RobotView:
        """The first state of which the condition is true; DeviceTimeout if none is."""


class Wheels:
    """A robot that can be sent along ways, in the frame of a world.

    `start` is where odometry's origin lies in the world. `closed` are the circles which the
    robot's middle must not enter. `moved` is called with every report while it drives.
    """

    def __init__(
        self,
        robot: Robot,
        start: Pose2,
        *,
        pace: Pace,
        closed: tuple[Circle, ...] = (),
        moved: Callable[[float, Pose2], None] | None = None,
    ) -> None:
        self._robot, self._start, self._pace = robot, start, pace
        self._closed, self._moved = closed, moved

    @property
    def state(self) -> RobotView:
        """The last report."""
        return self._robot.state

    def place(self, state: RobotView) -> Pose2:
        """Where a report says that the robot is, in the world."""
        return self._start.compose(state.pose)

    def follow(self, way: Way) -> None:
        """Drives along a way and stops at its end.

        DeviceError if something stops or holds the robot, DeviceTimeout if it takes far too long
        or its reports cease; it is told to stop first in any case.
        """
        progress = Progress()

        def steer(here: Pose2) -> Motion | None:
            nonlocal progress
            motion, progress = along(here, way, progress, self._pace)
            return motion

        corners = max(len(way) - 1, 1)
        self._drive(steer, length_of(way) / self._pace.speed + corners)

    def turn_to(self, heading: float) -> None:
        """Turns on the spot to a heading in the world; errors as of `follow`."""
        self._drive(lambda here: towards_heading(here, heading, self._pace), 0.0)

    def stand(self, settle: float) -> RobotView:
        """The report after the robot has stood still for `settle` seconds.

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
        try:
            while (motion := steer(self.place(state))) is not None:
                self._check(state)
                if state.at - first > PATIENCE * expected + PATIENCE_SECONDS:
                    raise DeviceTimeout("the robot takes too long for its way: is its path free?")
                watch.check(state, motion)
                self._tell(motion)
                state = self._next(state)
        except BaseException:
            # The first error is the one to tell; the driver's own leases and its exit stop too.
            with suppress(DeviceError):
                self._robot.stop()
            raise
        self._robot.stop()

    def _tell(self, motion: Motion) -> None:
        try:
            self._robot.drive(motion.speed, motion.turning, LEASE)
        except DeviceError as exc:
            if (halted := self._robot.halted) is None:
                raise
            # The driver's own way out is a call that whoever collects cannot make.
            raise DeviceError(f"{halted}, then go on with --resume") from exc

    def _next(self, state: RobotView) -> RobotView:
        try:
            later = self._robot.wait_for(lambda new: new.at > state.at, REPORT_TIMEOUT)
        except DeviceTimeout:
            # The time may have passed while this program was held up, and the driver is to say so.
            later = self._robot.wait_for(lambda new: new.at > state.at, REPORT_TIMEOUT)
        if self._moved is not None:
            self._moved(later.at, self.place(later))
        return later

    def _check(self, state: RobotView) -> None:
        """DeviceError if a report says that the robot must not go on."""
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
        if distance_to(self._closed, (here.x, here.y)) < -INTRUSION:
            raise DeviceError(
                f"the robot is within the keep-out circle {_at(here)}: move it away, then go on "
                "with --resume"
            )


def _at(here: Pose2) -> str:
    return f"at x {here.x:.2f} m, y {here.y:.2f} m"


class _Watch:
    """Notices that a robot that is told to move does not."""

    def __init__(self, state: RobotView) -> None:
        self._pose, self._last = state.pose, state.at
        self._held = 0.0

    def check(self, state: RobotView, motion: Motion) -> None:
        """DeviceError if nothing has moved for too long although `motion` was told."""
        off = self._pose.between(state.pose)
        moved = max(abs(off.x), abs(off.y)) > BLOCKED_WAY or abs(off.heading) > BLOCKED_TURN
        since, self._last = state.at - self._last, state.at
        if moved or motion == Motion():
            self._pose, self._held = state.pose, 0.0
        elif since <= QUIET_AFTER:
            self._held += since
        if self._held > BLOCKED_AFTER:
            raise DeviceError(
                "the robot is told to move and does not: is it held, are its motors on?"
            )
