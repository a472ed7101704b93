"""Reports in metres, radians and seconds, with the covariance of the pose by wheel odometry.

Reports give positions that wrap around; their differences are summed, and none is dropped. A report
that no motion explains waits for the next one, which shows whether it was damaged (the checksum
misses some double faults) or the robot's odometry was reset. After a reset the pose stays, and is
less certain by as much as the robot may have moved meanwhile.

Most errors of odometry are systematic (wheel size, track): they do not average out, so they are
carried as unknown constants of the robot with their Jacobian, beside noise that grows with the
distance (Borenstein and Feng, "Measurement and correction of systematic odometry errors in mobile
robots", 1996; first-order propagation).
"""

import math
from dataclasses import dataclass, field

import numpy as np

from facetlog.perception.types import FloatArray
from facetlog.robot.pioneer.packets.reports import Configuration, ServerInformation
from facetlog.robot.pioneer.parameters import Parameters, SonarPlace
from facetlog.robot.pose2 import Pose2, wrapped


@dataclass(frozen=True, slots=True)
class OdometryErrors:
    """Standard deviations of the errors of a robot's odometry.

    The first three are of constants of one robot. Their defaults are those of a robot that was
    calibrated by its maker and not by its user: 1 % of the way, 2 % of turning, and a drift whose
    double makes 30 cm in 5 m, the worst that users report of such robots.
    """

    way: float = 0.01
    """Share of the distance."""
    turning: float = 0.02
    """Share of the angle turned."""
    drift: float = 0.012
    """Radians turned unseen in each metre: half of 2 × 0.3 m / (5 m)²."""
    way_noise: float = 0.003
    """Metres after one metre, growing with the root of the distance (assumed: floor, slip)."""
    turning_noise: float = 0.01
    """Radians after one radian turned, growing with the root of it (assumed)."""
    drift_noise: float = 0.009
    """Radians after one metre, growing with the root of the distance: 2 mm of slip of each wheel in
    a metre (assumed), 0.36 m apart."""


class OdometryCovariance:
    """The covariance (3, 3) of x, y, heading in the frame in which the way began."""

    def __init__(self, errors: OdometryErrors | None = None) -> None:
        self._errors = errors or OdometryErrors()
        self._noise: FloatArray = np.zeros((3, 3))
        self._influence: FloatArray = np.zeros((3, 3))
        """Derivatives (3, 3) of x, y and heading by the errors of distance, turning and drift."""

    @property
    def covariance(self) -> FloatArray:
        """At the end of the way so far: m² and rad²."""
        e = self._errors
        constants = np.diag([e.way**2, e.turning**2, e.drift**2])
        # P = J C Jᵀ + N
        total: FloatArray = self._influence @ constants @ self._influence.T + self._noise
        return (total + total.T) / 2

    def move(self, before: Pose2, after: Pose2) -> None:
        """Take a small motion, as the wheels counted it."""
        dx, dy = after.x - before.x, after.y - before.y
        turned = wrapped(after.heading - before.heading)
        way = math.hypot(dx, dy)
        # The small motion that its errors act on: along the mean heading, forward or backward.
        middle = before.heading + turned / 2
        ahead = dx * math.cos(middle) + dy * math.sin(middle)
        # F = ∂(pose after) / ∂(pose before): a heading that is off swings the step round.
        F = np.array([[1.0, 0.0, -dy], [0.0, 1.0, dx], [0.0, 0.0, 1.0]])
        # ∂(pose after) / ∂(way, turning, drift); a turn during the step swings half of it.
        swing = np.array([-dy / 2, dx / 2, 1.0])
        G = np.column_stack([[dx, dy, 0.0], swing * turned, swing * ahead])
        self._influence = F @ self._influence + G
        e = self._errors
        along = np.array([math.cos(middle), math.sin(middle), 0.0])
        heading_noise = e.turning_noise**2 * abs(turned) + e.drift_noise**2 * way
        self._noise = (
            F @ self._noise @ F.T
            + e.way_noise**2 * way * np.outer(along, along)
            + heading_noise * np.outer(swing, swing)
        )

    def lose(self, way: float, turned: float) -> None:
        """Take that it may have gone so far (m) and turned so much (rad) uncounted."""
        self._noise = self._noise + np.diag([way**2, way**2, turned**2])


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
        """Take a report that came at `at` (s); why the pose is unreliable from now on, or None."""
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
            self._subtract_positions(now.x, before.x) * p.distance,
            self._subtract_positions(now.y, before.y) * p.distance,
            wrapped((now.heading - before.heading) * p.angle),
            now.at - before.at,
        )

    def _subtract_positions(self, now: int, before: int) -> int:
        half = self._modulus // 2
        return (now - before + half) % self._modulus - half

    def _set_anew(self, before: _Reading, now: _Reading) -> None:
        """Go on from a reading in another frame, at the same pose."""
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
    """Return whether a robot can have moved so since a reading, though either may have come
    late.
    """
    seconds = max(0.0, step.seconds)
    way = before.speed * (seconds + LATE) + HARDEST * seconds**2 / 2 + JUMP
    turn = before.turning * (seconds + LATE) + HARDEST_TURN * seconds**2 / 2 + TURN_JUMP
    return step.way <= way and abs(step.turned) <= turn


