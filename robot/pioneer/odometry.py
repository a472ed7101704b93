"""The robot's pose from wheel odometry, with its covariance.

Reports give positions that wrap around; their differences are summed, and none is dropped: a driver
in wide use dropped every change beyond 100 mm, and with it the path of each report it missed. A
report that no motion explains waits for the next one, which shows whether it was damaged (the
checksum misses some double faults) or the robot's odometry was set anew. Then the pose stays where
it was, and is less certain by as much as the robot may have moved meanwhile.
"""

import math
from dataclasses import dataclass

import numpy as np

from facetlog.perception.types import FloatArray
from facetlog.robot.pioneer.odometry_covariance import OdometryCovariance, OdometryErrors
from facetlog.robot.pioneer.packets.server_information import ServerInformation
from facetlog.robot.pioneer.parameters import Parameters
from facetlog.robot.pose2 import Pose2, wrapped

__all__ = ["Odometry", "OdometryErrors"]

HARDEST, HARDEST_TURN = 2.0, 10.5
"""m/s² and rad/s² (600 degrees/s²): the largest accelerations that robots of the family report."""
LATE = 0.5
"""Seconds by which a report may come later than it was made, and the next one not."""
JUMP, TURN_JUMP = 0.1, 0.35
"""Metres and radians beyond the largest motion from which on a change is a jump."""


@dataclass(frozen=True, slots=True)
class _Reading:
    """One report: the robot's units of place and heading, its speeds in m/s and rad/s."""

    x: int
    y: int
    heading: int
    speed: float
    turning: float
    at: float


@dataclass(frozen=True, slots=True)
class _Step:
    """From one reading to the next, in the frame of the robot's own odometry."""

    x: float
    y: float
    turned: float
    seconds: float

    @property
    def way(self) -> float:
        return math.hypot(self.x, self.y)


class Odometry:
    """Pose and covariance in the frame in which the robot stood at its first report."""

    def __init__(self, parameters: Parameters, errors: OdometryErrors | None = None) -> None:
        self._parameters = parameters
        self._sure = OdometryCovariance(errors)
        self._modulus = 1 << parameters.position_bits
        self._last: _Reading | None = None
        self._suspect: _Reading | None = None
        self._confirmed = False
        self._turn = 0.0
        """Radians from the frame of the robot's own odometry to that of `pose`."""
        self.pose = Pose2()
        """Now."""

    @property
    def covariance(self) -> FloatArray:
        """(3, 3), of x, y (m²) and heading (rad²); not writeable."""
        # That of the way, and of two readings rounded to whole units.
        unit = self._parameters.distance
        total = self._sure.covariance
        total += np.diag([unit**2 / 6, unit**2 / 6, self._parameters.angle**2 / 6])
        total.flags.writeable = False
        return total

    def update(self, sip: ServerInformation, at: float) -> str | None:
        """Takes a report that came at `at` (s); why the pose is unreliable from now on, or None."""
        p = self._parameters
        here = _Reading(
            sip.x,
            sip.y,
            sip.heading,
            abs(sip.left + sip.right) / 2 * p.speed,
            abs(sip.right - sip.left) / 2 * p.speed * p.turning_per_speed,
            at,
        )
        last, suspect, self._suspect = self._last, self._suspect, None
        if last is None:
            self._last, self._turn = here, -here.heading * p.angle
            return None
        if _is_motion(step := self._step(last, here), last):
            self._confirmed = True
            self._move(step)
            self._last = here
            return self._gap(last, here)
        if not self._confirmed:
            # It is the first report that may have been damaged: nothing was built on it yet.
            self._last, self._turn = here, -here.heading * p.angle
            return None
        if suspect is not None and _is_motion(on := self._step(suspect, here), suspect):
            jump = self._step(last, suspect)
            self._set_anew(last, suspect)
            self._move(on)
            self._last = here
            return (
                f"odometry jumped by {jump.way:.2f} m and {math.degrees(jump.turned):.0f}° in"
                f" {jump.seconds:.2f} s, which no motion explains: something reset it, and the"
                " robot is taken to be where it was, less certainly if it moved"
            )
        self._suspect = here
        return None

    def _step(self, before: _Reading, now: _Reading) -> _Step:
        p = self._parameters
        return _Step(
            self._difference(now.x, before.x) * p.distance,
            self._difference(now.y, before.y) * p.distance,
            wrapped((now.heading - before.heading) * p.angle),
            now.at - before.at,
        )

    def _difference(self, now: int, before: int) -> int:
        half = self._modulus // 2
        return (now - before + half) % self._modulus - half

    def _set_anew(self, before: _Reading, now: _Reading) -> None:
        """Goes on from a reading in another frame, at the same pose."""
        self._turn = self.pose.heading - now.heading * self._parameters.angle
        seconds = max(0.0, now.at - before.at)
        way = max(before.speed, now.speed) * seconds
        turned = max(before.turning, now.turning) * seconds
        self._sure.lose(way, turned)

    def _gap(self, before: _Reading, now: _Reading) -> str | None:
        seconds = now.at - before.at
        speed = min(max(before.speed, now.speed), self._parameters.speed_top)
        turning = min(max(before.turning, now.turning), self._parameters.turning_top)
        half_round = self._modulus // 2 * self._parameters.distance
        if speed * seconds > half_round:
            return (
                f"no reports for {seconds:.1f} s at up to {speed:.2f} m/s: positions roll over"
                f" after {2 * half_round:.2f} m, so the robot may be farther by so much"
            )
        if turning * seconds > math.pi:
            return (
                f"no reports for {seconds:.1f} s while turning at up to"
                f" {math.degrees(turning):.0f}°/s: whole turns may be missing"
            )
        return None

    def _move(self, step: _Step) -> None:
        turn, turned = self._turn, step.turned
        c, s = math.cos(turn), math.sin(turn)
        dx, dy = c * step.x - s * step.y, s * step.x + c * step.y
        before = self.pose
        self.pose = Pose2(before.x + dx, before.y + dy, wrapped(before.heading + turned))
        self._sure.move(before, self.pose)


def _is_motion(step: _Step, before: _Reading) -> bool:
    """Whether a robot can have moved so since a reading, though either may have come late."""
    seconds = max(0.0, step.seconds)
    way = before.speed * (seconds + LATE) + HARDEST * seconds**2 / 2 + JUMP
    turn = before.turning * (seconds + LATE) + HARDEST_TURN * seconds**2 / 2 + TURN_JUMP
    return step.way <= way and abs(step.turned) <= turn