STANDING_SPEED = 0.005
"""m/s below which a wheel stands: some steps of the report's 1 … 2.5 mm/s."""
MOTORS, STOP_BUTTON = 1 << 0, 1 << 5
"""Flags of the report (Pioneer 3 manual, table 8)."""
BUMPERS = 5
"""Of a bumper ring: bits 1 to 5 (Pioneer 2 manual)."""


@dataclass(frozen=True, slots=True)
class SonarRange:
    """The last that a sonar measured: metres, when (s), and where it sits if that is known."""

    index: int
    range: float
    at: float
    place: SonarPlace | None = None


@dataclass(frozen=True, slots=True)
class RobotState:
    """The robot's state by its last report: metres, radians, seconds."""

    at: float
    """When its first byte came, on the driver's clock (monotonic unless another was given)."""
    pose: Pose2
    """In the frame in which the robot stood when the driver connected."""
    covariance: FloatArray = field(compare=False)
    """(3, 3), of x, y and heading."""
    speed: float
    """m/s ahead."""
    turning: float
    """rad/s, counter-clockwise."""
    left_speed: float
    right_speed: float
    battery_v: float
    """0 where the robot does not report it."""
    motors_on: bool | None
    """None until a flag or the robot's behaviour shows it."""
    stop_button: bool | None
    stalled: tuple[bool, bool]
    """Left wheel, right wheel."""
    front_bumpers: tuple[bool, ...]
    """From left to right."""
    rear_bumpers: tuple[bool, ...]
    """From right to left."""
    sonars: tuple[SonarRange, ...]
    """The last range of each that has measured yet."""

    @property
    def standing(self) -> bool:
        return max(abs(self.left_speed), abs(self.right_speed)) < STANDING_SPEED


class StateMaker:
    """Makes a state of each report, in the order in which they came."""

    def __init__(
        self,
        parameters: Parameters,
        configuration: Configuration | None = None,
        errors: OdometryErrors | None = None,
    ) -> None:
        self._parameters = parameters
        self._odometry = Odometry(parameters, errors)
        self._ranges: dict[int, SonarRange] = {}
        self._reports_motors = parameters.generation.reports_motors
        self._front = self._rear = BUMPERS
        if configuration is not None and configuration.rear_bumpers is not None:
            self._front = configuration.front_bumpers or 0
            self._rear = configuration.rear_bumpers
        self.motors_thought_on: bool | None = None
        """For models that do not report it: the state inferred from their behaviour."""

    def state(self, sip: ServerInformation, at: float) -> tuple[RobotState, str | None]:
        """Return the state after a report that came at `at`, and why odometry is unreliable, if
        it is.
        """
        p = self._parameters
        doubt = self._odometry.update(sip, at)
        for reading in sip.sonar:
            place = p.sonars[reading.index] if reading.index < len(p.sonars) else None
            metres = reading.range * p.range
            self._ranges[reading.index] = SonarRange(reading.index, metres, at, place)
        left, right = sip.left * p.speed, sip.right * p.speed
        turning = (right - left) / 2 * p.turning_per_speed
        if sip.turning is not None:
            turning = math.radians(sip.turning / 10)
        state = RobotState(
            at=at,
            pose=self._odometry.pose,
            covariance=self._odometry.covariance,
            speed=(left + right) / 2,
            turning=turning,
            left_speed=left,
            right_speed=right,
            battery_v=(sip.battery_10 or sip.battery) / 10,
            motors_on=self._read_flag(sip, MOTORS, self.motors_thought_on),
            stop_button=self._read_flag(sip, STOP_BUTTON),
            stalled=(sip.stall_left, sip.stall_right),
            front_bumpers=_bits(sip.front_bumpers, self._front),
            rear_bumpers=_bits(sip.rear_bumpers, self._rear),
            sonars=tuple(self._ranges[index] for index in sorted(self._ranges)),
        )
        return state, doubt

    def _read_flag(
        self, sip: ServerInformation, bit: int, else_: bool | None = None
    ) -> bool | None:
        return bool(sip.flags & bit) if self._reports_motors else else_


def _bits(value: int, count: int) -> tuple[bool, ...]:
    return tuple(bool(value >> bit & 1) for bit in range(count))
